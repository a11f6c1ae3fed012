"""What a thruster can reach within a step, from where it is: its turn and its change of thrust are limited.

The reachable forces are made convex, so that the optimum over them is exact: thrust may fall to what its rate allows
measured along the direction it has. A thruster whose target lies behind a forbidden zone lets its thrust fall to zero,
turns through, and is given thrust again behind it. One that can come to a direction a right angle or more away within
a step keeps the limit on growing thrust only.
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
def own_piece(pieces, first, i, azimuth, thrust):
    """The piece that thruster i works in: of those with the azimuth the one that gives most, else the first."""
    found, most = int(first[i]), -1.0
    for j in range(int(first[i]), int(first[i + 1])):
        if pieces[j, KIND] == LINE and (thrust < 0.0 or first[i + 1] - first[i] == 1.0):
            return j
        if lies_in(pieces, j, azimuth) and pieces[j, MOST] > most:
            found, most = j, pieces[j, MOST]
    return found


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
def kept(pieces, whole, first, i, j, most):
    """Part of a largest thrust that is left in piece j of thruster i; most: the column of it.

    whole: the pieces without losses. What turns loses against its best sector, too.
    """
    best = whole[j, most]
    if whole[j, KIND] != LINE:
        for other in range(int(first[i]), int(first[i + 1])):
            best = max(best, whole[other, MOST])
    return pieces[j, most] / best if best > 0.0 else 1.0


@kernel
def note_factors(pieces, whole, first, x, factors):
    """Note what part of its thrust each thruster keeps at the command just taken; factors: (n,)."""
    n = factors.shape[0]
    for i in range(n):
        j = own_piece(pieces, first, i, x[2 * n + i], x[3 * n + i])
        factors[i] = kept(pieces, whole, first, i, j, MOST_REVERSE if x[3 * n + i] < 0.0 else MOST)


@kernel
def astern(pieces, first, i):
    """The piece in which thruster i, that turns its force too, goes backwards; NONE if it does not."""
    j = int(first[i + 1]) - 1
    return j if j > int(first[i]) and pieces[j, KIND] == LINE else NONE


@kernel
def reach_along(sets, i, pieces, whole, first, j, thrust, change):
    """Row i becomes the part of the LINE j within `change` of a signed thrust."""
    for c in range(SET):
        sets[i, c] = pieces[j, c]
    ahead, back = kept(pieces, whole, first, i, j, MOST), kept(pieces, whole, first, i, j, MOST_REVERSE)
    high, low = thrust + change, change - thrust
    sets[i, MOST] = min(pieces[j, MOST], high * (ahead if high > 0.0 else back))
    sets[i, MOST_REVERSE] = min(pieces[j, MOST_REVERSE], low * (back if low > 0.0 else ahead))


@kernel
def is_slim(sets, i):
    """Whether both edges of row i's sector are within a right angle of the direction that the thruster has."""
    left = sets[i, E1X] * sets[i, E0X] + sets[i, E1Y] * sets[i, E0Y]
    right = sets[i, E2X] * sets[i, E0X] + sets[i, E2Y] * sets[i, E0Y]
    return sets[i, KIND] == SECTOR and left > 1e-9 and right > 1e-9


@kernel
def reach(sets, i, pieces, whole, first, azimuth, thrust, target, turn, change):
    """Row i becomes what is reached from `thrust` at `azimuth` by turning by `turn` [rad] and changing by `change`.

    thrust: signed; like `change` without the losses that part pieces from `whole`, so that these are limits of the
    shaft: what water, a wake or a sector takes is no step of it. target: the azimuth wanted.
    """
    j, back = int(first[i]), astern(pieces, first, i)
    if pieces[j, KIND] == LINE:
        reach_along(sets, i, pieces, whole, first, j, thrust, change)
        return
    wants_back = back != NONE and cos(target) * pieces[back, E1X] + sin(target) * pieces[back, E1Y] < 0.0
    if thrust < -NO_THRUST or (wants_back and thrust <= NO_THRUST):
        reach_along(sets, i, pieces, whole, first, back, thrust, change)
        return
    j, has_target = home(pieces, first, i, azimuth, target)
    if j == NONE or (not has_target and thrust <= NO_THRUST):
        sets[i, KIND] = NOTHING
        return
    narrow(sets, i, pieces, j, azimuth, turn)
    part = kept(pieces, whole, first, i, j, MOST)
    least = max(thrust - change, 0.0) * part
    sets[i, MOST] = min(pieces[j, MOST], (thrust + change) * part if has_target else least)
    least = min(least, sets[i, MOST])
    if least > 0.0 and is_slim(sets, i):
        sets[i, KIND], sets[i, LEAST] = SLICE, least


@kernel
def settle(azimuth, fx, fy, target, wanted, turn):
    """The azimuth commanded: the force's; without force towards the target, where thrust is wanted there."""
    if fx * fx + fy * fy > NO_THRUST * NO_THRUST:
        return azimuth + difference(atan2(fy, fx), azimuth)
    return turned(azimuth, target, turn) if wanted > NO_THRUST else azimuth


@kernel
def midships(pieces, back, ahead, azimuth, thrust):
    """The azimuth commanded of a propeller with a rudder that gives no thrust ahead: midships, or as it is at rest."""
    if thrust == 0.0 and lies_in(pieces, ahead, azimuth):
        return azimuth
    return atan2(pieces[back, E1Y], pieces[back, E1X])
