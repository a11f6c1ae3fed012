"""What lines pulled: tensions at their ends and the greatest along them, their length, and the models' own validity."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.markers import is_estimate, is_line
from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading


def lines(signals: Signals) -> list[str]:
    """The channels of lines, simulated and estimated."""
    return [name for name in signals.having("nodes") if is_line(signals.shape(name, "nodes"))]


def tab(signals: Signals) -> Tab | None:
    """None where no line recorded a tension."""
    items: list[str | Chart] = []
    for name in lines(signals):
        if is_estimate(signals.channels[name]):
            continue
        charts = list(_charts(signals, name))
        if charts:
            items += [heading(name), *charts]
    return Tab("tensions", "Tensions", items) if items else None


def _charts(signals: Signals, name: str) -> list[Chart]:
    t, found = signals.t(name), []
    curves = []
    if signals.has(name, "tension"):
        tension = signals.rows(name, "tension")
        curves.append(Series("greatest along the line", t, tension.max(axis=1), faint=True))
    for end in "ab":
        if signals.has(name, f"force_{end}"):
            force = np.linalg.norm(signals.rows(name, f"force_{end}"), axis=1)
            curves.append(Series(f"on the holder of end {end}", t, force))
    if curves:
        found.append(Chart(f"Tension of {name}", "tension [N]", curves))
    for end in "ab":
        if signals.has(name, f"force_{end}") and signals.shape(name, f"force_{end}") == (3,):
            force = signals.port(name, f"force_{end}")
            axes = [Series(axis, t, force[:, i]) for i, axis in enumerate(("north", "east", "down"))]
            found.append(Chart(f"Force of {name} on the holder of end {end}", "force [N]", axes))
    chord = np.linalg.norm(signals.port(name, "nodes")[:, -1] - signals.port(name, "nodes")[:, 0], axis=1)
    apart = [Series("ends apart", t, chord)]
    if signals.has(name, "unstretched_length"):
        apart.append(Series("unstretched length", t, signals.port(name, "unstretched_length")))
    found.append(Chart(f"Length of {name}", "length [m]", apart))
    measures = [one for one in signals.ports(name) if one.startswith("validity.") and not signals.shape(name, one)]
    if measures:
        curves = [
            Series(one.partition(".")[2], t, signals.port(name, one), faint=one == "validity.range")
            for one in measures
            if one == "validity.range" or (signals.port(name, one) > 0.01).any()
        ]
        title = f"Validity of the model of {name}"
        said = "Above 1 the model itself is not to be believed."
        found.append(Chart(title, "of its limit [1]", curves, said, limits=[(1.0, "limit")]))
    return found
