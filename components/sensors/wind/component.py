"""Binds the anemometer to the contract."""

from math import atan2, cos, inf, sin, sqrt

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.sensors.measurement import DELAY, measure
from components.sensors.wind import model


@kernel
def take(p, u, h, x, y, w):
    """Take and give out a sample."""
    c, s = cos(u[8]), sin(u[8])
    ahead, across = u[3] - c * u[0] - s * u[1], u[4] - c * u[1] + s * u[0]  # of the vessel through the air
    w[0], w[1] = sqrt(ahead * ahead + across * across), atan2(across, ahead)
    y[2] = measure(p[HEADER:], w, h, p[SEED_HIGH], p[SEED_LOW], 0, x, y)
    y[0] = max(y[0], 0.0)


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first sample."""
    take(p, u, inf, x, y, w)
    y[3] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The sample at the step's end."""
    take(p, u, dt_ns * 1e-9, x, y, w)
    y[3] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


COMPONENT = Component(
    name="sensors.wind",
    parameters=model.WindSensor,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    assumptions="The anemometer feels the wind of its wire, and not the ship round it nor its roll; "
    "noise is white, biases are Gauss-Markov processes of first order; channels fail together.",
)
