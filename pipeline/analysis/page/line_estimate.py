"""An estimated line over time, as figures 12 to 18 of Trigo et al. 2014 show it, beside the line that was simulated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.analysis.estimates import Estimate, TetherEstimate, estimates, tether_estimates
from pipeline.analysis.known import finite
from pipeline.analysis.page.charts import Chart, Series, when
from pipeline.analysis.page.estimator import LIKELY, chi_square
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading

PARTS = ((0.25, "a quarter from end a"), (0.5, "in the middle"), (0.75, "three quarters from it"), (1.0, "at end b"))
FRAME = 2.0  # of what the curves span and of the usual deviation: a larger deviation would leave them a flat line
MEASURED = ("position of end b", "tension")  # whose innovations estimators of a whole line tell


def tab(signals: Signals) -> Tab | None:
    """None where no line was estimated."""
    items: list[str | Chart] = []
    for one in estimates(signals):
        items += [heading(one.name), *charts_of(one)]
    for whole in tether_estimates(signals):
        items += [heading(whole.name), *_shape(whole), *_end_tensions(whole), *_squares(whole), *_refused(whole)]
    return Tab("line", "Estimated line", items) if items else None


def charts_of(one: Estimate) -> list[Chart]:
    """Tension, angles, moments, and how well the estimate met what was measured."""
    return [_tension(one), _angles(one), _moments(one), _consistency(one)]


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
    return _beside("Tension at the end", one.t, one.tension, one.deviation, one.true_tension)


def _beside(
    title: str, t: np.ndarray, tension: np.ndarray, deviation: np.ndarray, true: np.ndarray | None, said: str = ""
) -> Chart:
    """A tension with two standard deviations to either side, and the simulated one."""
    drawn = finite(tension if true is None else np.concatenate([tension, true]))
    room = FRAME * np.ptp(drawn) if len(drawn) else np.inf
    wild = np.abs(deviation) > max(room, FRAME * np.median(deviation))
    series = [Series("estimated", t, tension), *_two_sigma(t, tension, np.where(wild, np.nan, deviation))]
    if wild.any():
        said += f"2σ is out of the figure at {100 * np.mean(wild):.2g} % of the time. "
    if true is not None:
        series.append(Series("simulated", t, true))
        both = np.isfinite(tension - true)
        error, scale = (tension - true)[both], np.abs(true[both]).mean() if both.any() else 0.0
        if scale > 0.0:
            rms, within = np.sqrt(np.mean(error**2)), np.mean(np.abs(error) <= 2.0 * deviation[both])
            said += (
                f"Error {error.mean():.3g} N in the mean and {rms:.3g} N rms ({100 * rms / scale:.3g} % of the mean "
                f"tension); {100 * within:.3g} % of the time within 2σ."
            )
    return Chart(title, "tension [N]", series, said)


def _two_sigma(t: np.ndarray, about: np.ndarray, deviation: np.ndarray) -> list[Series]:
    return [
        Series(f"{sign}2σ", t, about + 2.0 * side * deviation, faint=True) for sign, side in (("+", 1.0), ("−", -1.0))
    ]


def _consistency(one: Estimate) -> Chart:
    chart = _nis("NIS over its degrees of freedom", one.t, one.nis, one.freedom)
    if one.contradicted is None or one.beginnings is None or not one.contradicted.any():
        return chart
    said = (
        f" In {int(one.contradicted.sum())} of {len(one.t)} frames (shaded) sensors contradict each other or the "
        f"estimate; new beginnings: {int(one.beginnings.max())}."
    )
    return replace(chart, caption=chart.caption + said, bands=when(one.t, one.contradicted))


def _nis(title: str, times: np.ndarray, nis: np.ndarray, all_freedom: np.ndarray) -> Chart:
    """Normalised innovations squared of what was measured, with the band of chi-square."""
    some = all_freedom > 0.0
    t, freedom = times[some], all_freedom[some]
    values = nis[some] / freedom
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
    return Chart(title, "NIS [1]", series, said, log=True)


def _shape(one: TetherEstimate) -> list[Chart]:
    """How far the estimated line is from the simulated one, along it and at end b."""
    if one.off is None or one.off_end is None:
        return []
    last = one.off.shape[1] - 1
    curves = [Series(name, one.t, one.off[:, round(part * last)]) for part, name in PARTS]
    curves.append(Series("root mean square of all nodes", one.t, np.sqrt((one.off**2).mean(axis=1)), faint=True))
    errors = finite(one.off)
    rms = f"Root mean square of all nodes and times {np.sqrt(np.mean(errors**2)):.3g} m. " if len(errors) else ""
    said = f"{rms}Between nodes at the same share of the length; the animation of the overview shows both lines."
    axes = [Series(axis, one.t, one.off_end[:, i]) for i, axis in enumerate(("north", "east", "down"))]
    sigma = np.sqrt((one.place**2).mean(axis=1))
    return [
        Chart("Off the simulated line", "distance [m]", curves, said),
        Chart(
            "Error of the place of end b",
            "error [m]",
            [*axes, *_two_sigma(one.t, np.zeros(len(one.t)), sigma)],
            "2σ: as estimated, root mean square of the three axes.",
        ),
    ]


def _end_tensions(one: TetherEstimate) -> list[Chart]:
    true = (None, None) if one.true_tension is None else one.true_tension.T
    return [
        _beside(f"Tension at end {end}", one.t, one.tension[:, i], one.deviation[:, i], true[i])
        for i, end in enumerate("ab")
    ]


def _squares(one: TetherEstimate) -> list[Chart]:
    return [
        _nis(f"NIS of the {what} over its degrees of freedom", one.t, one.nis[:, i], one.freedom[:, i])
        for i, what in enumerate(MEASURED)
    ]


def _refused(one: TetherEstimate) -> list[Chart]:
    """When no line fitted the ends and the length, and the last shape was given again."""
    spans = when(one.t, one.held > 0.5)
    return [Chart("Last shape held", "no line fits", lanes=[("held", spans)])] if spans else []
