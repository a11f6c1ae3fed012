"""Writes an allocation's outputs in SI: commands, what they achieve, and which limits were active."""

from math import sqrt

from components.allocator.exact.model import COUNT, FORCE, LEVER, POWER
from components.allocator.exact.reach import lies_in
from components.allocator.exact.response import (
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    LINE,
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
    """y up to its four flags, from the state x; best_f (n, 2): the optimum without limits of rate."""
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
