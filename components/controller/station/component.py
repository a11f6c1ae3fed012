"""Binds dynamic positioning to the contract."""

from math import cos, isfinite, sin

from components.compiled import kernel
from components.contract import HEADER, Component
from components.controller.guidance import choose, lead
from components.controller.layout import ASKED, LEG, LOAD, NOT_THERE, PLACE, RATE, SINCE, STATES
from components.controller.pid import are_numbers, demand
from components.controller.station import model

TAKES_ACHIEVED, TAKES_WIND, WIND_SHARE, TAKES_LINE, LINE_SHARE, HOOK, COMMON = 0, 1, 2, 3, 4, 5, 7
ESTIMATE = 6
ETA, NU, ERROR, ACHIEVED = range(0, 16, 4)


@kernel
def gather(u, w):
    """Write position and velocity (4 each) from the inputs."""
    w[ETA], w[ETA + 1], w[ETA + 2], w[ETA + 3] = u[0], u[1], 0.0, u[2]
    w[NU], w[NU + 1], w[NU + 2], w[NU + 3] = u[3], u[4], 0.0, u[5]


@kernel
def oppose(own, u, x, heading):
    """Work against the wind's load and the line's pull, as far as they are known."""
    at = ESTIMATE + (3 if own[TAKES_ACHIEVED] > 0.0 else 0)
    if own[TAKES_WIND] > 0.0:
        x[ASKED] -= own[WIND_SHARE] * u[at]
        x[ASKED + 1] -= own[WIND_SHARE] * u[at + 1]
        x[ASKED + 3] -= own[WIND_SHARE] * u[at + 2]
        at += 3
    if own[TAKES_LINE] > 0.0:
        c, s = cos(heading), sin(heading)
        ahead, across = c * u[at] + s * u[at + 1], c * u[at + 1] - s * u[at]
        x[ASKED] -= own[LINE_SHARE] * ahead
        x[ASKED + 1] -= own[LINE_SHARE] * across
        x[ASKED + 3] -= own[LINE_SHARE] * (own[HOOK] * across - own[HOOK + 1] * ahead)


@kernel
def write(x, w, held, y):
    """Write all outputs."""
    for i in range(3):
        k = i if i < 2 else 3
        y[i] = x[STATES + i]
        y[3 + i], y[6 + i] = x[PLACE + k], x[RATE + k]
        y[9 + i], y[12 + i] = w[ERROR + k], x[LOAD + k]
    y[15], y[16], y[17] = x[LEG], 1.0 if x[SINCE] > NOT_THERE else 0.0, held


@kernel
def control(own, u, x, y, w, t, h):
    """One step; inputs that are no numbers leave the demand as it is."""
    q = own[COMMON:]
    if not are_numbers(u):
        for i in range(4):
            w[ERROR + i] = 0.0
        write(x, w, 1.0, y)
        return
    gather(u, w)
    eta, nu, error, achieved = w[ETA : ETA + 4], w[NU : NU + 4], w[ERROR : ERROR + 4], w[ACHIEVED : ACHIEVED + 4]
    for i in range(4):
        achieved[i] = x[ASKED + i]
    if own[TAKES_ACHIEVED] > 0.0 and h > 0.0:
        achieved[0], achieved[1], achieved[3] = u[ESTIMATE], u[ESTIMATE + 1], u[ESTIMATE + 2]
    lead(q, x, choose(q, x, eta, t), h)
    demand(q, x, eta, nu, achieved, h, error)
    oppose(own, u, x, eta[3])
    x[STATES], x[STATES + 1], x[STATES + 2] = x[ASKED], x[ASKED + 1], x[ASKED + 3]
    write(x, w, 0.0, y)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the reference where the vessel is, at rest."""
    for i in range(len(x)):
        x[i] = 0.0
    x[SINCE] = NOT_THERE
    for i in range(3):
        x[PLACE + (i if i < 2 else 3)] = u[i] if isfinite(u[i]) else 0.0
    control(p[HEADER:], u, x, y, w, t_ns * 1e-9, 0.0)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The demand for the step to come."""
    control(p[HEADER:], u, x, y, w, t_ns * 1e-9, dt_ns * 1e-9)
    return 0


COMPONENT = Component(
    name="controller.station",
    parameters=model.Station,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="Low speed: gains are those of a linear vessel without coupling of sway and yaw; what is slow is a "
    "load in the world's frame.",
)
