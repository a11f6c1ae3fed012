"""The motion of a line's moving end and the distance of its ends: from the log's motions, else from the markers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.origin import Origin
from pipeline.log.reader import ChannelInfo, Log

DIFFERENCE_NS = 50_000_000  # 0.05 s to either side: 0.4 mm of noise make 6 mm/s and 0.4 m/s^2, a hand stays below 5 Hz


@dataclass(frozen=True)
class Ends:
    """t: (k,) [s]. speed: (k,) [m/s]; acceleration: (k,) its magnitude [m/s^2]; distance: (k,) of the ends [m].

    NaN where not known. source: what they were taken from.
    """

    t: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    distance: np.ndarray
    source: str


def ends_of_log(log: Log, where: Origin, frames: MarkerFrames) -> Ends:
    """From the line's nodes and the motion that drives its end b; from the markers where the log has none."""
    line, motion = log.channels.get(where.line), where.motion
    moving = log.channels.get(motion[0]) if motion else None
    if line is None or motion is None or moving is None or not _has(line, "nodes"):
        return ends_of_markers(frames)
    names = [f"{motion[1]}.{quantity}" for quantity in ("velocity", "acceleration")]
    if moving.count != line.count or not all(_has(moving, name) for name in names):
        return ends_of_markers(frames)
    nodes, (velocity, acceleration) = log.port(where.line, "nodes"), (log.port(motion[0], name) for name in names)
    return Ends(
        log.times(where.line) / 1e9,
        np.linalg.norm(velocity, axis=1),
        np.linalg.norm(acceleration, axis=1),
        np.linalg.norm(nodes[:, -1] - nodes[:, 0], axis=1),
        f"the motion of {motion[0]} and the ends of {where.line}, without noise",
    )


def _has(channel: ChannelInfo, port: str) -> bool:
    return any(one.name == port for one in channel.ports)


def ends_of_markers(frames: MarkerFrames) -> Ends:
    """From the last marker by central differences over DIFFERENCE_NS to either side, and its distance to the first."""
    t, here = frames.t_ns, np.where(frames.valid[..., None], frames.position, np.nan)
    before, after = (np.searchsorted(t, t + shift).clip(0, len(t) - 1) for shift in (-DIFFERENCE_NS, DIFFERENCE_NS))
    last = here[:, -1]
    with np.errstate(invalid="ignore", divide="ignore"):
        backward = (last - last[before]) / ((t - t[before]) / 1e9)[:, None]
        forward = (last[after] - last) / ((t[after] - t) / 1e9)[:, None]
        velocity = (last[after] - last[before]) / ((t[after] - t[before]) / 1e9)[:, None]
        acceleration = (forward - backward) / ((t[after] - t[before]) * 0.5e-9)[:, None]
    return Ends(
        t / 1e9,
        np.linalg.norm(velocity, axis=1),
        np.linalg.norm(acceleration, axis=1),
        np.linalg.norm(last - here[:, 0], axis=1),
        "the last and the first marker, with their noise",
    )
