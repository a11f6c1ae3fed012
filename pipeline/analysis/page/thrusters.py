"""What thrusters gave, and where the allocator met its limits."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.page.charts import Chart, Series, when
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading

FLAGS = {"met": (False, "demand not met"), "held": (True, "last command held"), "proven": (False, "not proven best")}


def tab(signals: Signals) -> Tab | None:
    """None where there are no thrusters."""
    items: list[str | Chart] = []
    for name in signals.having("thrust"):
        if signals.channels[name].port("thrust")[0].unit == "N":
            items += [heading(name), *_charts(signals, name)]
    return Tab("thrusters", "Thrusters", items) if items else None


def _charts(signals: Signals, name: str) -> list[Chart]:
    found = [_of_each(signals, name, "thrust", "Thrust", "thrust [kN]", 1e-3)]
    if signals.has(name, "power"):
        found.append(_of_each(signals, name, "power", "Power", "power [kW]", 1e-3))
        t, power = signals.t(name), 1e-3 * signals.rows(name, "power").sum(axis=1)
        found.append(Chart("Power of all", "power [kW]", [Series("all", t, power)]))
    if signals.has(name, "azimuth"):
        found.append(_of_each(signals, name, "azimuth", "Direction", "azimuth [°]", 180.0 / np.pi))
    lanes = _limits(signals, name)
    if lanes:
        found.append(Chart(f"Limits met by {name}", "limit", lanes=lanes, caption="Bars: while it is so."))
    if signals.has(name, "running"):
        stopped = signals.rows(name, "running") < 0.5
        lanes = [(f"thruster {i + 1}", when(signals.t(name), stopped[:, i])) for i in range(stopped.shape[1])]
        found.append(Chart("Thrusters out of order", "thruster", lanes=lanes, caption="Bars: while it does not run."))
    return found


def _of_each(signals: Signals, name: str, port: str, title: str, axis: str, scale: float) -> Chart:
    values = scale * signals.rows(name, port)
    curves = [Series(f"{i + 1}", signals.t(name), values[:, i]) for i in range(values.shape[1])]
    return Chart(f"{title} of each thruster", axis, curves)


def _limits(signals: Signals, name: str) -> list[tuple[str, list[tuple[float, float]]]]:
    lanes = []
    t = signals.t(name)
    for port in signals.ports(name):
        if port.startswith("limit."):
            values = signals.port(name, port).reshape(len(t), -1) > 0.5
            what = port.partition(".")[2]
            lanes += [_lane(f"{what} {i + 1}", t, values[:, i]) for i in range(values.shape[1]) if values[:, i].any()]
    for port, (sense, text) in FLAGS.items():
        if signals.has(name, port) and signals.has(name, "achieved.force"):
            so = (signals.rows(name, port)[:, 0] > 0.5) == sense
            if so.any():
                lanes.append(_lane(text, t, so))
    return lanes


def _lane(text: str, t: np.ndarray, so: np.ndarray) -> tuple[str, list[tuple[float, float]]]:
    """With the share of the messages in its name."""
    return f"{text}, {100.0 * so.mean():.2g} %", when(t, so)
