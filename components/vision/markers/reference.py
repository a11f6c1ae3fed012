"""Whether surveyed points fit each other: five or more tell of a mistyped one among them."""

from __future__ import annotations

from math import hypot, inf, log, sqrt

import numpy as np

from components.vision.markers import calibration

LEAST = 5  # points that say more than a homography has numbers
GATE = 5.0  # deviations by which they miss each other, beyond which one is wrong
FINEST = 0.05  # of these deviations [pixel]: files of calibration are rounded
UNSURE = 2.0  # times the least misfit up to which another point may as well be the wrong one


def homography(lens: calibration.Lens, pixels: np.ndarray, plane: np.ndarray, deviation: float) -> np.ndarray:
    """(9,) through points whose undistorted pixels (k, 2) have this deviation [pixel]; plane: (k, 2) [m].

    Raises ValueError if they give none, or one of them misses the others'.
    """
    if len(pixels) < LEAST:
        return calibration.homography(pixels, plane)
    gate, unfit = GATE * max(deviation, FINEST), None
    try:
        h = calibration.homography(pixels, plane)
        if _misfit(h, pixels, plane, 8) <= gate:
            return h
    except ValueError as error:
        unfit = error
    costs, away = zip(*(_without(i, lens, pixels, plane) for i in range(len(pixels))), strict=True)
    order = np.argsort(costs)
    if costs[order[0]] == inf and unfit:
        raise unfit
    others = f"or the lens distorts, or reference_deviation is more than {deviation:g} pixel"
    if len(pixels) > LEAST and costs[order[0]] > gate:
        raise ValueError(
            f"the {len(pixels)} reference points miss each other, whichever is left out: two or more err, {others}"
        )
    named = [i for i in order if costs[i] <= UNSURE * max(costs[order[0]], gate)]
    raise ValueError(
        " or ".join(f"reference point {i + 1} misses the others by {away[i]:.3g} pixels" for i in named)
        + f": correct its reference_pixel or reference_position; {others}"
    )


def _without(i: int, lens: calibration.Lens, pixels: np.ndarray, plane: np.ndarray) -> tuple[float, float]:
    """How badly the points but one fit each other [pixel], inf if they give no plane; and how far they miss that one.

    Any four fit a homography, but not any is that of a camera with square pixels.
    """
    rest = np.arange(len(pixels)) != i
    try:
        h = calibration.homography(pixels[rest], plane[rest])
    except ValueError:
        return inf, inf
    away = float(np.linalg.norm(_seen(h, plane[[i]]) - pixels[[i]]))
    if len(pixels) > LEAST:
        return _misfit(h, pixels[rest], plane[rest], 8), away
    return _skew(lens, h) * float(np.linalg.norm(pixels[rest] - pixels[rest].mean(axis=0), axis=1).mean()), away


def _skew(lens: calibration.Lens, h: np.ndarray) -> float:
    """By what part the plane's axes are seen at another than a right angle, or in unequal scales: Zhang 2000, (3), (4).

    The focal length counts with the square of the plane's tilt, so that it need not be known well.
    """
    shown = np.linalg.inv(h.reshape(3, 3))
    axes = np.vstack([(shown[:2] - np.outer((lens.cu, lens.cv), shown[2])) / lens.f, shown[2]])
    north, down = axes[:, 0], axes[:, 1]
    lengths = np.linalg.norm(north), np.linalg.norm(down)
    return hypot(float(north @ down) / (lengths[0] * lengths[1]), log(lengths[0] / lengths[1]))


def _misfit(h: np.ndarray, pixels: np.ndarray, plane: np.ndarray, numbers: int) -> float:
    """Root of the mean square by which points miss a homography of so many numbers [pixel]."""
    return sqrt(float(((_seen(h, plane) - pixels) ** 2).sum()) / (2 * len(pixels) - numbers))


def _seen(h: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """Pixels (k, 2) of points of the plane."""
    return calibration.mapped(np.ravel(np.linalg.inv(h.reshape(3, 3))), plane)
