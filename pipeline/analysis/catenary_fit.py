"""The catenary nearest to markers in their plane, at the same x: compiled Levenberg-Marquardt over batches of frames.

The curve of Drupt et al. 2022, eq. 8, z = z0 + [cosh(C (x - x0)) - 1] / C, is written about the middle of the markers,

    z = a + [S sinh(C u) + K (cosh(C u) - 1)] / C,   u = x - x_middle,  S = sinh beta,  K = cosh beta,

S the slope in the middle, beta = C (x_middle - x0). So it stays accurate through C = 0, where x0 and z0 go to
infinity, and for either sign of C. The level a enters linearly and is projected out; two unknowns, beta and C, remain.
Lengths are in units of the half-width h of the markers in x (c = C h).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asinh, inf, sinh, sqrt

import numpy as np

from pipeline.analysis.compiled import kernel

EPS = 2.220446049250313e-16
FITTED, NO_CATENARY, NOT_CONVERGED = 0, 1, 2
ITERATIONS = 200
# Stop when the next step promises less than this part of the sum of squares: 1e-5 of the parameters' deviations.
GAIN = 1e-10
# Below this |C u| the difference that d/dC takes loses digits, and its series (four terms) is exact to 1e-11.
SERIES = 0.3
ROUNDING = 4.0  # of a residual, in units of eps times the largest |v|
LARGEST = 300.0  # |C u| + |beta| of a trial: cosh stays finite when squared
LARGEST_DAMPING = 1e12
SINGULAR = 64 * EPS  # pivot over diagonal, of scaled normal equations
# With a root of the mean square beyond this part of the half-width the minimum may be a false one: start again from
# elsewhere. Of 20,985 simulated frames (pool chain and rope) none had another minimum that mattered.
DOUBTFUL = 0.05
# Columns of the work array: u, v, the residual and its derivatives with their means taken off.
U, V, F, F_BETA, F_C = range(5)


@dataclass(frozen=True)
class Catenaries:
    """Catenaries of k frames, in the form above; NaN where status is not 0.

    status: (k,) int. middle: (k,) of the markers' x, from the centroid [m]. a: (k,) level [m]. beta: (k,).
    C: (k,) [1/m]. e_catenary: (k,) RMS distance at the same x [m].
    """

    status: np.ndarray
    middle: np.ndarray
    a: np.ndarray
    beta: np.ndarray
    C: np.ndarray
    e_catenary: np.ndarray

    @property
    def x0(self) -> np.ndarray:
        """(k,) x of the lowest point (the highest where C < 0) from the centroid [m]."""
        return self.middle - self.beta / self.C

    @property
    def z0(self) -> np.ndarray:
        """(k,) z of that point from the centroid [m]; cosh beta - 1 = 2 sinh(beta / 2)^2."""
        return self.a - 2.0 * np.sinh(0.5 * self.beta) ** 2 / self.C


def fit_catenaries(points: np.ndarray, n: np.ndarray) -> Catenaries:
    """Catenaries of least RMS distance at the same x.

    points: (k, m, 2) x and z in F_p [m], the first n (k,) of each frame hold; frames with n = 0 are left out.
    """
    k, m = points.shape[:2]
    status, numbers = np.full(k, NO_CATENARY, np.int64), np.full((k, 5), np.nan)
    _fit_all(points, n, np.empty((m, 5)), status, numbers)
    return Catenaries(status, *numbers.T)


@kernel
def _fit_all(points, n, work, status, numbers):
    """All frames; work (m, 5) is scratch."""
    for f in range(len(n)):
        if n[f] > 0:
            status[f] = _fit(points[f], n[f], work, numbers[f])


@kernel
def _fit(points, n, work, numbers):
    """One frame; status."""
    middle, h = _scale(points, n, work)
    if not _three_abscissas(work, n):
        return NO_CATENARY
    beta, c = _first_guess(work, n)
    beta, c, sse, converged = _descend(work, n, beta, c)
    if not converged or sse > n * DOUBTFUL**2:
        for guess in range(3):
            other_beta, other_c = _other_guess(work, n, guess)
            other_beta, other_c, other_sse, good = _descend(work, n, other_beta, other_c)
            if other_sse < sse or (good and not converged and other_sse <= sse):
                beta, c, sse, converged = other_beta, other_c, other_sse, good
    if not converged:
        return NOT_CONVERGED
    sse, a = _evaluate(work, n, beta, c)
    numbers[0], numbers[1], numbers[2], numbers[3], numbers[4] = middle, h * a, beta, c / h, h * sqrt(sse / n)
    return FITTED


@kernel
def _scale(points, n, w):
    """u and v of the points into w; middle and half-width of their x."""
    low, high = points[0, 0], points[0, 0]
    for i in range(1, n):
        low, high = min(low, points[i, 0]), max(high, points[i, 0])
    middle, h = 0.5 * (low + high), 0.5 * (high - low)
    if h == 0.0:
        h = 1.0
    for i in range(n):
        w[i, U] = (points[i, 0] - middle) / h
        w[i, V] = points[i, 1] / h
    return middle, h


@kernel
def _three_abscissas(w, n):
    """Whether some u lies clearly between the outermost, -1 and 1 (all are 0 if the points stand in one column)."""
    for i in range(n):
        if 16 * EPS < 1.0 - abs(w[i, U]) < 1.0 or (w[i, U] == 0.0 and (w[0, U] != 0.0 or w[n - 1, U] != 0.0)):
            return True
    return False


@kernel
def _first_guess(w, n):
    """(beta, c) from z' = C (s - s0), s along the polyline: a linear fit of dv = (c s - e) du."""
    ss = s1 = s11 = b0 = b1 = 0.0
    s = 0.0
    for i in range(1, n):
        du, dv = w[i, U] - w[i - 1, U], w[i, V] - w[i - 1, V]
        half = 0.5 * sqrt(du * du + dv * dv)
        s += half
        ss, s1, s11 = ss + s * s * du * du, s1 - s * du * du, s11 + du * du
        b0, b1 = b0 + s * du * dv, b1 - du * dv
        s += half
    det = ss * s11 - s1 * s1
    if det <= SINGULAR * ss * s11:
        return _quadratic(w, n)
    c, e = (b0 * s11 - b1 * s1) / det, (b1 * ss - b0 * s1) / det
    slope = c * _arc_at_middle(w, n) - e
    return asinh(slope), _bounded(c)


