"""An estimated line over time, as figures 12 to 18 of Trigo et al. 2014 show it, beside the line that was simulated."""

from __future__ import annotations

import numpy as np

from pipeline.analysis.estimates import Estimate, estimates
from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.estimator import LIKELY, chi_square
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading


def tab(signals: Signals) -> Tab | None:
    """None where no line was estimated."""
    items: list[str | Chart] = []
    for one in estimates(signals):
        items += [heading(one.name), _tension(one), _angles(one), _moments(one), _consistency(one)]
    return Tab("line", "Estimated line", items) if items else None


def _angles(one: Estimate) -> Chart:
    series = [Series(f"bar {i + 1}", one.t, np.degrees(column)) for i, column in enumerate(one.angle.T)]
    if one.true_angle is not None:
        columns = enumerate(np.degrees(one.true_angle).T)
        series += [Series(f"bar {i + 1}, simulated", one.t, column, faint=True) for i, column in columns]
    return Chart("Angles of the bars", "angle [°]", series, "From north towards down; bars from the pivot on.")


def _moments(one: Estimate) -> Chart:
    series = [Series(f"joint {i + 1}", one.t, 1e3 * column) for i, column in enumerate(one.moment.T)]
    return Chart("Bending moments", "moment [mN m]", series, "At the joints, from the pivot on.")


def _tension(one: Estimate) -> Chart:
    sides = (("+", 1.0), ("−", -1.0))
    series = [Series("estimated", one.t, one.tension)]
    series += [Series(f"{sign}2σ", one.t, one.tension + 2.0 * side * one.deviation, faint=True) for sign, side in sides]
    said = ""
    if one.true_tension is not None:
        series.append(Series("simulated", one.t, one.true_tension))
        error = one.tension - one.true_tension
        mean, rms, scale = error.mean(), np.sqrt(np.mean(error**2)), np.mean(np.abs(one.true_tension))
        said = f"Error {mean:.3g} N in the mean and {rms:.3g} N rms ({100 * rms / scale:.3g} % of the mean tension)."
    return Chart("Tension at the end", "tension [N]", series, said)


def _consistency(one: Estimate) -> Chart:
    some = one.freedom > 0.0
    t, freedom = one.t[some], one.freedom[some]
    values = one.nis[some] / freedom
    known = {
        degrees: [chi_square(degrees, 0.5 + side * LIKELY / 2) / degrees for side in (-1, 1)] for degrees in {*freedom}
    }
    edges = np.array([known[degrees] for degrees in freedom]).reshape(-1, 2)
    within = np.mean((values >= edges[:, 0]) & (values <= edges[:, 1])) if len(values) else 0.0
    series = [Series("each", t, values, kind="dots")]
    series += [
        Series(f"{100 * LIKELY:g} % band, {name}", t, edges[:, i], faint=True) for i, name in enumerate(("low", "high"))
    ]
    said = f"{100 * within:.3g} % of {len(values)} measurements are within the band of chi-square."
    return Chart("NIS over its degrees of freedom", "NIS [1]", series, said, log=True)
