"""Binds the point at rest to the contract."""

from components.contract import HEADER, Component
from components.motion.fixed import model

POSITION = HEADER


def step(t_ns, dt_ns, p, u, x, y, w):
    """Position, no velocity, no acceleration."""
    for i in range(3):
        y[i] = p[POSITION + i]
        y[3 + i] = 0.0
        y[6 + i] = 0.0
    return 0


COMPONENT = Component(
    name="motion.fixed",
    parameters=model.Fixed,
    outputs=model.outputs,
    init=step,
    step=step,
    assumptions="The point does not move.",
)
