"""Binds hydroacoustic positioning to the contract."""

from math import asin, inf, nan, sin, sqrt

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.kinematics import to_body, to_world
from components.sensors.hydroacoustic import model
from components.sensors.measurement import CHANNEL, DELAY, FIRST, measure

TRANSCEIVER, MAX_RANGE = HEADER + FIRST + 3 * CHANNEL, HEADER + FIRST + 3 * CHANNEL + 3


@kernel
def sine(value):
    """An angle's direction cosine, within its bounds."""
    return min(max(value, -1.0), 1.0)


@kernel
def take(p, u, h, x, y, w):
    """Take and give out a sample: the angles are those whose sines are the direction cosines along and across."""
    k = TRANSCEIVER
    north, east, down = to_world(u[3], u[4], u[5], p[k], p[k + 1], p[k + 2])
    north, east, down = u[6] - u[0] - north, u[7] - u[1] - east, u[8] - u[2] - down
    ahead, across, _ = to_body(u[3], u[4], u[5], north, east, down)
    reach = sqrt(north * north + east * east + down * down)
    w[0] = reach if reach <= p[MAX_RANGE] else nan
    w[1] = asin(sine(across / reach)) if reach > 0.0 else 0.0
    w[2] = asin(sine(ahead / reach)) if reach > 0.0 else 0.0
    y[6] = measure(p[HEADER:], w, h, p[SEED_HIGH], p[SEED_LOW], 0, x, y)
    side, front = sin(y[1]), sin(y[2])
    y[3], y[4] = y[0] * front, y[0] * side
    y[5] = y[0] * sqrt(max(1.0 - front * front - side * side, 0.0))


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first sample."""
    take(p, u, inf, x, y, w)
    y[7] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The sample at the step's end."""
    take(p, u, dt_ns * 1e-9, x, y, w)
    y[7] = (t_ns - p[HEADER + DELAY] * dt_ns) * 1e-9
    return 0


COMPONENT = Component(
    name="sensors.hydroacoustic",
    parameters=model.Hydroacoustic,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    assumptions="The transponder is below the transceiver; sound goes straight, and the delay is the same at all "
    "ranges; noise is white, biases are Gauss-Markov processes of first order; channels fail together.",
)
