"""The steady line of a law of drag between any two ends, by quadrature; Bhattacharya et al. 2011, eq. 9, with any law.

phi is the angle of the line's normal from the tow, and w with tan(phi) = sinh(w) runs along the line, 0 at the apex. Of
the apex's tension over c v^power, T_0 [m], the line is T_0 times a curve that the law alone gives:

    linear, c_V = rho c_S:       T = cosh^rho w,                 ds/dw = T
    quadratic, part by part:     T = exp(rho (sinh w - phi)),    ds/dw = T cosh w
    quadratic, isotropic:        T = cosh w,                     ds/dw = T

with dx = ds / cosh w across the tow and dy = ds tanh w along it. So linear drag with rho = 1, quadratic drag across
only and isotropic quadratic drag have the very same shapes: no picture of a steady tow tells them apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from pipeline.analysis.coverage.drag import Drag

CELL, FARTHEST = 0.05, 45.0  # of the table in w: its spacing, and its end at the most
STEEPEST = 16.0  # logarithm of ds/dw at which the table ends: a line 1e7 times its radius at the apex
ITERATIONS, CLOSED, LONGEST = 60, 1e-11, 1.0  # of Newton's method for the ends: at most, to this, its longest step
STARTS, NEAR = 65, 1e-5  # places among which a point's nearest is first looked for; what remains of w then


class Curve:
    """The law's curve for T_0 = 1."""

    def __init__(self, drag: Drag):
        """Tabulated by quadrature of order ten, with cubics between, to 2e-8 of s, x and y."""
        self.drag = drag
        last = FARTHEST
        w = np.arange(0.0, FARTHEST + CELL, CELL)
        too_steep = np.log(_slope(drag, w)[0]) > STEEPEST
        if too_steep.any():
            last = float(w[np.argmax(too_steep)])
        w = np.arange(0.0, last + CELL, CELL)
        node, weight = np.polynomial.legendre.leggauss(5)
        inside = _change(drag, w[:-1, None] + 0.5 * CELL * (node + 1.0))
        values = np.zeros((len(w), 3))
        values[1:] = np.cumsum(0.5 * CELL * np.einsum("k,ikj->ij", weight, inside), axis=0)
        self.last = float(w[-1])
        self._table = CubicHermiteSpline(w, values, _change(drag, w))

    def at(self, w: np.ndarray) -> np.ndarray:
        """Length, across and along from the apex: (3, *shape of w); beyond the table at its end."""
        found = self._table(np.minimum(np.abs(w), self.last)).transpose(-1, *range(w.ndim))
        found[:2] *= np.sign(w)
        return found

    def tension(self, w: np.ndarray) -> np.ndarray:
        """T."""
        return _slope(self.drag, np.minimum(np.abs(w), self.last))[1]

    def slope(self, w: np.ndarray) -> np.ndarray:
        """ds/dw."""
        return _slope(self.drag, np.minimum(np.abs(w), self.last))[0]


@lru_cache(maxsize=64)
def curve_of(drag: Drag) -> Curve:
    """The law's curve, kept."""
    return Curve(drag)


