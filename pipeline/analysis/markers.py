"""Markers on a line as arrays of frames: tidied, and taken from a log of Towline."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pipeline.errors import LogError
from pipeline.log.reader import ChannelInfo, Log

ESTIMATORS = "estimator."  # models of the family that tells of lines which are elsewhere in the scene
DEVIATION = "deviation."  # bundle in which an estimator says how sure it is, a user's own or an FMU too
FARTHEST = 1e12  # m: what is further is no place, such as the largest float that some tools write for a lost marker


@dataclass(frozen=True)
class MarkerFrames:
    """k frames of m markers, in the order of the line and of time.

    t_ns: (k,) int64, strictly increasing [ns]. position: (k, m, 3) NED [m]; zero where not valid.
    valid: (k, m) bool, the marker is visible. arc: (m,) the markers' places along the line [m], if known.
    source: file and channel. notes: what was mended on the way in, one sentence each.
    """

    t_ns: np.ndarray
    position: np.ndarray
    valid: np.ndarray
    arc: np.ndarray | None = None
    source: str = ""
    notes: tuple[str, ...] = field(default=())

    @property
    def markers(self) -> int:
        """Number of markers on the line, visible or not."""
        return self.position.shape[1]


def marker_frames(
    t_ns: np.ndarray,
    position: np.ndarray,
    valid: np.ndarray | None = None,
    arc: np.ndarray | None = None,
    source: str = "",
) -> MarkerFrames:
    """Frames in order of time: unsorted ones are sorted, of equal times the first is kept.

    What is not finite, or beyond FARTHEST, is not visible.

    t_ns: (k,) [ns]. position: (k, m, 3) NED [m]. valid: (k, m), default all. arc: (m,) [m], strictly increasing.
    Raises LogError if the shapes do not fit together, or arc does not increase.
    """
    t_ns, position = np.asarray(t_ns, np.int64), np.array(position, np.float64)
    if position.ndim != 3 or position.shape[2] != 3 or t_ns.shape != position.shape[:1]:
        raise LogError(
            f"{source}: markers need positions of shape (k, m, 3) and k times; "
            f"got positions {position.shape} and times {t_ns.shape}"
        )
    seen = np.ones(position.shape[:2], bool) if valid is None else np.asarray(valid).astype(bool)
    if seen.shape != position.shape[:2]:
        raise LogError(f"{source}: visibility has shape {seen.shape}, the markers {position.shape[:2]}")
    notes = []
    finite = (np.abs(position) <= FARTHEST).all(axis=2)
    if (seen & ~finite).any():
        notes.append(f"{int((seen & ~finite).sum())} positions were not finite: taken as not visible")
    seen = seen & finite
    if (np.diff(t_ns) < 0).any():
        notes.append(f"{int((np.diff(t_ns) < 0).sum())} times went backwards: frames sorted by time")
        order = np.argsort(t_ns, kind="stable")
        t_ns, position, seen = t_ns[order], position[order], seen[order]
    first = np.concatenate([[True], np.diff(t_ns) > 0])[: len(t_ns)]
    if not first.all():
        notes.append(f"{int((~first).sum())} frames repeated a time: the first of each was kept")
        t_ns, position, seen = t_ns[first], position[first], seen[first]
    if heaps := _heaps(position, seen):
        notes.append(f"in {heaps} of {len(t_ns)} frames all of it stands in one place: no length, no shape")
    position[~seen] = 0.0
    return MarkerFrames(t_ns, position, seen, _checked_arc(arc, position.shape[1], source), source, tuple(notes))


def _heaps(position: np.ndarray, seen: np.ndarray) -> int:
    """Frames in which more than one marker is seen, and all of them stand in one place."""
    if position.shape[1] < 2:
        return 0
    first = position[np.arange(len(position)), seen.argmax(axis=1), None]
    together = ((position == first).all(axis=2) | ~seen).all(axis=1)
    return int((together & (seen.sum(axis=1) > 1)).sum())


def _checked_arc(arc: np.ndarray | None, markers: int, source: str) -> np.ndarray | None:
    if arc is None:
        return None
    arc = np.asarray(arc, np.float64)
    if arc.shape != (markers,) or not (np.diff(arc) > 0).all():
        raise LogError(f"{source}: the {markers} markers' places along the line must be {markers} increasing lengths")
    return arc


def from_log(
    log: Log,
    channel: str,
    arc: np.ndarray | None = None,
    read: tuple[np.ndarray, np.ndarray] | None = None,
) -> MarkerFrames:
    """A channel's markers: its ports `position` (m, 3) and `valid` (m,), or a line's `nodes` (n, 3), all visible.

    read: times and values of the channel, if they are read already. Raises LogError if the channel has neither.
    """
    info = log.channel(channel)
    shapes = {port.name: port.shape for port in info.ports}
    has_markers = is_markers(shapes.get("position", ()), shapes.get("valid", ()))
    name = "position" if has_markers else "nodes"
    if not has_markers and not is_line(shapes.get("nodes", ())):
        have = ", ".join(f"{port} {shape}" for port, shape in shapes.items())
        raise LogError(
            f"{log.path}: channel {channel} has no markers: it needs the ports position (m, 3) and valid (m,), "
            f"or a line's nodes (n, 3), two at least; it has {have}"
        )
    t_ns, values = log.read([channel])[channel] if read is None else read
    position = values[:, info.port(name)[1]].reshape(len(values), *shapes[name])
    valid = values[:, info.port("valid")[1]] > 0.5 if name == "position" else None
    return marker_frames(t_ns, position, valid, arc, f"{log.path}: {channel}")


def marker_channels(log: Log) -> list[str]:
    """Channels with markers; if there are none, the lines' channels (those with nodes)."""
    shapes = {name: {port.name: port.shape for port in info.ports} for name, info in log.channels.items()}
    tracked = [name for name, own in shapes.items() if is_markers(own.get("position", ()), own.get("valid", ()))]
    return tracked or lines(log)


def lines(log: Log) -> list[str]:
    """Channels with a line's nodes: the port `nodes` of shape (n, 3). What an estimator says of a line is none."""
    return [
        name
        for name, info in log.channels.items()
        if any(port.name == "nodes" and is_line(port.shape) for port in info.ports) and not is_estimate(info)
    ]


def is_line(nodes: tuple[int, ...]) -> bool:
    """Whether nodes of this shape are a line's."""
    return len(nodes) == 2 and nodes[0] > 1 and nodes[1] == 3


def is_markers(position: tuple[int, ...], valid: tuple[int, ...]) -> bool:
    """Whether ports of these shapes are places of markers and which of them are seen."""
    return len(position) == 2 and position[1] == 3 and valid == position[:1]


def is_estimate(info: ChannelInfo) -> bool:
    """Whether a channel tells of what is elsewhere in the scene: by its model, or as it says how sure it is."""
    told = any(port.name.startswith(DEVIATION) for port in info.ports)
    return told or info.metadata.get("model", "").startswith(ESTIMATORS)
