"""The noises of an estimator that make what a log holds most likely: Q and R by the innovations.

Schweppe 1965, "Evaluation of likelihood functions for Gaussian signals": the sum of the innovations' densities. Its
curvature at the top says how well a log tells each noise. Readings that the filter of the log refuses are left out, and
no others: a gate makes steps in the likelihood, and rewards noises with which inconvenient readings are refused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from components.estimator.line import Line
from pipeline.estimation.record import Record

WIDEST = 12.0  # of a noise's natural logarithm from where it began
STEP = 0.1  # of the logarithms, by which the curvature is taken
VAGUE = 1.0  # deviation of a logarithm beyond which a log does not tell the noise: the curvature holds nearby only
# Those that a fit takes unless others are asked for, and times that it may take.
MEASURED = ("marker_noise", "chain_noise", "end_position_noise", "end_tension_noise", "tilt_noise", "gyro_noise")
DRIVEN = ("moment_noise", "force_noise", "end_force_spread", "pivot_acceleration")
TIMES = ("end_force_time", "pivot_time")
NOT_GIVEN = 1e-3  # of a bar: where a fit of `chain_noise` begins if it is 0


@dataclass(frozen=True)
class Fit:
    """noises: by parameter; deviations: of their natural logarithms, inf where the log does not tell them.

    log_likelihood: with them, and `before` with those that the log has.
    """

    noises: dict[str, float]
    deviations: dict[str, float]
    log_likelihood: float
    before: float
    evaluations: int


def noises_of(record: Record) -> tuple[str, ...]:
    """The noises of a log's estimator that have an effect there."""
    given = record.parameters
    idle = {"marker_noise" if given.takes_covariance else "chain_noise"}  # without a covariance only their sum is told
    idle |= {noise for noise, of in (("tilt_noise", "tilts"), ("gyro_noise", "gyros")) if not getattr(given, of, ())}
    if getattr(given, "pivot", "") == "fixed":
        idle |= {"pivot_acceleration", "pivot_time"}
    return tuple(name for name in (*MEASURED, *DRIVEN, *TIMES) if name not in idle and _first(given, name))


def _first(given: Line, name: str) -> float | None:
    """The number of a parameter with which a fit begins."""
    value = getattr(given, name, None)
    return NOT_GIVEN * given.bar if name == "chain_noise" and value == 0.0 else value


def fit_noises(record: Record, names: tuple[str, ...], tolerance: float = 0.01) -> Fit:
    """Find the positive parameters `names` by their logarithms.

    tolerance: relative. Raises ValueError if a name is no positive number of the estimator, or the filter
    fails with the noises that the log has.
    """
    first = []
    for name in names:
        value = _first(record.parameters, name)
        if not isinstance(value, float) or value <= 0.0:
            raise ValueError(f"{name} is no positive number of {record.component.name}")
        first.append(np.log(value))
    start = np.array(first)

    data = record.without_refused()

    def cost(logarithms: np.ndarray) -> float:
        if np.abs(logarithms - start).max() > WIDEST:
            return np.inf
        noises = dict(zip(names, np.exp(logarithms).tolist(), strict=True))
        return -data.with_parameters(**noises).log_likelihood()

    before = data.log_likelihood()
    if not np.isfinite(before):
        raise ValueError(
            f"{record.component.name} fails with the noises that the log has: there is nothing to begin at"
        )
    simplex = np.vstack([start, start + 0.7 * np.eye(len(names))])
    options = {"initial_simplex": simplex, "xatol": tolerance, "fatol": 0.01, "maxfev": 200 * len(names)}
    found = minimize(cost, start, method="Nelder-Mead", options=options)
    noises = dict(zip(names, np.exp(found.x).tolist(), strict=True))
    deviations = dict(zip(names, _deviations(cost, found.x, float(found.fun)), strict=True))
    return Fit(noises, deviations, -float(found.fun), before, int(found.nfev))


def _deviations(cost: Callable[[np.ndarray], float], top: np.ndarray, least: float) -> list[float]:
    """Of the logarithms about the top, by the inverse of the cost's second differences; inf for those not told."""
    n, step = len(top), STEP * np.eye(len(top))
    ahead, back = ([cost(top + sign * row) for row in step] for sign in (1.0, -1.0))
    second = np.diag([a + b - 2.0 * least for a, b in zip(ahead, back, strict=True)])
    for i in range(n):
        for j in range(i):
            both = cost(top + step[i] + step[j]) + cost(top - step[i] - step[j])
            second[i, j] = second[j, i] = 0.5 * (both - ahead[i] - ahead[j] - back[i] - back[j] + 2.0 * least)
    curved = np.flatnonzero(np.isfinite(np.diag(second)) & (np.diag(second) > 0.0))
    found = np.full(n, np.inf)
    part = second[np.ix_(curved, curved)]
    if len(curved) and np.isfinite(part).all() and np.linalg.eigvalsh(part)[0] > 0.0:
        found[curved] = STEP * np.sqrt(np.diag(np.linalg.inv(part)))
    return [float(one) if one < VAGUE else float("inf") for one in found]
