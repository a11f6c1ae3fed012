"""Binds the drum to the contract."""

from components.contract import HEADER, Component
from components.winch.drum import model
from components.winch.drum.speed import advance, wanted

SPEED, MAX_SPEED, MAX_ACCELERATION, STALL, STORED, COMMANDED = range(HEADER, HEADER + 6)
RATE, LEFT = 0, 1
TENSION, COMMAND = 0, 1


def init(t_ns, dt_ns, p, u, x, y, w):
    """The drum stands still."""
    x[RATE], x[LEFT] = 0.0, p[STORED]
    y[0], y[1], y[2] = 0.0, p[STORED], 0.0
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Follow the command within the limits."""
    speed = p[SPEED] + (u[COMMAND] if p[COMMANDED] > 0.0 else 0.0)
    target = wanted(speed, u[TENSION], p[MAX_SPEED], p[STALL])
    x[RATE], x[LEFT] = advance(x[RATE], x[LEFT], target, p[MAX_ACCELERATION], dt_ns * 1e-9)
    y[0], y[1], y[2] = x[RATE], x[LEFT], -u[TENSION] * x[RATE]
    return 0


COMPONENT = Component(
    name="winch.drum",
    parameters=model.Drum,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="One layer of line; the motor's own time constant is short against the period.",
)
