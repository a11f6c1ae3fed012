"""Figures of a cable's validity over time, like figures 4 to 7 of Drupt et al. 2022, as SVG to stand in a page."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from pipeline.analysis.ends import Ends
from pipeline.analysis.statistics import LEAST_MARKERS, reliable
from pipeline.analysis.validity import Cable

WIDTH, PANEL = 4.2, 1.35  # inches: on a phone the text is then a little smaller than the page's
# Margins about the panels [inches], and where the titles stand, in widths of a panel: laid out by hand, since a solver
# takes half of the report's time and gives other last bits each time.
LEFT, RIGHT, ABOVE, BELOW, BETWEEN, TITLES = 0.72, 0.1, 0.1, 0.42, 0.46, -0.13
ALONE = 0.5  # s shown on either side of a record of one frame
# Of the panels; both figures are of one height, since a wide screen shows them side by side.
INDICATOR, CIRCUMSTANCES = 1.375, (1.0, 1.5, 1.0, 1.0, 1.0)
SPANS = 700  # of a curve, each drawn by its extremes: more than the figure has pixels
USED, DOUBTFUL, FAILING = "#12608a", "#b9b9b9", "#d1495b"
STYLE: Any = {
    "font.size": 8.5,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 0.9,
    "svg.fonttype": "none",  # text stays text: small, and found by search
    "svg.hashsalt": "towline",  # the same figure gives the same bytes
}
EXTREMES = ((np.argmin, np.inf), (np.argmax, -np.inf))
NO_METADATA = {"Creator": None, "Date": None, "Format": None, "Type": None}


@dataclass(frozen=True)
class Window:
    """The part of a record that is drawn [s]."""

    start: float
    end: float

    def of(self, t: np.ndarray) -> np.ndarray:
        """(k,) bool: the times inside."""
        return (t >= self.start) & (t <= self.end)


def thinned(t: np.ndarray, values: np.ndarray, spans: int = SPANS) -> tuple[np.ndarray, np.ndarray]:
    """The least and the greatest value of each of many spans of equal length, in order of time; NaN where all are.

    t, values: (k,). Curves of at most 4 points a span are returned as they are.
    """
    count = len(t) // spans
    if count < 4:
        return t, values
    edge = count * (len(t) // count)
    parts = values[:edge].reshape(-1, count)
    least, greatest = (pick(np.where(np.isnan(parts), fill, parts), axis=1) for pick, fill in EXTREMES)
    index = np.sort(np.stack([least, greatest], axis=1), axis=1) + count * np.arange(len(parts))[:, None]
    kept = np.concatenate([index.ravel(), np.arange(edge, len(t))])
    return t[kept], values[kept]


@rc_context(STYLE)
def indicators(cable: Cable, window: Window, name: str) -> str:
    """alpha, e_P, e_C and C over time, figures 4 and 6: SVG. Grey where too few markers are visible.

    name: of this figure among those of the page.
    """
    fits = cable.fits
    t = fits.t_ns / 1e9
    inside = window.of(t)
    good = reliable(fits)[inside]
    curves = (
        ("inclination\nα [°]", np.degrees(fits.alpha), "linear"),
        ("off the plane\ne_P [mm]", 1e3 * fits.e_plane, "log"),
        ("off the catenary\ne_C [mm]", 1e3 * fits.e_catenary, "log"),
        ("catenary\nC [1/m]", fits.C, "linear"),
    )
    figure, panels = stacked((INDICATOR,) * len(curves), window)
    for panel, (title, values, scale) in zip(panels, curves, strict=True):
        shown = values[inside]
        for color, which in ((DOUBTFUL, ~good), (USED, good)):
            panel.plot(*thinned(t[inside], np.where(which, shown, np.nan)), color=color)
        if scale == "log":
            _logarithmic(panel)
        panel.set_ylabel(title)
    panels[2].axhline(1e3 * cable.tolerance, color=FAILING, linewidth=0.8, linestyle="--")
    for span in cable.spans:
        panels[2].axvspan(span.start_ns / 1e9, span.end_ns / 1e9, color=FAILING, alpha=0.25, linewidth=0.6)
    return svg(figure, f"indicators-{name}", "inclination, distances from plane and catenary, and C over time")


@rc_context(STYLE)
def circumstances(cable: Cable, ends: Ends, window: Window, name: str) -> str:
    """Number and visibility of the markers, speed and acceleration of the moving end, distance of the ends: SVG.

    name: of this figure among those of the page.
    """
    figure, panels = stacked(CIRCUMSTANCES, window)
    _markers(cable, panels[0], panels[1], window)
    for panel, title, t, values in (
        (panels[2], "moving end\nspeed [m/s]", ends.t, ends.speed),
        (panels[3], "moving end\naccel. [m/s²]", ends.t, ends.acceleration),
        (panels[4], "ends apart\nd [m]", ends.t_distance, ends.distance),
    ):
        inside = window.of(t)
        panel.plot(*thinned(t[inside], values[inside]), color=USED)
        panel.set_ylabel(title)
    return svg(figure, f"circumstances-{name}", "visible markers and the ends' motion over time")


def _markers(cable: Cable, number: Axes, visibility: Axes, window: Window) -> None:
    """N over time, and a bar for each time that a marker was visible."""
    frames = cable.recording.frames
    t = frames.t_ns / 1e9
    inside = window.of(t)
    t, valid = t[inside], frames.valid[inside]
    number.plot(*thinned(t, valid.sum(axis=1).astype(float)), color=USED, drawstyle="steps-post")
    number.axhline(LEAST_MARKERS - 0.5, color=FAILING, linewidth=0.8, linestyle="--")
    number.set_ylim(0, frames.markers + 0.5)
    number.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    number.set_ylabel("visible\nmarkers N [1]")
    for i in range(frames.markers):
        visibility.plot(*_bars(t, valid[:, i], i + 1), color=USED, linewidth=3.0, solid_capstyle="butt")
    visibility.set_ylim(0.3, frames.markers + 0.7)
    visibility.set_yticks(range(1, frames.markers + 1, max(1, frames.markers // 6)))
    visibility.set_ylabel("visible marker\nindex [1]")


def _logarithmic(panel: Axes) -> None:
    """A logarithmic axis with plain numbers: 0.1, 1, 10."""
    panel.set_yscale("log")
    panel.yaxis.set_major_locator(LogLocator(numticks=5))
    panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    panel.yaxis.set_minor_formatter(NullFormatter())


def _bars(t: np.ndarray, valid: np.ndarray, height: int) -> tuple[np.ndarray, np.ndarray]:
    """A line broken where the marker is lost: start, end and a gap for each visible time."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], valid, [False]]).astype(np.int8)))
    starts, ends = t[edges[::2]], t[np.minimum(edges[1::2], len(t) - 1)]
    x = np.stack([starts, ends, np.full(len(starts), np.nan)], axis=1).ravel()
    return x, np.full(len(x), float(height))


