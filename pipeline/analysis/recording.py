"""The cables of a file: markers from a log of Towline, a CSV, or an MCAP file of another tool."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader

from pipeline.analysis.ends import Ends, ends_of_log, ends_of_markers
from pipeline.analysis.foreign import from_mcap
from pipeline.analysis.line_order import in_line_order
from pipeline.analysis.marker_csv import from_csv
from pipeline.analysis.markers import MarkerFrames, from_log, marker_channels
from pipeline.analysis.origin import Origin, lines_without_markers, origin
from pipeline.analysis.reading import Reading
from pipeline.errors import LogError
from pipeline.log.conventions import PROFILE
from pipeline.log.reader import Log, open_log

CSV, MCAP, LOG = "csv", "mcap", "log"
TABLES = (".csv", ".tsv", ".txt")


EVERYTHING = Reading()


@dataclass(frozen=True)
class Recording:
    """The markers of one cable, and what the file says of them."""

    path: Path
    name: str
    frames: MarkerFrames
    origin: Origin
    is_log: bool = False

    def with_noise(self, noise: float | None) -> Recording:
        """The same with the markers' noise as given [m]; None: as it is."""
        return self if noise is None else replace(self, origin=replace(self.origin, noise=noise))

    def ends(self) -> Ends:
        """Motion of the moving end, distance of the ends."""
        if not self.is_log:
            return ends_of_markers(self.frames)
        with open_log(self.path) as log:
            return ends_of_log(log, self.origin, self.frames)


def recordings(path: Path, reading: Reading = EVERYTHING) -> list[Recording]:
    """All cables of the file, or the one asked for.

    Raises LogError if the file cannot be read or has no markers.
    """
    kind = _kind(path)
    if kind == LOG:
        with open_log(path) as log:
            found = _of_log(log, path, reading.channel)
    else:
        parts = from_csv(path, reading) if kind == CSV else from_mcap(path, reading)
        found = [Recording(path, name, in_line_order(frames), Origin()) for name, frames in parts.items()]
    if not found:
        raise LogError(f"{path} has no markers: no channel with positions of shape (m, 3) in its messages")
    return found


def _kind(path: Path) -> str:
    """CSV, MCAP of another tool, or LOG; what is none of them is left to open_log to complain of."""
    if path.suffix.lower() in TABLES:
        return CSV
    try:
        with open(path, "rb") as file:
            return LOG if make_reader(file).get_header().profile == PROFILE else MCAP
    except (OSError, McapError):
        return LOG


def _of_log(log: Log, path: Path, channel: str | None) -> list[Recording]:
    """The channels of a log that have markers; lines beside them that have none are named in a note."""
    names = [channel] if channel else marker_channels(log)
    origins = {name: origin(log, name) for name in names}
    parts = {name: from_log(log, name, origins[name].arc) for name in names}
    bare = [] if channel else lines_without_markers(log, [where.line for where in origins.values()])
    if bare and names:
        note = f"no markers on {', '.join(bare)}: left out; --channel {bare[0]} judges the line by its nodes"
        parts[names[0]] = replace(parts[names[0]], notes=(*parts[names[0]].notes, note))
    return [Recording(path, name, parts[name], origins[name], is_log=True) for name in names]
