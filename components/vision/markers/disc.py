"""A marker's centre to hundredths of a pixel: a blurred disc on a blurred strip, fitted by least squares.

I(u, v) = b + g_u u + g_v v + (c + e q / h) T(q) (1 - S) + a S, with S the disc of radius r about (u0, v0) and T the
strip through its centre at the angle phi, both with edges blurred by sigma; q is the distance from the strip's axis and
h half its width, so that e tells how much brighter one side of it is. Gauss-Newton on (u0, v0, phi, r, a, c, e, b, g_u,
g_v).
A disc alone, or a weighted centroid, is drawn aside where the background changes or the line is lit from one side, and
a strip left out takes along the edges that it crosses.
"""

from math import atan2, ceil, cos, erf, exp, sin, sqrt
from typing import NamedTuple

from components.compiled import kernel

PARAMETERS = 10
CENTRE_U, CENTRE_V, ANGLE, RADIUS, DISC, STRIP, SKEW, GROUND, SLOPE_U, SLOPE_V = range(PARAMETERS)
LINEAR = DISC  # the first of those in which the model is linear
ROOM = 3 * PARAMETERS * PARAMETERS + 3 * PARAMETERS  # of scratch
ITERATIONS = 12
QUANTISATION = 1.0 / 12.0  # variance of rounding [grey level^2]
SETTLED = 3e-3  # last correction of the centre, of which a tenth or so remains [pixel]
NEARLY = 0.03  # the same, with which a fit in a disturbed window may end [pixel]
TURN_DEVIATION = 0.3  # of phi about its first value [rad], which keeps it where no strip is to be seen
SIZE_DEVIATION = 0.15  # of the radius about the expected one, relative
MARGIN = 3.0  # of the window around the disc, beyond three standard deviations of blur [pixel]
MOST_ALIKE = 0.8
FAR = 5.0  # standard deviations of blur beyond which the strip is left out: 6e-7 of it
SQRT2, NORM = sqrt(2.0), 0.3989422804014327


class Shape(NamedTuple):
    """radius: of the disc, half: half the strip's width, sigma: blur of their edges; all in pixels."""

    radius: float
    half: float
    sigma: float


class Fit(NamedTuple):
    """u, v: centre [pixel], with covariance uu, uv, vv [pixel^2]; radius [pixel]; misfit: rms of the residuals.

    contrast, line: of disc and strip over the background [grey level]; found: whether the fit settled in its window.
    """

    u: float
    v: float
    uu: float
    uv: float
    vv: float
    contrast: float
    line: float
    radius: float
    misfit: float
    found: bool


@kernel
def reach_of(shape):
    """Radius of the window [pixel]."""
    return shape.radius + 3.0 * shape.sigma + MARGIN


@kernel
def direction(image, shape, u0, v0):
    """Angle of the strip from the second harmonic of the grey levels in the ring outside the disc."""
    inner, outer = shape.radius + 2.0 * shape.sigma, reach_of(shape)
    c = s = m = mc = ms = n = 0.0
    for v in range(int(v0 - outer), int(v0 + outer) + 2):
        for u in range(int(u0 - outer), int(u0 + outer) + 2):
            du, dv = u - u0, v - v0
            square = du * du + dv * dv
            if inner * inner < square < outer * outer:
                x, y, level = (du * du - dv * dv) / square, 2.0 * du * dv / square, float(image[v, u])
                c, s, m, mc, ms, n = c + level * x, s + level * y, m + level, mc + x, ms + y, n + 1.0
    return 0.5 * atan2(s - m * ms / n, c - m * mc / n)


