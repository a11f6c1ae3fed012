"""Symmetric block-tridiagonal systems with symmetric 3x3 blocks, by block elimination with LDL' in scalars."""

from components.compiled import kernel
from components.tether.cable.line import SCRATCH, D, E, R


@kernel
def factor(xx, yy, zz, xy, xz, yz):
    """L and D^-1 of the symmetric 3x3 block: l21, l31, l32, 1/d1, 1/d2, 1/d3.

    The cofactor formula would lose the square of the block's condition number, which a stiff line makes 1e6.
    """
    i1 = 1.0 / xx
    l21, l31 = xy * i1, xz * i1
    i2 = 1.0 / (yy - l21 * xy)
    c32 = yz - l31 * xy
    l32 = c32 * i2
    i3 = 1.0 / (zz - l31 * xz - l32 * c32)
    return l21, l31, l32, i1, i2, i3


@kernel
def backsolve(l21, l31, l32, i1, i2, i3, bx, by, bz):
    """Solution of L D L' x = b."""
    by = by - l21 * bx
    bz = (bz - l31 * bx - l32 * by) * i3
    by = by * i2 - l32 * bz
    return bx * i1 - l21 * by - l31 * bz, by, bz


@kernel
def eliminate(w, start, count, direction):
    """Eliminate `count` nodes from `start` on towards the neighbour in `direction` (+1 or -1).

    Afterwards an eliminated node holds D^-1 R in its R, and the block D^-1 E stands in the E of its segment. The
    diagonal block and the right-hand side of the first node not eliminated become the Schur complement's.
    """
    for step in range(count):
        i = start + step * direction
        b = i * SCRATCH
        e = b if direction > 0 else b - SCRATCH
        to = b + direction * SCRATCH
        l21, l31, l32, i1, i2, i3 = factor(
            w[b + D], w[b + D + 1], w[b + D + 2], w[b + D + 3], w[b + D + 4], w[b + D + 5]
        )
        exx, eyy, ezz, exy, exz, eyz = w[e + E], w[e + E + 1], w[e + E + 2], w[e + E + 3], w[e + E + 4], w[e + E + 5]
        rx, ry, rz = backsolve(l21, l31, l32, i1, i2, i3, w[b + R], w[b + R + 1], w[b + R + 2])
        g11, g21, g31 = backsolve(l21, l31, l32, i1, i2, i3, exx, exy, exz)
        g12, g22, g32 = backsolve(l21, l31, l32, i1, i2, i3, exy, eyy, eyz)
        g13, g23, g33 = backsolve(l21, l31, l32, i1, i2, i3, exz, eyz, ezz)
        w[b + R], w[b + R + 1], w[b + R + 2] = rx, ry, rz
        w[to + R] -= exx * rx + exy * ry + exz * rz
        w[to + R + 1] -= exy * rx + eyy * ry + eyz * rz
        w[to + R + 2] -= exz * rx + eyz * ry + ezz * rz
        w[to + D] -= exx * g11 + exy * g21 + exz * g31
        w[to + D + 1] -= exy * g12 + eyy * g22 + eyz * g32
        w[to + D + 2] -= exz * g13 + eyz * g23 + ezz * g33
        w[to + D + 3] -= exx * g12 + exy * g22 + exz * g32
        w[to + D + 4] -= exx * g13 + exy * g23 + exz * g33
        w[to + D + 5] -= exy * g13 + eyy * g23 + eyz * g33
        w[e + E], w[e + E + 1], w[e + E + 2] = g11, g12, g13
        w[e + E + 3], w[e + E + 4], w[e + E + 5] = g21, g22, g23
        w[e + E + 6], w[e + E + 7], w[e + E + 8] = g31, g32, g33


@kernel
def solve(w, first, last):
    """Overwrite R of the nodes first..last by the solution; the neighbours outside keep their place (zero)."""
    eliminate(w, first, last - first, 1)
    b = last * SCRATCH
    l21, l31, l32, i1, i2, i3 = factor(w[b + D], w[b + D + 1], w[b + D + 2], w[b + D + 3], w[b + D + 4], w[b + D + 5])
    x, y, z = backsolve(l21, l31, l32, i1, i2, i3, w[b + R], w[b + R + 1], w[b + R + 2])
    w[b + R], w[b + R + 1], w[b + R + 2] = x, y, z
    for i in range(last - 1, first - 1, -1):
        b = i * SCRATCH
        g = b + E
        x, y, z = (
            w[b + R] - w[g] * x - w[g + 1] * y - w[g + 2] * z,
            w[b + R + 1] - w[g + 3] * x - w[g + 4] * y - w[g + 5] * z,
            w[b + R + 2] - w[g + 6] * x - w[g + 7] * y - w[g + 8] * z,
        )
        w[b + R], w[b + R + 1], w[b + R + 2] = x, y, z
