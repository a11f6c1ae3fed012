"""A sink for the source: a moving end, a force, a scalar pull and a matrix; it gives the pull on."""

from components.contract import HEADER, Component, Parameters, Port, motion_ports, quantity


class Sink(Parameters):
    """One parameter that events may change and one that they may not."""

    share: float = quantity("1", "of the pull that is given on", 1.0, tunable=True, ge=0, le=1)
    length: float = quantity("m", "no default", gt=0)


def inputs(_: Sink) -> tuple[Port, ...]:
    return (
        *motion_ports("end"),
        Port("force", "N", (3,), "NED"),
        Port("pull", "N"),
        Port("matrix", "m", (2, 2)),
    )


def outputs(_: Sink) -> tuple[Port, ...]:
    return (Port("pull", "N"),)


def step(t_ns, dt_ns, p, u, x, y, w):
    y[0] = p[HEADER] * u[12]
    return 0


COMPONENT = Component(name="test.sink", parameters=Sink, inputs=inputs, outputs=outputs, init=step, step=step)
