"""A line as its own channel recorded it: nodes with their motion, the forces at its ends, the length paid out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.known import first_of_each, known
from pipeline.log.reader import ChannelInfo, Log

# Frames of a line's own nodes that are judged, evenly over the record: of ten minutes 7 a second.
FRAMES = 4000


@dataclass(frozen=True)
class LineRecord:
    """k frames of n nodes. t_ns: (k,). nodes, velocity, acceleration: (k, n, 3) NED, by differences between the
    messages, however many of them are judged; NaN in the first and the last, and whatever is not finite. force_a,
    force_b: (k, 3) of the line on its holders [N], None where not recorded. length: (k,) unstretched [m], None
    likewise. whole: (k,) bool, not broken. current: (k, m, 3) that a channel gave it, held between its messages [m/s];
    None where there is none.
    """

    name: str
    t_ns: np.ndarray
    nodes: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    force_a: np.ndarray | None
    force_b: np.ndarray | None
    length: np.ndarray | None
    whole: np.ndarray
    current: np.ndarray | None = None


Rows = tuple[np.ndarray, np.ndarray]  # of a channel: times [ns] and values, as Log.read gives them


def has(channel: ChannelInfo | None, port: str) -> bool:
    """Whether there is such a channel, with such a port."""
    return channel is not None and any(one.name == port for one in channel.ports)


def known_rows(rows: Rows) -> Rows:
    """The first message of each time, its numbers NaN where they are none."""
    t_ns, values = rows
    first = first_of_each(t_ns)
    return t_ns[first], known(values[first])


def stride(messages: int) -> int:
    """Every how many messages a line is judged."""
    return max(1, messages // FRAMES)


def line_record(log: Log, name: str, read: dict[str, Rows], current: tuple[str, str] = ("", "")) -> LineRecord:
    """The frames of a line's channel that are judged; read: it and the current's channel, as they stand in the log."""
    info = log.channel(name)
    t_ns, values = known_rows(read[name])
    index = np.arange(0, len(t_ns), stride(len(t_ns)))

    def port(wanted: str, size: int = 3) -> np.ndarray | None:
        found = info.port(wanted)[1] if has(info, wanted) else slice(0, 0)
        return values[:, found][index] if found.stop - found.start == size else None

    nodes = values[:, info.port("nodes")[1]]
    velocity, acceleration = _motion(t_ns / 1e9, nodes, index)
    length, broken = port("unstretched_length", 1), port("broken_segment", 1)
    shape = (len(index), *info.port("nodes")[0].shape)
    return LineRecord(
        name=name,
        t_ns=t_ns[index],
        nodes=nodes[index].reshape(shape),
        velocity=velocity.reshape(shape),
        acceleration=acceleration.reshape(shape),
        force_a=port("force_a"),
        force_b=port("force_b"),
        length=None if length is None else np.where(length[:, 0] > 0.0, length[:, 0], np.nan),
        whole=np.ones(len(index), bool) if broken is None else broken[:, 0] == 0.0,
        current=_held(log, read, current, t_ns[index]),
    )


def _held(log: Log, read: dict[str, Rows], current: tuple[str, str], t_ns: np.ndarray) -> np.ndarray | None:
    """(k, m, 3): the last message of the current's channel at these times."""
    name, port = current
    if name not in read or not has(log.channels.get(name), port):
        return None
    times, values = known_rows(read[name])
    if not len(times):
        return None
    rows = np.maximum(np.searchsorted(times, t_ns, "right") - 1, 0)
    found, part = log.channel(name).port(port)
    return values[:, part][rows].reshape(len(rows), found.size // 3, 3) if found.size % 3 == 0 else None


def _motion(t: np.ndarray, places: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivatives of places (k, m) at these frames: those of the parabola through three messages."""
    motion = np.full((2, len(index), places.shape[1]), np.nan)
    inside = (index > 0) & (index < len(t) - 1)
    i = index[inside]
    back, ahead = (t[i] - t[i - 1])[:, None], (t[i + 1] - t[i])[:, None]
    backward, forward = (places[i] - places[i - 1]) / back, (places[i + 1] - places[i]) / ahead
    motion[0, inside] = (ahead * backward + back * forward) / (back + ahead)
    motion[1, inside] = 2.0 * (forward - backward) / (back + ahead)
    return motion[0], motion[1]
