"""The body's side of a power bond, without physics: it stays where it is."""

from components.contract import BodyEnd, Component, Parameters, Port, law_ports, motion_ports, quantity


class Ball(Parameters):
    """One parameter."""

    mass: float = quantity("kg", "of the ball", 1.0)


def inputs(_: Ball) -> tuple[Port, ...]:
    return law_ports("hook")


def outputs(_: Ball) -> tuple[Port, ...]:
    return (Port("energy", "J"), *motion_ports("hook"))


def step(t_ns, dt_ns, p, u, x, y, w):
    for i in range(10):
        y[i] = 0.0
    return 0


COMPONENT = Component(
    name="test.ball",
    parameters=Ball,
    inputs=inputs,
    outputs=outputs,
    init=step,
    step=step,
    bodies={"hook": BodyEnd(motion="hook", law="hook")},
)
