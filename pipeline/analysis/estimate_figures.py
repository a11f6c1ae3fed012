"""Figures of an estimated line over time, like figures 12 to 18 of Trigo et al. 2014, as SVG to stand in a page."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from scipy.stats import chi2

from pipeline.analysis.estimates import Estimate
from pipeline.analysis.figures import DOUBTFUL, FAILING, STYLE, USED, Window, stacked, svg
from pipeline.analysis.report import Picture

BARS = ("#12608a", "#3a9a5b", "#c58b1a", "#8a4fa0", "#5b6770")  # colours of bars, from the pivot on, again and again
BAND = 0.95
CAPTION = (
    "Estimated (full) and simulated (dashed) angles of the bars from north towards down, blue at the pivot; rates; "
    "moments at the joints; tension at the end with two standard deviations, simulated in red; normalised innovation "
    "squared over its degrees of freedom, and the 95 % band of chi-square."
)


@rc_context(STYLE)
def estimate_picture(estimate: Estimate, name: str) -> Picture:
    """One figure of five panels; name: of this figure among those of the page."""
    t = estimate.t
    figure, (angle, rate, moment, tension, nis) = stacked((1.6, 1.1, 1.1, 1.4, 1.1), Window(float(t[0]), float(t[-1])))
    for i in range(estimate.angle.shape[1]):
        color = BARS[i % len(BARS)]
        angle.plot(t, np.degrees(estimate.angle[:, i]), color=color)
        if estimate.true_angle is not None:
            angle.plot(t, np.degrees(estimate.true_angle[:, i]), color=color, linestyle="--", linewidth=0.6)
        rate.plot(t, estimate.rate[:, i], color=color, linewidth=0.6)
        moment.plot(t, 1e3 * estimate.moment[:, i], color=color, linewidth=0.6)
    angle.set_ylabel("angle\nθ [°]")
    rate.set_ylabel("rate\nω [rad/s]")
    moment.set_ylabel("moment\n[mN m]")
    _tension(estimate, tension)
    _nis(estimate, nis)
    return Picture(svg(figure, f"estimate-{name}", f"angles, moments, tension and NIS of {estimate.name}"), CAPTION)


def _tension(estimate: Estimate, panel: Axes) -> None:
    t, twice = estimate.t, 2.0 * estimate.deviation
    panel.fill_between(t, estimate.tension - twice, estimate.tension + twice, color=DOUBTFUL, alpha=0.6, linewidth=0)
    panel.plot(t, estimate.tension, color=USED)
    seen = [estimate.tension]
    if estimate.true_tension is not None:
        panel.plot(t, estimate.true_tension, color=FAILING, linewidth=0.7)
        seen.append(estimate.true_tension)
    # A deviation that nothing bounds is not to flatten the rest.
    low, high = np.percentile(np.concatenate(seen), [0.5, 99.5])
    panel.set_ylim(low - 0.5 * (high - low), high + 0.5 * (high - low))
    panel.set_ylabel("tension\nT [N]")


def _nis(estimate: Estimate, panel: Axes) -> None:
    some = estimate.freedom > 0
    freedom = np.where(some, estimate.freedom, np.nan)
    panel.plot(estimate.t, estimate.nis / freedom, ".", color=USED, markersize=1.5)
    for edge in (0.5 * (1.0 - BAND), 0.5 * (1.0 + BAND)):
        panel.plot(estimate.t, chi2.ppf(edge, freedom) / freedom, color=FAILING, linestyle="--", linewidth=0.8)
    panel.set_yscale("log")
    panel.set_ylim(0.05, 20.0)
    panel.set_ylabel("NIS over\nfreedom [1]")
