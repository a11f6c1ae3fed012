"""The motion of a line's moving end and the distance of its ends: what the log recorded, else differences of places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.known import first_of_each, known
from pipeline.analysis.markers import MarkerFrames, is_line
from pipeline.analysis.origin import Origin
from pipeline.log.reader import ChannelInfo, Log

# Markers are noisy: over 0.05 s to either side 0.4 mm make 6 mm/s and 0.4 m/s^2, and a hand stays below 5 Hz.
DIFFERENCE_NS = 50_000_000
FAR = 4  # times the usual step: places further apart, as about a drop-out, tell no acceleration between them


@dataclass(frozen=True)
class Ends:
    """t: (k,) [s]. speed: (k,) [m/s]; acceleration: (k,) its magnitude [m/s^2], of the moving end.

    t_distance: (j,) [s]; distance: (j,) of the ends [m]. NaN where not known. source: what all were taken from.
    """

    t: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    t_distance: np.ndarray
    distance: np.ndarray
    source: str


def ends_of_log(log: Log, where: Origin, frames: MarkerFrames) -> Ends:
    """From the motion that drives the line's end b and the line's nodes; from the markers where the log has none."""
    line = log.channels.get(where.line)
    if line is None or not any(port.name == "nodes" and is_line(port.shape) for port in line.ports):
        return ends_of_markers(frames)
    t_ns, (nodes,) = _recorded(log, where.line, "nodes")
    found = _of_motion(log, where) or _of_places(t_ns, nodes[:, -1], f"places of the end of {where.line}")
    return Ends(*found[:3], t_ns / 1e9, _length(nodes[:, -1] - nodes[:, 0]), f"{found[3]}; distance: {where.line}")


Motion = tuple[np.ndarray, np.ndarray, np.ndarray, str]  # t [s], speed, acceleration, what they were taken from


def _of_motion(log: Log, where: Origin) -> Motion | None:
    """As recorded; the acceleration by differences of the velocity where it was not, or both of the position."""
    channel = log.channels.get(where.motion[0]) if where.motion else None
    if where.motion is None or channel is None:
        return None
    name, bundle = where.motion
    names = [one for one in ("velocity", "acceleration", "position") if _has(channel, f"{bundle}.{one}")]
    t_ns, values = _recorded(log, name, *(f"{bundle}.{one}" for one in names))
    found = dict(zip(names, values, strict=True))
    if "velocity" not in found:
        return _of_places(t_ns, found["position"], f"positions of {name}") if "position" in found else None
    velocity = found["velocity"]
    if "acceleration" in found:
        acceleration, source = found["acceleration"], f"speed and acceleration: {name}, as recorded"
    else:
        acceleration = np.gradient(velocity, t_ns / 1e9, axis=0) if len(t_ns) > 1 else np.full_like(velocity, np.nan)
        source = f"speed: {name}, as recorded; acceleration: its differences"
    return t_ns / 1e9, _length(velocity), _length(acceleration), source


def _recorded(log: Log, name: str, *ports: str) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times [ns], each once, and ports of a channel (k, *shape); NaN where a number is none."""
    t_ns = log.times(name)
    first = first_of_each(t_ns)
    return t_ns[first], [known(log.port(name, port)[first]) for port in ports]


def _has(channel: ChannelInfo, port: str) -> bool:
    return any(one.name == port for one in channel.ports)


def ends_of_markers(frames: MarkerFrames) -> Ends:
    """From the frames that show the last marker, and its distance to the first where that is seen too."""
    last = frames.valid[:, -1]
    place, t_ns = frames.position[last, -1], frames.t_ns[last]
    apart = np.where(frames.valid[last, 0], _length(place - frames.position[last, 0]), np.nan)
    motion = _of_places(t_ns, place, "places of the last marker", DIFFERENCE_NS)
    return Ends(*motion[:3], t_ns / 1e9, apart, f"{motion[3]}, with its noise; distance: first and last marker")


def _of_places(t_ns: np.ndarray, place: np.ndarray, source: str, least_ns: int = 0) -> Motion:
    """By central differences of places (k, 3) that are at least one sample and `least_ns` away on either side."""
    index = np.arange(len(t_ns))
    before = np.minimum(np.searchsorted(t_ns, t_ns - least_ns, "right") - 1, index - 1)
    after = np.maximum(np.searchsorted(t_ns, t_ns + least_ns), index + 1)
    motion = np.full((2, len(t_ns)), np.nan)
    usual_ns = float(np.median(np.diff(t_ns))) if len(t_ns) > 1 else 0.0
    step_ns = max(usual_ns, float(least_ns))
    inside = np.flatnonzero((before >= 0) & (after < len(t_ns)))
    i, a, b = inside, before[inside], after[inside]
    near = (t_ns[i] - t_ns[a] <= FAR * step_ns) & (t_ns[b] - t_ns[i] <= FAR * step_ns)
    i, a, b = i[near], a[near], b[near]
    back, ahead = (t_ns[i] - t_ns[a])[:, None] / 1e9, (t_ns[b] - t_ns[i])[:, None] / 1e9
    backward, forward = (place[i] - place[a]) / back, (place[b] - place[i]) / ahead
    # Parabola through the three places: second order however unequal the two steps are.
    motion[0, i] = _length((ahead * backward + back * forward) / (back + ahead))
    motion[1, i] = _length(2.0 * (forward - backward) / (back + ahead))
    over = f" over {np.ceil(step_ns / usual_ns) * usual_ns / 1e9:.3g} s to either side" if usual_ns else ""
    return t_ns / 1e9, motion[0], motion[1], f"speed and acceleration: differences of {source}{over}"


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vectors, axis=-1)
