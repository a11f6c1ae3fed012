"""A block of numbers that passes through: what a large message costs."""

from typing import Annotated

from pydantic import Field

from components.contract import N_Y, Component, Parameters, Port, choice


class Block(Parameters):
    """How many numbers."""

    size: Annotated[int, Field(ge=1)] = choice("numbers in and out", 1)


def step(t_ns, dt_ns, p, u, x, y, w):
    for i in range(int(p[N_Y])):
        y[i] = u[i] + 1.0
    return 0


COMPONENT = Component(
    name="bench.block",
    parameters=Block,
    init=step,
    step=step,
    inputs=lambda block: (Port("numbers", "1", (block.size,)),),
    outputs=lambda block: (Port("numbers", "1", (block.size,)),),
)
