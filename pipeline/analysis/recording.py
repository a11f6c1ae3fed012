"""The cables of a file: markers from a log of Towline, a CSV, or an MCAP file of another tool."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader

from pipeline.analysis.ends import Ends, ends_of_log, ends_of_markers
from pipeline.analysis.foreign import from_mcap
from pipeline.analysis.marker_csv import from_csv
from pipeline.analysis.markers import MarkerFrames, from_log, marker_channels
from pipeline.analysis.origin import Origin, origin
from pipeline.analysis.vertical import Up
from pipeline.errors import LogError
from pipeline.log.conventions import PROFILE
from pipeline.log.reader import Log, open_log

CSV, MCAP, LOG = "csv", "mcap", "log"
TABLES = (".csv", ".tsv", ".txt")


@dataclass(frozen=True)
class Recording:
    """The markers of one cable, and what the file says of them."""

    path: Path
    name: str
    frames: MarkerFrames
    origin: Origin
    is_log: bool = False

    def ends(self) -> Ends:
        """Motion of the moving end, distance of the ends."""
        if not self.is_log:
            return ends_of_markers(self.frames)
        with open_log(self.path) as log:
            return ends_of_log(log, self.origin, self.frames)


def recordings(path: Path, channel: str | None = None, up: Up | None = None) -> list[Recording]:
    """All cables of the file, or the one of this channel. up: of files that do not say, as vertical.in_ned takes it.

    Raises LogError if the file cannot be read or has no markers.
    """
    kind = _kind(path)
    if kind == CSV:
        return [Recording(path, path.stem, from_csv(path, up), Origin())]
    if kind == MCAP:
        found = [Recording(path, name, frames, Origin()) for name, frames in from_mcap(path, channel, up).items()]
    else:
        with open_log(path) as log:
            names = [channel] if channel else marker_channels(log)
            found = [Recording(path, name, *_of_log(log, name), is_log=True) for name in names]
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


def _of_log(log: Log, channel: str) -> tuple[MarkerFrames, Origin]:
    where = origin(log, channel)
    return from_log(log, channel, where.arc), where