@kernel
def _bounded(c):
    """C h within what the curve can be evaluated for, and never quite zero."""
    c = max(-20.0, min(20.0, c))
    return c if abs(c) > 1e-30 else 1e-30


@kernel
def _arc_at_middle(w, n):
    """Arc length along the polyline where it first crosses u = 0."""
    s = 0.0
    for i in range(1, n):
        du, dv = w[i, U] - w[i - 1, U], w[i, V] - w[i - 1, V]
        length = sqrt(du * du + dv * dv)
        if w[i - 1, U] * w[i, U] <= 0.0 and du != 0.0:
            return s - w[i - 1, U] / du * length
        s += length
    return 0.5 * s


@kernel
def _quadratic(w, n):
    """(beta, c) of the parabola of least squares; needs no order along the line."""
    u1 = u2 = u3 = u4 = v0 = v1 = v2 = 0.0
    for i in range(n):
        u, v = w[i, U], w[i, V]
        u1, u2, u3, u4 = u1 + u, u2 + u * u, u3 + u * u * u, u4 + u * u * u * u
        v0, v1, v2 = v0 + v, v1 + u * v, v2 + u * u * v
    u1, u2, v0 = u1 / n, u2 / n, v0 / n
    a11, a12, a22 = u2 - u1 * u1, u3 / n - u1 * u2, u4 / n - u2 * u2
    r1, r2 = v1 / n - u1 * v0, v2 / n - u2 * v0
    det = a11 * a22 - a12 * a12
    if det <= SINGULAR * a11 * a22:
        return 0.0, 1e-30
    slope, bend = (r1 * a22 - r2 * a12) / det, (r2 * a11 - r1 * a12) / det
    return asinh(slope), _bounded(2.0 * bend / sqrt(1.0 + slope * slope))


