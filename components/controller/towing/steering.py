"""The moment that brings a boat onto its side of the path: integral line of sight, and its heading by PD."""

from math import atan2, cos, exp, sin

from components.compiled import kernel
from components.controller.path import CURVATURE, PIECE, beside
from components.controller.towing.layout import (
    ACROSS,
    COURSE,
    DRIFT,
    DRIFT_TIME,
    HEADING,
    HEADING_ERROR,
    INTEGRAL,
    LOOKAHEAD,
    MAX_SPEED,
    MAX_TURN_RATE,
    OFFSET,
    OWN,
    PIECES,
    PLACE,
    TURNING,
    VELOCITY,
    WANDERED,
    YAW_DAMPING,
    YAW_GAIN,
    YAW_RATE,
)
from components.kinematics import wrapped

SLOW = 0.2  # of the largest speed: a drift's angle is no larger than at this speed ahead


@kernel
def line_of_sight(q, u, x, w, h):
    """Note the heading to steer and the error across; returns the path's heading, curvature, and the speed along it.

    The course is towards a point `lookahead` ahead on the path and the heading is that less the drift's angle (Fossen
    2011, section 10.3.2), here as it was over the last `drift_time`. What is left, the integral of Borhaug, Pavlov,
    Pettersen 2008 (47th IEEE CDC, 4984-4991) takes away, which grows slower the farther off the boat is; it grows with
    the way made instead of with time, so that it rests while the boat waits.
    """
    k = q[PIECES + PIECE * int(x[OWN]) : PIECES + PIECE * (int(x[OWN]) + 1)]
    _, across, chi = beside(k, u[PLACE], u[PLACE + 1])
    off = u[HEADING] - chi
    along = u[VELOCITY] * cos(off) - u[VELOCITY + 1] * sin(off)
    error = across - q[OFFSET]
    aim = error + q[INTEGRAL] * x[WANDERED]
    drift = atan2(u[VELOCITY + 1], max(u[VELOCITY], SLOW * q[MAX_SPEED]))
    x[DRIFT] += (1.0 - exp(-h / q[DRIFT_TIME])) * (drift - x[DRIFT])
    w[ACROSS], w[COURSE] = error, chi - atan2(aim, q[LOOKAHEAD]) - x[DRIFT]
    x[WANDERED] += h * max(along, 0.0) * q[LOOKAHEAD] * error / (aim * aim + q[LOOKAHEAD] * q[LOOKAHEAD])
    return chi, k[CURVATURE], along


@kernel
def moment(q, u, w, rate):
    """The moment [N m] for the heading noted; rate: of the path's heading as the boat goes [rad/s].

    PD by pole placement (Fossen 2011, section 12.2.4) as a speed loop within a position loop, whose rate is limited.
    """
    w[HEADING_ERROR] = wrapped(w[COURSE] - u[HEADING])
    most = q[MAX_TURN_RATE]
    turn = min(max(rate + q[TURNING] * w[HEADING_ERROR], -most), most)
    return q[YAW_GAIN] * (turn - u[YAW_RATE]) + q[YAW_DAMPING] * turn
