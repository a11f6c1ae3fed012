"""Whether a catenary is a valid model of a recorded line: fits, statistics and failures of each cable of a file."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.analysis.bias import Shifts, by_drop_out, by_noise, floors
from pipeline.analysis.durations import Durations, durations
from pipeline.analysis.indicators import Fits, fit_frames
from pipeline.analysis.known import finite
from pipeline.analysis.line_validity import LineVerdict, judge_line
from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.published import Published, published
from pipeline.analysis.recording import Recording
from pipeline.analysis.statistics import LEAST_MARKERS, Span, Statistics, failing_spans, reliable, statistics
from pipeline.errors import TowlineError


@dataclass(frozen=True)
class Tolerance:
    """The e_C at which a catenary fails: a length [m], or a share of the line's length."""

    value: float
    is_share: bool

    def metres(self, length: float) -> float:
        """On a line of this length [m]."""
        return self.value * length if self.is_share else self.value


@dataclass(frozen=True)
class Noise:
    """What the markers' noise does, medians over the reliable frames.

    marker_mm: its standard deviation along each axis. e_plane_mm, e_catenary_mm: what it alone would give.
    alpha_deg, C_per_m: standard deviations of alpha and C.
    """

    marker_mm: float
    e_plane_mm: float
    e_catenary_mm: float
    alpha_deg: float
    C_per_m: float


@dataclass(frozen=True)
class Biases:
    """How much greater the indicators are on the average, by the markers' noise and drop-out; None: by none."""

    noise: Shifts | None
    drop_out: Shifts | None


@dataclass(frozen=True)
class Cable:
    """What was found of one cable. length: of the line [m], from length_source. tolerance: of e_C [m].

    noise: None where the file does not tell the markers' noise. biases: by that noise, or by what the record shows.
    line: of the catenary through the line's ends and of what loads it; None where only markers are known.
    """

    recording: Recording
    method: str
    fits: Fits
    statistics: Statistics
    spans: list[Span]
    durations: Durations
    length: float
    length_source: str
    tolerance: float
    published: Published | None
    noise: Noise | None
    biases: Biases
    wall_s: float
    line: LineVerdict | None = None

    def cause(self, span: Span) -> tuple[str, dict[str, float]]:
        """Why the catenary fails in a span, and how large each cause is beside the weight; "" where nothing tells."""
        return ("", {}) if self.line is None else self.line.cause(span)

    def as_json(self) -> dict[str, Any]:
        """The keys of `towline validity --json` for this cable."""
        return {
            **asdict(self.statistics),
            "wall_s": self.wall_s,
            "method": self.method,
            "scenario": self.recording.origin.scenario,
            "length_m": self.length,
            "length_source": self.length_source,
            "tolerance_mm": 1e3 * self.tolerance,
            **{f"seconds_{name}": seconds for name, seconds in asdict(self.durations).items()},
            "fails": [self._failure(span) for span in self.spans],
            "markers_left_out": int(self.fits.left_out.sum()),
            "markers_swapped": int(self.fits.swapped.sum()),
            "frames_by_reason": self.fits.reasons(),
            "notes": list(self.fits.notes),
            "noise": None if self.noise is None else asdict(self.noise),
            "marker_noise_taken_mm": 1e3 * self.fits.marker_sigma,
            "bias": asdict(self.biases),
            "published": None if self.published is None else asdict(self.published),
            "line": None if self.line is None else self.line.as_json(),
        }

    def _failure(self, span: Span) -> dict[str, Any]:
        name, ratios = self.cause(span)
        return {
            "start_s": span.start_ns / 1e9,
            "end_s": span.end_ns / 1e9,
            "frames": span.frames,
            "worst_mm": 1e3 * span.worst,
            "cause": name,
            "ratios": ratios,
        }


# Of the tension through the ends: assumed, for no source states one; the error of a good load pin and some reserve.
TENSION_TOLERANCE = 0.1


def judge(
    recording: Recording,
    method: str,
    tolerance: Tolerance,
    length: float | None = None,
    tension: float = TENSION_TOLERANCE,
) -> Cable:
    """Fit all frames of a recording and judge them.

    length: of the line [m], if it is known better than to the file. tension: tolerance of the end tensions of the
    catenary through the ends, relative. wall_s is the time of the fits. Raises ValueError if there is no such method,
    TowlineError if the tolerance is a share of a length that nothing tells.
    """
    start = time.perf_counter()
    fits = fit_frames(recording.frames, method, recording.origin.noise)
    wall_s = time.perf_counter() - start
    metres, source = (length, "as given") if length is not None else _length(recording, fits)
    limit = tolerance.metres(metres)
    if limit <= 0.0:
        why = "" if recording.frames.valid.any() else ", and no place on it"
        raise TowlineError(
            f"{recording.frames.source}: the line's length is not known{why}; give --length, or a tolerance in mm"
        )
    found = published(recording.origin.scenario) if recording.origin.arc is not None else None
    return Cable(
        recording=recording,
        method=method,
        fits=fits,
        statistics=statistics(fits),
        spans=failing_spans(fits, limit),
        durations=durations(fits, limit),
        length=metres,
        length_source=source,
        tolerance=limit,
        published=found,
        noise=_noise(fits, recording.origin.noise),
        biases=_biases(recording.frames, fits),
        wall_s=wall_s,
        line=None if recording.line is None else judge_line(*recording.line, limit, tension),
    )


def _noise(fits: Fits, sigma: float | None) -> Noise | None:
    use = reliable(fits)
    if sigma is None or not use.any():
        return None
    floor_plane, floor_catenary = floors(fits, sigma)
    return Noise(
        1e3 * sigma,
        1e3 * float(np.median(floor_plane[use])),
        1e3 * float(np.median(floor_catenary[use])),
        float(np.degrees(np.median(fits.sigma_alpha[use]))),
        float(np.median(fits.sigma_C[use])),
    )


def _biases(frames: MarkerFrames, fits: Fits) -> Biases:
    use = reliable(fits)
    return Biases(by_noise(fits, use) if use.any() else None, by_drop_out(frames, fits, LEAST_MARKERS))


def _length(recording: Recording, fits: Fits) -> tuple[float, str]:
    paid_out = None if recording.line is None else recording.line[0].length
    paid_out = finite(np.empty(0) if paid_out is None else paid_out)
    if len(paid_out) and np.ptp(paid_out) > 0.0:
        return float(np.median(paid_out)), f"of {recording.origin.line}, unstretched, median of what was paid out"
    if recording.origin.length is not None:
        return recording.origin.length, f"of {recording.origin.line}, unstretched"
    return _along_markers(recording.frames, fits), "along the markers, the line itself is longer"


def _along_markers(frames: MarkerFrames, fits: Fits) -> float:
    """Median length of the polyline through all markers; 0 if there is none.

    Over the frames that show all, each on the line and under its own label: an outlier would lengthen it.
    """
    whole = frames.position[(fits.n == frames.markers) & (fits.swapped == 0)]
    return float(np.median(np.linalg.norm(np.diff(whole, axis=1), axis=2).sum(axis=1))) if len(whole) else 0.0
