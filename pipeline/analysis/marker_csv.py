"""Markers from a CSV file, of Towline's own export or of another tool."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.analysis.marker_columns import Columns, understand
from pipeline.analysis.markers import MarkerFrames, marker_frames
from pipeline.analysis.vertical import Up, in_ned
from pipeline.errors import LogError

SEPARATORS = ";\t,"


def from_csv(path: Path, up: Up | None = None) -> MarkerFrames:
    """A frame a row, a marker three columns; empty cells are markers not seen. up: as vertical.in_ned takes it.

    Raises LogError if the file cannot be read, or its columns cannot be understood, by name.
    """
    import pandas  # takes half a second to import

    try:
        with open(path, encoding="utf-8-sig") as file:
            header = file.readline()
        separator = max(SEPARATORS, key=header.count)
        table = pandas.read_csv(path, sep=separator, encoding="utf-8-sig", skipinitialspace=True)
        columns = understand([str(name) for name in table.columns])
        return _frames(columns, table.apply(pandas.to_numeric, errors="coerce").to_numpy(np.float64), path, up)
    except OSError as error:
        raise LogError(f"{path}: cannot read the file: {error.strerror or error}") from error
    except (ValueError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: {str(error).splitlines()[0]}") from error


def _frames(columns: Columns, numbers: np.ndarray, path: Path, up: Up | None) -> MarkerFrames:
    """numbers: (k, columns)."""
    assert columns.time is not None
    index, scale = columns.time
    known = np.isfinite(numbers[:, index])
    rows = numbers[known]
    position = np.empty((len(rows), len(columns.numbers), 3))
    valid = np.ones(position.shape[:2], bool)
    for i, number in enumerate(columns.numbers):
        for axis in range(3):
            column, metres = columns.place[number, axis]
            position[:, i, axis] = rows[:, column] * metres
        if number in columns.flag:
            valid[:, i] = rows[:, columns.flag[number]] > 0.5
    frames = marker_frames(np.rint(rows[:, index] * scale).astype(np.int64), position, valid, source=str(path))
    notes = [f"{int((~known).sum())} rows without a time were left out"] if not known.all() else []
    notes += ["lengths without a unit in their header: taken as metres"] if columns.bare else []
    frames = replace(frames, notes=(*frames.notes, *notes))
    return frames if columns.is_ned and up is None else in_ned(frames, up)
