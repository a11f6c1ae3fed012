"""Alignment and scales of the image by the markers' known spacing, Trigo et al. 2014, (1) to (3), and right.

Markers lying on the floor give the inclination of the image and the horizontal scale (1), (2); the vertical scale
follows from a sloping segment of known length, its image of length d at the angle theta: s_theta = l / d. The printed

    s_y^2 = (s_theta s_x sin theta)^2 / (s_x^2 - s_theta^2 cos^2 theta)                              (3)

is right where theta is the segment's true angle, which an image of unequal scales does not show. With the image's angle
l^2 = (s_x d cos theta)^2 + (s_y d sin theta)^2, so that s_y^2 = (s_theta^2 - s_x^2 cos^2 theta) / sin^2 theta.
"""

from __future__ import annotations

from math import atan2, cos, hypot, isfinite, sin, sqrt
from typing import NamedTuple

import numpy as np

LYING = 0.06  # sine of the angle from the first two markers within which others lie on the floor too
SLOPING = 0.35  # sine of the angle from which a segment tells the vertical scale


class Affinity(NamedTuple):
    """angle: of the floor in the image [rad]; s_x, s_y: scales along and across it [m/pixel]; u, v: of marker 0."""

    angle: float
    s_x: float
    s_y: float
    u: float
    v: float


def aligned(pixels: np.ndarray, angle: float) -> np.ndarray:
    """Pixels (k, 2) turned so that a floor at the angle [rad] is level."""
    c, s = cos(angle), sin(angle)
    return pixels @ np.array([[c, -s], [s, c]])


def vertical_scale(s_x: float, s_theta: float, theta: float) -> float:
    """(3) as printed, theta [rad] being the true angle; nan where the denominator is not positive."""
    below = s_x**2 - (s_theta * cos(theta)) ** 2
    return sqrt((s_theta * s_x * sin(theta)) ** 2 / below) if below > 0.0 else float("nan")


def calibrate(pixels: np.ndarray, spacing: float) -> Affinity:
    """The affinity of an image whose markers (k, 2), in their order from the floor up, are one spacing [m] apart.

    With (3) as printed and the angles of the image, as far as they give a scale, else s_x. Raises ValueError if less
    than two lie on the floor, or two are at one pixel.
    """
    if len(pixels) < 2:
        raise ValueError(f"chain_pixel tells {len(pixels)} markers; expected those of two at least, lying on the floor")
    steps = np.diff(pixels, axis=0)
    if not np.hypot(*steps.T).min() > 0.0:
        raise ValueError("two markers that follow each other are at one pixel, which gives no scale")
    first = steps[0] / np.hypot(*steps[0])
    lies = np.abs(first[0] * steps[:, 1] - first[1] * steps[:, 0]) < LYING * np.linalg.norm(steps, axis=1)
    resting = int(np.argmin(np.append(lies, False))) + 1
    along = pixels[resting - 1] - pixels[0]
    angle = atan2(along[1], along[0])
    s_x = spacing * (resting - 1) / hypot(*along)
    found = []
    for du, dv in np.diff(aligned(pixels, angle), axis=0):
        d = hypot(du, dv)
        if abs(dv) > SLOPING * d:
            found.append(vertical_scale(s_x, spacing / d, atan2(abs(dv), du)))
    good = [s for s in found if isfinite(s)]
    return Affinity(angle, s_x, float(np.mean(good)) if good else s_x, *map(float, pixels[0]))


def to_plane(affinity: Affinity, pixels: np.ndarray, first: np.ndarray) -> np.ndarray:
    """North and down (k, 2) [m] of pixels (k, 2); first: (2,) of marker 0 where it lay at calibration [m]."""
    turned = aligned(pixels - (affinity.u, affinity.v), affinity.angle)
    return first + turned * (affinity.s_x, affinity.s_y)
