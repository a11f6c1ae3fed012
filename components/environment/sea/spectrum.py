"""The JONSWAP spectrum and how it is cut into components."""

from __future__ import annotations

from math import exp, pi, sqrt

import numpy as np

# Of the peak's frequency: the spectrum is below 1e-8 of its peak under the first; above the second lies 0.3 % of the
# energy of gamma = 3.3, and 1 % of gamma = 1.
LOWEST, HIGHEST = 0.5, 4.0


def peakedness(height: float, period: float) -> float:
    """gamma for a significant height [m] and peak period [s]; DNV-RP-C205 (2010), section 3.5.5.5."""
    ratio = period / sqrt(height) if height > 0.0 else 5.0
    return 5.0 if ratio <= 3.6 else 1.0 if ratio >= 5.0 else exp(5.75 - 1.15 * ratio)


def jonswap(omega: np.ndarray, height: float, period: float, gamma: float) -> np.ndarray:
    """S(omega) [m^2 s] of a significant height [m] and peak period [s]; DNV-RP-C205 (2010), section 3.5.5.

    Its factor 1 - 0.287 ln(gamma) is replaced by the one that makes the integral H_s^2 / 16, which it fits to 1 %.
    """
    peak = 2.0 * pi / period
    whole = np.linspace(0.2, 30.0, 20001) * peak
    area = np.trapezoid(_shape(whole, peak, gamma), whole)
    return height**2 / 16.0 / area * _shape(omega, peak, gamma)


def _shape(omega: np.ndarray, peak: float, gamma: float) -> np.ndarray:
    width = np.where(omega <= peak, 0.07, 0.09)
    bump = gamma ** np.exp(-0.5 * ((omega - peak) / (width * peak)) ** 2)
    return omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4) * bump


def cut(height: float, period: float, gamma: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges (count + 1,) [rad/s] of equal bins, and amplitudes (count,) [m] of a component for each.

    Each has its bin's variance, by Simpson's rule in 8 parts; what lies beyond the band is spread over all in
    proportion, so that the variance is H_s^2 / 16 whatever the count.
    """
    edges = np.linspace(LOWEST, HIGHEST, count + 1) * 2.0 * pi / period
    weights = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24.0
    omega = edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0.0, 1.0, 9)
    variance = jonswap(omega, height, period, gamma) @ weights * np.diff(edges)
    if height > 0.0:
        variance *= height**2 / 16.0 / variance.sum()
    return edges, np.sqrt(2.0 * variance)


def spreading(exponent: float, count: int = 721) -> tuple[np.ndarray, np.ndarray]:
    """Angles (count,) [rad] off the mean direction and the share of energy below each: cos^n, within 90 deg.

    DNV-RP-C205 (2010), section 3.5.8.3. An exponent of 0 stands for a long-crested sea.
    """
    angle = np.linspace(-0.5 * pi, 0.5 * pi, count)
    if exponent == 0.0:
        return np.zeros(count), np.linspace(0.0, 1.0, count)
    density = np.cos(angle).clip(0.0) ** exponent
    share = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return angle, share / share[-1]
