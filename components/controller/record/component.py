"""Binds a recorded demand to the contract."""

from components.compiled import kernel
from components.contract import HEADER, Component
from components.controller.record import model

COEFFICIENTS = 12


@kernel
def interval(times, t):
    """Index of the interval with t; the first or last beyond the ends."""
    low, high = 0, len(times) - 2
    while low < high:
        middle = (low + high + 1) // 2
        if times[middle] <= t:
            low = middle
        else:
            high = middle - 1
    return low


@kernel
def play(q, t, y):
    """Write the demand (3) at t [s]."""
    n = int(q[0])
    times = q[1 : 1 + n]
    t = min(max(t, times[0]), times[n - 1])
    i = interval(times, t)
    at, s = 1 + n + COEFFICIENTS * i, t - times[i]
    for k in range(3):
        c = q[at + 4 * k : at + 4 * k + 4]
        y[k] = ((c[0] * s + c[1]) * s + c[2]) * s + c[3]


def init(t_ns, dt_ns, p, u, x, y, w):
    """The demand at the start."""
    play(p[HEADER:], t_ns * 1e-9, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The demand at the step's end."""
    play(p[HEADER:], t_ns * 1e-9, y)
    return 0


COMPONENT = Component(
    name="controller.record",
    parameters=model.Record,
    outputs=model.outputs,
    init=init,
    step=step,
    assumptions="The demand does not depend on what the vessel does.",
)
