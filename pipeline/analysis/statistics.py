"""Statistics of the indicators as in Tables II and III of Drupt et al. 2022, and when the catenary fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.indicators import Fits

LEAST_MARKERS = 7  # Drupt et al. 2022: "only the values computed when N > 6 are considered reliable"
# Of the frames with markers enough, that must be identifiable: below a half, those refused, which are the straight ones
# and not a fair sample, could put the record's median anywhere (its breakdown point: Hampel 1971).
LEAST_SHARE = 0.5
# Noise floors that e_C may exceed the tolerance by: an rms of a sum is at most the sum of the rms, and that of noise
# alone exceeds two floors in one of 25,000 frames with 9 degrees of freedom (12 markers), one of 330 with 4.
FLOORS = 2.0
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
    """A cable's row of Table II or III: alpha in degrees, distances in mm.

    frames_enough: with at least LEAST_MARKERS; frames_used: those of them that were fitted, which stand behind the
    summaries. missing: why the summaries are None, or "".
    """

    alpha_deg: Summary | None
    e_plane_mm: Summary | None
    e_catenary_mm: Summary | None
    frames: int
    frames_enough: int
    frames_used: int
    missing: str = ""


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
    """Mean, minimum, maximum, median and standard deviation (of the population, 1/k) over the reliable frames.

    None, with the reason, where fewer than LEAST_SHARE of the frames with markers enough are identifiable.
    """
    use, enough = reliable(fits, least_markers), fits.n >= least_markers
    used, of = int(use.sum()), int(enough.sum())
    missing = ""
    if not of:
        missing = f"no statistics: no frame has {least_markers} markers"
    elif used < LEAST_SHARE * of:
        missing = (
            f"no statistics: only {used} of {of} frames with {least_markers} markers or more are identifiable, "
            f"fewer than {100 * LEAST_SHARE:g} %"
        )
    values = (np.degrees(fits.alpha), 1e3 * fits.e_plane, 1e3 * fits.e_catenary)
    alpha, e_plane, e_catenary = (None if missing else summary(of_all[use]) for of_all in values)
    return Statistics(alpha, e_plane, e_catenary, len(use), of, used, missing)


def summary(values: np.ndarray) -> Summary:
    """Of values (k,), k > 0."""
    numbers = (values.mean(), values.min(), values.max(), np.median(values), values.std())
    return Summary(*(float(number) for number in numbers))


def fails(fits: Fits, tolerance: float, least_markers: int = LEAST_MARKERS) -> np.ndarray:
    """(k,) bool: reliable, and e_C exceeds the tolerance [m] by more than the markers' noise explains."""
    floor = fits.marker_sigma * fits.noise_gain
    return reliable(fits, least_markers) & (fits.e_catenary > tolerance + FLOORS * floor)


def failing_spans(fits: Fits, tolerance: float, least_markers: int = LEAST_MARKERS) -> list[Span]:
    """Spans of time in which the catenary fails the tolerance [m], see fails.

    Of a frame that is not reliable nothing is known: it neither begins nor ends a span. Where nothing is known for
    longer than BRIDGED frames usually take, be it so or because the record has a gap, a span ends.
    """
    return spans(fits.t_ns, reliable(fits, least_markers), fails(fits, tolerance, least_markers), fits.e_catenary)


def spans(t_ns: np.ndarray, known: np.ndarray, failing: np.ndarray, error: np.ndarray) -> list[Span]:
    """The same of any frames: t_ns (k,), known, failing (k,) bool, and the error whose largest is told (k,)."""
    place = np.flatnonzero(known)
    found = place[failing[place]]
    if not len(found):
        return []
    holds = np.flatnonzero(np.diff(np.searchsorted(place, found)) > 1)  # a frame between them is within tolerance
    bridged_ns = BRIDGED * np.median(np.diff(t_ns)) if len(t_ns) > 1 else 0
    gaps = np.flatnonzero(np.diff(t_ns[found]) > bridged_ns)
    return [
        Span(int(t_ns[inside[0]]), int(t_ns[inside[-1]]), len(inside), float(error[inside].max()))
        for inside in np.split(found, np.union1d(holds, gaps) + 1)
    ]
