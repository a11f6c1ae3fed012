"""Counts its own steps, from 0 at t0: a signal whose value says when it was made."""

from components.contract import HEADER, Component, Parameters, Port, Sizes, quantity


class Counter(Parameters):
    """Counts in steps of `by`."""

    by: float = quantity("1", "increment", 1.0, tunable=True)


def init(t_ns, dt_ns, p, u, x, y, w):
    x[0] = 0.0
    y[0] = 0.0
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    x[0] += p[HEADER]
    y[0] = x[0]
    return 0


COMPONENT = Component(
    name="counter",
    parameters=Counter,
    outputs=lambda _: (Port("n", "1"),),
    sizes=lambda _: Sizes(state=1),
    init=init,
    step=step,
)
