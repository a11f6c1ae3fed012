"""Which way z points in a file that does not say: a line heavier than water hangs down."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from pipeline.analysis.markers import MarkerFrames

Up = Literal["z", "-z"]


def in_ned(frames: MarkerFrames, up: Up | None = None) -> MarkerFrames:
    """Frames whose positions are x, y, z of some tool, in NED: z up is taken as east, north, up.

    up: the direction that is up; None: that to which most lines are hollow, which is noted.
    """
    note = ()
    if up is None:
        up = "-z" if _sag(frames) > 0.0 else "z"
        note = (f"the file does not say where up is: {up} is taken, so that the line hangs",)
    position = frames.position if up == "-z" else frames.position[..., [1, 0, 2]] * np.array([1.0, 1.0, -1.0])
    return replace(frames, position=np.ascontiguousarray(position), notes=(*frames.notes, *note))


def _sag(frames: MarkerFrames) -> float:
    """Median over the frames of how much z is greater between the outermost visible markers than on their chord [m]."""
    valid = frames.valid[frames.valid.sum(axis=1) > 2]
    z = frames.position[frames.valid.sum(axis=1) > 2, :, 2]
    if not len(z):
        return 0.0
    rows, last = np.arange(len(z)), valid.shape[1] - 1
    a, b = valid.argmax(axis=1), last - valid[:, ::-1].argmax(axis=1)
    share = (np.arange(valid.shape[1]) - a[:, None]) / (b - a)[:, None]
    above = z - (z[rows, a][:, None] * (1.0 - share) + z[rows, b][:, None] * share)
    return float(np.median((above * valid).sum(axis=1)))
