"""Whether the catenary through a recorded line's ends has its shape and its end tensions, when not, and why not.

Two catenaries are judged, each of the line's own length and through its own ends: under its weight in water alone, and
under the mean of all that loads it, (force on holder a + force on holder b) / length, which a uniform stream or tow
turns out of the vertical (Drupt et al. 2022, eqs. 6-8; Bhattacharya et al. 2011, eq. 9).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pipeline.analysis.durations import Durations, shares
from pipeline.analysis.known import finite
from pipeline.analysis.line_loads import Loads, cause, loads
from pipeline.analysis.line_properties import Properties
from pipeline.analysis.line_record import LineRecord
from pipeline.analysis.statistics import Span, Summary, spans, summary
from pipeline.analysis.through_ends import Statics, through_ends

NEUTRAL = 0.1  # weight in water over dry weight, below which a line is called near neutral
# A load across a line moves its middle by about an eighth of the length times its ratio to the load there is (a shallow
# parabola's sag): a twelfth of the weight is 1 % of the length.
LEAST_CAUSE = 0.08
BEYOND = "beyond"  # the cause where no load is large enough, and the line has what a catenary has not
WEIGHT, MEAN_LOAD = "weight", "mean_load"
TITLES = {WEIGHT: "under its weight in water", MEAN_LOAD: "under the mean of all its load"}
VERDICTS = ("holds", "holds in part", "fails", "not known")


@dataclass(frozen=True)
class Failure:
    """A span in which shape or tension is out of tolerance: worst of both, the cause, "" where none is found, and the
    medians of the causes' ratios. worst_shape [m]; worst_tension: relative."""

    span: Span
    worst_shape: float
    worst_tension: float
    cause: str
    ratios: dict[str, float]


@dataclass(frozen=True)
class Match:
    """The catenary under one load beside the line. missing: why there is none, or "".

    e_shape: (k,) root mean square distance of the nodes from it at the same share of the length [m].
    e_tension: (k,) larger error of the two end tensions over the largest recorded (or half the weight, if that is
    more); tension: (2, k) of the catenary at ends a and b [N]. NaN where not known.
    """

    load: str
    missing: str
    e_shape: np.ndarray
    e_tension: np.ndarray
    tension: np.ndarray
    failures: list[Failure]
    durations: Durations

    @property
    def verdict(self) -> str:
        """One of VERDICTS."""
        if self.missing or self.durations.failing + self.durations.holding == 0.0:
            return VERDICTS[3]
        if self.durations.failing == 0.0:
            return VERDICTS[0]
        return VERDICTS[2] if self.durations.holding == 0.0 else VERDICTS[1]

    def as_json(self) -> dict[str, Any]:
        """Of `towline validity --json`."""
        return {
            "verdict": self.verdict,
            "missing": self.missing,
            "e_tension_percent": _summary(100.0 * self.e_tension),
            "e_shape_mm": _summary(1e3 * self.e_shape),
            **{f"seconds_{name}": seconds for name, seconds in asdict(self.durations).items()},
            "fails": [
                {
                    "start_s": one.span.start_ns / 1e9,
                    "end_s": one.span.end_ns / 1e9,
                    "frames": one.span.frames,
                    "worst_shape_mm": 1e3 * one.worst_shape,
                    "worst_tension_percent": 100.0 * one.worst_tension,
                    "cause": one.cause,
                    "ratios": one.ratios,
                }
                for one in self.failures
            ],
        }


