"""Binds the irregular sea to the contract."""

from math import asin, cos, pi, sin, sqrt

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.environment.harmonics import draw
from components.environment.sea import model
from components.environment.waves import wave_number
from components.random import uniform

COUNT, DIRECTION, DEPTH, GRAVITY, NORTH, EAST, ANGLES = range(HEADER, HEADER + 7)
QUANTILES = model.QUANTILES


@kernel
def angle(p, share):
    """Angle [rad] off the mean direction below which a share of the energy lies."""
    place = asin(sqrt(share)) / (0.5 * pi) * (QUANTILES - 1)
    i = min(int(place), QUANTILES - 2)
    return p[ANGLES + i] + (place - i) * (p[ANGLES + i + 1] - p[ANGLES + i])


@kernel
def observe(p, x, t, y):
    """Write the components, and the surface at t [s]."""
    n = int(p[COUNT])
    surface = 0.0
    for i in range(n):
        a, omega, k, beta, phase = x[i], x[n + i], x[2 * n + i], x[3 * n + i], x[4 * n + i]
        along = cos(beta) * p[NORTH] + sin(beta) * p[EAST]
        surface += a * cos(k * along - omega * t + phase)
    for i in range(5 * n):
        y[i] = x[i]
    y[5 * n] = surface


def init(t_ns, dt_ns, p, u, x, y, w):
    """Draw the components: frequencies in their bins, phases, directions; a stream of random numbers each."""
    n = int(p[COUNT])
    edges = ANGLES + QUANTILES
    for i in range(n):
        omega, phase = draw(p[edges + i], p[edges + i + 1], p[SEED_HIGH], p[SEED_LOW], i)
        share, _ = uniform(p[SEED_HIGH], p[SEED_LOW], i, 1)
        x[i] = p[edges + n + 1 + i]
        x[n + i] = omega
        x[2 * n + i] = wave_number(omega, p[DEPTH], p[GRAVITY])
        x[3 * n + i] = p[DIRECTION] + angle(p, share)
        x[4 * n + i] = phase
    observe(p, x, t_ns * 1e-9, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The surface at the step's end; the components stay."""
    observe(p, x, t_ns * 1e-9, y)
    return 0


COMPONENT = Component(
    name="environment.sea",
    parameters=model.Sea,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="A stationary Gaussian sea of linear waves from 0.5 to 4 times the peak's frequency; with spreading "
    "each frequency has one direction.",
)
