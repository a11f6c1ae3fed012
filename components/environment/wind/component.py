"""Binds the wind to the contract."""

from math import cos, sin

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.environment.harmonics import draw, total
from components.environment.wind import model

MEAN, DIRECTION, VEER, RISE, COUNT, EDGES = range(HEADER, HEADER + 6)
TURNED, RISEN, FREQUENCIES = range(3)


@kernel
def blow(p, x, t, y):
    """Write the wind at t [s]."""
    n = int(p[COUNT])
    mean = max(p[MEAN] + x[RISEN], 0.0)
    speed = mean
    if n > 0:
        shares = p[EDGES + n + 1 : EDGES + 2 * n + 1]
        phases = x[FREQUENCIES + n : FREQUENCIES + 2 * n]
        speed += mean * total(shares, x[FREQUENCIES : FREQUENCIES + n], phases, n, t)
    direction = p[DIRECTION] + x[TURNED]
    y[0], y[1], y[2] = -speed * cos(direction), -speed * sin(direction), 0.0
    y[3], y[4], y[5] = speed, direction, mean


def init(t_ns, dt_ns, p, u, x, y, w):
    """Draw the gusts."""
    n = int(p[COUNT])
    x[TURNED] = x[RISEN] = 0.0
    for i in range(n):
        frequency, phase = draw(p[EDGES + i], p[EDGES + i + 1], p[SEED_HIGH], p[SEED_LOW], i)
        x[FREQUENCIES + i], x[FREQUENCIES + n + i] = frequency, phase
    blow(p, x, t_ns * 1e-9, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Turn and rise, and blow at the step's end."""
    x[TURNED] += p[VEER] * dt_ns * 1e-9
    x[RISEN] += p[RISE] * dt_ns * 1e-9
    blow(p, x, t_ns * 1e-9, y)
    return 0


COMPONENT = Component(
    name="environment.wind",
    parameters=model.Wind,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="Gusts are along the mean wind, Gaussian and the same over a vessel; while the mean rises or an event "
    "changes it below 5 m/s, they keep their share of it and their spectrum's shape.",
)
