"""Zeros that stand for nothing seen: many trackers write (0, 0, 0) for a lost marker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.analysis.markers import MarkerFrames

STEPS = 5.0  # of the marker's own median step: a marker that really passes the origin comes and goes nearer than this


def without_zeros(frames: MarkerFrames) -> MarkerFrames:
    """Markers at exactly (0, 0, 0) taken as not seen where nothing else of the record is near the origin, and noted."""
    position, valid = frames.position, frames.valid
    zero = valid & (position == 0.0).all(axis=2)
    seen, lost = valid & ~zero, np.zeros_like(zero)
    for j in np.flatnonzero(zero.any(axis=0)):
        if seen[:, j].any():
            lost[:, j] = zero[:, j] & _isolated(position[:, j], seen[:, j])
        else:
            lost[:, j] = zero[:, j] & _far_from_neighbours(position, seen, int(j))
    if not lost.any():
        return frames
    note = f"{int(lost.sum())} positions were exactly (0, 0, 0), away from all others: taken as not visible"
    return replace(frames, valid=valid & ~lost, notes=(*frames.notes, note))


def _isolated(x: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """(k,) bool: whether the marker is far from the origin before and after. x: (k, 3)."""
    index = np.flatnonzero(seen)
    distance = np.linalg.norm(x[index], axis=1)
    steps = np.linalg.norm(np.diff(x[index], axis=0), axis=1)
    near = STEPS * float(np.median(steps)) if len(steps) else 0.0
    after = np.searchsorted(index, np.arange(len(x)))
    nearest = np.minimum(distance[np.maximum(after - 1, 0)], distance[np.minimum(after, len(index) - 1)])
    return nearest > near


def _far_from_neighbours(position: np.ndarray, seen: np.ndarray, j: int) -> bool:
    """Of a marker that is zero throughout: whether its neighbours are seen, and further away than they usually are."""
    pairs = seen[:, 1:] & seen[:, :-1]
    usual = np.linalg.norm(np.diff(position, axis=1), axis=2)[pairs]
    beside = [i for i in (j - 1, j + 1) if 0 <= i < position.shape[1] and seen[:, i].any()]
    if not beside or not len(usual):
        return False
    nearest = min(float(np.median(np.linalg.norm(position[seen[:, i], i], axis=1))) for i in beside)
    return nearest > 2.0 * float(np.median(usual))