def _slope(drag: Drag, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """ds/dw and T at w >= 0."""
    if drag.is_isotropic or drag.power == 1:
        tension = np.cosh(w) ** drag.ratio
        return tension, tension
    steep = np.minimum(drag.ratio * (np.sinh(w) - np.arctan(np.sinh(w))), 2.0 * STEEPEST)
    return np.exp(steep) * np.cosh(w), np.exp(steep)


def _change(drag: Drag, w: np.ndarray) -> np.ndarray:
    """d(s, x, y)/dw, last axis."""
    ds = _slope(drag, w)[0]
    return np.stack([ds, ds / np.cosh(w), ds * np.tanh(w)], axis=-1)


@dataclass(frozen=True)
class Lines:
    """Lines of one law and length between k pairs of ends: (k,) each. scale: T_0 [m]; first, last: w of the ends."""

    curve: Curve
    scale: np.ndarray
    first: np.ndarray
    last: np.ndarray

    def tension(self) -> np.ndarray:
        """At both ends over c v^power [m]: (k, 2)."""
        return self.scale[:, None] * self.curve.tension(np.stack([self.first, self.last], axis=1))


def between(curve: Curve, length: float, across: np.ndarray, along: np.ndarray) -> Lines:
    """The lines of this length [m] whose last end lies `across` (> 0) and `along` (ahead) of the first: (k,) [m].

    By Newton's method in the mean and the logarithm of the half width in w, from the catenary, which is exact for the
    three laws that have it. NaN where no line is found: where the ends are as far apart as the line is long.
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        excess = np.log(np.sqrt(length**2 - along**2) / across - 1.0)
        tilt = along / length
        mean, half = np.arctanh(tilt), np.log(_half_of_catenary(excess))
        for _ in range(ITERATIONS):
            f = _misses(curve, mean, half, excess, tilt)
            if np.nanmax(np.abs(f), initial=0.0) < CLOSED:
                break
            tiny = 1e-6
            by_mean = (_misses(curve, mean + tiny, half, excess, tilt) - f) / tiny
            by_half = (_misses(curve, mean, half + tiny, excess, tilt) - f) / tiny
            det = by_mean[0] * by_half[1] - by_mean[1] * by_half[0]
            mean = mean - np.clip((by_half[1] * f[0] - by_half[0] * f[1]) / det, -LONGEST, LONGEST)
            half = half - np.clip((by_mean[0] * f[1] - by_mean[1] * f[0]) / det, -LONGEST, LONGEST)
        found = np.abs(_misses(curve, mean, half, excess, tilt)).max(axis=0) < 1e3 * CLOSED
        first, last = mean - np.exp(half), mean + np.exp(half)
        scale = length / (curve.at(last)[0] - curve.at(first)[0])
    return Lines(curve, *(np.where(found, one, np.nan) for one in (scale, first, last)))


def _misses(curve: Curve, mean: np.ndarray, half: np.ndarray, excess: np.ndarray, tilt: np.ndarray) -> np.ndarray:
    """(2, k): of the logarithm of the length that the level distance leaves over, and of the rise over the length."""
    a, b = curve.at(np.stack([mean - np.exp(half), mean + np.exp(half)])).transpose(1, 0, 2)
    s, x, y = b - a
    return np.stack([np.log(np.sqrt(s * s - y * y) / x - 1.0) - excess, y / s - tilt])


def _half_of_catenary(excess: np.ndarray) -> np.ndarray:
    """u of sinh(u) / u = 1 + exp(excess), by Newton's method for the logarithm, from above."""
    ratio = 1.0 + np.exp(excess)
    u = np.sqrt(6.0 * np.exp(excess)) + 1e-300
    u = np.minimum(u, 2.0 * np.log(2.0 * ratio) + 1.0)
    for _ in range(ITERATIONS):
        step = (np.log(np.sinh(u) / u) - np.log(ratio)) / (1.0 / np.tanh(u) - 1.0 / u)
        u = np.maximum(u - step, 0.1 * u)
        if np.nanmax(np.abs(step) / u, initial=0.0) < CLOSED:
            break
    return u


def misses(lines: Lines, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Signed distances (k, m) [m] of points from their line, ahead of it positive, and its curvature there [1/m].

    x, y: (k, m) across and along the tow from the first end. The line goes on beyond its ends.
    """
    curve, scale = lines.curve, lines.scale[:, None]
    _, x_a, y_a = curve.at(lines.first[:, None])
    places = lines.first[:, None] + (lines.last - lines.first)[:, None] * np.linspace(0.0, 1.0, STARTS)
    _, X, Y = curve.at(places)
    X, Y = scale * (X - x_a), scale * (Y - y_a)
    near = ((X[:, :, None] - x[:, None]) ** 2 + (Y[:, :, None] - y[:, None]) ** 2).argmin(axis=1)
    w = np.take_along_axis(places, near, axis=1)
    across = ds = co = np.ones_like(w)
    for _ in range(ITERATIONS):
        _, X, Y = curve.at(w)
        dx, dy = x - scale * (X - x_a), y - scale * (Y - y_a)
        co, si = 1.0 / np.cosh(w), np.tanh(w)
        ds, across = scale * curve.slope(w), co * dy - si * dx
        step = np.clip((co * dx + si * dy) / np.maximum(ds - across * co, 0.2 * ds), -0.5, 0.5)
        if np.nanmax(np.abs(step), initial=0.0) < NEAR:
            break
        w = w + step
    return across, co / ds
