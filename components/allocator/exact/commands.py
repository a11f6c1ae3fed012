"""Writes an allocation's outputs in SI: commands, what they achieve, and which limits were active."""

from math import cos, sin, sqrt

from components.allocator.exact.losses import STOPS, past, still
from components.allocator.exact.model import BOARDS, COUNT, DEMAND, FLAGS, FORCE, LEVER, POWER
from components.allocator.exact.reach import lies_in, own_piece
from components.allocator.exact.response import (
    BOARD,
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    MOST,
    MOST_REVERSE,
    SECTOR,
    X,
    Y,
    coefficient,
)
from components.compiled import kernel

NEAR = 1e-9  # of the sum of largest thrusts


@kernel
def is_edge(pieces, first, i, fx, fy):
    """Whether the force lies on an edge of thruster i's pieces and inside none."""
    T, is_on = sqrt(fx * fx + fy * fy), False
    for j in range(int(first[i]), int(first[i + 1])):
        if pieces[j, KIND] != SECTOR or T <= NEAR:
            return False
        left = (pieces[j, E1X] * fy - pieces[j, E1Y] * fx) / T
        right = (fx * pieces[j, E2Y] - fy * pieces[j, E2X]) / T
        if left > NEAR and right > NEAR:
            return False
        is_on = is_on or (left >= -NEAR and right >= -NEAR)
    return is_on


@kernel
def write_commands(q, pieces, first, x, y, best_f):
    """y up to the limits of rate, from the state x; best_f (n, 2): the optimum without limits of rate."""
    n, F, L = int(q[COUNT]), q[FORCE], q[LEVER]
    total_x = total_y = moment = 0.0
    for i in range(n):
        fx, fy, thrust = x[2 * i], x[2 * i + 1], x[3 * n + i]
        j = own_piece(pieces, first, i, x[2 * n + i], thrust)
        most = pieces[j, MOST_REVERSE] if thrust < 0.0 else pieces[j, MOST]
        y[i], y[n + i] = F * thrust, x[2 * n + i]
        y[2 * n + i] = q[POWER] * coefficient(pieces, j, fx, fy) * abs(thrust) * sqrt(abs(thrust))
        total_x += fx
        total_y += fy
        moment += pieces[j, X] * fy - pieces[j, Y] * fx
        at = 3 * n + 3 + i
        is_out = pieces[j, KIND] == SECTOR and not lies_in(pieces, j, x[2 * n + i])
        y[at] = 1.0 if abs(thrust) >= most - NEAR and most > 0.0 else 0.0
        y[at + n] = 1.0 if is_out or is_edge(pieces, first, i, fx, fy) else 0.0
        gone = abs(fx - best_f[i, 0]) + abs(fy - best_f[i, 1])
        y[at + 2 * n] = 1.0 if gone > 1e3 * NEAR else 0.0
    y[3 * n], y[3 * n + 1], y[3 * n + 2] = F * total_x, F * total_y, F * L * moment


@kernel
def write_still(q, pieces, first, losing, water, wakes, x, y):
    """What the shafts would give in still and open water; pieces: without the losses, wakes (n,)."""
    n = int(q[COUNT])
    for i in range(n):
        thrust, azimuth = x[3 * n + i], x[2 * n + i]
        j = own_piece(pieces, first, i, azimuth, thrust)
        most = pieces[j, MOST_REVERSE] if thrust < 0.0 else pieces[j, MOST]
        sign = -1.0 if thrust < 0.0 else 1.0
        speed = past(water, pieces[j, X], pieces[j, Y], sign * cos(azimuth), sign * sin(azimuth))
        is_idle = thrust == 0.0 or most == 0.0
        shaft = 0.0 if is_idle else still(abs(thrust) / wakes[i], most, speed, losing[i, STOPS])
        y[6 * n + 3 + i] = sign * q[FORCE] * shaft


@kernel
def write_boards(q, pieces, first, u, y):
    """What the boards give, from the thrusters' powers in y, and whether that is all they have."""
    n, count = int(q[COUNT]), int(q[BOARDS])
    at = y.shape[0] - FLAGS - 2 * count
    for b in range(count):
        power = 0.0
        for i in range(n):
            if pieces[int(first[i]), BOARD] == b:
                power += y[2 * n + i]
        y[at + b] = power
        y[at + count + b] = 1.0 if power >= u[DEMAND + b] - NEAR * q[POWER] else 0.0
