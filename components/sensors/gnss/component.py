"""Binds the satellite receiver to the contract."""

from math import inf

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.kinematics import to_world
from components.sensors.gnss import model
from components.sensors.measurement import CHANNEL, DELAY, FIRST, measure

ANTENNA = HEADER + FIRST + 3 * CHANNEL


@kernel
def take(p, u, h, x, y, w):
    """Take and give out a sample."""
    north, east, down = to_world(u[3], u[4], u[5], p[ANTENNA], p[ANTENNA + 1], p[ANTENNA + 2])
    w[0], w[1], w[2] = u[0] + north, u[1] + east, u[2] + down
    y[3] = measure(p[HEADER:], w, h, p[SEED_HIGH], p[SEED_LOW], 0, x, y)


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first sample."""
    take(p, u, inf, x, y, w)
    y[4] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The sample at the step's end."""
    take(p, u, dt_ns * 1e-9, x, y, w)
    y[4] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


COMPONENT = Component(
    name="sensors.gnss",
    parameters=model.Gnss,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    assumptions="Noise is white, biases are Gauss-Markov processes of first order; channels fail together.",
)
