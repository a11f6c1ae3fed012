"""Markers from a CSV file, of Towline's own export or of another tool: a frame a row, or a marker a row."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.analysis.marker_columns import Cable, Columns, understand
from pipeline.analysis.marker_rows import by_frames
from pipeline.analysis.marker_text import Table, read_table
from pipeline.analysis.marker_time import times_of
from pipeline.analysis.markers import MarkerFrames, marker_frames
from pipeline.analysis.reading import Reading
from pipeline.analysis.vertical import Up, in_ned
from pipeline.analysis.zeros import without_zeros
from pipeline.errors import LogError

LEAST_MARKERS = 4  # of a line: a plane and a catenary in it need as many; fewer columns of places are something else
EXPORTED = ("position", "nodes")  # prefixes as towline export writes them, which name no cable


def from_csv(path: Path, reading: Reading) -> dict[str, MarkerFrames]:
    """Markers by cable, named by the columns' prefix, or by the file where there is one cable only.

    Empty cells are markers not seen. Raises LogError, with the place, if the file cannot be read or understood.
    """
    table = read_table(path)
    try:
        columns = understand(table.names)
    except ValueError as error:
        raise LogError(f"{path}: {error}") from error
    assert columns.time is not None
    t_ns, known, note = times_of(table, *columns.time, reading.time_unit)
    notes = [f"{int((~known).sum())} rows without a time were left out"] if not known.all() else []
    notes += [*table.notes, *([note] if note else [])]
    rows = table.rows(known)
    if not len(rows.lines):
        raise LogError(f"{path}: no row has a time")
    parts = by_frames(rows, columns, t_ns) if columns.label is not None else _by_columns(rows, columns, t_ns)
    parts, more = _wanted(path, parts, reading.channel)
    bare = any("" in cable.units for cable in columns.cables.values())
    notes += [*more, *(["lengths without a unit in their header: taken as metres"] if bare else [])]
    ned = all(cable.is_ned for cable in columns.cables.values())
    return {name: _finished(frames, tuple(notes), ned, reading.up) for name, frames in parts.items()}


def _finished(frames: MarkerFrames, notes: tuple[str, ...], is_ned: bool, up: Up | None) -> MarkerFrames:
    frames = without_zeros(replace(frames, notes=(*frames.notes, *notes)))
    return frames if is_ned and up is None else in_ned(frames, up)


def _by_columns(table: Table, columns: Columns, t_ns: np.ndarray) -> dict[str, MarkerFrames]:
    """Each prefix as a cable. Of equal times only the first is kept: what would lose most frames is refused."""
    different = len(np.unique(t_ns))
    if len(t_ns) > 2 and 2 * different < len(t_ns):
        raise LogError(
            f"{table.path}: {len(t_ns)} frames have {different} different times; write the times with more digits, "
            "or give their unit with --time-unit"
        )
    alone = len(columns.cables) == 1
    return {
        table.path.stem if alone or not prefix or prefix in EXPORTED else prefix: _cable(table, cable, t_ns, prefix)
        for prefix, cable in columns.cables.items()
    }


def _cable(table: Table, cable: Cable, t_ns: np.ndarray, prefix: str) -> MarkerFrames:
    position = np.empty((len(t_ns), len(cable.numbers), 3))
    valid = np.ones(position.shape[:2], bool)
    for i, number in enumerate(cable.numbers):
        for axis in range(3):
            place = cable.place[number, axis]
            position[:, i, axis] = table.numbers(place.column) * place.metres
        if number in cable.flag:
            valid[:, i] = table.numbers(cable.flag[number]) > 0.5
    valid &= ~np.isnan(position).all(axis=2)  # nothing was written: not seen, and nothing to note
    return marker_frames(t_ns, position, valid, source=f"{table.path}{f': {prefix}' if prefix else ''}")


def _wanted(
    path: Path, parts: dict[str, MarkerFrames], channel: str | None
) -> tuple[dict[str, MarkerFrames], list[str]]:
    if channel is not None:
        if channel not in parts:
            raise LogError(f"{path} has no cable {channel}; it has {', '.join(parts)}")
        return {channel: parts[channel]}, []
    lines = {name: frames for name, frames in parts.items() if frames.markers >= LEAST_MARKERS}
    if not lines or len(lines) == len(parts):
        return parts, []
    others = ", ".join(f"{name} ({parts[name].markers})" for name in parts if name not in lines)
    return lines, [
        f"left out, with fewer than {LEAST_MARKERS} markers: {others}; --channel NAME takes one all the same"
    ]
