"""A step of the chain by the implicit midpoint rule, its exact slope, and the noise of the step.

theta_1 = theta_0 + h omega_0 + h^2 alpha / 2, omega_1 = omega_0 + h alpha, with alpha from Lagrange's equations at the
midpoint: second order, A-stable, and differentiated as it stands, so that Phi is the slope of the very step. A white
moment stays the same over a step; the loads take exact Ornstein-Uhlenbeck steps, half of what comes anew at the middle.
"""

from math import exp, sqrt

from components.compiled import kernel
from components.estimator.best.layout import (
    FORCE_DOWN,
    FORCE_NORTH,
    FORCE_SPREAD,
    FORCE_TIME,
    PIVOT_SPREAD,
    PIVOT_TIME,
    TORQUE,
    layout_of,
    tables_of,
)
from components.matrices import table
from components.tether.linkage.lagrangian import bars_at, evaluate, slopes_at

# Newton's steps, and the last one's size in an angle [rad].
MOST, CLOSE = 12, 1e-10


@kernel
def solve(a, b, columns):
    """Solve a x = b in place by elimination with pivots; a: (n, n), b: (n, columns at least)."""
    n = a.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        top, right = a[k], b[k]
        if best != k:
            other, beside = a[best], b[best]
            for j in range(n):
                top[j], other[j] = other[j], top[j]
            for j in range(columns):
                right[j], beside[j] = beside[j], right[j]
        over = 1.0 / top[k]
        for i in range(k + 1, n):
            row, mine = a[i], b[i]
            part = row[k] * over
            for j in range(k + 1, n):
                row[j] -= part * top[j]
            for j in range(columns):
                mine[j] -= part * right[j]
    for k in range(n - 1, -1, -1):
        row, mine = a[k], b[k]
        for i in range(k + 1, n):
            part, beside = row[i], b[i]
            for j in range(columns):
                mine[j] -= part * beside[j]
        over = 1.0 / row[k]
        for j in range(columns):
            mine[j] *= over


@kernel
def memory(p, i, h):
    """Of load i: what is left of its deviation after h [s], and the deviation of what comes anew."""
    spread, tau = (p[FORCE_SPREAD], p[FORCE_TIME]) if i < 2 else (p[PIVOT_SPREAD], p[PIVOT_TIME])
    kept = exp(-h / tau)
    return kept, spread * sqrt(1.0 - kept * kept)


@kernel
def mean_load(p, i):
    """Mean of load i."""
    return p[FORCE_NORTH] if i == 0 else (p[FORCE_DOWN] if i == 1 else 0.0)


@kernel
def at_middle(bars, m, x, h, w, load, out):
    """Evaluate the chain at the midpoint for the rates alpha that stand in w, and make out.M the slope by alpha."""
    n, a = m.n, m.spare
    middle, rate, alpha, v = w[a : a + n], w[a + n : a + 2 * n], w[a + 2 * n : a + 3 * n], w[a + 3 * n : a + 3 * n + 2]
    v[0] = v[1] = 0.0
    if m.loads > 2:
        v[0], v[1] = x[m.speed] + 0.5 * h * load[2], x[m.speed + 1] + 0.5 * h * load[3]
    for i in range(n):
        rate[i] = x[n + i] + 0.5 * h * alpha[i]
        middle[i] = x[i] + 0.5 * h * rate[i]
    evaluate(bars, middle, rate, alpha, v, load, out)
    for i in range(n):
        for j in range(n):
            out.M[i, j] += 0.5 * h * (out.omega[i, j] + 0.5 * h * out.theta[i, j])


@kernel
def right_sides(p, m, h, out, X):
    """Write what changes alpha: angles, rates (n each), loads at the midpoint, moments (n), the pivot's velocity."""
    n, loads = m.n, m.loads
    end = 2 * n + loads
    for i in range(n):
        for j in range(n):
            X[i, j] = -out.theta[i, j]
            X[i, n + j] = -0.5 * h * out.theta[i, j] - out.omega[i, j]
            X[i, end + j] = p[TORQUE] / sqrt(h) if i == j else 0.0
        for j in range(2):
            X[i, 2 * n + j] = -out.load[i, j]
            if loads > 2:
                X[i, 2 * n + 2 + j] = -out.load[i, 2 + j] - 0.5 * h * out.v[i, j]
            X[i, end + n + j] = -out.v[i, j]


