"""Binds the current to the contract."""

from math import cos, exp, sin, sqrt

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.environment.current import current
from components.environment.stream import model
from components.random import normal

FACTOR, TURN, SPREAD, TIME, COUNT, DEPTHS = range(HEADER, HEADER + 6)
DRAWS, NORTH, EAST = range(3)


@kernel
def flow(p, x, depth, y, k):
    """Write the velocity at a depth to y[k:]."""
    north, east, down = current(p, DEPTHS + int(p[COUNT]), depth)
    c, s = p[FACTOR] * cos(p[TURN]), p[FACTOR] * sin(p[TURN])
    y[k], y[k + 1], y[k + 2] = c * north - s * east + x[NORTH], s * north + c * east + x[EAST], p[FACTOR] * down


@kernel
def observe(p, x, y):
    """Write all outputs."""
    n = int(p[COUNT])
    flow(p, x, 0.0, y, 0)
    for i in range(n):
        flow(p, x, p[DEPTHS + i], y, 3 + 3 * i)
    y[3 + 3 * n], y[4 + 3 * n], y[5 + 3 * n] = x[NORTH], x[EAST], 0.0


def init(t_ns, dt_ns, p, u, x, y, w):
    """Draw the variation as it is at any time."""
    a, b = normal(p[SEED_HIGH], p[SEED_LOW], 0, 0)
    x[DRAWS], x[NORTH], x[EAST] = 0.0, p[SPREAD] * a, p[SPREAD] * b
    observe(p, x, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Vary as a Gauss-Markov process of first order does, exactly for any step (Fossen 2011, eq. 8.154)."""
    if p[SPREAD] > 0.0:
        x[DRAWS] += 1.0
        a, b = normal(p[SEED_HIGH], p[SEED_LOW], 0, int(x[DRAWS]))
        kept = exp(-dt_ns * 1e-9 / p[TIME])
        fresh = p[SPREAD] * sqrt(1.0 - kept * kept)
        x[NORTH] = kept * x[NORTH] + fresh * a
        x[EAST] = kept * x[EAST] + fresh * b
    observe(p, x, y)
    return 0


COMPONENT = Component(
    name="environment.stream",
    parameters=model.Stream,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="Level flow, the same everywhere at a depth; the slow variation is alike at all depths.",
)
