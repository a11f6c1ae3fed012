"""The separation at which two boats of a given pull sweep most, numerically; Bhattacharya et al. 2011, eq. 26."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log

import numpy as np
from scipy.optimize import minimize_scalar

from pipeline.analysis.coverage.drag import Drag
from pipeline.analysis.coverage.steady import Tow, tow

APEX = (0.02, 10.0)  # tensions at the apex that are searched: separations from 0.2 (c_V = 0: 0.06) to 0.9995 of L
PARTS = 40
EXACT = 1e-9  # of the logarithm of that tension


@dataclass(frozen=True)
class Optimum:
    """rate: the greatest area per time, over (f_max / c)^(1/power) L^(1 - 1/power); separation: where, D/L."""

    separation: float
    rate: float


def rate(drag: Drag, one: Tow) -> float:
    """Area per time over (f_max / c)^(1/power) L^(1 - 1/power): (26), with v = (f_max / (c L g))^(1/power)."""
    return one.separation * one.force ** (-1.0 / drag.power)


def optimum(drag: Drag) -> Optimum | None:
    """None where the rate is greatest at an end of the range, so that there is no optimum between."""
    ends = np.linspace(log(APEX[0]), log(APEX[1]), PARTS + 1)
    k = int(np.argmax([rate(drag, tow(drag, exp(e))) for e in ends]))
    if k in (0, PARTS):
        return None
    found = minimize_scalar(
        lambda e: -rate(drag, tow(drag, exp(e))),
        bounds=(float(ends[k - 1]), float(ends[k + 1])),
        method="bounded",
        options={"xatol": EXACT},
    )
    best = tow(drag, exp(found.x))
    return Optimum(best.separation, rate(drag, best))
