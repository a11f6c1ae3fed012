"""The line's balance with bending, whose nodes know the second next ones too: a symmetric band, by LDL'.

Row 3 i + a of the band holds the entries of the upper triangle from the diagonal on, nine of them.
"""

from components.compiled import kernel
from components.tether.cable.line import BAND, SCRATCH, D, E, R, first_unknown, last_unknown

WIDTH = 9


@kernel
def place_of(r, c):
    """Where the entry (r, c) of a symmetric block stands in xx, yy, zz, xy, xz, yz."""
    return r if r == c else r + c + 2


@kernel
def gather(line, w):
    """Add the blocks D and E of all nodes to the band that bending has written."""
    for i in range(line.n + 1):
        b, k = i * SCRATCH, line.band + BAND * i
        for r in range(3):
            for c in range(3):
                if c >= r:
                    w[k + WIDTH * r + c - r] += w[b + D + place_of(r, c)]
                if i < line.n:
                    w[k + WIDTH * r + 3 + c - r] += w[b + E + place_of(r, c)]


@kernel
def factor(line, w, first, last):
    """L D L' of the rows of the nodes first..last in place: D on the diagonal, D L' beside it."""
    end = 3 * (last + 1)
    for row in range(3 * first, end):
        k = line.band + WIDTH * row
        inverse = 1.0 / w[k]
        for o in range(1, min(WIDTH, end - row)):
            f = w[k + o] * inverse
            to = k + WIDTH * o
            for c in range(o, min(WIDTH, end - row)):
                w[to + c - o] -= f * w[k + c]


@kernel
def substitute(line, w, first, last):
    """Overwrite R of the nodes first..last by the solution, after factor."""
    end = 3 * (last + 1)
    for row in range(3 * first, end):
        k = line.band + WIDTH * row
        f = w[right(row)] / w[k]
        for o in range(1, min(WIDTH, end - row)):
            w[right(row + o)] -= f * w[k + o]
    for row in range(end - 1, 3 * first - 1, -1):
        k = line.band + WIDTH * row
        rest = w[right(row)]
        for o in range(1, min(WIDTH, end - row)):
            rest -= w[k + o] * w[right(row + o)]
        w[right(row)] = rest / w[k]


@kernel
def right(row):
    """Where the right-hand side of a row stands in w."""
    return row // 3 * SCRATCH + R + row % 3


@kernel
def entry(line, w, i, j, r, c):
    """The entry (r, c) of the block between the nodes i and j, either way round."""
    if j < i:
        i, j, r, c = j, i, c, r
    if i == j and c < r:
        r, c = c, r
    return w[line.band + BAND * i + WIDTH * r + 3 * (j - i) + c - r] if j - i <= 2 else 0.0


@kernel
def solve(line, w, first, last):
    """Overwrite R of the nodes first..last by the solution; the neighbours outside keep their place (zero)."""
    gather(line, w)
    factor(line, w, first, last)
    substitute(line, w, first, last)


@kernel
def condense(line, w, node, column, other):
    """Column of the Schur complement that all free nodes leave between the held nodes `other` and `node`: (3).

    After factor; uses R of the free nodes.
    """
    first, last = first_unknown(line), last_unknown(line)
    for i in range(first, last + 1):
        for r in range(3):
            w[i * SCRATCH + R + r] = entry(line, w, i, node, r, column)
    substitute(line, w, first, last)
    x, y, z = (
        entry(line, w, other, node, 0, column),
        entry(line, w, other, node, 1, column),
        entry(line, w, other, node, 2, column),
    )
    near, far = (1, 2) if other == 0 else (line.n - 1, line.n - 2)
    for i in (near, far):
        if first <= i <= last:
            for c in range(3):
                d = w[i * SCRATCH + R + c]
                x -= entry(line, w, other, i, 0, c) * d
                y -= entry(line, w, other, i, 1, c) * d
                z -= entry(line, w, other, i, 2, c) * d
    return x, y, z


@kernel
def write_schur(line, w, node, other, scale, y, k):
    """Write scale times the Schur complement between two held nodes (9, row-major) to y[k:]."""
    for c in range(3):
        y[k + c], y[k + 3 + c], y[k + 6 + c] = condense(line, w, node, c, other)
    for c in range(9):
        y[k + c] *= scale
