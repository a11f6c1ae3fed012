"""Local error of a sub-step's positions."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable.dynamics import soften
from components.tether.cable.line import ACC, FREE, SCRATCH, STATE, Q, R, V, first_unknown, last_unknown


@kernel
def largest(w, first, last):
    """Largest length of the vectors in the nodes' R."""
    worst = 0.0
    for i in range(first, last + 1):
        b = i * SCRATCH + R
        worst = max(worst, w[b] * w[b] + w[b + 1] * w[b + 1] + w[b + 2] * w[b + 2])
    return sqrt(worst)


@kernel
def end_error(line, s, w, old, start):
    """How far [m] a held end is from where accelerations that change evenly between both instants would take it.

    Of the velocity times the step, too. An end that is jerked within the step shows in no other node's acceleration.
    """
    worst = 0.0
    for i in range(0, line.n + 1, line.n):
        if (line.end_a if i == 0 else line.end_b) == FREE:
            continue
        away, late = 0.0, 0.0
        for c in range(3):
            b, o = i * SCRATCH + c, start + i * STATE + c
            a0, a1 = old[o + ACC], w[b + ACC]
            d = w[b + Q] - old[o + Q] - s.h * (old[o + V] + s.h * (a0 / 3.0 + a1 / 6.0))
            e = s.h * (w[b + V] - old[o + V] - 0.5 * s.h * (a0 + a1))
            away += d * d
            late += e * e
        worst = max(worst, away, late)
    return sqrt(worst)


@kernel
def position_error(line, s, w, old, start):
    """Largest local error of a node's position [m] by the scheme's formula; old[start:]: where the sub-step began."""
    worst = 0.0
    for i in range(first_unknown(line), last_unknown(line) + 1):
        b, o = i * SCRATCH + ACC, start + i * STATE + ACC
        dx, dy, dz = w[b] - old[o], w[b + 1] - old[o + 1], w[b + 2] - old[o + 2]
        worst = max(worst, dx * dx + dy * dy + dz * dz)
    return s.error * sqrt(worst)


@kernel
def smooth_error(line, s, w, old, start):
    """The same without what stiffness holds back; uses up the matrix that was assembled last in w."""
    first, last = first_unknown(line), last_unknown(line)
    for i in range(first, last + 1):
        b, o = i * SCRATCH, start + i * STATE + ACC
        for c in range(3):
            w[b + R + c] = s.error * (w[b + ACC + c] - old[o + c])
    soften(line, s, w, first, last)
    return largest(w, first, last)
