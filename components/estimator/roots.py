"""A covariance by its square root, P = S S': how it grows over a step, and how a measurement shrinks it.

Symmetric and definite by construction, however many steps are taken: Bierman 1977, "Factorization methods for discrete
sequential estimation", chapters II.7 (Householder) and V.1 (Potter).
"""

from math import log, pi, sqrt

from components.compiled import kernel


@kernel
def triangulate(a, rows, columns, reach):
    """Turn a (rows, columns) by Householder's reflections into a lower triangle in its first columns: a a' stays.

    reach: row i is zero from column reach + i + 1 on; `columns` where nothing is known of that.
    """
    for i in range(rows):
        top, end = a[i], min(columns, reach + i + 1)
        square = 0.0
        for k in range(i + 1, end):
            square += top[k] * top[k]
        if square == 0.0:
            continue
        head = top[i]
        length = sqrt(head * head + square)
        first = head + length if head > 0.0 else head - length
        over = 2.0 / (first * first + square)
        top[i] = first
        for j in range(i + 1, rows):
            row = a[j]
            one = two = three = four = 0.0
            k = i
            while k + 3 < end:
                one += top[k] * row[k]
                two += top[k + 1] * row[k + 1]
                three += top[k + 2] * row[k + 2]
                four += top[k + 3] * row[k + 3]
                k += 4
            while k < end:
                one += top[k] * row[k]
                k += 1
            part = over * ((one + two) + (three + four))
            for k in range(i, end):
                row[k] -= part * top[k]
        top[i] = -length if head > 0.0 else length
        for k in range(i + 1, end):
            top[k] = 0.0


@kernel
def multiply(f, s, wide):
    """Write F S into the first columns of `wide`; s: (n, n); F: the first columns of f."""
    n = f.shape[0]
    for i in range(n):
        out, row = wide[i], f[i]
        for j in range(n):
            out[j] = 0.0
        for k in range(n):
            part, other = row[k], s[k]
            for j in range(n):
                out[j] += part * other[j]


@kernel
def keep_triangle(wide, s):
    """Copy the lower triangle from `wide` to s (n, n), zeros above."""
    n = s.shape[0]
    for i in range(n):
        for j in range(n):
            s[i, j] = wide[i, j] if j <= i else 0.0


@kernel
def project(s, row, by):
    """Write by = S' row (n); its square is the row's variance."""
    n = len(by)
    square = 0.0
    for j in range(n):
        by[j] = 0.0
    for i in range(n):
        part = row[i]
        if part != 0.0:
            for j in range(n):
                by[j] += part * s[i, j]
    for j in range(n):
        square += by[j] * by[j]
    return square


@kernel
def correct(x, s, row, innovation, by):
    """Use a scalar whose noise has the variance 1; by: scratch (n). The innovation over its deviation, and ln v.

    Potter's update: gain K = S S' row / v, S <- S (I - by by' / (v + sqrt(v))), v = 1 + |S' row|^2.
    """
    n = len(x)
    v = 1.0 + project(s, row, by)
    root = sqrt(v)
    shrink = 1.0 / (v + root)
    for i in range(n):
        gain = 0.0
        for j in range(n):
            gain += s[i, j] * by[j]
        x[i] += gain * (innovation / v)
        gain *= shrink
        for j in range(n):
            s[i, j] -= gain * by[j]
    return innovation / root, log(v)


@kernel
def deviation(s, i):
    """Standard deviation of a state."""
    square = 0.0
    for j in range(s.shape[1]):
        square += s[i, j] * s[i, j]
    return sqrt(square)


@kernel
def log_density(normalised, log_v, log_noise):
    """Logarithm of a scalar's density, its noise being of deviation exp(log_noise)."""
    return -0.5 * (normalised * normalised + log_v + log(2.0 * pi)) - log_noise
