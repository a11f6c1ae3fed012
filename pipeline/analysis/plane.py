"""The plane nearest to each frame's markers, by singular values, and the markers in it.

That plane's frame is F_p of Drupt et al. 2022, II.B: x_p horizontal, z_p up the plane, y_p its normal.

Inside, axes are north, west, up; the first marker is subtracted before anything else, which is exact in float64.
The plane's normal is the last right singular vector of the centred markers: through a Householder QR and one-sided
Jacobi rotations, never through the squared 3x3 covariance, which would lose half of the digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot, sqrt

import numpy as np

from pipeline.analysis.compiled import kernel

EPS = 2.220446049250313e-16
LEAST_POINTS = 4
SWEEPS = 12  # Jacobi on 3 columns converges quadratically; 4 to 6 sweeps are usual
# Rounding of a point's three coordinates displaces it by at most 0.87 eps times the largest; twice for generating it,
# and twice to be safe.
ROUNDING = 4.0
FITTED, TOO_FEW, COINCIDENT, STRAIGHT, HORIZONTAL = range(5)
# Columns of the kernel's numbers.
SIN, COS, PSI, E_PLANE, WIDTH, FIRM, DXX, DXZ, DZZ, NORMAL = range(10)
CENTROID = NORMAL + 3
COLUMNS = CENTROID + 3


@dataclass(frozen=True)
class Planes:
    """Planes of k frames of m markers; NaN where status is not 0.

    status, n: (k,) int, n markers used. inclination: (k,) signed angle to the vertical about x_p [rad].
    psi: (k,) heading of x_p [rad]. e_plane: (k,) RMS distance [m].
    tilt: (k, 3) variances xx, xz, zz of the normal's deviation along x_p and z_p, for a unit variance of the markers
    [1/m^2]. normal, centroid: (k, 3) NED. points: (k, m, 2) x and z in F_p from the centroid [m], the first n of each
    frame hold. width: (k,) root of the sum of squares by which the markers leave their straight line in the plane [m],
    the second singular value. firm: (k,) the same without the one marker whose absence makes it least.
    """

    status: np.ndarray
    n: np.ndarray
    inclination: np.ndarray
    psi: np.ndarray
    e_plane: np.ndarray
    tilt: np.ndarray
    normal: np.ndarray
    centroid: np.ndarray
    points: np.ndarray
    width: np.ndarray
    firm: np.ndarray


def fit_planes(position: np.ndarray, order: np.ndarray) -> Planes:
    """Planes of least RMS distance; refused is what is singular but for rounding, for noise see scatter.

    position: (k, m, 3) NED [m]. order: (k, m) int, markers used in order, then -1.
    """
    k, m = order.shape
    status, n = np.zeros(k, np.int64), np.zeros(k, np.int64)
    numbers, points = np.full((k, COLUMNS), np.nan), np.zeros((k, m, 2))
    work = np.empty((2 * m + 6, 3))
    _fit_all(np.ascontiguousarray(position), order, work, status, n, numbers, points)
    return Planes(
        status=status,
        n=n,
        inclination=np.arctan2(numbers[:, SIN], numbers[:, COS]),
        psi=numbers[:, PSI],
        e_plane=numbers[:, E_PLANE],
        tilt=numbers[:, DXX : DZZ + 1],
        normal=numbers[:, NORMAL : NORMAL + 3],
        centroid=numbers[:, CENTROID : CENTROID + 3],
        points=points,
        width=numbers[:, WIDTH],
        firm=numbers[:, FIRM],
    )


@kernel
def _fit_all(position, order, work, status, n, numbers, points):
    """All frames; work (2 m + 6, 3) holds centred points, their triangularised copy, R and V."""
    m = order.shape[1]
    for f in range(order.shape[0]):
        count = 0
        while count < m and order[f, count] >= 0:
            count += 1
        n[f] = count
        status[f] = _fit(position[f], order[f], count, work, m, numbers[f], points[f])


@kernel
def _fit(position, order, n, work, m, numbers, points):
    """One frame; status."""
    if n < LEAST_POINTS:
        return TOO_FEW
    largest = _gather(position, order, n, work)
    noise = ROUNDING * EPS * largest
    if not _four_places(work, n, noise):
        return COINCIDENT
    _centre(work, n, position[order[0]], numbers)
    _triangularise(work, n, m)
    r, v = work[2 * m : 2 * m + 3], work[2 * m + 3 : 2 * m + 6]
    _rotate_columns(r, v)
    s1, s2 = _sort(r, v)
    noise *= sqrt(1.0 * n)
    if s2 <= noise + ROUNDING * EPS * s1:
        return STRAIGHT
    cosine = hypot(v[0, 2], v[1, 2])
    if cosine * s2 <= noise + ROUNDING * EPS * s1:
        return HORIZONTAL
    _project(work, n, v, cosine, s1, s2, numbers, points)
    return FITTED


@kernel
def _gather(position, order, n, a):
    """a[i] = marker - first marker in north, west, up; the largest absolute coordinate."""
    first = position[order[0]]
    largest = 0.0
    for i in range(n):
        p = position[order[i]]
        a[i, 0] = p[0] - first[0]
        a[i, 1] = first[1] - p[1]
        a[i, 2] = first[2] - p[2]
        largest = max(largest, abs(p[0]), abs(p[1]), abs(p[2]))
    return largest


@kernel
def _four_places(a, n, noise):
    """Whether at least four markers stand apart."""
    found_1 = found_2 = -1
    places = 1
    for i in range(1, n):
        if _apart(a, i, 0, noise):
            if found_1 < 0:
                found_1 = i
                places = 2
            elif _apart(a, i, found_1, noise):
                if found_2 < 0:
                    found_2 = i
                    places = 3
                elif _apart(a, i, found_2, noise):
                    places = 4
                    break
    return places == 4


@kernel
def _apart(a, i, j, noise):
    return abs(a[i, 0] - a[j, 0]) + abs(a[i, 1] - a[j, 1]) + abs(a[i, 2] - a[j, 2]) > noise


@kernel
def _centre(a, n, first, numbers):
    """Subtract the centroid, and note it in NED."""
    for axis in range(3):
        mean = 0.0
        for i in range(n):
            mean += a[i, axis]
        mean /= n
        for i in range(n):
            a[i, axis] -= mean
        numbers[CENTROID + axis] = first[axis] + (mean if axis == 0 else -mean)


@kernel
def _triangularise(work, n, m):
    """Householder QR of the centred points: R (3, 3) into rows 2 m to 2 m + 2 of work; the points stay."""
    q, r = work[m : m + n], work[2 * m : 2 * m + 3]
    for i in range(n):
        for j in range(3):
            q[i, j] = work[i, j]
    for j in range(3):
        norm = 0.0
        for i in range(j, n):
            norm += q[i, j] * q[i, j]
        norm = sqrt(norm)
        pivot = -norm if q[j, j] > 0.0 else norm
        head = q[j, j] - pivot
        for column in range(j + 1, 3):
            dot = head * q[j, column]
            for i in range(j + 1, n):
                dot += q[i, j] * q[i, column]
            scale = dot / (pivot * head) if norm > 0.0 else 0.0
            q[j, column] += scale * head
            for i in range(j + 1, n):
                q[i, column] += scale * q[i, j]
        for i in range(3):
            r[i, j] = q[i, j] if i < j else 0.0
        r[j, j] = pivot


@kernel
def _rotate_columns(r, v):
    """Hestenes' one-sided Jacobi: columns of r become orthogonal, v (3, 3) gathers the rotations."""
    for i in range(3):
        for j in range(3):
            v[i, j] = 1.0 if i == j else 0.0
    for _ in range(SWEEPS):
        done = True
        for p in range(2):
            for q in range(p + 1, 3):
                pp = r[0, p] * r[0, p] + r[1, p] * r[1, p] + r[2, p] * r[2, p]
                qq = r[0, q] * r[0, q] + r[1, q] * r[1, q] + r[2, q] * r[2, q]
                pq = r[0, p] * r[0, q] + r[1, p] * r[1, q] + r[2, p] * r[2, q]
                if abs(pq) <= EPS * sqrt(pp * qq):
                    continue
                done = False
                tau = (qq - pp) / (2.0 * pq)
                t = (1.0 if tau >= 0.0 else -1.0) / (abs(tau) + hypot(1.0, tau))
                c = 1.0 / hypot(1.0, t)
                s = c * t
                for i in range(3):
                    r[i, p], r[i, q] = c * r[i, p] - s * r[i, q], s * r[i, p] + c * r[i, q]
                    v[i, p], v[i, q] = c * v[i, p] - s * v[i, q], s * v[i, p] + c * v[i, q]
        if done:
            break


