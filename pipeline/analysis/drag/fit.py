"""How well a law of drag fits pictures of a steady tow: chi-square over the ratio of its coefficients.

A point's distance from the line has the deviation of its noise, and in the mean half the noise's variance times the
line's curvature. Errors of the boats' positions and headings move all points of a boat's picture together, and the
ends: what is new in each picture is in the covariance, what stays is estimated beside its own deviation; both to first
order. Pulls are c v^power T_0 T at the ends; c is estimated with them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2 as chi2_distribution

from pipeline.analysis.coverage.drag import QUADRATIC, Drag
from pipeline.analysis.drag.curve import between, curve_of, misses
from pipeline.analysis.drag.pictures import Errors, Pictures

GRID = np.linspace(0.0, 1.0, 11)  # ratios among which the best is first looked for
CLOSE = 1e-4  # of the ratio
CERTAIN = 3.841  # chi-square of one freedom that 95 % stay below
CLEAR = 9.0  # chi-square above the best law's at which another is excluded: three standard deviations
UNLIKELY = 1e-3  # chance of a chi-square beyond which the best law does not fit either
MOVE = np.array([1e-4, 1e-4, 1e-5] * 2)  # by which a boat is moved, and turned, to see what it does [m, rad]


@dataclass(frozen=True)
class Family:
    """A law of drag up to the ratio of its coefficients; None where it has no choice of it."""

    name: str
    power: int
    ratio: float | None

    def law(self, ratio: float) -> Drag:
        """With this ratio."""
        return QUADRATIC if self.ratio is not None else Drag(self.name, self.power, ratio)


FAMILIES = (
    Family("linear", 1, None),
    Family("quadratic, part by part", 2, None),
    Family("quadratic, isotropic", 2, 1.0),
)


@dataclass(frozen=True)
class Fit:
    """chi2: least, at `ratio`; low, high: between which the ratio is with 95 %, 0 and 1 being its own bounds.

    coefficient: c_S [N s/m^2] or k [N s^2/m^3] by the pulls, None without; bias: (6,) of the boats' positions and
    headings; freedom: of chi2, the estimated numbers taken off.
    """

    family: Family
    ratio: float
    low: float
    high: float
    chi2: float
    freedom: int
    coefficient: float | None
    bias: np.ndarray


class Problem:
    """The pictures, whitened: what does not change from ratio to ratio."""

    def __init__(self, pictures: Pictures, errors: Errors):
        """Raises ValueError where no picture has points."""
        self.pictures, self.errors = pictures, errors
        self.valid = np.isfinite(pictures.deviation).reshape(len(pictures.pose), -1)
        self.counted = int(self.valid.sum()) + int(np.isfinite(pictures.pull).sum())
        if not self.valid.any():
            raise ValueError("no point is seen in a steady tow")
        deviation = pictures.deviation.reshape(self.valid.shape)
        self.inverse = np.where(self.valid, 1.0 / np.where(self.valid, deviation, 1.0), 0.0)
        self.variance = np.where(self.valid, deviation, 0.0) ** 2
        self.slopes = np.zeros((*self.valid.shape, 6))
        self.factor: np.ndarray | None = None

    def chi2(self, law: Drag) -> tuple[float, np.ndarray, float | None]:
        """Chi-square at its least over biases and coefficient, these biases (6,), and the coefficient."""
        tension, distance = self._distances(law, np.zeros(6))
        if not np.isfinite(tension).all():
            return float("inf"), np.zeros(6), None
        r, J = self._whitened(distance[..., None])[..., 0].ravel(), self._whitened(self.slopes)
        total, bias = float(r @ r), np.zeros(6)
        sigma = self.errors.bias()
        if sigma.any():
            J = J.reshape(-1, 6)[:, sigma > 0.0]
            prior = np.diag(1.0 / sigma[sigma > 0.0] ** 2)
            bias[sigma > 0.0] = -np.linalg.solve(J.T @ J + prior, J.T @ r)
            total += float(r @ J @ bias[sigma > 0.0])
        pulled, coefficient = self._pulls(law, tension)
        return total + pulled, bias, coefficient

    def linearise(self, law: Drag) -> None:
        """Find what the boats' errors do to the distances, at this law; nothing where there are none."""
        if not self.errors.any():
            return
        at = self._distances(law, np.zeros(6))[1]
        for j in range(6):
            moved = self._distances(law, MOVE * (np.arange(6) == j))[1]
            self.slopes[..., j] = np.where(np.isfinite(moved), (moved - at) / MOVE[j], 0.0)
        each = self.slopes * self.inverse[..., None] * self.errors.each()
        # Of a picture's whitened distances the covariance is 1 + e e'; its inverse root by the small matrix 1 + e' e.
        values, vectors = np.linalg.eigh(np.einsum("kmi,kmj->kij", each, each))
        values = np.maximum(values, 0.0)
        part = np.where(values > 1e-12, (1.0 / np.sqrt(1.0 + values) - 1.0) / np.maximum(values, 1e-300), 0.0)
        self.factor = np.einsum("kmi,kij,kj,klj,knl->kmn", each, vectors, part, vectors, each)

    def _whitened(self, rows: np.ndarray) -> np.ndarray:
        """(k, m, c) over the points' deviations, free of what the boats' errors have in common."""
        rows = rows * self.inverse[..., None]
        return rows if self.factor is None else rows + np.einsum("kmn,knc->kmc", self.factor, rows)

    def _distances(self, law: Drag, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tension at the boats over c v^power (k, 2) [m], NaN where no line reaches; points' distances (k, m) [m]."""
        pictures = self.pictures
        ends, points = pictures.placed(moved)
        k = np.arange(len(ends))
        port = (ends[:, 0, 0] > ends[:, 1, 0]).astype(int)
        first, last = ends[k, port], ends[k, 1 - port]
        lines = between(curve_of(law), pictures.length, *(last - first).T)
        places = points.reshape(len(ends), -1, 2) - first[:, None]
        places = np.where(self.valid[..., None], places, 0.0)
        distance, curvature = misses(lines, places[..., 0], places[..., 1])
        tension = np.where(port[:, None] == 0, lines.tension(), lines.tension()[:, ::-1])
        return tension, np.where(self.valid, distance + 0.5 * self.variance * curvature, 0.0)

    def _pulls(self, law: Drag, tension: np.ndarray) -> tuple[float, float | None]:
        """Chi-square of the pulls at the best coefficient, and that."""
        pictures = self.pictures
        there = np.isfinite(pictures.pull)
        if not there.any():
            return 0.0, None
        deviation = pictures.pull_error * pictures.pull[there]
        model = (pictures.speed[:, None] ** law.power * tension)[there] / deviation
        measured = pictures.pull[there] / deviation
        coefficient = float(model @ measured / (model @ model))
        return float(((measured - coefficient * model) ** 2).sum()), coefficient


def fit(pictures: Pictures, errors: Errors, family: Family) -> Fit:
    """The family's best ratio and how far it may be off. Raises ValueError where no picture has points."""
    problem = Problem(pictures, errors)
    if family.ratio is not None:
        problem.linearise(family.law(family.ratio))
        chi2, bias, coefficient = problem.chi2(family.law(family.ratio))
        freedom = problem.counted - (coefficient is not None)
        return Fit(family, family.ratio, family.ratio, family.ratio, chi2, freedom, coefficient, bias)

    over = cache(lambda ratio: problem.chi2(family.law(ratio))[0])
    best = _best(over)
    if errors.any():
        problem.linearise(family.law(best))
        over.cache_clear()
        best = _best(over)
    least, bias, coefficient = problem.chi2(family.law(best))
    freedom = problem.counted - 1 - (coefficient is not None)
    allowed = CERTAIN * max(1.0, least / max(freedom, 1))
    low, high = (_crossing(lambda r: over(r) - least - allowed, best, side) for side in (0.0, 1.0))
    return Fit(family, best, low, high, least, freedom, coefficient, bias)


def _best(chi2: Callable[[float], float]) -> float:
    """The ratio of the least chi-square."""
    values = [chi2(float(ratio)) for ratio in GRID]
    k = int(np.argmin(values))
    bounds = float(GRID[max(k - 1, 0)]), float(GRID[min(k + 1, len(GRID) - 1)])
    found = minimize_scalar(chi2, bounds=bounds, method="bounded", options={"xatol": CLOSE})
    return min((float(GRID[k]), float(found.x)), key=chi2)  # pyright: ignore


def _crossing(excess: Callable[[float], float], best: float, side: float) -> float:
    """Where between the best ratio and a bound of its range chi-square is too large; the bound where nowhere."""
    if best == side or excess(side) <= 0.0:
        return side
    return float(brentq(excess, best, side, xtol=CLOSE))  # pyright: ignore


@dataclass(frozen=True)
class Judgement:
    """fits: of all families, the best first. equal: names of those whose chi-square is not clearly above the least.

    scale: chi-square over its freedom of the best, where above 1: intervals and differences are judged by it.
    fits_at_all: whether the best is within what the noise allows.
    """

    fits: list[Fit]
    equal: list[str]
    scale: float
    fits_at_all: bool


def judge(pictures: Pictures, errors: Errors) -> Judgement:
    """Fit all laws and compare. Raises ValueError where no picture has points."""
    fits = sorted((fit(pictures, errors, family) for family in FAMILIES), key=lambda one: one.chi2)
    best = fits[0]
    freedom = max(best.freedom, 1)
    scale = max(1.0, best.chi2 / freedom)
    equal = [one.family.name for one in fits if one.chi2 - best.chi2 <= CLEAR * scale]
    return Judgement(fits, equal, scale, bool(best.chi2 <= chi2_distribution.ppf(1.0 - UNLIKELY, freedom)))
