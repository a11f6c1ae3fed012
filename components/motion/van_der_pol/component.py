"""Binds the van der Pol oscillator to the contract."""

from components.contract import HEADER, Component
from components.motion.van_der_pol import model
from components.motion.van_der_pol.oscillator import runge_kutta

MU, KAPPA, X0, V0 = range(HEADER, HEADER + 4)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Start at the given position and velocity."""
    x[0] = p[X0]
    x[1] = p[V0]
    y[0] = x[0]
    y[1] = x[1]
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """One Runge-Kutta step."""
    x[0], x[1] = runge_kutta(x[0], x[1], u[0], p[MU], p[KAPPA], dt_ns * 1e-9)
    y[0] = x[0]
    y[1] = x[1]
    return 0


COMPONENT = Component(
    name="motion.van_der_pol",
    parameters=model.VanDerPol,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="The neighbour is held over a step.",
)
