"""Binds the point on an ellipse to the contract."""

from components.contract import HEADER, Component
from components.motion.ellipse import model
from components.motion.ellipse.orbit import orbit

CENTRE, COSINE, SINE, FREQUENCY, RAMP = HEADER, HEADER + 3, HEADER + 6, HEADER + 9, HEADER + 10


def step(t_ns, dt_ns, p, u, x, y, w):
    """Where the point is at t_ns."""
    c, dc, ddc, s, ds, dds = orbit(t_ns * 1e-9, p[FREQUENCY], p[RAMP])
    for i in range(3):
        y[i] = p[CENTRE + i] + p[COSINE + i] * c + p[SINE + i] * s
        y[3 + i] = p[COSINE + i] * dc + p[SINE + i] * ds
        y[6 + i] = p[COSINE + i] * ddc + p[SINE + i] * dds
    return 0


COMPONENT = Component(
    name="motion.ellipse",
    parameters=model.Ellipse,
    outputs=model.outputs,
    init=step,
    step=step,
    terms=model.terms,
    assumptions="The line does not move the point.",
)