@kernel
def gradient(shape, du, dv, q, g):
    """Model at (du, dv) from the centre; g (PARAMETERS,): its derivatives by q (PARAMETERS,), whose centre is 0."""
    rho, sine, cosine, inverse = sqrt(du * du + dv * dv), sin(q[ANGLE]), cos(q[ANGLE]), 1.0 / shape.sigma
    across, along = cosine * dv - sine * du, cosine * du + sine * dv
    edge = (rho - q[RADIUS]) * inverse
    disc = 0.5 - 0.5 * erf(edge / SQRT2)
    rim = NORM * exp(-0.5 * edge * edge) * inverse
    strip = slope = 0.0
    if abs(across) < shape.half + FAR * shape.sigma and disc < 1.0:
        low, high = (across + shape.half) * inverse, (across - shape.half) * inverse
        strip = 0.5 * (erf(low / SQRT2) - erf(high / SQRT2))
        slope = NORM * (exp(-0.5 * low * low) - exp(-0.5 * high * high)) * inverse
    skewed = across / shape.half * strip
    line, tilt = q[STRIP] * strip + q[SKEW] * skewed, 1.0 - disc
    tilt *= q[STRIP] * slope + q[SKEW] * (strip + across * slope) / shape.half
    rise = (q[DISC] - line) * rim
    outward = rise / max(rho, 1e-9)
    g[CENTRE_U], g[CENTRE_V] = outward * du + tilt * sine, outward * dv - tilt * cosine
    g[ANGLE], g[RADIUS], g[DISC] = -tilt * along, rise, disc
    g[STRIP], g[SKEW] = strip * (1.0 - disc), skewed * (1.0 - disc)
    g[GROUND], g[SLOPE_U], g[SLOPE_V] = 1.0, du, dv
    ground = q[GROUND] + q[SLOPE_U] * du + q[SLOPE_V] * dv
    return ground + line * (1.0 - disc) + q[DISC] * disc


