"""Whether an estimator's errors are as large as it says: normalised innovations squared, and errors against the truth.

Where the filter fits, the NIS of a measurement of m numbers is chi-square of m, and the sum of N of them of N m
(Bar-Shalom, Li, Kirubarajan 2001, 5.4.2): the running mean is shown with the band of 95 % of the latter.
"""

from __future__ import annotations

import numpy as np

from pipeline.analysis.page.charts import Chart, Series
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import Tab, heading

RUNNING = 50  # measurements in the running mean
LIKELY = 0.95


def tab(signals: Signals) -> Tab | None:
    """None where nothing was estimated."""
    items: list[str | Chart] = []
    for name in signals.channels:
        found = _errors(signals, name)
        for port in signals.ports(name):
            if port.startswith("nis."):
                found += _consistency(signals, name, port)
        if found:
            items += [heading(name), *found]
    return Tab("estimator", "Estimator", items) if items else None


def chi_square(degrees: float, share: float) -> float:
    """What chi-square of so many degrees of freedom exceeds with a chance of 1 - share."""
    from scipy.special import chdtri

    return float(chdtri(degrees, 1.0 - share))


def _consistency(signals: Signals, name: str, port: str) -> list[Chart]:
    """A chart for each column of a port of NIS."""
    what, t = port.partition(".")[2], signals.t(name)
    nis = signals.port(name, port).reshape(len(t), -1)
    degrees = _degrees(signals, name, what, nis.shape[1])
    charts = []
    for i in range(nis.shape[1]):
        used = nis[:, i] > 0.0
        if not used.any():
            continue
        label = f"{what} {i + 1}" if nis.shape[1] > 1 else what
        values, times = nis[used, i], t[used]
        count = min(RUNNING, len(values))
        mean = np.convolve(values, np.full(count, 1.0 / count), "valid") / degrees
        low, high = (chi_square(count * degrees, p) / (count * degrees) for p in (0.5 - LIKELY / 2, 0.5 + LIKELY / 2))
        running = Series(f"running mean of {count}", times[count - 1 :], mean)
        limits = [(low, ""), (high, f"{100 * LIKELY:g} % band of the mean")]
        single = Series("each", times, values / degrees, kind="dots", faint=True)
        title = f"NIS of {label} over its degrees of freedom, {degrees}"
        said = _sentence(label, values, degrees, mean, low, high)
        charts.append(Chart(title, "NIS [1]", [single, running], said, log=True, limits=limits))
    return charts


def _sentence(label: str, values: np.ndarray, degrees: int, mean: np.ndarray, low: float, high: float) -> str:
    total = len(values) * degrees
    band = [chi_square(total, p) / total for p in (0.5 - LIKELY / 2, 0.5 + LIKELY / 2)]
    within = np.mean(values <= chi_square(degrees, LIKELY))
    return (
        f"{label}: mean {values.mean() / degrees:.3g} of {len(values)} measurements (a filter that fits has 1, within "
        f"{band[0]:.3g} to {band[1]:.3g}); {100 * within:.3g} % of them below what {100 * LIKELY:g} % should be; "
        f"the running mean is within its band {100 * np.mean((mean >= low) & (mean <= high)):.3g} % of the time."
    )


def _degrees(signals: Signals, name: str, what: str, columns: int) -> int:
    """Numbers of a measurement: by the innovation beside it."""
    if not signals.has(name, f"innovation.{what}"):
        return 1
    return max(1, signals.channels[name].port(f"innovation.{what}")[0].size // columns)


def _errors(signals: Signals, name: str) -> list[Chart]:
    """Of the estimated position and heading from the vessel's own slow motion, beside what the estimator says."""
    vessel = _vessel(signals, name)
    told = signals.has(name, "estimate.position", "estimate.heading")
    if not told or not signals.has(vessel, "low.position", "low.heading"):
        return []
    t, heading = signals.t(name), signals.rows(vessel, "low.heading")[:, 0]
    seen = np.isfinite(heading)
    if not seen.any():
        return []
    true = _at(t, signals.t(vessel), signals.rows(vessel, "low.position"))
    error = signals.rows(name, "estimate.position") - true
    turn = np.interp(t, signals.t(vessel)[seen], np.unwrap(heading[seen]))
    turned = signals.rows(name, "estimate.heading")[:, 0] - turn
    turned = (turned + np.pi) % (2.0 * np.pi) - np.pi
    place = [Series(axis, t, error[:, i]) for i, axis in enumerate(("north", "east"))]
    angle = [Series("heading", t, np.degrees(turned))]
    if signals.has(name, "deviation.position", "deviation.heading"):
        sigma = 2.0 * np.linalg.norm(signals.rows(name, "deviation.position"), axis=1) / np.sqrt(2.0)
        place += [Series(f"{sign}2σ as estimated", t, side * sigma, faint=True) for sign, side in (("+", 1), ("−", -1))]
        sigma = 2.0 * np.degrees(signals.port(name, "deviation.heading"))
        angle += [Series(f"{sign}2σ as estimated", t, side * sigma, faint=True) for sign, side in (("+", 1), ("−", -1))]
    return [
        Chart(f"Error of the estimated position of {vessel}", "error [m]", place),
        Chart(f"Error of the estimated heading of {vessel}", "error [°]", angle),
    ]


def _vessel(signals: Signals, observer: str) -> str:
    """The vessel whose compass the observer hears."""
    return signals.entries.source(signals.entries.source(observer, "compass")[0], "vessel")[0]


def _at(t: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (k, n) at other times, linear between."""
    return np.stack([np.interp(t, times, values[:, i]) for i in range(values.shape[1])], axis=1)
