"""The fits as published: two Nelder-Mead searches a frame, for the plane and then for the catenary in it.

Drupt et al. 2022, III.A: the plane by least point-plane distance from a guess through three markers, the inclined
catenary (C, x0, z0) from the static vertical catenary between the visible markers nearest to the ends. SciPy's
algorithm and first simplex are those of the paper's `fminsearch` (Lagarias et al. 1998). Where the paper is silent:
the three markers are the outermost two and the one furthest from their chord; the static catenary's length is the
arc between its markers, or the polyline through those in between if arcs are unknown.
"""

from __future__ import annotations

from dataclasses import replace
from math import cosh, sqrt

import numpy as np
from scipy.optimize import brentq, minimize

from pipeline.analysis.catenary_fit import FITTED, NO_CATENARY, NOT_CONVERGED, Catenaries
from pipeline.analysis.compiled import kernel
from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.plane import Planes

# fminsearch stops at 1e-4, in the unit of the lengths: too coarse in metres, where e_P is 5e-4.
TOLERANCE = 1e-9
EVALUATIONS = 3000  # fminsearch's default of 600 ends before that tolerance
TAUT = 1.0 + 1e-6  # length over chord, at least: a static catenary needs some slack
NED_TO_NWU = np.array([1.0, -1.0, -1.0])


def search(
    frames: MarkerFrames, order: np.ndarray, planes: Planes, chosen_frames: np.ndarray
) -> tuple[Planes, Catenaries]:
    """Planes and catenaries of the chosen frames (k,) bool; order: (k, m) markers used, then -1.

    Which frames can be fitted at all is for the caller to know; the first-order tilt is taken from `planes`.
    """
    k = len(planes.n)
    planes = replace(
        planes, **{name: getattr(planes, name).copy() for name in ("inclination", "psi", "e_plane", "normal", "points")}
    )
    status, numbers = np.full(k, NO_CATENARY), np.full((k, 5), np.nan)
    for f in np.flatnonzero(chosen_frames):
        n = planes.n[f]
        chosen = order[f, :n]
        points = (frames.position[f, chosen] - frames.position[f, chosen[0]]) * NED_TO_NWU
        centroid = points.mean(axis=0)
        normal, planes.e_plane[f] = search_plane(points)
        across = np.hypot(normal[0], normal[1])
        x_p = np.array([normal[1], -normal[0], 0.0]) / across
        if x_p @ (points[-1] - points[0]) < 0.0:
            x_p, normal = -x_p, -normal
        flat = np.stack([(points - centroid) @ x_p, (points - centroid) @ np.cross(x_p, normal)], axis=1)
        planes.points[f, :n], planes.normal[f] = flat, normal * NED_TO_NWU
        planes.inclination[f], planes.psi[f] = np.arctan2(normal[2], across), np.arctan2(-x_p[1], x_p[0])
        length = _length(points, None if frames.arc is None else float(frames.arc[chosen[-1]] - frames.arc[chosen[0]]))
        (C, x0, z0), e_catenary, found = search_catenary(flat, _static(points, flat, length))
        # The form of catenary_fit, about the middle of the markers.
        middle = 0.5 * (flat[:, 0].max() + flat[:, 0].min())
        beta = C * (middle - x0)
        status[f] = FITTED if found else NOT_CONVERGED
        numbers[f] = middle, z0 + (np.cosh(beta) - 1.0) / C, beta, C, e_catenary
    return planes, Catenaries(status, *numbers.T)


def search_plane(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit normal (3,) of the plane of least RMS distance to points (n, 3), and that distance."""
    chord = points[-1] - points[0]
    aside = np.cross(points - points[0], chord)
    normal = aside[np.argmax(np.linalg.norm(aside, axis=1))]
    normal = normal / np.linalg.norm(normal)
    across = np.cross(normal, chord)
    axes = np.stack([normal, chord / np.linalg.norm(chord), across / np.linalg.norm(across)])
    start = np.array([0.0, 0.0, normal @ points[0]])
    found = _minimise(lambda q: _plane_distance(q, axes, points), start)
    normal = axes[0] + found.x[0] * axes[1] + found.x[1] * axes[2]
    return normal / np.linalg.norm(normal), float(found.fun)


def search_catenary(flat: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, float, bool]:
    """(C, x0, z0) of least RMS distance at the same x to flat (n, 2), that distance, and whether it is a number.

    As with fminsearch, a search that ran out of evaluations gives the best it found.
    """
    found = _minimise(lambda q: _catenary_distance(q, flat), start)
    return found.x, float(found.fun), bool(np.isfinite(found.fun))


def _minimise(distance, start: np.ndarray):
    options = {"xatol": TOLERANCE, "fatol": TOLERANCE, "maxiter": EVALUATIONS, "maxfev": EVALUATIONS}
    return minimize(distance, start, method="Nelder-Mead", options=options)


@kernel
def _plane_distance(q, axes, points):
    """RMS distance to the plane of normal axes[0] + q[0] axes[1] + q[1] axes[2] and offset q[2]."""
    x = axes[0, 0] + q[0] * axes[1, 0] + q[1] * axes[2, 0]
    y = axes[0, 1] + q[0] * axes[1, 1] + q[1] * axes[2, 1]
    z = axes[0, 2] + q[0] * axes[1, 2] + q[1] * axes[2, 2]
    square = 0.0
    for i in range(len(points)):
        square += (x * points[i, 0] + y * points[i, 1] + z * points[i, 2] - q[2]) ** 2
    return sqrt(square / (len(points) * (x * x + y * y + z * z)))


@kernel
def _catenary_distance(q, flat):
    """RMS distance at the same x to the catenary (C, x0, z0)."""
    square = 0.0
    for i in range(len(flat)):
        square += (flat[i, 1] - q[2] - (cosh(q[0] * (flat[i, 0] - q[1])) - 1.0) / q[0]) ** 2
    return sqrt(square / len(flat))


def _length(points: np.ndarray, arc: float | None) -> float:
    """Length of line between the outermost markers [m]."""
    chord = float(np.linalg.norm(points[-1] - points[0]))
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) if arc is None else float(arc)
    return max(length, TAUT * chord)


def _static(points: np.ndarray, flat: np.ndarray, length: float) -> np.ndarray:
    """(C, x0, z0) of the vertical catenary of this length between the outermost markers, put at the first in F_p."""
    rise = points[-1, 2] - points[0, 2]
    span = max(float(np.hypot(*(points[-1] - points[0])[:2])), 1e-6 * length)
    ratio = sqrt(length**2 - rise**2) / span
    # sinh(y) / y = ratio with y = C span / 2; from 1 + y^2/6 <= sinh(y)/y and sinh(y)/y >= e^y / (2 y) (1 - e^-2)
    high = min(sqrt(6.0 * (ratio - 1.0)), 2.0 * np.log(2.0 * ratio) + 2.0)
    half = float(brentq(lambda y: np.sinh(y) / y - ratio, 1e-9, high + 1e-6))  # pyright: ignore[reportArgumentType]
    C = 2.0 * half / span
    middle = np.arctanh(rise / length)
    x0 = flat[0, 0] + (half - middle) / C
    return np.array([C, x0, flat[0, 1] - (np.cosh(half - middle) - 1.0) / C])
