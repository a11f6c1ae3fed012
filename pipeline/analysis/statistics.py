"""Statistics of the indicators as in Tables II and III of Drupt et al. 2022, and when the catenary fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.indicators import Fits

LEAST_MARKERS = 7  # Drupt et al. 2022: "only the values computed when N > 6 are considered reliable"
BRIDGED = 10  # frames of which nothing is known between two failing ones; more of them end the span


@dataclass(frozen=True)
class Summary:
    """Of one indicator over the frames used."""

    mean: float
    min: float
    max: float
    median: float
    std: float


@dataclass(frozen=True)
class Statistics:
    """A cable's row of Table II or III: alpha in degrees, distances in mm. Summaries are None without frames."""

    alpha_deg: Summary | None
    e_plane_mm: Summary | None
    e_catenary_mm: Summary | None
    frames: int
    frames_used: int


@dataclass(frozen=True)
class Span:
    """From the first to the last of consecutive frames in which the catenary fails; worst: largest e_C in it [m]."""

    start_ns: int
    end_ns: int
    frames: int
    worst: float


def reliable(fits: Fits, least_markers: int = LEAST_MARKERS) -> np.ndarray:
    """(k,) bool: fitted, with at least this many markers."""
    return fits.fitted & (fits.n >= least_markers)


def statistics(fits: Fits, least_markers: int = LEAST_MARKERS) -> Statistics:
    """Mean, minimum, maximum, median and standard deviation (of the population, 1/k) over the reliable frames."""
    use = reliable(fits, least_markers)
    return Statistics(
        _summary(np.degrees(fits.alpha[use])),
        _summary(1e3 * fits.e_plane[use]),
        _summary(1e3 * fits.e_catenary[use]),
        len(use),
        int(use.sum()),
    )


def _summary(values: np.ndarray) -> Summary | None:
    if not len(values):
        return None
    numbers = (values.mean(), values.min(), values.max(), np.median(values), values.std())
    return Summary(*(float(number) for number in numbers))


def failing_spans(fits: Fits, tolerance: float, least_markers: int = LEAST_MARKERS) -> list[Span]:
    """Spans of time in which e_C exceeds the tolerance [m].

    Of a frame that is not reliable nothing is known: it neither begins nor ends a span. Where nothing is known for
    longer than BRIDGED frames usually take, be it so or because the record has a gap, a span ends.
    """
    known = np.flatnonzero(reliable(fits, least_markers))
    failing = known[fits.e_catenary[known] > tolerance]
    if not len(failing):
        return []
    holds = np.flatnonzero(np.diff(np.searchsorted(known, failing)) > 1)  # a frame between them is within tolerance
    bridged_ns = BRIDGED * np.median(np.diff(fits.t_ns)) if len(fits.t_ns) > 1 else 0
    gaps = np.flatnonzero(np.diff(fits.t_ns[failing]) > bridged_ns)
    parts = np.split(failing, np.union1d(holds, gaps) + 1)
    return [_span(fits, inside) for inside in parts]


def _span(fits: Fits, inside: np.ndarray) -> Span:
    worst = float(fits.e_catenary[inside].max())
    return Span(int(fits.t_ns[inside[0]]), int(fits.t_ns[inside[-1]]), len(inside), worst)
