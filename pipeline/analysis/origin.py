"""Where a channel of markers comes from, by the scenario in the log: the line behind it, its length, its ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.markers import lines
from pipeline.analysis.scenario_entries import Entries
from pipeline.log.reader import Log


@dataclass(frozen=True)
class Origin:
    """scenario: its name. line: the channel with the line's nodes; "" where the log does not tell.

    length: of the line, unstretched [m]. arc: (m,) the markers' places along it from its end a [m].
    motion: channel and bundle of what moves end b, such as ("hand", "motion"). noise: of a marker, each axis [m].
    """

    scenario: str = ""
    line: str = ""
    length: float | None = None
    arc: np.ndarray | None = None
    motion: tuple[str, str] | None = None
    noise: float | None = None


def origin(found: Entries | None, channel: str) -> Origin:
    """What the log's scenario says of the channel; as little as nothing where it holds none."""
    if found is None:
        return Origin()
    line = channel if found.wire(channel, "nodes") is None else found.source(channel, "nodes")[0]
    end = found.source(line, "end_b")
    return Origin(
        scenario=found.name,
        line=line,
        length=found.metres(line, "length"),
        arc=_arc(found, channel),
        motion=end if end[0] else None,
        noise=found.metres(channel, "noise") or None,
    )


def lines_without_markers(log: Log, tracked: list[str]) -> list[str]:
    """Channels with a line's nodes whose markers nothing tracks; tracked: the lines behind the channels judged."""
    if "" in tracked:
        return []  # the log does not tell which line a channel is of
    return [name for name in lines(log) if name not in tracked]


def _arc(found: Entries, channel: str) -> np.ndarray | None:
    """Places of equally spaced markers, the last one `offset` from end b: the parameters of markers.tracker."""
    length, spacing, offset = (found.metres(channel, name) for name in ("length", "spacing", "offset"))
    count = found.given(channel, "markers")
    if length is None or spacing is None or offset is None or not isinstance(count, int):
        return None
    return length - offset - spacing * np.arange(count - 1, -1, -1)
