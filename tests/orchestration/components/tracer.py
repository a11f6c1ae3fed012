"""A tracer of execution order: every output is the first input plus the number of steps taken."""

from typing import Annotated

from pydantic import Field

from components.contract import HEADER, N_Y, Component, Parameters, Port, Sizes, choice, quantity

START = HEADER + 2


class Tracer(Parameters):
    """How many scalar ports it has (`in_0`, ...; `out_0`, ...) and where it starts counting."""

    inputs: Annotated[int, Field(ge=0, le=100)] = choice("number of inputs", 0)
    outputs: Annotated[int, Field(ge=1, le=100)] = choice("number of outputs", 1)
    start: float = quantity("1", "added to every output", 0.0, tunable=True)


def inputs(tracer: Tracer) -> tuple[Port, ...]:
    return tuple(Port(f"in_{i}", "1") for i in range(tracer.inputs))


def outputs(tracer: Tracer) -> tuple[Port, ...]:
    return tuple(Port(f"out_{i}", "1") for i in range(tracer.outputs))


def init(t_ns, dt_ns, p, u, x, y, w):
    x[0] = 0.0
    first = u[0] if p[HEADER] > 0.0 else 0.0
    for i in range(int(p[N_Y])):
        y[i] = first + p[START]
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    x[0] += 1.0
    first = u[0] if p[HEADER] > 0.0 else 0.0
    for i in range(int(p[N_Y])):
        y[i] = first + p[START] + x[0]
    return 0


COMPONENT = Component(
    name="test.tracer",
    parameters=Tracer,
    inputs=inputs,
    outputs=outputs,
    sizes=lambda _: Sizes(state=1),
    init=init,
    step=step,
)
