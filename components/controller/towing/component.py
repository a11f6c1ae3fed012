"""Binds the towing controller to the contract."""

from math import cos, isfinite, sin

from components.compiled import kernel
from components.contract import HEADER, Component
from components.controller.path import nearest
from components.controller.towing import model
from components.controller.towing.formation import locate, pace
from components.controller.towing.layout import (
    ACROSS,
    ARRIVED,
    ASKED,
    COUNT,
    COURSE,
    GAP,
    HEADING,
    HEADING_ERROR,
    HOOK,
    HOOK_Y,
    IS_ALONE,
    IS_CLOSED,
    IS_HELD,
    IS_LIMITED,
    LINE_SHARE,
    OFFSET,
    OTHERS,
    OWN,
    PACE,
    PARTNER,
    PIECES,
    PLACE,
    PROGRESS,
    RADIUS,
    SCRATCH,
    SPEED_ERROR,
    STEADY,
    TAKES_LINE,
    TAKES_PARTNER,
    THRUST,
    VELOCITY,
    WANDERED,
    WAY,
)
from components.controller.towing.steering import line_of_sight, moment
from components.controller.towing.thrust import divide, surge


@kernel
def known(q, u):
    """Whether all inputs but the partner's position are finite."""
    total = 0.0
    line = OTHERS + (2 if q[TAKES_PARTNER] > 0.0 else 0)
    for i in range(OTHERS):
        total += 0.0 * u[i]
    for i in range(line, line + (3 if q[TAKES_LINE] > 0.0 else 0)):
        total += 0.0 * u[i]
    return total == 0.0


@kernel
def pulled(q, u):
    """The line's force ahead [N] and its moment [N m] on the boat, as far as they are to be worked against."""
    if q[TAKES_LINE] == 0.0:
        return 0.0, 0.0
    at = OTHERS + (2 if q[TAKES_PARTNER] > 0.0 else 0)
    c, s = cos(u[HEADING]), sin(u[HEADING])
    ahead, across = c * u[at] + s * u[at + 1], c * u[at + 1] - s * u[at]
    return q[LINE_SHARE] * ahead, q[LINE_SHARE] * (q[HOOK] * across - q[HOOK_Y] * ahead)


@kernel
def write(x, w, y):
    """Write all outputs."""
    y[0], y[1], y[2], y[3] = x[THRUST], x[THRUST + 1], 0.0, 0.0
    y[4], y[5] = w[COURSE], w[PACE]
    y[6], y[7], y[8], y[9] = w[ACROSS], x[GAP], w[HEADING_ERROR], w[SPEED_ERROR]
    y[10], y[11], y[12] = x[WANDERED], x[STEADY], w[PROGRESS]
    y[13], y[14], y[15], y[16] = w[ARRIVED], w[IS_LIMITED], w[IS_HELD], w[IS_ALONE]


@kernel
def control(q, u, x, y, w, h):
    """One step; inputs that are no numbers leave the thrust as it is."""
    for i in range(SCRATCH):
        w[i] = 0.0
    if not known(q, u):
        w[IS_HELD] = 1.0
        write(x, w, y)
        return
    locate(q, u, x, w)
    chi, curvature, along = line_of_sight(q, u, x, w, h)
    torque = moment(q, u, w, curvature * along / max(1.0 - curvature * q[OFFSET], 0.1))
    force = surge(q, u, x, w, pace(q, x, w[PROGRESS]), u[HEADING] - chi, h)
    pull, twist = pulled(q, u)
    divide(q, x, w, force - pull, torque - twist, h)
    w[ARRIVED] = 1.0 if q[IS_CLOSED] == 0.0 and q[WAY] - w[PROGRESS] <= q[RADIUS] else 0.0
    write(x, w, y)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin on the nearest pieces of the path, at the speed ahead that the boat has."""
    q = p[HEADER:]
    for i in range(len(x)):
        x[i] = 0.0
    count = int(q[COUNT])
    if isfinite(u[PLACE]) and isfinite(u[PLACE + 1]):
        x[OWN] = nearest(q[PIECES:], count, u[PLACE], u[PLACE + 1])
    if q[TAKES_PARTNER] > 0.0 and isfinite(u[OTHERS]) and isfinite(u[OTHERS + 1]):
        x[PARTNER] = nearest(q[PIECES:], count, u[OTHERS], u[OTHERS + 1])
    x[ASKED] = max(u[VELOCITY], 0.0) if isfinite(u[VELOCITY]) else 0.0
    control(q, u, x, y, w, 0.0)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The thrust for the step to come."""
    control(p[HEADER:], u, x, y, w, dt_ns * 1e-9)
    return 0


COMPONENT = Component(
    name="controller.towing",
    parameters=model.Towing,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="Two propellers side by side that give their thrust at once; a boat that answers its moment as a "
    "linear one without coupling of sway and yaw, and has no means to push sideways: against side pull it steers up.",
)
