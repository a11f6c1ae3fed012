"""What a thruster can reach within a step, from where it is: its turn and its change of thrust are limited.

The reachable forces are made convex, so that the optimum over them is exact: thrust may fall to what its rate allows
measured along the direction it has. A thruster whose target lies behind a forbidden zone lets its thrust fall to zero,
turns through, and is given thrust again behind it. One that can turn by a right angle or more within a step keeps the
limit on growing thrust only.
"""

from math import atan2, cos, pi, sin

from components.allocator.exact.response import (
    DISC,
    E0X,
    E0Y,
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    LEAST,
    LINE,
    MOST,
    MOST_REVERSE,
    NOTHING,
    SECTOR,
    SET,
    SLICE,
)
from components.compiled import kernel

NO_THRUST = 1e-9  # of the sum of largest thrusts: below it a thruster may turn through a forbidden zone
NONE = -1


@kernel
def difference(a, b):
    """The angle from b to a, in [-pi, pi) [rad]."""
    return (a - b + pi) % (2.0 * pi) - pi


@kernel
def turned(azimuth, target, turn):
    """The azimuth after turning towards the target by at most `turn`."""
    return azimuth + min(max(difference(target, azimuth), -turn), turn)


@kernel
def lies_in(pieces, j, azimuth):
    """Whether piece j has the azimuth."""
    if pieces[j, KIND] != SECTOR:
        return pieces[j, KIND] == DISC
    x, y = cos(azimuth), sin(azimuth)
    rounding = 1e-9  # edges are given by a sine and a cosine
    is_left = pieces[j, E1X] * y - pieces[j, E1Y] * x >= -rounding
    return is_left and x * pieces[j, E2Y] - y * pieces[j, E2X] >= -rounding


@kernel
def home(pieces, first, i, azimuth, target):
    """The piece with the azimuth, and the target if one has both; (piece or NONE, whether it has the target)."""
    found = NONE
    for j in range(int(first[i]), int(first[i + 1])):
        if lies_in(pieces, j, azimuth):
            if lies_in(pieces, j, target):
                return j, True
            found = j
    return found, False


@kernel
def narrow(sets, i, pieces, j, azimuth, turn):
    """Row i becomes the part of piece j within `turn` of the azimuth, which lies in it."""
    for c in range(SET):
        sets[i, c] = pieces[j, c]
    sets[i, E0X], sets[i, E0Y], sets[i, LEAST] = cos(azimuth), sin(azimuth), 0.0
    if turn >= 0.5 * pi:
        return
    sets[i, KIND] = SECTOR
    low, high = azimuth - turn, azimuth + turn
    is_whole = pieces[j, KIND] == DISC
    if is_whole or lies_in(pieces, j, low):
        sets[i, E1X], sets[i, E1Y] = cos(low), sin(low)
    if is_whole or lies_in(pieces, j, high):
        sets[i, E2X], sets[i, E2Y] = cos(high), sin(high)


@kernel
def reach(sets, i, pieces, first, azimuth, thrust, target, turn, change):
    """Row i becomes what is reached from `thrust` at `azimuth` by turning by `turn` [rad] and changing by `change`.

    target: the azimuth wanted. thrust: signed, for what cannot turn.
    """
    j = int(first[i])
    if pieces[j, KIND] == LINE:
        for c in range(SET):
            sets[i, c] = pieces[j, c]
        sets[i, MOST] = min(pieces[j, MOST], thrust + change)
        sets[i, MOST_REVERSE] = min(pieces[j, MOST_REVERSE], change - thrust)
        return
    j, has_target = home(pieces, first, i, azimuth, target)
    if j == NONE or (not has_target and thrust <= NO_THRUST):
        sets[i, KIND] = NOTHING
        return
    narrow(sets, i, pieces, j, azimuth, turn)
    least = max(thrust - change, 0.0)
    sets[i, MOST] = min(pieces[j, MOST], thrust + change if has_target else max(least, 0.0))
    least = min(least, sets[i, MOST])
    if turn < 0.5 * pi and least > 0.0:
        sets[i, KIND], sets[i, LEAST] = SLICE, least


@kernel
def settle(azimuth, fx, fy, target, wanted, turn):
    """The azimuth commanded: the force's; without force towards the target, where thrust is wanted there."""
    if fx * fx + fy * fy > NO_THRUST * NO_THRUST:
        return azimuth + difference(atan2(fy, fx), azimuth)
    return turned(azimuth, target, turn) if wanted > NO_THRUST else azimuth
