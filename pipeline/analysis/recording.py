"""The cables of a file: markers from a log of Towline, a CSV, or an MCAP file of another tool."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from pipeline.analysis.ends import Ends, ends_of_log, ends_of_markers
from pipeline.analysis.fmu_entries import with_fmus
from pipeline.analysis.foreign import DAMAGED, from_mcap
from pipeline.analysis.line_order import in_line_order
from pipeline.analysis.line_properties import Properties, properties
from pipeline.analysis.line_record import LineRecord, has, line_record, stride
from pipeline.analysis.marker_csv import from_csv
from pipeline.analysis.markers import MarkerFrames, from_log, lines, marker_channels
from pipeline.analysis.origin import Origin, lines_without_markers, origin
from pipeline.analysis.reading import Reading
from pipeline.analysis.scenario_entries import entries
from pipeline.errors import LogError
from pipeline.log.conventions import PROFILE
from pipeline.log.reader import ChannelInfo, Log, open_log

CSV, MCAP, LOG = "csv", "mcap", "log"
TABLES = (".csv", ".tsv", ".txt")


EVERYTHING = Reading()


@dataclass(frozen=True)
class Recording:
    """The markers of one cable, and what the file says of them.

    line: what the log recorded of the line behind them, and what it is made of; None where it does not tell.
    """

    path: Path
    name: str
    frames: MarkerFrames
    origin: Origin
    is_log: bool = False
    line: tuple[LineRecord, Properties] | None = None

    def with_noise(self, noise: float | None) -> Recording:
        """The same with the markers' noise as given [m]; None: as it is."""
        return self if noise is None else replace(self, origin=replace(self.origin, noise=noise))

    def ends(self) -> Ends:
        """Motion of the moving end, distance of the ends."""
        if not self.is_log:
            return ends_of_markers(self.frames)
        with open_log(self.path) as log:
            return ends_of_log(log, self.origin, self.frames)


def recordings(path: Path, reading: Reading = EVERYTHING, needed: bool = True) -> list[Recording]:
    """All cables of the file, or the one asked for; needed: whether a log must have one.

    Raises LogError if the file cannot be read, or has no markers and needs them.
    """
    kind = _kind(path)
    if kind == LOG:
        with open_log(path) as log:
            found = _of_log(log, path, reading.channel)
    else:
        parts = from_csv(path, reading) if kind == CSV else from_mcap(path, reading)
        found = [Recording(path, name, in_line_order(frames), Origin()) for name, frames in parts.items()]
    if not found and (needed or kind != LOG):
        raise LogError(
            f"{path} has no markers and no line: no channel with positions or nodes of shape (m, 3) in its messages"
        )
    return found


def is_log(path: Path) -> bool:
    """Whether the file is a log of Towline."""
    return _kind(path) == LOG


def _kind(path: Path) -> str:
    """CSV, MCAP of another tool, or LOG; what is none of them is left to open_log to complain of."""
    if path.suffix.lower() in TABLES:
        return CSV
    try:
        with open(path, "rb") as file:
            return LOG if make_reader(file).get_header().profile == PROFILE else MCAP
    except (OSError, *DAMAGED):
        return LOG


def _of_log(log: Log, path: Path, channel: str | None) -> list[Recording]:
    """The channels of a log that have markers, and the lines that none track, by their nodes; all read in one pass."""
    found = entries(log)
    found = with_fmus(log, found, lines(log)) if found else None
    names = [channel] if channel else marker_channels(log)
    if not channel:
        names += [name for name in lines_without_markers(log, [origin(found, one).line for one in names])]
    origins = {name: origin(found, name) for name in names}
    made = {where.line: properties(found, where.line) for where in origins.values() if found and where.line}
    made = {line: known for line, known in made.items() if known and line in lines(log)}
    currents = {known.water.recorded[0] for known in made.values()} & set(log.channels)
    read = log.read([name for name in log.channels if name in {*names, *made, *currents}])
    records = {name: line_record(log, name, read, known.water.recorded) for name, known in made.items()}
    recordings = []
    for name, where in origins.items():
        info, notes = log.channel(name), ()
        rows = read[name]
        if not info.count:
            notes = ("it has no message",)
        if not has(info, "valid") and (every := stride(len(rows[0]))) > 1:
            notes = (f"1 message in {every} of {len(rows[0])} is judged",)
            rows = rows[0][::every], rows[1][::every]
        frames = from_log(log, name, _fitting(where.arc, info), rows)
        frames = replace(frames, notes=(*frames.notes, *notes))
        line = (records[where.line], made[where.line]) if where.line in made else None
        recordings.append(Recording(path, name, frames, where, True, line))
    return recordings


def _fitting(arc: np.ndarray | None, info: ChannelInfo) -> np.ndarray | None:
    """The markers' places by the scenario, where they are places of this channel's markers."""
    shapes = [port.shape for port in info.ports if port.name == "position"]
    return arc if arc is not None and shapes == [(len(arc), 3)] and (np.diff(arc) > 0.0).all() else None
