"""A patch of oil on the water and how much of it a line sweeps up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from pipeline.analysis.coverage.swept import swept
from pipeline.errors import TowlineError


@dataclass(frozen=True)
class Capture:
    """area: of the patch, captured: of it what the line swept, [m^2]. t, taken: (k,) times when that grew [s], and to
    what [m^2].

    `first` is when the line reaches the patch, `last` when it has taken the last that it takes, [s]; None if it never
    takes any.
    """

    area: float
    captured: float
    t: np.ndarray
    taken: np.ndarray

    @property
    def first(self) -> float | None:
        """The first time when it grew."""
        return float(self.t[0]) if len(self.t) else None

    @property
    def last(self) -> float | None:
        """The last time when it grew."""
        return float(self.t[-1]) if len(self.t) else None

    def at(self, t: np.ndarray) -> np.ndarray:
        """What is taken by these times [m^2]."""
        return np.concatenate([[0.0], self.taken])[np.searchsorted(self.t, t, side="right")]


def patch_of(corners: list[tuple[float, float]]) -> shapely.Polygon:
    """The polygon of corners, north and east [m] at the first time. Raises TowlineError where it is none."""
    if len(corners) < 3:
        raise TowlineError(f"a patch of {len(corners)} corners; expected three at least")
    polygon = shapely.Polygon(corners)
    if not polygon.is_valid or polygon.area == 0.0:
        raise TowlineError(f"a patch that is no area: {shapely.is_valid_reason(polygon)}; give corners in turn")
    return polygon


def capture(patch: shapely.Polygon, t: np.ndarray, shapes: np.ndarray) -> Capture:
    """t: (k,) [s]; shapes: (k, n + 1, 2) of the line [m], in the water's frame.

    What the line went over is taken to stay with it. Times are of the shape that ends the step.
    """
    south, west, north, east = patch.bounds  # x is north
    low, high = shapes.min(axis=1), shapes.max(axis=1)
    low, high = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
    near = np.flatnonzero((low <= (north, east)).all(axis=1) & (high >= (south, west)).all(axis=1))
    left: shapely.Geometry = patch
    when, taken = [], []
    for i in near:
        rest = shapely.difference(left, swept(shapes[i : i + 2]))
        if rest.area < left.area:
            left = rest
            when.append(t[i + 1])
            taken.append(patch.area - left.area)
    return Capture(patch.area, patch.area - left.area, np.array(when), np.array(taken))
