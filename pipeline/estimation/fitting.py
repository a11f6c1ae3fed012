"""The noises of an estimator that make what a log holds most likely: Q and R by the innovations.

Schweppe 1965, "Evaluation of likelihood functions for Gaussian signals": the sum of the innovations' densities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from pipeline.estimation.record import Record

WIDEST = 12.0  # of a noise's natural logarithm from where it began


@dataclass(frozen=True)
class Fit:
    """noises: by parameter; log_likelihood: with them, and `before` with those that the log has."""

    noises: dict[str, float]
    log_likelihood: float
    before: float
    evaluations: int


def fit_noises(record: Record, names: tuple[str, ...], tolerance: float = 0.01) -> Fit:
    """Find the positive parameters `names` by their logarithms.

    tolerance: relative. Raises ValueError if a name is no positive number of the estimator, or the filter
    fails with the noises that the log has.
    """
    first = []
    for name in names:
        value = getattr(record.parameters, name, None)
        if not isinstance(value, float) or value <= 0.0:
            raise ValueError(f"{name} is no positive number of {record.component.name}")
        first.append(np.log(value))
    start = np.array(first)

    def cost(logarithms: np.ndarray) -> float:
        if np.abs(logarithms - start).max() > WIDEST:
            return np.inf
        noises = dict(zip(names, np.exp(logarithms).tolist(), strict=True))
        return -record.with_parameters(**noises).log_likelihood()

    before = -cost(start)
    if not np.isfinite(before):
        raise ValueError(
            f"{record.component.name} fails with the noises that the log has: there is nothing to begin at"
        )
    simplex = np.vstack([start, start + 0.7 * np.eye(len(names))])
    options = {"initial_simplex": simplex, "xatol": tolerance, "fatol": 0.01, "maxfev": 200 * len(names)}
    found = minimize(cost, start, method="Nelder-Mead", options=options)
    noises = dict(zip(names, np.exp(found.x).tolist(), strict=True))
    return Fit(noises, -float(found.fun), before, int(found.nfev))
