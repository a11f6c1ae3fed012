"""The static balance in a current by Newton's full matrix: drag that turns with the line makes it unsymmetric.

Where drag outweighs the weight its turning is not small beside the other stiffness, and leaving it out would not
converge. In time, over a step, it is; this matrix is for the static start alone. Row 3 i + a of the full band has its
diagonal in the middle.
"""

from math import sqrt

from components.compiled import kernel
from components.tether.cable import banded
from components.tether.cable.drag import STILL
from components.tether.cable.line import DIR, FULL, SCRATCH, WATER, D, E, Q
from components.tether.cable.part import part

HALF = 8  # entries beside the diagonal, as many as bending needs
WIDE = 2 * HALF + 1


@kernel
def at(line, row, column):
    """Place in w of an entry of the full band."""
    return line.full + WIDE * row + HALF + column - row


@kernel
def gather(line, w):
    """Fill the full band with the symmetric blocks, bending's among them."""
    for k in range(line.full, line.full + FULL * (line.n + 1)):
        w[k] = 0.0
    for i in range(line.n + 1):
        for r in range(3):
            for c in range(3):
                place = banded.place_of(r, c)
                w[at(line, 3 * i + r, 3 * i + c)] += w[i * SCRATCH + D + place]
                if i < line.n:
                    e = w[i * SCRATCH + E + place]
                    w[at(line, 3 * i + r, 3 * i + 3 + c)] += e
                    w[at(line, 3 * i + 3 + c, 3 * i + r)] += e
    if line.band:
        for row in range(3 * (line.n + 1)):
            for o in range(min(banded.WIDTH, 3 * (line.n + 1) - row)):
                value = w[line.band + banded.WIDTH * row + o]
                w[at(line, row, row + o)] += value
                if o > 0:
                    w[at(line, row + o, row)] += value


@kernel
def turn(line, w):
    """Add to the full band how drag at rest in the current turns with the tangents."""
    for i in range(line.n):
        b, s = i * SCRATCH, part(line, i)
        tx, ty, tz = w[b + DIR], w[b + DIR + 1], w[b + DIR + 2]
        along = 0.0
        for c in range(3):
            along += w[b + DIR + c] * (w[b + SCRATCH + Q + c] - w[b + Q + c])
        for j in range(2):
            k, g = line.water + WATER * (i + j), 1.0 / max(along, 0.1 * s.l0)
            spread(line, w, 3 * i, 3 * (i + j), s, tx, ty, tz, -w[k], -w[k + 1], -w[k + 2], g)


@kernel
def spread(line, w, column, row, s, tx, ty, tz, vx, vy, vz, g):
    """Add -df/dq of the drag f on one half of the segment s, at velocity v through the water; g: 1 / length.

    df = G dt with G = c_n (|v_n| (t v_n' + v_t I) + v_t v_n v_n' / |v_n|) - c_t |v_t| (2 t v_n' + v_t I) and
    dt = (I - t t') (dq_1 - dq_0) / length.
    """
    vt = vx * tx + vy * ty + vz * tz
    nx, ny, nz = vx - vt * tx, vy - vt * ty, vz - vt * tz
    speed = sqrt(nx * nx + ny * ny + nz * nz + STILL)
    a = s.drag_n * speed - 2.0 * s.drag_t * abs(vt)
    b, c = s.drag_n * vt / speed, (s.drag_n * speed - s.drag_t * abs(vt)) * vt
    for r in range(3):
        t = tx if r == 0 else ty if r == 1 else tz
        n = nx if r == 0 else ny if r == 1 else nz
        for k in range(3):
            tk = tx if k == 0 else ty if k == 1 else tz
            nk = nx if k == 0 else ny if k == 1 else nz
            value = g * (a * t * nk + b * n * nk + c * ((1.0 if r == k else 0.0) - t * tk))
            w[at(line, row + r, column + k)] += value
            w[at(line, row + r, column + 3 + k)] -= value


@kernel
def solve(line, w, first, last):
    """Overwrite R of the nodes first..last by the solution, by L U without exchange of rows."""
    gather(line, w)
    turn(line, w)
    begin, end = 3 * first, 3 * (last + 1)
    for row in range(begin, end):
        inverse = 1.0 / w[at(line, row, row)]
        for below in range(row + 1, min(row + HALF + 1, end)):
            f = w[at(line, below, row)] * inverse
            for column in range(row + 1, min(row + HALF + 1, end)):
                w[at(line, below, column)] -= f * w[at(line, row, column)]
            w[banded.right(below)] -= f * w[banded.right(row)]
    for row in range(end - 1, begin - 1, -1):
        rest = w[banded.right(row)]
        for column in range(row + 1, min(row + HALF + 1, end)):
            rest -= w[at(line, row, column)] * w[banded.right(column)]
        w[banded.right(row)] = rest / w[at(line, row, row)]
