"""Error against speed of a benchmark's rows: a point a row, a panel a unit of error, the better the further down right.

Rows of one case are joined; only they, and methods on one case, are to be compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

Row = Mapping[str, Any]
# Columns that tell how fast a row's method is, or how fine: the first that two rows have; and their names on the axis.
SPEEDS = {
    "real_time_factor": "times real time",
    "component_steps_per_s": "component steps/s",
    "frames_per_s": "frames/s",
    "images/s": "images/s",
    "us": "time of one [µs]",
    "step": "step [s]",
}
TIMES = ("us", "step")  # the less the better: their axis is turned
LEAST = 4  # points; fewer are read better in the table
MOST_SERIES = 9
PANEL = 4.2  # inches
COLOURS = ("#12608a", "#d1495b", "#e0912f", "#3c8d53", "#7b5ea7", "#5b6770", "#a0693c", "#c56fa5", "#2f9fa8")
MARKERS = "osD^vPX<>"
STYLE: Any = {"font.size": 9, "axes.grid": True, "grid.color": "#dddddd", "svg.hashsalt": "towline"}


def draw(rows: Sequence[Row], out: Path) -> bool:
    """Write the figure as SVG; False, and nothing is written, where fewer than four rows have both. Raises OSError."""
    speed = _speed(rows)
    points = [row for row in rows if speed and _is_above_zero(row.get(speed)) and _is_above_zero(row.get("error"))]
    if len(points) < LEAST or not speed:
        return False
    counts = Counter(str(row.get("error_unit", "")) for row in points)
    units = [unit for unit, count in counts.items() if count > 1] or list(counts)[:1]
    by = _names_of_series(points)
    names = list(dict.fromkeys(str(row.get(by, "")) for row in points))
    with rc_context(STYLE):
        figure = Figure(figsize=(PANEL * len(units) + 1.5, PANEL), layout="constrained")
        for axes, unit in zip(figure.subplots(1, len(units), squeeze=False)[0], units, strict=True):
            for i, series in enumerate(names):
                these = [
                    row for row in points if (str(row.get("error_unit", "")), str(row.get(by, ""))) == (unit, series)
                ]
                _dots(axes, these, speed, series, i)
            _finish(axes, speed, unit)
        handles = {str(line.get_label()): line for axes in figure.axes for line in axes.get_lines()}
        figure.legend(handles.values(), handles.keys(), loc="outside right upper", frameon=False, fontsize=8)
        figure.savefig(out, metadata={"Date": None})  # the same rows give the same file
    return True


def _is_above_zero(value: Any) -> bool:
    return isinstance(value, (int, float)) and 0.0 < value < float("inf")


def _speed(rows: Sequence[Row]) -> str:
    """The column that tells the speed, empty where there is none."""
    found = (key for key in SPEEDS if sum(_is_above_zero(row.get(key)) for row in rows) >= LEAST)
    return next(found, "")


def _names_of_series(points: Sequence[Row]) -> str:
    """The column whose values are told apart by colour: the method, or the case where all rows have one method."""
    counts = {column: len({row.get(column) for row in points}) for column in ("method", "case")}
    return next((column for column, n in counts.items() if 1 < n <= MOST_SERIES), "method")


def _dots(axes: Axes, rows: Sequence[Row], speed: str, label: str, i: int) -> None:
    """The rows of a series; those of one case are joined."""
    colour, marker = COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]
    for case in dict.fromkeys(row.get("case") for row in rows):
        points = sorted((row[speed], row["error"]) for row in rows if row.get("case") == case)
        axes.plot(
            *zip(*points, strict=True), marker + "-", color=colour, label=label, markersize=5, linewidth=0.6, alpha=0.8
        )


def _finish(axes: Axes, speed: str, unit: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    if speed in TIMES:
        axes.invert_xaxis()
    axes.set_xlabel(SPEEDS[speed])
    axes.set_ylabel(f"error [{unit}]" if len(unit) < 12 else f"error: {unit.partition(';')[0]}", wrap=True)
