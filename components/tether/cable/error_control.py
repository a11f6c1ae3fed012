"""Local error of a sub-step's positions."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable.dynamics import soften
from components.tether.cable.line import ACC, SCRATCH, STATE, R, first_unknown, last_unknown


@kernel
def largest(w, first, last):
    """Largest length of the vectors in the nodes' R."""
    worst = 0.0
    for i in range(first, last + 1):
        b = i * SCRATCH + R
        worst = max(worst, w[b] * w[b] + w[b + 1] * w[b + 1] + w[b + 2] * w[b + 2])
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
