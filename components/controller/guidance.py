"""Where a vehicle should be: waypoints in turn, and a smooth reference on the way to each."""

from math import ceil, exp, sqrt

from components.compiled import kernel
from components.controller.layout import (
    ANGLE,
    CHANGE,
    COUNT,
    LEG,
    MAX_ACCELERATION,
    MAX_RATE,
    MAX_SPEED,
    MAX_TURN_ACCELERATION,
    NOT_THERE,
    PATH_FREQUENCY,
    PLACE,
    RADIUS,
    RATE,
    REPEATS,
    SETPOINT,
    SINCE,
    SPEED,
    STAY,
    TURN_FREQUENCY,
    WAYPOINT,
    WAYPOINTS,
)
from components.kinematics import wrapped

FINE = 2.0  # steps for each time constant of the reference, which without them overshoots at 2 and is unstable at 0.5


@kernel
def is_at(q, at, eta):
    """Whether a position and heading eta (4) are within the radius and the angle of arrival of q[at : at + 4]."""
    gap = (q[at] - eta[0]) ** 2 + (q[at + 1] - eta[1]) ** 2 + (q[at + 2] - eta[2]) ** 2
    return sqrt(gap) <= q[RADIUS] and abs(wrapped(q[at + 3] - eta[3])) <= q[ANGLE]


@kernel
def choose(q, x, eta, t):
    """The index in q of the position and heading (4) to go to; eta: (4) of the vehicle. Arrivals are noted in x."""
    count = int(q[COUNT])
    if count == 0:
        return SETPOINT
    at = WAYPOINTS + WAYPOINT * int(x[LEG])
    if x[SINCE] == NOT_THERE and is_at(q, at, eta) and is_at(q, at, x[PLACE : PLACE + 4]):
        x[SINCE] = t
    if x[SINCE] > NOT_THERE and t - x[SINCE] >= q[at + STAY] and (q[REPEATS] > 0.0 or x[LEG] + 1.0 < count):
        x[LEG], x[SINCE] = (x[LEG] + 1.0) % count, NOT_THERE
    return WAYPOINTS + WAYPOINT * int(x[LEG])


@kernel
def wanted(distance, frequency, fastest, acceleration):
    """Speed towards a target at a distance from which it can still be stopped without passing it."""
    return min(frequency / 3.0 * distance, fastest, sqrt(acceleration * distance))


@kernel
def lead(q, x, at, h):
    """Move the reference over h [s] towards the position and heading at q[at : at + 4], a slow step in parts."""
    n = max(ceil(FINE * h * max(q[PATH_FREQUENCY], q[TURN_FREQUENCY])), 1)
    for _ in range(n):
        go(q, x, at, h / n)
        turn(q, x, wrapped(q[at + 3] - x[PLACE + 3]), h / n)


@kernel
def go(q, x, at, h):
    """Move the reference's position over h [s].

    Three poles at the frequency, as Fossen 2011, section 10.2.1, with speed and acceleration limited as vectors, so
    that a leg from rest is a straight line; braking takes half of the largest acceleration.
    """
    omega, most = q[PATH_FREQUENCY], q[MAX_ACCELERATION]
    fastest = q[MAX_SPEED] if at == SETPOINT else min(q[MAX_SPEED], q[at + SPEED])
    gap = sqrt((q[at] - x[PLACE]) ** 2 + (q[at + 1] - x[PLACE + 1]) ** 2 + (q[at + 2] - x[PLACE + 2]) ** 2)
    share = wanted(gap, omega, fastest, most) / gap if gap > 0.0 else 0.0
    size = 0.0
    for i in range(3):
        size += (omega * (share * (q[at + i] - x[PLACE + i]) - x[RATE + i])) ** 2
    size = sqrt(size)
    limit = most / size if size > most else 1.0
    soon = 1.0 - exp(-3.0 * omega * h)
    for i in range(3):
        push = limit * omega * (share * (q[at + i] - x[PLACE + i]) - x[RATE + i])
        x[CHANGE + i] += soon * (push - x[CHANGE + i])
        x[RATE + i] += h * x[CHANGE + i]
        x[PLACE + i] += h * x[RATE + i]


@kernel
def turn(q, x, gap, h):
    """The same for the heading, the shorter way round; gap: to the target [rad]."""
    omega, most = q[TURN_FREQUENCY], q[MAX_TURN_ACCELERATION]
    rate = wanted(abs(gap), omega, q[MAX_RATE], most)
    push = omega * ((rate if gap > 0.0 else -rate) - x[RATE + 3])
    push = min(max(push, -most), most)
    x[CHANGE + 3] += (1.0 - exp(-3.0 * omega * h)) * (push - x[CHANGE + 3])
    x[RATE + 3] += h * x[CHANGE + 3]
    x[PLACE + 3] += h * x[RATE + 3]
