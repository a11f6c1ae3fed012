"""How long the catenary fails a tolerance, how long it holds, and how long nothing is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.indicators import Fits
from pipeline.analysis.statistics import BRIDGED, fails, reliable


@dataclass(frozen=True)
class Durations:
    """Seconds of a record, from its first frame to its last; failing, holding and unknown add up to it."""

    failing: float
    holding: float
    unknown: float

    @property
    def record(self) -> float:
        """The whole record [s]."""
        return self.failing + self.holding + self.unknown

    def __str__(self) -> str:
        """One sentence."""
        return (
            f"Of {self.record:.5g} s the catenary holds for {self.holding:.4g} s, fails for {self.failing:.4g} s, "
            f"and for {self.unknown:.4g} s it is not known."
        )


def durations(fits: Fits, tolerance: float) -> Durations:
    """Seconds in which the catenary fails the tolerance [m], holds, and is not known: no reliable fit, or no frame.

    Nor is it known where e_C exceeds the tolerance by no more than noise may explain: it holds only within it.
    """
    within = reliable(fits) & (fits.e_catenary <= tolerance)
    return shares(fits.t_ns, fails(fits, tolerance), within)


def shares(t_ns: np.ndarray, failing: np.ndarray, within: np.ndarray) -> Durations:
    """The same of any frames: t_ns (k,), failing, within (k,) bool.

    A frame stands for the time that is nearer to it than to another. Where the record has a gap, longer than BRIDGED
    frames usually take, the frames beside it stand for half a usual interval of it, and the rest is not known.
    """
    t = t_ns / 1e9
    if len(t) < 2:
        return Durations(0.0, 0.0, 0.0)
    intervals = np.diff(t)
    usual = np.median(intervals)
    covered = np.where(intervals > BRIDGED * usual, usual, intervals)
    share = 0.5 * (np.append(covered, 0.0) + np.insert(covered, 0, 0.0))
    seconds, held = float(share[failing].sum()), float(share[within].sum())
    return Durations(seconds, held, max(0.0, float(t[-1] - t[0]) - seconds - held))