@kernel
def _sort(r, v):
    """Sort the columns by the singular values, largest first; the first two values."""
    for last in (2, 1):
        for p in range(last):
            here = r[0, p] ** 2 + r[1, p] ** 2 + r[2, p] ** 2
            after = r[0, p + 1] ** 2 + r[1, p + 1] ** 2 + r[2, p + 1] ** 2
            if after > here:
                for i in range(3):
                    r[i, p], r[i, p + 1] = r[i, p + 1], r[i, p]
                    v[i, p], v[i, p + 1] = v[i, p + 1], v[i, p]
    s1 = sqrt(r[0, 0] ** 2 + r[1, 0] ** 2 + r[2, 0] ** 2)
    s2 = sqrt(r[0, 1] ** 2 + r[1, 1] ** 2 + r[2, 1] ** 2)
    return s1, s2


@kernel
def _project(a, n, v, cosine, s1, s2, numbers, points):
    """F_p, the points in it and what goes with the plane. x_p points from the first marker to the last."""
    xn, xw = v[1, 2] / cosine, -v[0, 2] / cosine
    sign = 1.0 if xn * (a[n - 1, 0] - a[0, 0]) + xw * (a[n - 1, 1] - a[0, 1]) >= 0.0 else -1.0
    xn, xw = sign * xn, sign * xw
    yn, yw, yu = sign * v[0, 2], sign * v[1, 2], sign * v[2, 2]
    zn, zw, zu = xw * yu, -xn * yu, xn * yw - xw * yn
    thickness = 0.0
    for i in range(n):
        points[i, 0] = xn * a[i, 0] + xw * a[i, 1]
        points[i, 1] = zn * a[i, 0] + zw * a[i, 1] + zu * a[i, 2]
        thickness += (yn * a[i, 0] + yw * a[i, 1] + yu * a[i, 2]) ** 2
    x1, x2 = xn * v[0, 0] + xw * v[1, 0], xn * v[0, 1] + xw * v[1, 1]
    z1, z2 = zn * v[0, 0] + zw * v[1, 0] + zu * v[2, 0], zn * v[0, 1] + zw * v[1, 1] + zu * v[2, 1]
    numbers[SIN], numbers[COS], numbers[PSI] = yu, cosine, atan2(-xw, xn)
    numbers[E_PLANE] = sqrt(thickness / n)
    numbers[WIDTH], numbers[FIRM] = s2, _firm_width(a, n, v, s1, s2)
    numbers[DXX] = (x1 / s1) ** 2 + (x2 / s2) ** 2
    numbers[DXZ] = x1 * z1 / (s1 * s1) + x2 * z2 / (s2 * s2)
    numbers[DZZ] = (z1 / s1) ** 2 + (z2 / s2) ** 2
    numbers[NORMAL], numbers[NORMAL + 1], numbers[NORMAL + 2] = yn, -yw, -yu


@kernel
def _firm_width(a, n, v, s1, s2):
    """Width left without the marker that it owes most to: the deletion formula of least squares, w on t.

    t, w: along the line and across it in the plane. Without marker i the sum of squares falls by w^2 / (1 - h), h its
    leverage (Cook and Weisberg 1982, eq. 2.2.8).
    """
    least = s2 * s2
    for i in range(n):
        t = a[i, 0] * v[0, 0] + a[i, 1] * v[1, 0] + a[i, 2] * v[2, 0]
        w = a[i, 0] * v[0, 1] + a[i, 1] * v[1, 1] + a[i, 2] * v[2, 1]
        rest = 1.0 - 1.0 / n - (t / s1) ** 2
        if rest > 16.0 * EPS:
            least = min(least, s2 * s2 - w * w / rest)
    return sqrt(max(least, 0.0))
