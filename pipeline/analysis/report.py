"""The report of a recording: a page of what the log has, from the overview to the weather."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from pipeline.analysis.page import (
    bonds,
    catenary,
    control,
    estimator,
    line_estimate,
    motion,
    others,
    overview,
    scene,
    tensions,
    thrusters,
    weather,
)
from pipeline.analysis.page.charts import Window
from pipeline.analysis.page.document import document
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.validity import Cable
from pipeline.errors import LogError, TowlineError
from pipeline.log.reader import open_log

OF_SIGNALS = (tensions, motion, control, thrusters, estimator, line_estimate, bonds, weather, others)


def report(
    path: Path, is_log: bool, cables: list[Cable], window: Window | None = None, unjudged: Sequence[str] = ()
) -> str:
    """The page. path: of the recording; window: what the charts show at first [s]; unjudged: on lines left out.

    Raises TowlineError if the window is not within the record, LogError if the log is damaged or holds nothing.
    """
    if not is_log:
        return _of_markers(path, cables, window, unjudged)
    with open_log(path) as log:
        if not log.channels:
            raise LogError(log.warning or f"{path} has no channels: there is nothing to report")
        signals = Signals(log)
        whole = Window(signals.start, signals.end)
        _check_within(window, whole, path.name)
        drawn = scene.of_log(signals)
        tabs = [overview.tab(log, signals, cables, drawn is not None, unjudged), catenary.tab(cables)]
        tabs += [module.tab(signals) for module in OF_SIGNALS]
        about = signals.entries.description or path.name
        found = [tab for tab in tabs if tab]
        return document(signals.entries.name or path.name, about, found, drawn, whole, window, signals.events)


def _of_markers(path: Path, cables: list[Cable], window: Window | None, unjudged: Sequence[str]) -> str:
    """Of a table, or of another tool's file."""
    starts, ends = ([cable.fits.t_ns[i] / 1e9 for cable in cables if len(cable.fits.t_ns)] for i in (0, -1))
    whole = Window(float(min(starts, default=0.0)), float(max(ends, default=1.0)))
    _check_within(window, whole, ", ".join(cable.recording.name for cable in cables))
    drawn = scene.of_markers(cables[0].recording.frames) if len(cables) == 1 else None
    tabs = [overview.tab(None, None, cables, drawn is not None, unjudged), catenary.tab(cables)]
    return document(path.name, "Markers on a line", [tab for tab in tabs if tab], drawn, whole, window)


def _check_within(window: Window | None, whole: Window, name: str) -> None:
    if window is not None and not whole.start <= window.start < window.end <= whole.end:
        raise TowlineError(
            f"--window: {window.start:g} to {window.end:g} s is not within the record of {name}, "
            f"which goes from {whole.start:.6g} to {whole.end:.6g} s"
        )


def write(path: Path, text: str) -> None:
    """Write the page whole or not at all. Raises OSError."""
    fresh = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)