@kernel
def place_slopes(p, m, h, X, phi):
    """Write Phi and behind it the noise's columns, (N, N + K), from alpha's slopes X."""
    n, N, loads = m.n, m.N, m.loads
    half, end = 0.5 * h * h, 2 * n + loads
    for i in range(N):
        for j in range(N + m.K):
            phi[i, j] = 1.0 if i == j else 0.0
    for i in range(n):
        phi[i, n + i] = h
        for j in range(2 * n):
            phi[i, j] += half * X[i, j]
            phi[n + i, j] += h * X[i, j]
        for j in range(n):
            phi[i, N + j], phi[n + i, N + j] = half * X[i, end + j], h * X[i, end + j]
        if loads > 2:
            for j in range(2):
                phi[i, m.speed + j], phi[n + i, m.speed + j] = half * X[i, end + n + j], h * X[i, end + n + j]
    for j in range(loads):
        kept, fresh = memory(p, j, h)
        now, later = 0.5 * (1.0 + kept), 0.5 * fresh
        k, c = m.F + j, N + n + j
        for i in range(n):
            part = X[i, 2 * n + j]
            phi[i, k], phi[n + i, k] = half * now * part, h * now * part
            phi[i, c], phi[n + i, c] = half * later * part, h * later * part
        phi[k, k], phi[k, c] = kept, fresh
        if j >= 2:
            place, speed = m.place + j - 2, m.speed + j - 2
            phi[place, speed] = h
            phi[place, k], phi[speed, k] = half * now, h * now
            phi[place, c], phi[speed, c] = half * later, h * later


@kernel
def predict(p, x, h, w):
    """Move x on by h [s]; write into w its slope Phi (N, N), and behind that the noise's columns (N, K)."""
    m, at = layout_of(p), tables_of(p)[2]
    n, loads = m.n, m.loads
    bars, out = bars_at(p, at), slopes_at(w, m.slopes, n)
    alpha = w[m.spare + 2 * n : m.spare + 3 * n]
    load = w[m.spare + 3 * n + 2 : m.spare + 3 * n + 6]
    X = table(w, m.columns, n, 3 * n + 6)
    for i in range(4):
        load[i] = 0.0
    for i in range(loads):
        kept, _ = memory(p, i, h)
        load[i] = mean_load(p, i) + 0.5 * (1.0 + kept) * (x[m.F + i] - mean_load(p, i))
    for i in range(n):
        alpha[i] = 0.0
    for _ in range(MOST):
        at_middle(bars, m, x, h, w, load, out)
        largest = 0.0
        for i in range(n):
            X[i, 0] = -out.r[i]
        solve(out.M, X, 1)
        for i in range(n):
            alpha[i] += X[i, 0]
            largest = max(largest, abs(X[i, 0]))
        if 0.25 * h * h * largest < CLOSE:
            break
    at_middle(bars, m, x, h, w, load, out)
    right_sides(p, m, h, out, X)
    solve(out.M, X, 3 * n + loads + 2)
    place_slopes(p, m, h, X, table(w, m.moves, m.N, m.N + m.K))
    for i in range(n):
        x[i] += h * (x[n + i] + 0.5 * h * alpha[i])
        x[n + i] += h * alpha[i]
    for i in range(loads):
        kept, _ = memory(p, i, h)
        x[m.F + i] = mean_load(p, i) + kept * (x[m.F + i] - mean_load(p, i))
    for j in range(2):
        if loads > 2:
            x[m.place + j] += h * (x[m.speed + j] + 0.5 * h * load[2 + j])
            x[m.speed + j] += h * load[2 + j]
