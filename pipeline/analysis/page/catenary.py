"""What was found of each line's catenary: verdicts, statistics, indicators over time and where they fail, and why."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

import numpy as np

from pipeline.analysis import line_tables
from pipeline.analysis.line_loads import CAUSES
from pipeline.analysis.line_validity import TITLES, LineVerdict, Match
from pipeline.analysis.page.charts import Chart, Series, when
from pipeline.analysis.page.tab import Tab, heading, paragraph, table
from pipeline.analysis.statistics import LEAST_MARKERS, Span, reliable
from pipeline.analysis.tables import INDICATORS, failures, noise, rows
from pipeline.analysis.validity import Cable

MOST_SPANS = 20
MEANINGS = (
    "α: inclination to the vertical of the plane nearest to the markers. e_P: root mean square of their distances from "
    "that plane. e_C: root mean square of their distances, in the plane at the same x, from the nearest catenary."
)


def tab(cables: list[Cable]) -> Tab | None:
    """None where there are no lines."""
    items: list[str | Chart] = [item for cable in cables for item in _cable(cable)]
    return Tab("catenary", "Catenary", items) if items else None


def _cable(cable: Cable) -> Iterator[str | Chart]:
    scenario = cable.recording.origin.scenario
    yield f"<h2>{escape(cable.recording.name)}{escape(f' of {scenario}' if scenario else '')}</h2>"
    if cable.line is not None:
        yield from (paragraph(text) for text in line_tables.sentences(cable.line))
    yield f"<p><strong>Fitted to its markers or nodes: {escape(str(cable.durations))}</strong></p>"
    yield _statistics(cable)
    yield f"<p>{escape(failures(cable))} {escape(noise(cable))}</p>"
    yield from _spans(cable)
    yield from _indicators(cable)
    yield from _circumstances(cable)
    if cable.line is not None:
        yield from _line(cable.line)
    yield _facts(cable)


def _statistics(cable: Cable) -> str:
    header = [""]
    for title in INDICATORS.values():
        header.append(escape(title))
        if cable.published:
            header.append('<span class="published">publ&shy;ished</span>')
    lines = [[name, *map(escape, values)] for name, values in rows(cable)]
    said = [MEANINGS]
    if cable.published is not None:
        said.append(f"Published: {cable.published.table} of {cable.published.source}.")
    return table(header, lines, "statistics") + paragraph(" ".join(said), "small")


def _spans(cable: Cable) -> Iterator[str]:
    worst = sorted(sorted(cable.spans, key=lambda span: -span.worst)[:MOST_SPANS], key=lambda span: span.start_ns)
    if not worst:
        return
    title = "Where the catenary fails" if len(worst) == len(cable.spans) else f"The {MOST_SPANS} worst spans"
    header = ["from [s]", "to [s]", "frames [1]", "largest e_C [mm]", *([] if cable.line is None else ["cause"])]
    found = table(header, (_span(cable, span) for span in worst), "spans")
    yield f"<details><summary>{title} ({len(cable.spans)} in all)</summary>{found}</details>"


def _span(cable: Cable, s: Span) -> list[str]:
    why = [] if cable.line is None else [escape(line_tables.cause(cable.cause(s)[0], cable.line, of_fit=True))]
    return [f"{s.start_ns / 1e9:.2f}", f"{s.end_ns / 1e9:.2f}", str(s.frames), f"{1e3 * s.worst:.4g}", *why]


def _indicators(cable: Cable) -> Iterator[Chart]:
    """alpha, e_P, e_C and C over time: figures 4 and 6 of Drupt et al. 2022."""
    fits, (scale, unit) = cable.fits, line_tables.length_unit(cable.tolerance)
    t, good = fits.t_ns / 1e9, reliable(fits)
    bands = [(s.start_ns / 1e9, s.end_ns / 1e9) for s in cable.spans]
    for title, name, axis, values, log, level in (
        ("Inclination of the plane", "α", "inclination α [°]", np.degrees(fits.alpha), False, None),
        ("Distance from the plane", "e_P", f"off the plane e_P [{unit}]", scale * fits.e_plane, True, None),
        (
            "Distance from the catenary",
            "e_C",
            f"off the catenary e_C [{unit}]",
            scale * fits.e_catenary,
            True,
            scale * cable.tolerance,
        ),
        ("Catenary parameter", "C", "catenary C [1/m]", fits.C, False, None),
    ):
        if not np.isfinite(values).any():  # such as C of a line that is straight throughout
            continue
        curves = [Series(name, t, np.where(good, values, np.nan))]
        if not good.all() and np.isfinite(values[~good]).any():
            few = Series(f"fewer than {LEAST_MARKERS} markers", t, np.where(good, np.nan, values), faint=True)
            curves.insert(0, few)
        limits = [] if level is None else [(level, "tolerance")]
        shaded = [] if level is None else bands
        said = "Red: beyond the tolerance by more than noise explains." if shaded else ""
        yield Chart(title, axis, curves, said, log, limits, shaded)


def _circumstances(cable: Cable) -> Iterator[Chart]:
    """Number and visibility of the markers, speed and acceleration of the moving end, distance of the ends."""
    frames = cable.recording.frames
    t = frames.t_ns / 1e9
    if not frames.valid.all():
        seen = [Series("visible", t, frames.valid.sum(axis=1).astype(float), kind="step")]
        limits = [(LEAST_MARKERS - 0.5, "used above it")]
        yield Chart("Visible markers", "visible markers N [1]", seen, limits=limits)
        lanes = [(f"marker {i + 1}", when(t, frames.valid[:, i])) for i in range(frames.markers)]
        yield Chart("Which markers are visible", "visible marker, index [1]", lanes=lanes)
    ends = cable.recording.ends()
    source = f"{ends.source[0].upper()}{ends.source[1:]}."
    for title, axis, times, values in (
        ("Speed of the moving end", "speed [m/s]", ends.t, ends.speed),
        ("Acceleration of the moving end", "acceleration [m/s²]", ends.t, ends.acceleration),
        ("Distance of the ends", "ends apart d [m]", ends.t_distance, ends.distance),
    ):
        yield Chart(title, axis, [Series(axis.partition(" [")[0], times, values)], source)


def _line(verdict: LineVerdict) -> Iterator[str | Chart]:
    """The catenary through the ends, and what loads the line beside its weight."""
    judged = {name: match for name, match in verdict.matches.items() if not match.missing}
    if not judged:
        return
    yield heading("The catenary through the ends")
    t = verdict.record.t_ns / 1e9
    bands = [(one.span.start_ns / 1e9, one.span.end_ns / 1e9) for one in next(iter(judged.values())).failures]
    said = f"Red: shape or tension out of tolerance {TITLES[next(iter(judged))]}."
    for end, row in (("a", 0), ("b", 1)):
        curves = [Series("recorded", t, verdict.tension[row])]
        curves += [Series(f"catenary {TITLES[name]}", t, match.tension[row]) for name, match in judged.items()]
        yield Chart(f"Tension at end {end}", "tension [N]", curves, said, bands=bands)
    metres, unit = line_tables.length_unit(verdict.shape_tolerance)
    for title, axis, scale, limit, error in (
        ("Tension error", "e_T [%]", 100.0, verdict.tension_tolerance, "e_tension"),
        ("Shape error", f"off the catenary [{unit}]", metres, verdict.shape_tolerance, "e_shape"),
    ):
        curves = [Series(TITLES[name], t, scale * getattr(match, error)) for name, match in judged.items()]
        limits = [(scale * limit, "tolerance")]
        yield Chart(f"{title} of the catenary through the ends", axis, curves, said, True, limits, bands)
    over = verdict.loads.over_weight().items()
    base = "weight in water" if verdict.line.weight > 0.0 else "mean load"
    curves = [Series(CAUSES[name], t, values) for name, values in over]
    yield Chart(f"What loads the line, over its {base}", f"over {base} [1]", curves, "Root mean squares along it.")
    uneven = [Series(CAUSES[name], t, values) for name, values in verdict.loads.uneven.items()]
    title, said = "How uneven these loads are along the line", "Differences from their means along it, likewise."
    yield Chart(title, "over all mean load [1]", uneven, said)
    for name, match in judged.items():
        yield _failures(verdict, name, match)


def _failures(verdict: LineVerdict, name: str, match: Match) -> str:
    chosen = line_tables.worst(match, MOST_SPANS)
    which = "all" if len(chosen) == len(match.failures) else f"the {MOST_SPANS} longest"
    summary = f"Where the catenary {TITLES[name]} fails ({len(match.failures)} spans, {which})"
    lines = ([escape(cell) for cell in line_tables.row(one, verdict)] for one in chosen)
    return f"<details><summary>{escape(summary)}</summary>{table(line_tables.COLUMNS, lines, 'failures')}</details>"


def _facts(cable: Cable) -> str:
    """How the numbers came about."""
    facts = [
        f"{cable.statistics.frames_used} of {cable.statistics.frames} frames used; method {cable.method}, "
        f"{cable.wall_s:.3g} s",
        *(f"{count} frames: {reason}" for reason, count in cable.fits.reasons().items()),
        *cable.fits.notes,
        f"markers from {cable.recording.frames.source}",
    ]
    return f'<ul class="small">{"".join(f"<li>{escape(fact)}</li>" for fact in facts)}</ul>'
