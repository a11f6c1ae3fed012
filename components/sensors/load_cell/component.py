"""Binds the load cell to the contract."""

from math import inf

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.sensors.load_cell import model
from components.sensors.measurement import DELAY, measure


@kernel
def take(p, u, h, x, y, w):
    """Take and give out a sample."""
    w[0] = u[0]
    y[1] = measure(p[HEADER:], w, h, p[SEED_HIGH], p[SEED_LOW], 0, x, y)


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first sample."""
    take(p, u, inf, x, y, w)
    y[2] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The sample at the step's end."""
    take(p, u, dt_ns * 1e-9, x, y, w)
    y[2] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


COMPONENT = Component(
    name="sensors.load_cell",
    parameters=model.LoadCell,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    assumptions="Noise is white, the bias is a Gauss-Markov process of first order.",
)
