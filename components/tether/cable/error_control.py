"""Local error of a sub-step's positions."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable import block_tridiagonal
from components.tether.cable.line import ACC, FREE, SCRATCH, STATE, R, first_unknown, last_unknown


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
    """The same without what stiffness holds back: the error as a load on the nodes' inertia in the Newton matrix.

    Axial waves shorter than the step change a node's acceleration much, its position hardly. Hairer and Wanner 1996,
    Solving ODEs II, eq. IV.8.20, filter by the matrix in the same way. Needs the matrix of the balance that was
    assembled last in w, and uses it up.
    """
    first, last = first_unknown(line), last_unknown(line)
    for i in range(first, last + 1):
        halves = 1.0 if (i == 0 and line.end_a == FREE) or (i == line.n and line.end_b == FREE) else 2.0
        scale = s.c_m * halves * (line.mass + line.added_n) * s.error
        b, o = i * SCRATCH, start + i * STATE + ACC
        for c in range(3):
            w[b + R + c] = scale * (w[b + ACC + c] - old[o + c])
    block_tridiagonal.solve(w, first, last)
    return largest(w, first, last)
