"""A log as a recording for Rerun: lines and bodies in space, curves beside them, and the layout of the windows."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.errors import TowlineError
from pipeline.log.reader import Log
from pipeline.viewing.drawn import Drawn, drawn, shown_unit

TIMELINE = "time"
ABSENT = 'Rerun is not installed; pip install -e ".[view]" in the folder of Towline'
LINE, BODY, TRACK = (255, 153, 25), (51, 153, 255), (130, 140, 150)  # colours
PLOTS = 6  # of a component, in the layout; the others are in the list of entities


def rerun_module(name: str = "rerun") -> Any:
    """Rerun's Python package, or a module in it. Raises TowlineError where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise TowlineError(ABSENT) from error


def write_recording(log: Log, title: str, path: Path) -> float:
    """Write the recording (.rrd); gives the time of its end [s]. Raises TowlineError."""
    rr = rerun_module()
    recording = rr.RecordingStream("towline", recording_id=title)
    try:
        recording.save(str(path))
    except Exception as error:  # Rerun's are of many kinds
        raise TowlineError(f"{path}: cannot be written: {error}") from error
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    views, end_s = {}, 0.0
    # Lines first, then bodies: their plots are the first tabs.
    for one in sorted(drawn(log), key=lambda one: (not [*one.lines()], not [*one.bodies()])):
        end_s = max(end_s, one.t_ns[-1] / 1e9)
        _draw(rr, recording, one)
        if plots := _plot(rr, recording, one):
            views[one.channel.name] = plots
    recording.send_blueprint(_layout(views))
    recording.flush()
    recording.disconnect()
    return end_s


def _draw(rr: Any, recording: Any, one: Drawn) -> None:
    """The component's lines and bodies over time, and the bodies' tracks."""
    name, when = one.channel.name, _when(rr, one)
    for port, places in one.lines():
        path = f"world/{name}/{port.name}"
        recording.log(path, rr.LineStrips3D.from_fields(colors=[LINE], radii=[rr.Radius.ui_points(1.5)]), static=True)
        recording.send_columns(path, [when], rr.LineStrips3D.columns(strips=places.astype(np.float32)))
    for port, places in one.bodies():
        path = f"world/{name}" if port.name == "position" else f"world/{name}/{port.name}"
        style = rr.Points3D.from_fields(colors=[BODY], radii=[rr.Radius.ui_points(6.0)], labels=[name])
        recording.log(path, style, static=True)
        recording.send_columns(path, [when], rr.Points3D.columns(positions=places.astype(np.float32)))
        track = rr.LineStrips3D([places.astype(np.float32)], colors=[TRACK], radii=[rr.Radius.ui_points(0.5)])
        recording.log(f"{path}/track", track, static=True)


def _plot(rr: Any, recording: Any, one: Drawn) -> list[tuple[str, str]]:
    """The component's curves; title and entity of each plot."""
    plots = []
    for port, names, values in one.curves():
        path = f"curves/{one.channel.name}/{port.name}"
        recording.log(path, rr.SeriesLines(names=names), static=True)
        columns = rr.Scalars.columns(scalars=values.ravel())
        if len(names) > 1:
            columns = columns.partition([len(names)] * len(values))
        recording.send_columns(path, [_when(rr, one)], columns)
        unit = shown_unit(port)
        plots.append((f"{port.name} [{unit}]" if unit else port.name, path))
    return plots


def _when(rr: Any, one: Drawn) -> Any:
    return rr.TimeColumn(TIMELINE, duration=one.t_ns.astype("timedelta64[ns]"))


def _layout(views: dict[str, list[tuple[str, str]]]) -> Any:
    """The scene at the left, each component's plots behind a tab at the right."""
    rrb = rerun_module("rerun.blueprint")
    tabs = [
        rrb.Grid(*(rrb.TimeSeriesView(name=title, origin=path) for title, path in plots[:PLOTS]), name=name)
        for name, plots in views.items()
    ]
    scene = rrb.Spatial3DView(name="scene: east, north, up [m]", origin="world", line_grid=True)
    parts = [scene, rrb.Tabs(*tabs)] if tabs else [scene]
    return rrb.Blueprint(rrb.Horizontal(*parts, column_shares=[3, 2][: len(parts)]), collapse_panels=True)
