"""Markers whose labels a tracker exchanged: each position goes to the marker whose motion leads there.

Only frames in which a marker jumps further than any motion of the record are looked at. There the positions are
assigned to the markers' motions so that the sum of the distances is least (linear_sum_assignment); an exchange holds
until another frame undoes it. What such jumps do not show is left to the order along the line (continuity).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.analysis.trajectories import LIMIT, UNSEEN, greatest_motion, second_differences

JUMP = 6.0  # times the noise and the lower quartile of the frame; a frame looked at in vain costs 50 microseconds only


def tracked_labels(t_ns: np.ndarray, position: np.ndarray, valid: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Which label stands for each marker in each frame: (k, m) int; the markers' own where nothing was exchanged.

    reach: (m,) as continuity makes it; it decides which of two labellings is the line's.
    """
    k, m = valid.shape
    own = np.broadcast_to(np.arange(m), (k, m))
    difference = second_differences(t_ns, position, valid)
    if m < 2 or not np.isfinite(difference).any():
        return own
    noise = np.nanmedian(difference)
    ordered = np.sort(difference, axis=1)
    quartile = ordered[np.arange(k), np.isfinite(difference).sum(axis=1) // 4]
    gate = JUMP * (noise + np.where(np.isfinite(quartile), quartile, noise))
    least = LIMIT * greatest_motion(difference)
    suspicious = np.flatnonzero((difference > np.maximum(gate, least)[:, None]).any(axis=1))
    if not len(suspicious):
        return own
    labels = _follow(t_ns, position, valid, suspicious, gate, least, reach)
    return _of_the_line(labels, position, valid, reach)


def _follow(
    t_ns: np.ndarray,
    position: np.ndarray,
    valid: np.ndarray,
    suspicious: np.ndarray,
    gate: np.ndarray,
    least: float,
    reach: np.ndarray,
) -> np.ndarray:
    """As tracked_labels, in the markers' own names. gate: (k,) how near a motion leads [m]. least: a jump [m]."""
    labels = np.tile(np.arange(valid.shape[1]), (len(t_ns), 1))
    longest = UNSEEN * float(np.median(np.diff(t_ns)))
    is_suspicious = np.zeros(len(t_ns), bool)
    is_suspicious[suspicious] = True
    unknown = np.full((valid.shape[1], valid.shape[1]), np.nan)
    own, f = np.arange(valid.shape[1]), int(suspicious[0])
    while f < len(t_ns):
        exchanged = f > 0 and bool((labels[f] != own).any())
        if not exchanged and not is_suspicious[f]:
            later = suspicious[np.searchsorted(suspicious, f) :]
            if not len(later):
                break
            f = int(later[0])
        # The two frames before tell the motion; a marker lost in one of them has none.
        distance = unknown
        if f >= 2 and t_ns[f] - t_ns[f - 2] <= longest:
            first, last = (np.where(valid[i, labels[i], None], position[i, labels[i]], np.nan) for i in (f - 2, f - 1))
            ahead = last + (last - first) * ((t_ns[f] - t_ns[f - 1]) / (t_ns[f - 1] - t_ns[f - 2]))
            distance = np.linalg.norm(ahead[:, None] - np.where(valid[f, :, None], position[f], np.nan)[None], axis=2)
        here = labels[f]
        if exchanged:
            here = _given_back(
                here,
                distance,
                gate[f],
                lambda one, f=f: _misfits(one[None], position[f : f + 1], valid[f : f + 1], reach),
            )
        labels[f:] = _assign(distance, here, gate[f], least) if is_suspicious[f] else here
        f += 1
    return labels


def _given_back(
    here: np.ndarray, distance: np.ndarray, gate: float, misfits: Callable[[np.ndarray], int]
) -> np.ndarray:
    """The markers' own labels wherever their motion, or where that is unknown their order on the line, allows it."""
    own = np.arange(len(here))
    apart = distance[own, own]
    result = here.copy()
    for cycle in _cycles(here, own):
        known = np.isfinite(apart[cycle])
        given = result.copy()
        given[cycle] = cycle
        if (apart[cycle][known] <= gate).all() if known.any() else misfits(given) < misfits(result):
            result = given
    return result


def _assign(distance: np.ndarray, here: np.ndarray, gate: float, least: float) -> np.ndarray:
    """The label for each marker, `here` kept where nothing fits better, or what it holds did not jump.

    distance: (m, m) from where each marker's motion leads to each label's position [m], NaN where unknown.
    """
    near = distance <= gate
    near[np.arange(len(here)), here] = False
    if not near.any():
        return here
    from scipy.optimize import linear_sum_assignment  # a quarter of a second, and most records need none

    # A position off every motion is nobody's: beyond the gate all are equally far, and the labels stay.
    cost = np.where(distance <= gate, distance, 4.0 * gate)
    cost[np.arange(len(here)), here] -= 1e-3 * gate
    found = linear_sum_assignment(cost)[1]
    result = here.copy()
    for cycle in _cycles(found, here):
        apart = distance[cycle, found[cycle]]
        jump = distance[cycle, here[cycle]]
        known = np.isfinite(apart)
        jumped = (jump[np.isfinite(jump)] > max(gate, least)).all()
        if known.any() and (apart[known] <= gate).all() and jumped:
            result[cycle] = found[cycle]
    return result


def _cycles(found: np.ndarray, here: np.ndarray) -> list[list[int]]:
    """The markers that exchange their labels among themselves, in groups of two or more."""
    marker_of = np.argsort(here)
    cycles, done = [], np.zeros(len(here), bool)
    for start in np.flatnonzero(found != here):
        cycle, j = [], int(start)
        while not done[j]:
            done[j] = True
            cycle.append(j)
            j = int(marker_of[found[j]])
        if cycle:
            cycles.append(cycle)
    return cycles


def _of_the_line(labels: np.ndarray, position: np.ndarray, valid: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Name the markers as in the frames whose order is the line's best; the tracker's first where several are."""
    kinds, frames = np.unique(labels, axis=0, return_counts=True)
    own = np.arange(labels.shape[1])
    best, least = labels, (np.inf, 0)
    for kind in kinds[np.argsort(-frames)][:8]:
        renamed = labels[:, np.argsort(kind)]
        misfits = _misfits(renamed, position, valid, reach)
        kept = int((renamed == own).all(axis=1).sum())
        if (misfits, -kept) < least:
            best, least = renamed, (misfits, -kept)
    return best


def _misfits(labels: np.ndarray, position: np.ndarray, valid: np.ndarray, reach: np.ndarray) -> int:
    """Neighbours further apart than the line between them is long, over all frames."""
    rows = np.arange(len(labels))[:, None]
    x, seen = position[rows, labels], valid[rows, labels]
    far = np.linalg.norm(np.diff(x, axis=1), axis=2) > np.diff(reach)
    return int((far & seen[:, 1:] & seen[:, :-1]).sum())
