"""From pixels to the plane of motion: radial distortion undone, then the homography through surveyed points.

A pinhole camera sees a plane through a homography (Hartley, Zisserman 2004, section 2.3), however it is tilted; an
affinity, as Trigo et al. 2014 take it, holds where the depth does not change across the view.
"""

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np

NEWTON_STEPS = 8  # of the inverse distortion
STEP = 0.01  # of the derivatives' differences [pixel]


class Lens(NamedTuple):
    """f: focal length [pixel]; cu, cv: principal point [pixel]; k: r_d = r (1 + k r^2), r in focal lengths."""

    f: float
    cu: float
    cv: float
    k: float


class Turned(NamedTuple):
    """How a camera was turned since its calibration: rotation vector in its axes right, down, ahead [rad]."""

    x: float
    y: float
    z: float


STILL = Turned(0.0, 0.0, 0.0)


def rotation(turned: Turned) -> np.ndarray:
    """(3, 3) that takes directions as the turned camera was at calibration to those as it is (Rodrigues)."""
    angle = sqrt(turned.x**2 + turned.y**2 + turned.z**2)
    cross = np.array([[0.0, -turned.z, turned.y], [turned.z, 0.0, -turned.x], [-turned.y, turned.x, 0.0]])
    if angle == 0.0:
        return np.eye(3)
    return np.eye(3) + sin(angle) / angle * cross + (1.0 - cos(angle)) / angle**2 * cross @ cross


def rays(lens: Lens, pixels: np.ndarray) -> np.ndarray:
    """(k, 3) directions that pixels (k, 2) see, right, down and ahead of the camera; ahead is 1."""
    seen = (pixels - (lens.cu, lens.cv)) / lens.f
    square = lens.k * (seen**2).sum(axis=1)
    g = np.ones(len(seen))  # r = g r_d, where g (1 + k r_d^2 g^2) = 1
    for _ in range(NEWTON_STEPS):
        g -= (g * (1.0 + square * g * g) - 1.0) / (1.0 + 3.0 * square * g * g)
    return np.column_stack([g[:, None] * seen, np.ones(len(seen))])


def seen_at(lens: Lens, directions: np.ndarray) -> np.ndarray:
    """Pixels (k, 2) that see directions (k, 3): the inverse of rays()."""
    x = directions[:, :2] / directions[:, 2:]
    return np.array([lens.cu, lens.cv]) + lens.f * (1.0 + lens.k * (x**2).sum(axis=1))[:, None] * x


def undistorted(lens: Lens, turned: Turned, pixels: np.ndarray) -> np.ndarray:
    """Pixels (k, 2) as a camera without distortion, in its direction of calibration, would see them."""
    there = rays(lens, pixels) @ rotation(turned)
    return np.array([lens.cu, lens.cv]) + lens.f * there[:, :2] / there[:, 2:]


def mapped(h: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (k, 2) through the homography h (9,)."""
    there = points @ h.reshape(3, 3)[:, :2].T + h.reshape(3, 3)[:, 2]
    return there[:, :2] / there[:, 2:]


def to_plane(lens: Lens, turned: Turned, h: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """North and down (k, 2) [m] of what pixels (k, 2) show in the plane."""
    return mapped(h, undistorted(lens, turned, pixels))


def plane_derivatives(lens: Lens, turned: Turned, h: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """(k, 2, 2) derivatives of north and down (rows) by column and row of the image [m/pixel]."""
    columns = []
    for step in np.array([[STEP, 0.0], [0.0, STEP]]):
        ahead, back = (to_plane(lens, turned, h, pixels + s * step) for s in (1.0, -1.0))
        columns.append(0.5 / STEP * (ahead - back))
    return np.stack(columns, axis=2)


def _normaliser(points: np.ndarray) -> np.ndarray:
    """Takes the points' middle to the origin and their mean distance from it to sqrt 2 (ibid., section 4.4.4)."""
    middle = points.mean(axis=0)
    s = sqrt(2.0) / np.linalg.norm(points - middle, axis=1).mean()
    return np.array([[s, 0.0, -s * middle[0]], [0.0, s, -s * middle[1]], [0.0, 0.0, 1.0]])


def homography(pixels: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """(9,) from undistorted pixels (k, 2) to the plane (k, 2) [m]; with three points the affinity through them.

    Normalised direct linear transformation (ibid., algorithm 4.2). Raises ValueError if the points, or all but one of
    them, lie on a line, or if no camera sees them so.
    """
    for name, points in (("pixels", pixels), ("positions", plane)):
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[1] <= 1e-3 * spread[0]:
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
    _, sizes, vectors = np.linalg.svd(np.array(rows))
    if sizes[7] <= 1e-3 * sizes[0]:
        raise ValueError("all reference points but one lie on a line: move one off it, or give three that do not")
    h = np.linalg.inv(b) @ vectors[-1].reshape(3, 3) @ a
    depths = pixels @ h[2, :2] + h[2, 2]
    if not depths.min() * depths.max() > 0.0:
        raise ValueError("no camera sees the reference positions at these pixels: are they in the same order?")
    return np.ravel(h / h[2, 2])


def scale_deviation(pixels: np.ndarray, deviation: float) -> np.ndarray:
    """(2,) relative standard deviations of the scales along u and v, of points read with this deviation [pixel].

    As of an affinity's diagonal in least squares, the points about their middle; 1 at most, as of points in one row.
    """
    spread = np.linalg.norm(pixels - pixels.mean(axis=0), axis=0)
    return deviation / np.maximum(spread, max(deviation, np.finfo(float).tiny))
