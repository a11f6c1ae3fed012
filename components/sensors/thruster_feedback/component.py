"""Binds the feedback of thrusters to the contract."""

from math import inf

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.sensors.measurement import DELAY, measure, streams
from components.sensors.thruster_feedback import model

COUNT, BLOCKS = HEADER, HEADER + 1
BLOCK, CHANNELS = model.BLOCK, model.CHANNELS


@kernel
def take(p, u, t_ns, dt_ns, h, x, y, w):
    """Take and give out a sample of each thruster."""
    n = int(p[COUNT])
    state = len(x) // n
    for i in range(n):
        q = p[BLOCKS + BLOCK * i : BLOCKS + BLOCK * (i + 1)]
        for c in range(CHANNELS):
            w[c] = u[c * n + i]
        seen = w[CHANNELS : 2 * CHANNELS]
        own = x[state * i : state * (i + 1)]
        y[CHANNELS * n + i] = measure(q, w, h, p[SEED_HIGH], p[SEED_LOW], i * streams(q), own, seen)
        for c in range(CHANNELS):
            y[c * n + i] = seen[c]
    y[(CHANNELS + 1) * n] = (t_ns - p[BLOCKS + DELAY] * dt_ns) * 1e-9


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first sample."""
    take(p, u, t_ns, dt_ns, inf, x, y, w)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The sample at the step's end."""
    take(p, u, t_ns, dt_ns, dt_ns * 1e-9, x, y, w)
    return 0


COMPONENT = Component(
    name="sensors.thruster_feedback",
    parameters=model.ThrusterFeedback,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    assumptions="Noise is white and alike for all thrusters; biases are Gauss-Markov processes of first order.",
)
