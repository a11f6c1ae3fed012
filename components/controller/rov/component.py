"""Binds waypoint control of an ROV to the contract."""

from math import cos, isfinite, sin

from components.compiled import kernel
from components.contract import HEADER, Component
from components.controller.guidance import choose, lead
from components.controller.layout import ASKED, LEG, NOT_THERE, PLACE, SINCE, STATES
from components.controller.pid import are_numbers, demand
from components.controller.rov import model

LIMIT, TAKES_LINE, HOOK, COMMON = 0, 4, 5, 7
HEADING, VELOCITY, YAW_RATE, LINE = 5, 6, 11, 12
ETA, NU, ERROR = range(0, 12, 4)


@kernel
def oppose(own, u, x):
    """Work against the line's pull."""
    if own[TAKES_LINE] > 0.0:
        c, s = cos(u[HEADING]), sin(u[HEADING])
        ahead, across = c * u[LINE] + s * u[LINE + 1], c * u[LINE + 1] - s * u[LINE]
        x[ASKED] -= ahead
        x[ASKED + 1] -= across
        x[ASKED + 2] -= u[LINE + 2]
        x[ASKED + 3] -= own[HOOK] * across - own[HOOK + 1] * ahead


@kernel
def write(x, w, is_limited, is_held, y):
    """Write all outputs."""
    for i in range(4):
        y[i], y[4 + i], y[8 + i] = x[STATES + i], x[PLACE + i], w[ERROR + i]
    y[12], y[13], y[14], y[15] = x[LEG], 1.0 if x[SINCE] > NOT_THERE else 0.0, is_limited, is_held


@kernel
def control(own, u, x, y, w, t, h):
    """One step; inputs that are no numbers leave the thrust as it is."""
    q, eta, nu, error = own[COMMON:], w[ETA : ETA + 4], w[NU : NU + 4], w[ERROR : ERROR + 4]
    if not are_numbers(u):
        for i in range(4):
            error[i] = 0.0
        write(x, w, 0.0, 1.0, y)
        return
    for i in range(3):
        eta[i], nu[i] = u[i], u[VELOCITY + i]
    eta[3], nu[3] = u[HEADING], u[YAW_RATE]
    lead(q, x, choose(q, x, eta, t), h)
    demand(q, x, eta, nu, x[STATES : STATES + 4], h, error)
    oppose(own, u, x)
    is_limited = 0.0
    for i in range(4):
        x[STATES + i] = min(max(x[ASKED + i], -own[LIMIT + i]), own[LIMIT + i])
        if x[STATES + i] != x[ASKED + i]:
            is_limited = 1.0
    write(x, w, is_limited, 0.0, y)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the reference where the vehicle is, at rest."""
    for i in range(len(x)):
        x[i] = 0.0
    x[SINCE] = NOT_THERE
    for i in range(3):
        x[PLACE + i] = u[i] if isfinite(u[i]) else 0.0
    x[PLACE + 3] = u[HEADING] if isfinite(u[HEADING]) else 0.0
    control(p[HEADER:], u, x, y, w, t_ns * 1e-9, 0.0)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The thrust for the step to come."""
    control(p[HEADER:], u, x, y, w, t_ns * 1e-9, dt_ns * 1e-9)
    return 0


COMPONENT = Component(
    name="controller.rov",
    parameters=model.RovControl,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="The thrusters give each axis its load by itself, at once; gains are those of a linear vehicle without "
    "coupling; roll and pitch are small.",
)
