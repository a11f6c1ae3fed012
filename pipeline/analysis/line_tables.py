"""What was found of a line beside its markers, as sentences and rows: the same on the terminal and on the page."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.analysis.line_loads import CAUSES
from pipeline.analysis.line_validity import BEYOND, TITLES, Failure, LineVerdict, Match, is_near_neutral

UNKNOWN_CAUSE = "none that the log tells"
COLUMNS = ("from [s]", "to [s]", "shape [mm]", "tension [%]", "cause", *(f"{name} [1]" for name in CAUSES))


def sentences(verdict: LineVerdict) -> Iterator[str]:
    """One of what the line weighs, one for each catenary, one of what it is more than a catenary."""
    yield weight(verdict)
    for name, match in verdict.matches.items():
        yield f"The catenary through its ends {TITLES[name]} {_judged(match, verdict)}"
    if verdict.line.beyond:
        yield f"It has what no catenary has: {', '.join(verdict.line.beyond)}."
    for note in verdict.line.notes:
        yield f"Note: {note}."


def weight(verdict: LineVerdict) -> str:
    """How heavy the line is in water, and what loads it as much."""
    line = verdict.line
    if line.weight == 0.0:
        return f"{verdict.record.name} has no weight in its plane: only the water's drag and its inertia load it."
    part = f" ({100.0 * line.weight / line.dry_weight:.2g} % of its dry weight)" if line.dry_weight else ""
    near = ", near neutral" if is_near_neutral(line) else ""
    as_much = [
        f"{value:.2g} {unit}"
        for value, unit in ((line.speed, "m/s through the water"), (line.acceleration, "m/s² of acceleration"))
        if np.isfinite(value)
    ]
    loads = f"; {' or '.join(as_much)}, across it, load it as much" if as_much else ""
    return f"{verdict.record.name} weighs {line.weight:.3g} N/m in water{part}{near}{loads}."


def _judged(match: Match, verdict: LineVerdict) -> str:
    if match.missing:
        return f"is not judged: {match.missing}."
    d = match.durations
    if not (np.isfinite(match.e_shape) | np.isfinite(match.e_tension)).any():
        return f"is not judged: in none of {len(match.e_shape)} frames are its ends, shape and length known."
    said = [f"out of tolerance for {d.failing:.4g} of {d.record:.5g} s"]
    for error, scale, unit, name, limit in (
        (match.e_tension, 100.0, "%", "end tensions", verdict.tension_tolerance),
        (match.e_shape, *length_unit(verdict.shape_tolerance), "shape", verdict.shape_tolerance),
    ):
        known = scale * error[np.isfinite(error)]
        if len(known):
            said.append(
                f"{name} off by {np.median(known):.3g} {unit} in the median, {known.max():.3g} at most "
                f"(tolerance {scale * limit:.3g})"
            )
    return f"{match.verdict}: {'; '.join(said)}."


def length_unit(tolerance: float) -> tuple[float, str]:
    """Factor from metres, and name, of the unit for errors about a tolerance [m]."""
    return (1.0, "m") if tolerance >= 1.0 else (1e3, "mm")


def cause(name: str, verdict: LineVerdict, of_fit: bool = False) -> str:
    """In words; of_fit: of the catenary fitted to the markers, which knows no seabed."""
    if name == BEYOND:
        bed = ["a seabed"] if of_fit and np.isfinite(verdict.line.seabed) else []
        return ", ".join([*bed, *verdict.line.beyond])
    return CAUSES.get(name, UNKNOWN_CAUSE)


def worst(match: Match, most: int) -> list[Failure]:
    """The longest spans of failure, in order of time."""
    chosen = sorted(match.failures, key=lambda one: one.span.start_ns - one.span.end_ns)[:most]
    return sorted(chosen, key=lambda one: one.span.start_ns)


def row(failure: Failure, verdict: LineVerdict) -> list[str]:
    """Under COLUMNS."""
    times = (f"{t_ns / 1e9:.2f}" for t_ns in (failure.span.start_ns, failure.span.end_ns))
    ratios = (f"{failure.ratios[name]:.2g}" for name in CAUSES)
    worst = f"{1e3 * failure.worst_shape:.4g}", f"{100.0 * failure.worst_tension:.3g}"
    return [*times, *worst, cause(failure.cause, verdict), *ratios]
