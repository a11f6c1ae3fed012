"""Wind, current and sea."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab


def tab(signals: Signals) -> Tab | None:
    """None where the log has no weather."""
    charts = []
    for name in signals.having("velocity", "speed", "mean"):
        t = signals.t(name)
        curves = [Series("gusts included", t, signals.port(name, "speed"), faint=True)]
        charts.append(
            Chart(f"Speed of the {name}", "speed [m/s]", [*curves, Series("mean", t, signals.port(name, "mean"))])
        )
    for name in signals.having("surface", "velocity"):
        if signals.shape(name, "velocity")[-1:] != (3,):
            continue
        t, velocity = signals.t(name), signals.port(name, "velocity").reshape(len(signals.t(name)), -1, 3)
        depths, count = signals.entries.array(name, "depths"), velocity.shape[1]
        labels = [f"at {z:g} m" for z in depths] if len(depths) == count else [f"{i + 1}" for i in range(count)]
        speed, towards = np.linalg.norm(velocity, axis=2), np.degrees(np.arctan2(velocity[..., 1], velocity[..., 0]))
        for title, axis, values in (("Speed", "speed [m/s]", speed), ("Direction", "towards [°]", towards % 360.0)):
            curves = [Series(label, t, values[:, i]) for i, label in enumerate(labels)]
            charts.append(Chart(f"{title} of the {name}", axis, curves))
    for name in signals.having("elevation"):
        sea = [Series("elevation", signals.t(name), signals.port(name, "elevation"))]
        charts.append(Chart(f"The {name} at the origin", "elevation [m]", sea))
    return Tab("weather", "Weather", charts) if charts else None
