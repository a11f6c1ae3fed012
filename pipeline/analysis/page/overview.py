"""The first tab: what ran, what happened, and the verdicts in one table each; the animation and the map stand below."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from pipeline.analysis.line_validity import TITLES
from pipeline.analysis.page import control
from pipeline.analysis.page.charts import Chart
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading, paragraph, table
from pipeline.analysis.page.tensions import lines
from pipeline.analysis.validity import Cable
from pipeline.log.conventions import RESULT, SPEED
from pipeline.log.reader import Log

MOST_ODD = 5  # lines that are shown at once


def tab(
    log: Log | None, signals: Signals | None, cables: list[Cable], has_scene: bool, unjudged: Sequence[str] = ()
) -> Tab:
    """log, signals: None for a table of markers. unjudged: a sentence on each line that was not judged."""
    items: list[str | Chart] = []
    if log is not None and signals is not None:
        items += _run(log, signals)
    items += _verdicts(cables)
    items += [paragraph(text, "warning") for text in unjudged]
    if has_scene:
        items.append(SCENE)
    if signals is not None:
        items += _numbers(signals)
        items += _events(signals)
    return Tab("overview", "Overview", items)


SCENE = (
    '<div class="views"><figure class="view"><figcaption><b>In space</b> <span>drag to turn, wheel or pinch to zoom; '
    'north, east and depth [m]</span></figcaption><canvas id="scene" tabindex="0"></canvas></figure>'
    '<figure class="view"><figcaption><b>Footprint</b> <span>from above, north up; north and east [m]</span>'
    '</figcaption><canvas id="map"></canvas></figure></div>'
)


def _run(log: Log, signals: Signals) -> Iterator[str]:
    run, speed = log.metadata("run"), log.metadata(RESULT).get(SPEED)
    if log.warning:
        yield paragraph(log.warning, "warning")
    facts = [
        f"{signals.end - signals.start:.6g} s from {signals.start:.6g} s",
        f"{len(log.channels)} channels, {sum(info.count for info in log.channels.values())} messages",
        f"{log.path.stat().st_size / 1e6:.3g} MB",
        *([f"run at {speed} times real time"] if speed else []),
        *([f"Towline {run['towline']}"] if "towline" in run else []),
    ]
    yield paragraph(" · ".join(facts), "small")
    if odd := [*signals.oddities, *_heaps(signals)]:
        listed = f'<ul class="small warning">{"".join(f"<li>{escape(line)}</li>" for line in odd)}</ul>'
        summary = f"<summary>{len(odd)} things are odd in this log</summary>"
        yield listed if len(odd) <= MOST_ODD else f"<details>{summary}{listed}</details>"


def _heaps(signals: Signals) -> Iterator[str]:
    """Lines that have no length."""
    for name in lines(signals):
        nodes = signals.port(name, "nodes")
        count = int((nodes == nodes[:, :1]).all(axis=(1, 2)).sum())
        if count:
            yield f"{name}: all its nodes stand in one place in {count} of {len(nodes)} messages"


def _events(signals: Signals) -> Iterator[str]:
    if signals.events:
        rows = ([f"{t:.6g}", escape(text)] for t, text in signals.events[:100])
        inside = table(["at [s]", "event"], rows, "events")
        count = "1 event" if len(signals.events) == 1 else f"{len(signals.events)} events"
        yield f"<details open><summary>{count}</summary>{inside}</details>"


def _verdicts(cables: list[Cable]) -> Iterator[str]:
    """A row for each catenary of each line."""
    rows = []
    for cable in cables:
        d = cable.durations
        name = escape(cable.recording.name)
        rows.append([name, "fitted to its shape", _badge(d.failing, d.holding), f"{d.failing:.4g}", f"{d.record:.4g}"])
        if cable.line is not None:
            for load, match in cable.line.matches.items():
                verdict = _badge(match.durations.failing, match.durations.holding)
                times = f"{match.durations.failing:.4g}", f"{match.durations.record:.4g}"
                rows.append([name, f"through its ends, {TITLES[load]}", verdict, *times])
    if rows:
        yield heading("Was the catenary valid?")
        yield table(["line", "catenary", "verdict", "fails for [s]", "of [s]"], rows, "verdicts")


def _badge(failing: float, holding: float) -> str:
    """In words, coloured."""
    if failing + holding == 0.0:
        return '<span class="badge unknown">not known</span>'
    if failing == 0.0:
        return '<span class="badge good">holds</span>'
    return (
        f'<span class="badge {"bad" if holding == 0.0 else "part"}">{"fails" if holding == 0.0 else "in part"}</span>'
    )


def _numbers(signals: Signals) -> Iterator[str]:
    held = signals.having("error.position", "error.heading")
    if held:
        yield heading("Control")
        rows = [control.row(signals, name) for name in held]
        yield table(["", "position, rms [m]", "largest [m]", "heading, rms [°]", "largest [°]"], rows, "performance")
