"""How well a controller held its place: errors, demands beside what was achieved."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.known import finite
from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading, table

AXES = ("ahead", "to starboard", "down")


def tab(signals: Signals) -> Tab | None:
    """None where nothing was controlled."""
    items: list[str | Chart] = []
    rows = []
    for name in signals.having("error.position", "error.heading"):
        rows.append(row(signals, name))
        items += [heading(name), *_errors(signals, name), *_forces(signals, name)]
    for name in signals.having("error.across", "error.along"):
        items += [heading(name), *_towing(signals, name)]
    if rows:
        header = ["", "position, rms [m]", "largest [m]", "heading, rms [°]", "largest [°]"]
        items.insert(0, table(header, rows, "performance"))
    return Tab("control", "Control", items) if items else None


def performance(signals: Signals, name: str) -> tuple[float, float, float, float]:
    """Root mean square and largest error of position [m] and heading [deg]; NaN where none is known."""
    distance = np.linalg.norm(signals.rows(name, "error.position"), axis=1)
    angle = np.abs(np.degrees(signals.rows(name, "error.heading")))
    return (*_sizes(distance), *_sizes(angle))


def _sizes(values: np.ndarray) -> tuple[float, float]:
    known = finite(values)
    return (float(np.sqrt(np.mean(known**2))), float(known.max())) if len(known) else (np.nan, np.nan)


def row(signals: Signals, name: str) -> list[str]:
    """The controller's name and its performance, in figures."""
    return [name, *("-" if np.isnan(value) else f"{value:.3g}" for value in performance(signals, name))]


def _errors(signals: Signals, name: str) -> list[Chart]:
    t, error = signals.t(name), signals.rows(name, "error.position")
    distance = Series("distance", t, np.linalg.norm(error, axis=1), faint=True)
    parts = [Series(axis, t, error[:, i]) for i, axis in enumerate(AXES[: error.shape[1]])]
    angle = [Series("heading", t, np.degrees(signals.port(name, "error.heading")))]
    return [
        Chart("Position error", "error [m]", [distance, *parts], "Of the controller's estimate from its reference."),
        Chart("Heading error", "error [°]", angle),
    ]


def _forces(signals: Signals, name: str) -> list[Chart]:
    """Demand beside what the allocator said to achieve, and what the thrusters gave."""
    if not signals.has(name, "demand.force", "demand.moment") or signals.shape(name, "demand.force")[:1] < (2,):
        return []
    sources = [("demanded", name, "demand")]
    for allocator in signals.having("achieved.force", "achieved.moment"):
        if signals.entries.source(allocator, "demand")[0] == name:
            sources.append(("allocated", allocator, "achieved"))
            sources += [("given", one, "total") for one in _driven_by(signals, allocator)]
    charts = []
    for i, axis in enumerate(("ahead", "to starboard")):
        curves = [
            Series(word, signals.t(one), 1e-3 * signals.port(one, f"{bundle}.force")[:, i])
            for word, one, bundle in sources
        ]
        charts.append(Chart(f"Force {axis}", "force [kN]", curves))
    moment = [
        Series(word, signals.t(one), 1e-3 * signals.port(one, f"{bundle}.moment")) for word, one, bundle in sources
    ]
    return [*charts, Chart("Moment about the vertical", "moment [kN m]", moment)]


def _driven_by(signals: Signals, allocator: str) -> list[str]:
    """Propulsion that takes this allocator's thrust."""
    found = []
    for name in signals.having("total.force", "total.moment"):
        wires = (signals.entries.wire(name, "command.thrust"), signals.entries.wire(name, "command"))
        texts = [wire.get("from", "") if isinstance(wire, dict) else str(wire) for wire in wires]
        if any(text.partition(".")[0] == allocator for text in texts):
            found.append(name)
    return found


def _towing(signals: Signals, name: str) -> list[Chart]:
    t = signals.t(name)
    across = [Series(word, t, signals.port(name, f"error.{word}")) for word in ("across", "along")]
    charts = [Chart("Off the path", "error [m]", across)]
    if signals.has(name, "error.heading"):
        charts.append(
            Chart("Heading error", "error [°]", [Series("heading", t, np.degrees(signals.port(name, "error.heading")))])
        )
    if signals.has(name, "error.speed"):
        charts.append(Chart("Speed error", "error [m/s]", [Series("speed", t, signals.port(name, "error.speed"))]))
    return charts
