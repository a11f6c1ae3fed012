"""The grid on which a tracker rounded its markers' coordinates: millimetres, sixteenths of an inch, float32."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.markers import MarkerFrames

COARSEST = 1e-2  # m: wider grids are found as finer ones
FINEST = 1e-9
ON_GRID = 1e-6  # of a spacing: float64 holds multiples of the finest one up to 1e6 m so well
NEAR = 1e-2  # of a spacing: what is left of great multiples while the spacing is known by its least one only
SOME = 200  # values of a coordinate that tell in a moment that there is no grid
STEPS = 60  # of Euclid's algorithm, each of which at least halves the spacing or ends it


def grid(frames: MarkerFrames) -> float:
    """Coarsest spacing [m] of which all differences of a coordinate are multiples, or that of float32; 0 if none.

    Half of it is the greatest error of a coordinate.
    """
    values = frames.position[frames.valid]
    if not len(values):
        return 0.0
    apart = values - values[0]
    spacing = _common(apart[:SOME].ravel(), np.inf)
    if spacing > 0.0:
        spacing = _common(apart.ravel(), spacing)
    if spacing > 0.0:
        return spacing / max(1.0, np.ceil(spacing / COARSEST * (1.0 - ON_GRID)))
    single = np.abs(values).max().astype(np.float32)
    return float(np.spacing(single)) if (values == values.astype(np.float32)).all() else 0.0


def _common(apart: np.ndarray, spacing: float) -> float:
    """Greatest spacing of which all values are multiples, by Euclid's algorithm; 0 below FINEST or if all are zero.

    spacing: to begin with; inf: the least of the values.
    """
    apart = np.abs(apart)
    apart = apart[apart > 0.5 * FINEST]
    if not len(apart):
        return 0.0
    spacing = min(spacing, float(apart.min()))
    for _ in range(STEPS):
        multiples = np.rint(apart / spacing)
        rest = np.abs(apart - multiples * spacing)
        off = rest > NEAR * spacing
        if not off.any():
            spacing = float((apart @ multiples) / (multiples @ multiples))
            rest = np.abs(apart - multiples * spacing)
            off = rest > ON_GRID * spacing
        if not off.any():
            return spacing
        spacing = float(rest[off].min())
        if spacing < FINEST:
            return 0.0
    return 0.0