@dataclass(frozen=True)
class LineVerdict:
    """A line judged. tension: (2, k) recorded at ends a and b [N], NaN where not. length: median of the unstretched.

    shape_tolerance [m], tension_tolerance relative. matches: by the load, WEIGHT and MEAN_LOAD.
    """

    record: LineRecord
    line: Properties
    loads: Loads
    tension: np.ndarray
    length: float
    shape_tolerance: float
    tension_tolerance: float
    matches: dict[str, Match]

    def cause(self, span: Span) -> tuple[str, dict[str, float]]:
        """Why a catenary fails in a span of the record, by what loads the line beside its weight."""
        name, ratios = cause(self.loads.over_weight(), self._within(span), LEAST_CAUSE)
        return name or (BEYOND if np.isfinite(self.line.seabed) or self.line.beyond else ""), ratios

    def _within(self, span: Span) -> np.ndarray:
        """(k,) bool; the frames of a short span's two sides where it has none of its own."""
        t, step = self.record.t_ns, int(np.median(np.diff(self.record.t_ns))) if len(self.record.t_ns) > 1 else 0
        return (t >= span.start_ns - step // 2) & (t <= span.end_ns + step // 2)

    def as_json(self) -> dict[str, Any]:
        """Of `towline validity --json`."""
        line = self.line
        return {
            "channel": self.record.name,
            "length_m": self.length,
            "weight_N_per_m": line.weight,
            "weight_over_dry_weight": line.weight / line.dry_weight if line.dry_weight else None,
            "near_neutral": is_near_neutral(line),
            "drag_equals_weight_at_m_s": _finite(line.speed),
            "inertia_equals_weight_at_m_s2": _finite(line.acceleration),
            "beside_weight": {name: _summary(values) for name, values in self.loads.over_weight().items()},
            "shape_tolerance_mm": 1e3 * self.shape_tolerance,
            "tension_tolerance_percent": 100.0 * self.tension_tolerance,
            "through_ends": {name: match.as_json() for name, match in self.matches.items()},
            "notes": list(line.notes),
        }


def is_near_neutral(line: Properties) -> bool:
    """Whether water carries nearly all of it."""
    return bool(0.0 < line.weight < NEUTRAL * line.dry_weight)


@np.errstate(divide="ignore", invalid="ignore", over="ignore")  # what is not known, or stands in one place, gives NaN
def judge_line(record: LineRecord, line: Properties, shape: float | None, tension: float) -> LineVerdict:
    """shape: tolerance of e_shape [m]; None: 1 % of the length. tension: of e_tension."""
    length = record.length if record.length is not None else np.full(len(record.t_ns), line.length)
    told = finite(length)
    usual = float(np.median(told)) if len(told) else line.length
    found = loads(record, line)
    recorded = np.full((2, len(record.t_ns)), np.nan)
    for row, force in zip(recorded, (record.force_a, record.force_b), strict=True):
        if force is not None:
            row[:] = np.linalg.norm(force, axis=1)
    verdict = LineVerdict(record, line, found, recorded, usual, shape or 0.01 * usual, tension, {})
    least = 0.5 * line.weight * length
    for name in TITLES:
        load, missing = _load(record, line, length, name)
        match = _match(verdict, name, load, missing, length, np.fmax(np.fmax(*recorded), least))
        verdict.matches[name] = match
    return verdict


def _load(record: LineRecord, line: Properties, length: np.ndarray, name: str) -> tuple[np.ndarray, str]:
    """The load of each frame (k, 3) [N/m], and why there is none, or ""."""
    load = np.broadcast_to(line.load, (len(record.t_ns), 3))
    if not all(line.held):
        return load, "an end is free: no catenary through both ends has its shape"
    if name == WEIGHT:
        return load, "" if line.weight > 0.0 else "it has no weight in water: under that alone it has no shape"
    if record.force_a is None or record.force_b is None:
        return load, "the forces at its ends are not recorded"
    if np.isfinite(line.seabed):
        return load, "a seabed carries a part of its load"
    return (record.force_a + record.force_b) / length[:, None], ""


def _match(
    verdict: LineVerdict, name: str, load: np.ndarray, missing: str, length: np.ndarray, largest: np.ndarray
) -> Match:
    record, line = verdict.record, verdict.line
    unknown = np.full(len(record.t_ns), np.nan)
    if missing:
        nothing = Durations(0.0, 0.0, float(np.ptp(record.t_ns) / 1e9) if len(unknown) else 0.0)
        return Match(name, missing, unknown, unknown, np.stack([unknown] * 2), [], nothing)
    nodes = record.nodes
    along = np.linalg.norm(np.diff(nodes, axis=1), axis=2).cumsum(axis=1)
    share = np.insert(along, 0, 0.0, axis=1) / along[:, -1:]
    ends = nodes[:, 0], nodes[:, -1]
    statics = through_ends(*ends, length, load, line.flexibility, share, line.seabed, line.rough)
    e_shape = np.sqrt(((statics.shape - nodes) ** 2).sum(axis=2).mean(axis=1))
    e_tension = _tension_error(statics, verdict.tension, largest)
    e_shape, e_tension = (np.where(record.whole, error, np.nan) for error in (e_shape, e_tension))
    known = np.isfinite(e_shape) | np.isfinite(e_tension)
    relative = np.fmax(e_shape / verdict.shape_tolerance, e_tension / verdict.tension_tolerance)
    fails = known & (relative > 1.0)
    causes = verdict.loads.over_weight() if name == WEIGHT else verdict.loads.uneven
    failures = []
    for span in spans(record.t_ns, known, fails, relative):
        frames = (record.t_ns >= span.start_ns) & (record.t_ns <= span.end_ns) & fails
        why, ratios = cause(causes, frames, LEAST_CAUSE)
        why = why or (BEYOND if line.beyond else "")
        worst = [float(np.fmax.reduce(error[frames], initial=0.0)) for error in (e_shape, e_tension)]
        failures.append(Failure(span, worst[0], worst[1], why, ratios))
    tension = np.stack([statics.tension_a, statics.tension_b])
    return Match(name, "", e_shape, e_tension, tension, failures, shares(record.t_ns, fails, known & ~fails))


def _tension_error(statics: Statics, recorded: np.ndarray, largest: np.ndarray) -> np.ndarray:
    difference = np.abs(np.stack([statics.tension_a, statics.tension_b]) - recorded)
    return np.fmax(difference[0], difference[1]) / largest


def _summary(values: np.ndarray) -> dict[str, float] | None:
    known = finite(values)
    found: Summary | None = summary(known) if len(known) else None
    return None if found is None else asdict(found)


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
