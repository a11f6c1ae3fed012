"""A source of everything that can be wired: a bundle, vectors in two frames, a matrix, an angle, a force."""

from typing import Annotated, Literal

from pydantic import Field

from components.contract import N_Y, Component, Parameters, Port, choice, motion_ports, quantity


class Source(Parameters):
    """Parameters of every kind."""

    level: float = quantity("m", "height", 1.0, tunable=True, gt=0, le=100)
    heading: float = quantity("rad", "clockwise from north", 0.0)
    weights: tuple[float, ...] = quantity("kg", "of the nodes", ())
    wet_mass: float = quantity("kg/m", "in water, per length", 0.1)
    ratio: float = quantity("1", "of something", 0.5, tunable=True)
    nodes: Annotated[int, Field(ge=1)] = choice("number of nodes", 4)
    kind: Literal["steady", "swinging"] = choice("what it does", "steady")
    smooth: bool = choice("whether it is smooth", True)
    table: tuple[tuple[float, ...], ...] = choice("rows of time and height", ())


def outputs(source: Source) -> tuple[Port, ...]:
    return (
        *motion_ports("motion"),
        Port("nodes", "m", (source.nodes, 3), "NED"),
        Port("heading", "rad"),
        Port("thrust", "N", (3,), "body"),
        Port("force", "N", (3,), "NED"),
        Port("pull", "N"),
        Port("torque", "N m"),
    )


def step(t_ns, dt_ns, p, u, x, y, w):
    for i in range(int(p[N_Y])):
        y[i] = i
    return 0


COMPONENT = Component(name="test.source", parameters=Source, outputs=outputs, init=step, step=step)
