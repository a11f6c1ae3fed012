"""Tables with a row for each marker and time, put into frames."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from pipeline.analysis.marker_columns import Columns
from pipeline.analysis.marker_text import Table
from pipeline.analysis.markers import MarkerFrames, marker_frames
from pipeline.errors import LogError
from pipeline.quantities import shown

_NUMBERED = re.compile(r"(?P<prefix>.*?)[ ._:#-]*(?P<number>\d+)")
MOST_CELLS = 50_000_000  # frames times markers: a table whose labels are something else would take all memory


def by_frames(table: Table, columns: Columns, t_ns: np.ndarray) -> dict[str, MarkerFrames]:
    """Markers by cable: labels such as `chain_3` are marker 3 of the cable chain.

    t_ns: (k,) of the rows. Rows may stand in any order; of two for one marker and time the first is kept. Raises
    LogError where a label does not tell the marker's place in the order of the line.
    """
    assert columns.label is not None
    cable = columns.cables[""]
    position = np.stack([table.numbers(cable.place[0, a].column) * cable.place[0, a].metres for a in range(3)], axis=1)
    seen = table.numbers(cable.flag[0]) > 0.5 if 0 in cable.flag else np.ones(len(t_ns), bool)
    seen &= ~np.isnan(position).all(axis=1)
    prefixes, numbers = _labels(table, columns.label)
    names = list(dict.fromkeys(prefixes))
    return {
        name if name and len(names) > 1 else table.path.stem: _frames(
            table, t_ns[mine], numbers[mine], position[mine], seen[mine], name
        )
        for name in names
        for mine in [prefixes == name]
    }


def _labels(table: Table, column: int) -> tuple[np.ndarray, np.ndarray]:
    """Prefix and number of each row's marker."""
    cells = table.cells[column]
    empty = table.empty(column)
    if empty.any():
        raise LogError(f"{table.place(int(empty.argmax()), column)}: empty; expected which marker the row is of")
    labels, which = np.unique(cells.astype(str), return_inverse=True)
    prefixes, numbers = np.empty(len(labels), object), np.empty(len(labels), np.int64)
    for i, label in enumerate(labels):
        text = label.strip().removesuffix(".0")
        found = _NUMBERED.fullmatch(text)
        if found is None or len(found["number"]) > 9:
            row = int((which == i).argmax())
            raise LogError(
                f"{table.place(row, column)}: {shown(label)} does not end with the marker's number on the line; "
                "expected labels such as 1, 2, 3 or chain_1, chain_2"
            )
        prefixes[i], numbers[i] = found["prefix"], int(found["number"])
    return prefixes[which], numbers[which]


def _frames(
    table: Table, t_ns: np.ndarray, number: np.ndarray, position: np.ndarray, seen: np.ndarray, name: str
) -> MarkerFrames:
    """One cable's rows: t_ns, number, seen (k,); position (k, 3)."""
    times, frame = np.unique(t_ns, return_inverse=True)
    numbers, marker = np.unique(number, return_inverse=True)
    if len(numbers) > 3 and len(t_ns) < 1.5 * len(times):
        raise LogError(
            f"{table.path}: {len(t_ns)} rows of {len(numbers)} markers have {len(times)} different times; the rows of "
            "one frame must have the same time"
        )
    if len(times) * len(numbers) > MOST_CELLS:
        raise LogError(
            f"{table.path}: {len(numbers)} markers at {len(times)} times; the labels are no markers' numbers"
        )
    _, first = np.unique(frame * len(numbers) + marker, return_index=True)
    x, valid = np.zeros((len(times), len(numbers), 3)), np.zeros((len(times), len(numbers)), bool)
    x[frame[first], marker[first]], valid[frame[first], marker[first]] = position[first], seen[first]
    frames = marker_frames(times, x, valid, source=f"{table.path}{f': {name}' if name else ''}")
    twice = len(t_ns) - len(first)
    if not twice:
        return frames
    if twice > len(first):
        raise LogError(
            f"{table.path}: {twice} of {len(t_ns)} rows repeat a marker and time; give --time-unit, or labels"
        )
    note = f"{twice} rows repeated a marker at the same time: the first of each was kept"
    return replace(frames, notes=(*frames.notes, note))