@kernel
def _other_guess(w, n, guess):
    """Starts for doubtful frames: the parabola, and a deep curve either way up through the chord's slope."""
    if guess == 0:
        return _quadratic(w, n)
    rise, run = w[n - 1, V] - w[0, V], w[n - 1, U] - w[0, U]
    slope = rise / run if run != 0.0 else 0.0
    return asinh(slope), (2.0 if guess == 1 else -2.0)


@kernel
def _evaluate(w, n, beta, c):
    """Residual and derivatives by beta and c at all points, centred; (sum of squares, level a).

    With s = sinh(c u / 2): sinh(c u) = 2 s k and cosh(c u) - 1 = 2 s^2, exact however small c u is.
    """
    slope = sinh(beta)
    K = sqrt(1.0 + slope * slope)
    mean = mean_beta = mean_c = 0.0
    for i in range(n):
        u = w[i, U]
        y = c * u
        s = sinh(0.5 * y)
        sinh_y, cosh_1 = 2.0 * s * sqrt(1.0 + s * s), 2.0 * s * s
        A, B = sinh_y / c, cosh_1 / c
        B_c = (u * sinh_y - B) / c
        if abs(y) < SERIES:
            q = y * y
            A_c = u * u * y * (1.0 / 3.0 + q * (1.0 / 30.0 + q * (1.0 / 840.0 + q / 45360.0)))
        else:
            A_c = (u * (1.0 + cosh_1) - A) / c
        w[i, F] = w[i, V] - slope * A - K * B
        w[i, F_BETA] = K * A + slope * B
        w[i, F_C] = slope * A_c + K * B_c
        mean, mean_beta, mean_c = mean + w[i, F], mean_beta + w[i, F_BETA], mean_c + w[i, F_C]
    mean, mean_beta, mean_c = mean / n, mean_beta / n, mean_c / n
    sse = 0.0
    for i in range(n):
        w[i, F] -= mean
        w[i, F_BETA] -= mean_beta
        w[i, F_C] -= mean_c
        sse += w[i, F] * w[i, F]
    return sse, mean


@kernel
def _descend(w, n, beta, c):
    """Levenberg-Marquardt from (beta, c): (beta, c, sum of squares, converged)."""
    best, _ = _evaluate(w, n, beta, c)
    if not best < inf:
        return beta, c, inf, False
    damping = 1e-3
    size = 1.0
    for i in range(n):
        size = max(size, abs(w[i, V]))
    floor = n * (ROUNDING * EPS * size) ** 2
    bb, bc, cc, gb, gc = _normal(w, n)
    for _ in range(ITERATIONS):
        det = bb * cc * (1.0 + damping) ** 2 - bc * bc
        db = (gb * cc * (1.0 + damping) - gc * bc) / det
        dc = (gc * bb * (1.0 + damping) - gb * bc) / det
        promise = db * gb + dc * gc
        near = promise <= GAIN * best + floor + sqrt(best * floor)  # less cannot be told from rounding
        if abs(beta + db) + abs(c + dc) > LARGEST or not det > 0.0:
            sse = inf
        else:
            sse, _ = _evaluate(w, n, beta + db, c + dc)
        if sse <= best:
            best, beta, c = sse, beta + db, c + dc
            c = c if abs(c) > 1e-30 else 1e-30
            damping = 0.1 * damping if damping > 1e-12 else 0.0
            bb, bc, cc, gb, gc = _normal(w, n)
            if near:
                return beta, c, best, True
        else:
            if near or damping > LARGEST_DAMPING:
                return beta, c, best, True
            damping = max(10.0 * damping, 1e-6)
    return beta, c, best, False


@kernel
def _normal(w, n):
    """Normal equations of the two unknowns, the level projected out: bb, bc, cc and the right side."""
    bb = bc = cc = gb = gc = 0.0
    for i in range(n):
        r, b, g = w[i, F], w[i, F_BETA], w[i, F_C]
        bb, bc, cc = bb + b * b, bc + b * g, cc + g * g
        gb, gc = gb + b * r, gc + g * r
    return bb, bc, cc, gb, gc
