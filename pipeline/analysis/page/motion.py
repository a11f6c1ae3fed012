"""How bodies moved: speed, heading, depth, roll and pitch; what a winch paid out."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab


def bodies(signals: Signals) -> list[str]:
    """The channels of rigid bodies."""
    return [
        name
        for name in signals.having("position", "attitude", "velocity")
        if {signals.shape(name, port) for port in ("position", "attitude", "velocity")} == {(3,)}
    ]


def tab(signals: Signals) -> Tab | None:
    """None where the log has no bodies and no winch."""
    found = bodies(signals)
    charts = []
    if found:
        speed = [(name, np.linalg.norm(signals.port(name, "velocity"), axis=1)) for name in found]
        charts.append(Chart("Speed over ground", "speed [m/s]", _series(signals, speed)))
        heading = [(name, np.degrees(signals.port(name, "attitude")[:, 2])) for name in found]
        charts.append(Chart("Heading", "heading [°]", _series(signals, heading)))
        depth = [(name, signals.port(name, "position")[:, 2]) for name in found]
        charts.append(Chart("Depth of the reference points", "depth [m]", _series(signals, depth)))
    for name in found:
        attitude = np.degrees(signals.port(name, "attitude")[:, :2])
        if not (attitude == attitude[0]).all():
            tilt = [("roll", attitude[:, 0]), ("pitch", attitude[:, 1])]
            charts.append(Chart(f"Roll and pitch of {name}", "angle [°]", _of(signals, name, tilt)))
    for name in signals.having("payout_rate", "stored"):
        if signals.shape(name, "payout_rate") or signals.shape(name, "stored"):
            continue
        rate, stored = signals.port(name, "payout_rate"), signals.port(name, "stored")
        charts.append(Chart(f"Payout by {name}", "rate [m/s]", _of(signals, name, [("paid out", rate)])))
        charts.append(Chart(f"Length left on {name}", "length [m]", _of(signals, name, [("stored", stored)])))
    return Tab("motion", "Motion", charts) if charts else None


def _series(signals: Signals, curves: list[tuple[str, np.ndarray]]) -> list[Series]:
    return [Series(name, signals.t(name), values) for name, values in curves]


def _of(signals: Signals, channel: str, curves: list[tuple[str, np.ndarray]]) -> list[Series]:
    return [Series(name, signals.t(channel), values) for name, values in curves]
