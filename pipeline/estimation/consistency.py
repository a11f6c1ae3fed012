"""Whether a filter is as sure as it says: NIS and NEES against chi-square, innovations against white noise.

Bar-Shalom, Li and Kirubarajan 2001, "Estimation with applications to tracking and navigation", section 5.4.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

BAND = 0.95


def inside(values: np.ndarray, freedom: np.ndarray | float) -> float:
    """Share of the times at which the average over the runs lies in its pointwise 95 % band.

    values: (runs, steps) squares; freedom: theirs, (runs, steps) or one number for all.
    """
    total = np.broadcast_to(freedom, values.shape).sum(axis=0)
    low, high = chi2.ppf(0.5 * (1.0 - BAND), total), chi2.ppf(0.5 * (1.0 + BAND), total)
    return float(((low <= values.sum(axis=0)) & (values.sum(axis=0) <= high)).mean())


def autocorrelation(innovations: np.ndarray, lags: int) -> tuple[np.ndarray, float]:
    """(lags,) of normalised innovations (runs, steps, k), k being one after another, and their standard deviation.

    For white noise each is normal about zero. Zeros, which stand where nothing was measured, are left out.
    """
    seen = innovations != 0.0
    count = max(int((seen[:, 1:] & seen[:, :-1]).sum()), 1)
    found = []
    for lag in range(1, lags + 1):
        product = innovations[:, lag:] * innovations[:, :-lag]
        found.append(product.sum() / max((seen[:, lag:] & seen[:, :-lag]).sum(), 1))
    return np.array(found), 1.0 / float(np.sqrt(count))
