"""From pixels to the plane of motion: radial distortion undone, then the homography through surveyed points.

A pinhole camera sees a plane through a homography (Hartley, Zisserman 2004, section 2.3), however it is tilted; an
affinity, as Trigo et al. 2014 take it, holds where the depth does not change across the view.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from components.compiled import kernel

NEWTON_STEPS = 8  # of the inverse distortion
STEP = 0.01  # of the derivatives' differences [pixel]


class Lens(NamedTuple):
    """f: focal length [pixel]; cu, cv: principal point [pixel]; k: r_d = r (1 + k r^2), r in focal lengths."""

    f: float
    cu: float
    cv: float
    k: float


class Moved(NamedTuple):
    """How the image lies against the calibration's: turned by angle [rad] about the principal point, then by u, v."""

    u: float
    v: float
    angle: float


@kernel
def undistorted(lens, moved, u, v):
    """Pixel (u, v) as an ideal camera at its place of calibration would see it."""
    x, y = (u - moved.u - lens.cu) / lens.f, (v - moved.v - lens.cv) / lens.f
    x, y = x + moved.angle * y, y - moved.angle * x
    rd2 = x * x + y * y
    g = 1.0
    for _ in range(NEWTON_STEPS):
        g -= (g * (1.0 + lens.k * rd2 * g * g) - 1.0) / (1.0 + 3.0 * lens.k * rd2 * g * g)
    return lens.cu + lens.f * g * x, lens.cv + lens.f * g * y


@kernel
def distorted(lens, moved, u, v):
    """The inverse of undistorted, to first order in the angle."""
    x, y = (u - lens.cu) / lens.f, (v - lens.cv) / lens.f
    s = 1.0 + lens.k * (x * x + y * y)
    x, y = s * x, s * y
    x, y = x - moved.angle * y, y + moved.angle * x
    return lens.cu + lens.f * x + moved.u, lens.cv + lens.f * y + moved.v


@kernel
def mapped(h, a, b):
    """A point through the homography h (9,)."""
    w = h[6] * a + h[7] * b + h[8]
    return (h[0] * a + h[1] * b + h[2]) / w, (h[3] * a + h[4] * b + h[5]) / w


@kernel
def to_plane(lens, moved, h, u, v):
    """North and down [m] of what pixel (u, v) shows in the plane."""
    u, v = undistorted(lens, moved, u, v)
    return mapped(h, u, v)


@kernel
def plane_derivatives(lens, moved, h, u, v):
    """dn/du, dn/dv, dd/du, dd/dv [m/pixel]."""
    n1, d1 = to_plane(lens, moved, h, u + STEP, v)
    n0, d0 = to_plane(lens, moved, h, u - STEP, v)
    n3, d3 = to_plane(lens, moved, h, u, v + STEP)
    n2, d2 = to_plane(lens, moved, h, u, v - STEP)
    s = 0.5 / STEP
    return s * (n1 - n0), s * (n3 - n2), s * (d1 - d0), s * (d3 - d2)


@kernel
def plane_covariance(derivatives, uu, uv, vv):
    """Covariance nn, nd, dd [m^2] of a pixel's uu, uv, vv [pixel^2]."""
    a, b, c, d = derivatives
    nn = a * a * uu + 2.0 * a * b * uv + b * b * vv
    nd = a * c * uu + (a * d + b * c) * uv + b * d * vv
    return nn, nd, c * c * uu + 2.0 * c * d * uv + d * d * vv


def _normaliser(points: np.ndarray) -> np.ndarray:
    """Takes the points' middle to the origin and their mean distance from it to sqrt 2 (ibid., section 4.4.4)."""
    middle = points.mean(axis=0)
    s = sqrt(2.0) / np.linalg.norm(points - middle, axis=1).mean()
    return np.array([[s, 0.0, -s * middle[0]], [0.0, s, -s * middle[1]], [0.0, 0.0, 1.0]])


def homography(pixels: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """(9,) from undistorted pixels (k, 2) to the plane (k, 2) [m]; with three points the affinity through them.

    Normalised direct linear transformation (ibid., algorithm 4.2). Raises ValueError if the points lie on a line.
    """
    for name, points in (("pixels", pixels), ("positions", plane)):
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[1] < 1e-3 * spread[0]:
            raise ValueError(f"the reference {name} lie on a line: no scale across it follows from them")
    if len(pixels) == 3:
        solved = np.linalg.solve(np.column_stack([pixels, np.ones(3)]), plane)
        return np.concatenate([solved.T.ravel(), [0.0, 0.0, 1.0]])
    a, b = _normaliser(pixels), _normaliser(plane)
    rows = []
    for p, q in zip(pixels, plane, strict=True):
        x, y = (a @ [*p, 1.0])[:2], (b @ [*q, 1.0])[:2]
        rows.append([*x, 1.0, 0.0, 0.0, 0.0, *(-y[0] * np.array([*x, 1.0]))])
        rows.append([0.0, 0.0, 0.0, *x, 1.0, *(-y[1] * np.array([*x, 1.0]))])
    h = np.linalg.inv(b) @ np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3) @ a
    return np.ravel(h / h[2, 2])


def scale_deviation(pixels: np.ndarray, deviation: float) -> np.ndarray:
    """(2,) relative standard deviations of the scales along u and v, of points read with this deviation [pixel].

    As of an affinity's diagonal in least squares, the points about their middle.
    """
    return deviation / np.linalg.norm(pixels - pixels.mean(axis=0), axis=0)
