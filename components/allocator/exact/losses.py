"""Losses of thrust that depend on where thrusters point: the water's motion past them and their neighbours' wakes.

Each piece of a thruster gets one factor, taken at the last azimuths, so that a step's problem keeps its convex pieces
and its optimum is exact. A thruster's own factor is taken at its azimuth, or at the edge nearest to it of a piece that
does not have it; those of the wakes at the azimuths of the thrusters upstream.

Water: at full shaft speed, of thrust 1 - V / V_0 and of power 1 - V / V_Q, V being the speed of the water against the
thrust, V_0 and V_Q those at which thrust and torque vanish (K_T and K_Q straight; Fossen 2011, eqs. 9.2 to 9.7;
thrusters.propulsion has the same law). At part speed the loss is greater, and is left to `still`.
Wakes: of thrusters behind one another under a flat bottom t = 1 - 0.75^((x / D)^(2/3)), x being their distance, D the
diameter upstream (Lehn 1980; ABS, Guide for Dynamic Positioning Systems), and with the jet turned away by phi degrees
t + (1 - t) phi^3 / (130 / t^3 + phi^3) (Dang and Laheij 2004, Hydrodynamic aspects of steerable thrusters, MTS Dynamic
Positioning Conference; the 130 quoted from memory), t being 0.05 at least. Wakes of
several multiply, and grow and fade over `wake_time`.
"""

from math import atan2, cos, exp, pi, sin, sqrt

from components.allocator.exact.reach import NO_THRUST, difference, lies_in
from components.allocator.exact.response import (
    A_REVERSE,
    DISC,
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    LINE,
    MOST,
    MOST_REVERSE,
    NOTHING,
    SECTOR,
    SET,
    A,
    X,
    Y,
)
from components.compiled import kernel

# Columns of a table of what makes losses, in units of the model: 1 / V_0, 1 / V_Q [s/m], diameter [of the lever].
STOPS, STALLS, DIAMETER, LOSING = range(4)
SLOWEST = 0.9  # part of V_0 beyond which the straight K_T is not followed


@kernel
def past(water, x, y, ex, ey):
    """Speed [m/s] of the water against a thrust along e at (x, y).

    water: (3,) velocity of the hull through it, and yaw rate times the unit of x and y.
    """
    return (water[0] - y * water[2]) * ex + (water[1] + x * water[2]) * ey


@kernel
def in_water(speed, losing, i):
    """Factors of thrust and power at full shaft speed in water that comes against the thrust at a speed [m/s]."""
    part = min(max(speed * losing[i, STOPS], 0.0), SLOWEST)
    return 1.0 - part, 1.0 - part * losing[i, STALLS] / losing[i, STOPS] if losing[i, STOPS] > 0.0 else 1.0


@kernel
def in_wakes(pieces, first, losing, x, i):
    """Factor of thrust of thruster i in the jets of the others as they are; x: the state."""
    n, factor, mine = losing.shape[0], 1.0, int(first[i])
    for j in range(n):
        fx, fy, its = x[2 * j], x[2 * j + 1], int(first[j])
        if j == i or losing[j, DIAMETER] == 0.0 or fx * fx + fy * fy <= NO_THRUST * NO_THRUST:
            continue
        dx, dy = pieces[mine, X] - pieces[its, X], pieces[mine, Y] - pieces[its, Y]
        distance = sqrt(dx * dx + dy * dy)
        turned = abs(difference(atan2(-fy, -fx), atan2(dy, dx))) * 180.0 / pi
        factor *= behind(distance / losing[j, DIAMETER], turned)
    return factor


@kernel
def behind(distance, turned):
    """Thrust over that in open water, `distance` diameters from a thruster whose jet points `turned` degrees past."""
    t = max(1.0 - 0.75 ** (distance ** (2.0 / 3.0)), 0.05)
    cube = turned * turned * turned
    return t + (1.0 - t) * cube / (130.0 / (t * t * t) + cube)


@kernel
def nearest_way(pieces, j, azimuth):
    """The direction in piece j that is nearest to an azimuth."""
    if pieces[j, KIND] == LINE:
        return pieces[j, E1X], pieces[j, E1Y]
    ex, ey = cos(azimuth), sin(azimuth)
    if pieces[j, KIND] != SECTOR or lies_in(pieces, j, azimuth):
        return ex, ey
    e1x, e1y, e2x, e2y = pieces[j, E1X], pieces[j, E1Y], pieces[j, E2X], pieces[j, E2Y]
    return (e1x, e1y) if e1x * ex + e1y * ey >= e2x * ex + e2y * ey else (e2x, e2y)


@kernel
def lose(covers, pieces, first, losing, water, x, wakes, own_covers, own_pieces, part):
    """Fill own_covers and own_pieces with covers and pieces less the losses at the state x.

    wakes: (n,) factors of the wakes, which are taken along; part: the step over the time in which they grow.
    """
    n = covers.shape[0]
    for i in range(n):
        wakes[i] += (in_wakes(pieces, first, losing, x, i) - wakes[i]) * (1.0 - exp(-part))
        a, b = int(first[i]), int(first[i + 1])
        for j in range(a, b):
            for c in range(SET):
                own_pieces[j, c] = pieces[j, c]
            ex, ey = nearest_way(pieces, j, x[2 * n + i])
            speed = past(water, pieces[j, X], pieces[j, Y], ex, ey)
            thrust, power = in_water(speed, losing, i)
            scale(own_pieces, j, MOST, A, wakes[i] * thrust, power)
            thrust, power = in_water(-speed, losing, i)
            scale(own_pieces, j, MOST_REVERSE, A_REVERSE, wakes[i] * thrust, power)
        for c in range(SET):
            own_covers[i, c] = own_pieces[a, c] if b - a == 1 else covers[i, c]
        if b - a > 1 and covers[i, KIND] != NOTHING:
            widen(own_covers, i, own_pieces, a, b)


@kernel
def scale(rows, j, most, a, thrust, power):
    """Take from a row's largest thrust and power these parts."""
    rows[j, most] *= thrust
    rows[j, a] *= power / (thrust * sqrt(thrust))


@kernel
def widen(covers, i, pieces, a, b):
    """Make row i the disc that covers pieces a to b at a power that is nowhere above theirs."""
    covers[i, KIND], covers[i, MOST], covers[i, A] = DISC, 0.0, pieces[a, A]
    for j in range(a, b):
        covers[i, MOST] = max(covers[i, MOST], pieces[j, MOST], pieces[j, MOST_REVERSE])
        covers[i, A] = min(covers[i, A], pieces[j, A], pieces[j, A_REVERSE])


@kernel
def still(thrust, most, speed, stops):
    """The thrust in still water at the shaft speed that gives `thrust` in water that comes against it at a speed.

    most: that of full shaft speed in still water; n^2 - n V / V_0 = thrust / most, n in full speeds.
    """
    half = 0.5 * speed * stops
    n = half + sqrt(half * half + thrust / most)
    return min(n * n, 1.0) * most