@kernel
def invert(matrix, inverse):
    """Inverse of a symmetric positive definite matrix (PARAMETERS, PARAMETERS) by Gauss-Jordan; False if it is not."""
    n = len(matrix)
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 1.0 if i == j else 0.0
    for k in range(n):
        pivot = matrix[k, k]
        if not pivot > 1e-12:
            return False
        for j in range(n):
            matrix[k, j] /= pivot
            inverse[k, j] /= pivot
        for i in range(n):
            factor = matrix[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    matrix[i, j] -= factor * matrix[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return True


@kernel
def accumulate(image, shape, u0, v0, q, with_residuals, normal, right, spread, g):
    """Sums over the window: J'J in normal, J'r in right, J' diag(r^2) J in spread; sum of r^2 and number of pixels.

    The priors of the angle and the radius are not in the sums.
    """
    reach = reach_of(shape)
    total = count = 0.0
    for i in range(PARAMETERS):
        right[i] = 0.0
        for j in range(PARAMETERS):
            normal[i, j] = spread[i, j] = 0.0
    for v in range(int(v0 - reach), int(v0 + reach) + 2):
        for u in range(int(u0 - reach), int(u0 + reach) + 2):
            du, dv = u - u0, v - v0
            if du * du + dv * dv > reach * reach:
                continue
            r = image[v, u] - gradient(shape, du, dv, q, g)
            total, count = total + r * r, count + 1.0
            for i in range(PARAMETERS):
                right[i] += g[i] * r
                for j in range(i + 1):
                    normal[i, j] += g[i] * g[j]
                    if with_residuals:
                        spread[i, j] += g[i] * g[j] * r * r
    for i in range(PARAMETERS):
        for j in range(i):
            normal[j, i], spread[j, i] = normal[i, j], spread[i, j]
    return total, count


@kernel
def correlation(image, shape, u0, v0, q, along_u, g):
    """Correlation of neighbouring residuals along u or v over the window, 0 to MOST_ALIKE."""
    reach = reach_of(shape)
    product = square = 0.0
    u1, v1, size = int(u0 - reach), int(v0 - reach), int(2.0 * reach) + 3
    for i in range(size):
        last = 0.0
        for j in range(size):
            u, v = (u1 + j, v1 + i) if along_u else (u1 + i, v1 + j)
            du, dv = u - u0, v - v0
            r = 0.0
            if du * du + dv * dv <= reach * reach:
                r = image[v, u] - gradient(shape, du, dv, q, g)
            product, square, last = product + r * last, square + r * r, r
    return min(max(product / max(square, 1e-12), 0.0), MOST_ALIKE)


@kernel
def sandwich(inverse, spread, i, j):
    """Element (i, j) of inverse spread inverse: covariance under residuals of unequal size (White 1980)."""
    total = 0.0
    for k in range(PARAMETERS):
        for m in range(PARAMETERS):
            total += inverse[i, k] * spread[k, m] * inverse[m, j]
    return total


@kernel
def inside(image, shape, u0, v0):
    """Whether the window around (u0, v0) lies in the image (height, width)."""
    reach = ceil(reach_of(shape)) + 1.0
    return reach <= u0 < image.shape[1] - reach and reach <= v0 < image.shape[0] - reach


@kernel
def add_priors(normal, right, shape, q, first, variance):
    """What is known of the angle and the radius beforehand, against residuals of this variance."""
    variance = max(variance, QUANTISATION)
    turn, size = variance / TURN_DEVIATION**2, variance / (SIZE_DEVIATION * shape.radius) ** 2
    normal[ANGLE, ANGLE] += turn
    right[ANGLE] -= turn * (q[ANGLE] - first)
    normal[RADIUS, RADIUS] += size
    right[RADIUS] -= size * (q[RADIUS] - shape.radius)


@kernel
def levels_only(normal, right):
    """Leave the linear parameters free alone."""
    for i in range(LINEAR):
        right[i] = 0.0
        for j in range(PARAMETERS):
            normal[i, j] = normal[j, i] = 1.0 if i == j else 0.0


@kernel
def improve(inverse, right, q, radius, correction):
    """Correct q by inverse right, the centre by 0.3 radius at most; the centre's shift (u, v)."""
    for i in range(PARAMETERS):
        correction[i] = 0.0
        for j in range(PARAMETERS):
            correction[i] += inverse[i, j] * right[j]
    longest = sqrt(correction[CENTRE_U] ** 2 + correction[CENTRE_V] ** 2)
    factor = min(1.0, 0.3 * radius / max(longest, 1e-12))
    q[ANGLE] += min(max(factor * correction[ANGLE], -0.2), 0.2)
    q[RADIUS] = min(max(q[RADIUS] + factor * correction[RADIUS], 0.5 * radius), 1.5 * radius)
    for i in range(LINEAR, PARAMETERS):
        q[i] += factor * correction[i]
    return factor * correction[CENTRE_U], factor * correction[CENTRE_V]


@kernel
def fit_disc(image, shape, u0, v0, w):
    """Fit from a centre that is right to about half the radius; image: (H, W) uint8; w: (ROOM,) scratch."""
    n, size = PARAMETERS, PARAMETERS * PARAMETERS
    normal, inverse = w[:size].reshape(n, n), w[size : 2 * size].reshape(n, n)
    spread = w[2 * size : 3 * size].reshape(n, n)
    right, q, g = w[3 * size : 3 * size + n], w[3 * size + n : 3 * size + 2 * n], w[3 * size + 2 * n : 3 * size + 3 * n]
    missed = Fit(u0, v0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, False)
    if not inside(image, shape, u0, v0):
        return missed
    first_u, first_v, first = u0, v0, direction(image, shape, u0, v0)
    for i in range(n):
        q[i] = 0.0
    q[ANGLE], q[RADIUS], q[DISC] = first, shape.radius, 1.0
    settled = False
    for iteration in range(ITERATIONS):
        total, count = accumulate(image, shape, u0, v0, q, False, normal, right, spread, g)
        if iteration == 0:
            levels_only(normal, right)
        else:
            add_priors(normal, right, shape, q, first, total / (count - n))
        if not invert(normal, inverse):
            return missed
        du, dv = improve(inverse, right, q, shape.radius, g)
        u0, v0 = u0 + du, v0 + dv
        away = (u0 - first_u) ** 2 + (v0 - first_v) ** 2
        if not away < shape.radius * shape.radius or not inside(image, shape, u0, v0):
            return missed
        settled = iteration > 0 and du * du + dv * dv < NEARLY * NEARLY
        if settled and du * du + dv * dv < SETTLED * SETTLED:
            break
    total, count = accumulate(image, shape, u0, v0, q, True, normal, right, spread, g)
    variance = total / (count - n)
    add_priors(normal, right, shape, q, first, variance)
    if not settled or not invert(normal, inverse):
        return missed
    uu, uv, vv = sandwich(inverse, spread, 0, 0), sandwich(inverse, spread, 0, 1), sandwich(inverse, spread, 1, 1)
    # Residuals that are alike count as fewer (Bartlett 1946, for a first-order process along both axes).
    alike_u = correlation(image, shape, u0, v0, q, True, g)
    alike_v = correlation(image, shape, u0, v0, q, False, g)
    rest = count / (count - n) * (1.0 + alike_u) * (1.0 + alike_v) / ((1.0 - alike_u) * (1.0 - alike_v))
    return Fit(u0, v0, rest * uu, rest * uv, rest * vv, q[DISC], q[STRIP], q[RADIUS], sqrt(variance), True)