def stacked(heights: tuple[float, ...], window: Window) -> tuple[Figure, list[Axes]]:
    """Panels one above the other over the same time."""
    beside = ALONE if window.start == window.end else 0.0
    height = PANEL * sum(heights)
    figure = Figure((WIDTH, height))
    figure.subplots_adjust(LEFT / WIDTH, BELOW / height, 1.0 - RIGHT / WIDTH, 1.0 - ABOVE / height)
    usual = (height - BELOW - ABOVE - BETWEEN * (len(heights) - 1)) / len(heights)  # of a panel
    panels = list(
        figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, gridspec_kw={"hspace": BETWEEN / usual})
    )
    for panel in panels:
        panel.set_xlabel("time [s]")
        panel.set_xlim(window.start - beside, window.end + beside)
        panel.tick_params(labelbottom=True)
        panel.yaxis.set_label_coords(TITLES, 0.5)
    return figure, panels


def svg(figure: Figure, name: str, title: str) -> str:
    """The figure as an SVG element to stand among others: with a title, its identifiers made its own by a name."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata=NO_METADATA)
    text = buffer.getvalue()
    text = re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{name}-", text[text.index("<svg") :])
    return re.sub(r'<svg[^>]*?(viewBox="[^"]*")[^>]*>', rf'<svg \1 role="img"><title>{title}</title>', text, count=1)
