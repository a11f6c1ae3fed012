"""Which way is up in a file that does not say: a line heavier than water hangs down."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from pipeline.analysis.markers import MarkerFrames

Up = Literal["x", "-x", "y", "-y", "z", "-z"]
UPS: tuple[Up, ...] = get_args(Up)
CLEAR = 3.0  # times more sag along x or y than along z: beyond it z is not the vertical
# The axes of the file in the order of a right-handed frame whose third axis is vertical.
_ORDER = {"x": [1, 2, 0], "y": [2, 0, 1], "z": [0, 1, 2]}


def in_ned(frames: MarkerFrames, up: Up | None = None) -> MarkerFrames:
    """Frames whose positions are x, y, z of some tool, in NED: z up is taken as east, north, up; no mirror image.

    up: the direction that is up; None: that to which most lines are hollow, which is noted.
    """
    note = ()
    if up is None:
        up = _hollow_side(frames)
        note = (f"the file does not say where up is: {up} is taken, so that the line hangs; else give --up",)
    position = frames.position[..., _ORDER[up[-1]]]
    if not up.startswith("-"):
        position = position[..., [1, 0, 2]] * np.array([1.0, 1.0, -1.0])
    return replace(frames, position=np.ascontiguousarray(position), notes=(*frames.notes, *note))


def _hollow_side(frames: MarkerFrames) -> Up:
    """Up or down along z, unless the line clearly hangs along another axis."""
    sag = _sag(frames)
    axis = int(np.abs(sag).argmax())
    if abs(sag[axis]) <= CLEAR * abs(sag[2]):
        axis = 2
    return UPS[2 * axis + (1 if sag[axis] > 0.0 else 0)]


def _sag(frames: MarkerFrames) -> np.ndarray:
    """How much each coordinate is greater between the outermost visible markers than on their chord: (3,) [m].

    Summed over the markers; the median over the frames.
    """
    enough = frames.valid.sum(axis=1) > 2
    valid, x = frames.valid[enough], frames.position[enough]
    if not len(x):
        return np.zeros(3)
    rows, last = np.arange(len(x)), valid.shape[1] - 1
    a, b = valid.argmax(axis=1), last - valid[:, ::-1].argmax(axis=1)
    share = ((np.arange(valid.shape[1]) - a[:, None]) / (b - a)[:, None])[..., None]
    above = x - (x[rows, a][:, None] * (1.0 - share) + x[rows, b][:, None] * share)
    return np.median((above * valid[..., None]).sum(axis=1), axis=0)
