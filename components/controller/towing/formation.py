"""Where the boats are along their common path, and how fast each should go so that they are abeam."""

from math import isfinite, sqrt

from components.compiled import kernel
from components.controller.path import BEFORE, CURVATURE, PIECE, beside, goes_on
from components.controller.towing.layout import (
    COUNT,
    GAP,
    GATHERING,
    IS_ALONE,
    IS_CLOSED,
    MAX_ACCELERATION,
    MAX_SPEED,
    OFFSET,
    OTHERS,
    OWN,
    PARTNER,
    PIECES,
    PLACE,
    PROGRESS,
    ROUNDS,
    SPEED,
    TAKES_PARTNER,
    WAY,
)


@kernel
def locate(q, u, x, w):
    """Note the pieces, the way made and the way ahead of the partner; where it is not known, it stays as it was."""
    count, is_closed = int(q[COUNT]), q[IS_CLOSED] > 0.0
    own, rounds = goes_on(q[PIECES:], count, is_closed, int(x[OWN]), u[PLACE], u[PLACE + 1])
    x[OWN], x[ROUNDS] = own, x[ROUNDS] + rounds
    k = q[PIECES + PIECE * own : PIECES + PIECE * (own + 1)]
    way = k[BEFORE] + beside(k, u[PLACE], u[PLACE + 1])[0]
    w[PROGRESS] = way + x[ROUNDS] * q[WAY]
    w[IS_ALONE] = 0.0
    if q[TAKES_PARTNER] == 0.0:
        return
    north, east = u[OTHERS], u[OTHERS + 1]
    if not (isfinite(north) and isfinite(east)):
        w[IS_ALONE] = 1.0
        return
    partner, _ = goes_on(q[PIECES:], count, is_closed, int(x[PARTNER]), north, east)
    x[PARTNER] = partner
    k = q[PIECES + PIECE * partner : PIECES + PIECE * (partner + 1)]
    gap = way - k[BEFORE] - beside(k, north, east)[0]
    if is_closed:
        gap -= q[WAY] * round(gap / q[WAY])
    x[GAP] = gap


@kernel
def pace(q, x, progress):
    """The speed [m/s] that the boat should make along its own side of the path.

    Straight-line formations by path following and coordination along the path, without a leader: Borhaug, Pavlov,
    Panteley, Pettersen 2011, IEEE Transactions on Control Systems Technology 19(3), 493-506, whose saturated function
    of the gap is here min and max; on an arc the outer boat is faster by 1 - curvature * offset. A boat that is far
    ahead waits. Before the end of an open path it brakes with half of the largest acceleration.
    """
    most = q[MAX_SPEED]
    along = min(max(q[SPEED] - q[GATHERING] * x[GAP], 0.0), most)
    if q[IS_CLOSED] == 0.0:
        along = min(along, sqrt(q[MAX_ACCELERATION] * max(q[WAY] - progress, 0.0)))
    curvature = q[PIECES + PIECE * int(x[OWN]) + CURVATURE]
    return min(along * max(1.0 - curvature * q[OFFSET], 0.0), most)
