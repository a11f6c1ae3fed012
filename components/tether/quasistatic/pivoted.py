"""The line's equations as one banded matrix, solved with row interchanges: where newton.py's sweep loses digits.

The sweep does not interchange rows, and drag along the flow can make one of its 3 by 3 pivots nearly singular though
the whole matrix is well conditioned. Unknowns are N_0, r_1, N_1, ... in the forces' scale and the line's reach,
equations are segment 0, node 1, segment 1, ...: block tridiagonal, half bandwidth 5, and 10 above the diagonal after
interchanges (Golub and Van Loan 2013, Matrix computations, sec. 4.3.3).
"""

from components.compiled import kernel
from components.tether.quasistatic.line import F0, RECORD, N, R
from components.tether.quasistatic.loads import free_load, node_load, size_of
from components.tether.quasistatic.newton import small_place, write_slopes

# A row: its columns from BELOW left of the diagonal on, then two right-hand sides.
BELOW, ABOVE, STEP, RATE, WIDTH = 5, 10, 16, 17, 18


@kernel
def unknowns(line):
    """Number of unknowns."""
    return 6 * line.n - (0 if line.free else 3)


@kernel
def reach(line):
    """Length [m] that places are measured by: the line's, stretched by all its load."""
    return line.length * (1.0 + line.scale * line.flexibility)


@kernel
def entry(rows, row, column):
    """Place of a matrix element."""
    return rows + row * WIDTH + column - row + BELOW


@kernel
def write_residual(line, p, u, w, share, rows, side):
    """Write the negative residual, with this share of the loads, to a right-hand side; returns its largest element."""
    worst, length = 0.0, reach(line)
    for j in range(line.n):
        b, o = j * RECORD, rows + 6 * j * WIDTH + side
        size = size_of(line, w, j)
        for k in range(3):
            g = w[b + N + k] * (1.0 / size + line.flexibility)
            misfit = (w[b + RECORD + R + k] - w[b + R + k] - line.l0 * g) / length
            w[o + k * WIDTH] = -misfit
            worst = max(worst, abs(misfit))
        i = j + 1
        if i == line.n and not line.free:
            continue
        b, o = i * RECORD, o + 3 * WIDTH
        f = node_load(line, p, u, w, i)
        if i == line.n:
            body = free_load(line, p, u, w)
            f = f[0] + body[0], f[1] + body[1], f[2] + body[2]
        for k in range(3):
            forward = w[b + N + k] if i < line.n else 0.0
            load = f[k] if share == 1.0 else (1.0 - share) * w[b + F0 + k] + share * f[k]
            missing = (forward - w[b - RECORD + N + k] + load) / line.scale
            w[o + k * WIDTH] = -missing
            worst = max(worst, abs(missing))
    return worst


@kernel
def write_matrix(line, p, u, w, share, rows):
    """Write the derivatives of the residual."""
    small, length, m = small_place(line), reach(line), unknowns(line)
    left, right, by_r, free = small + 12, small + 21, small + 30, small + 39
    for row in range(m):
        for k in range(STEP):
            w[rows + row * WIDTH + k] = 0.0
    for j in range(line.n):
        b, size, at = j * RECORD, size_of(line, w, j), 6 * j
        for k in range(3):
            row = at + k
            if j > 0:
                w[entry(rows, row, at - 3 + k)] = -1.0
            if at + 3 < m:
                w[entry(rows, row, at + 3 + k)] = 1.0
            for c in range(3):
                same = 1.0 if k == c else 0.0
                bent = (same - (w[b + N + k] / size) * (w[b + N + c] / size)) / size
                g = line.l0 * (bent + same * line.flexibility)
                w[entry(rows, row, at + c)] = -g * line.scale / length
        i, at = j + 1, at + 3
        if at == m:
            continue
        write_slopes(line, p, u, w, i, share, left, right, by_r, free)
        for k in range(3):
            for c in range(3):
                same = 1.0 if k == c else 0.0
                w[entry(rows, at + k, at - 3 + c)] = w[left + 3 * k + c] - same
                w[entry(rows, at + k, at + c)] = w[by_r + 3 * k + c] * length / line.scale
                if i < line.n:
                    w[entry(rows, at + k, at + 3 + c)] = w[right + 3 * k + c] + same


@kernel
def interchange(w, rows, a, b, first, last):
    """Interchange rows a and b between two columns, and their right-hand sides."""
    for c in range(first, last + 1):
        x, y = entry(rows, a, c), entry(rows, b, c)
        w[x], w[y] = w[y], w[x]
    for side in (STEP, RATE):
        x, y = rows + a * WIDTH + side, rows + b * WIDTH + side
        w[x], w[y] = w[y], w[x]


@kernel
def solve_rows(w, rows, m):
    """Solve for both right-hand sides, which the solutions replace; the sign of the determinant, 0 if singular."""
    sign = 1.0
    for k in range(m):
        lowest, last = min(k + BELOW, m - 1), min(k + ABOVE, m - 1)
        best, largest = k, abs(w[entry(rows, k, k)])
        for row in range(k + 1, lowest + 1):
            size = abs(w[entry(rows, row, k)])
            if size > largest:
                best, largest = row, size
        if not largest > 0.0:
            return 0.0
        if best != k:
            interchange(w, rows, k, best, k, last)
            sign = -sign
        pivot = w[entry(rows, k, k)]
        if pivot < 0.0:
            sign = -sign
        for row in range(k + 1, lowest + 1):
            factor = w[entry(rows, row, k)] / pivot
            if factor != 0.0:
                for c in range(k + 1, last + 1):
                    w[entry(rows, row, c)] -= factor * w[entry(rows, k, c)]
                for side in (STEP, RATE):
                    w[rows + row * WIDTH + side] -= factor * w[rows + k * WIDTH + side]
    for k in range(m - 1, -1, -1):
        for side in (STEP, RATE):
            o = rows + k * WIDTH + side
            for c in range(k + 1, min(k + ABOVE, m - 1) + 1):
                w[o] -= w[entry(rows, k, c)] * w[rows + c * WIDTH + side]
            w[o] /= w[entry(rows, k, k)]
    return sign


@kernel
def move_by(line, w, at, stride, factor):
    """Add factor times a vector of the unknowns, which stands at `at` in steps of `stride`, to places and forces."""
    length = reach(line)
    for j in range(line.n):
        b, o = j * RECORD, at + 6 * j * stride
        for k in range(3):
            w[b + N + k] += factor * line.scale * w[o + k * stride]
            if j < line.n - 1 or line.free:
                w[b + RECORD + R + k] += factor * length * w[o + (3 + k) * stride]
