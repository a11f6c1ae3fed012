"""Markers that cannot stand where they were seen: neighbours further apart than the line between them is long.

A marker far off is left out, two markers whose labels were exchanged are exchanged back. What is too near is possible:
a line bends.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from pipeline.analysis.compiled import kernel
from pipeline.analysis.markers import MarkerFrames

KNOWN_SLACK = 0.05  # of the arc between two markers: 12 mm of the chain's 245 mm
# Without arcs the median distance of neighbours stands for the arc between them; it is up to 4 % less for a line that
# turns by a radian from marker to marker, and bends to and fro as it moves.
ESTIMATED_SLACK = 0.25
# What the record shows neighbours to do most of the time is allowed, whatever the slack: markers may be noisy.
# Deviations of their distance from its median, by 1.4826 times the median absolute deviation.
DEVIATIONS = 6.0 * 1.4826
LEAST_FRAMES = 5  # fewer give no median that an outlier does not move


@dataclass(frozen=True)
class Continuity:
    """order: (k, m) int, the position to take at each place on the line in turn, filled up with -1.

    left_out, swapped: (k,) markers seen but not on the line, markers exchanged. note: why nothing was checked, or "".
    """

    order: np.ndarray
    left_out: np.ndarray
    swapped: np.ndarray
    note: str = ""


def check_continuity(frames: MarkerFrames) -> Continuity:
    """Order the visible markers of every frame along the line, without those that cannot be on it."""
    reach, note = _reach(frames)
    k, m = frames.valid.shape
    order, left_out, swapped = np.empty((k, m), np.int64), np.zeros(k, np.int64), np.zeros(k, np.int64)
    place = np.empty(m, np.int64)
    _check_all(frames.position, frames.valid, reach, place, order, left_out, swapped)
    return Continuity(order, left_out, swapped, note)


def _reach(frames: MarkerFrames) -> tuple[np.ndarray, str]:
    """How far along the line the markers can be from the first, slack included: (m,) [m], infinite steps if unknown."""
    pairs = frames.valid[:, 1:] & frames.valid[:, :-1]
    often = pairs.sum(axis=0) >= LEAST_FRAMES
    if not often.any() and frames.arc is None:
        reason = f"fewer than {LEAST_FRAMES} frames and no spacing given"
        return np.arange(frames.markers) * 1e300, f"markers far off were not looked for: {reason}"
    distance = np.where(pairs, np.linalg.norm(np.diff(frames.position, axis=1), axis=2), np.nan)[:, often]
    middle, usual = np.zeros(len(often)), np.zeros(len(often))
    middle[often] = np.nanmedian(distance, axis=0)
    usual[often] = middle[often] + DEVIATIONS * np.nanmedian(np.abs(distance - middle[often]), axis=0)
    if frames.arc is not None:
        step = (1.0 + KNOWN_SLACK) * np.diff(frames.arc)
    else:
        step = (1.0 + ESTIMATED_SLACK) * np.where(often, middle, middle.max())
    return np.concatenate([[0.0], np.cumsum(np.maximum(step, usual))]), ""


@kernel
def _check_all(position, valid, reach, place, order, left_out, swapped):
    """All frames; place (m,) is scratch: the labels of the markers in `order`."""
    m = valid.shape[1]
    for f in range(valid.shape[0]):
        n = 0
        for j in range(m):
            if valid[f, j]:
                place[n] = j
                order[f, n] = j
                n += 1
        while n > 1 and not _neighbours_fit(position[f], reach, place, order[f], n):
            worst = _worst(position[f], reach, place, order[f], n)
            if _exchange(position[f], reach, place, order[f], n, worst):
                swapped[f] += 2
                break
            for j in range(worst, n - 1):
                place[j], order[f, j] = place[j + 1], order[f, j + 1]
            n -= 1
            left_out[f] += 1
        for j in range(n, m):
            order[f, j] = -1


@kernel
def _excess(position, reach, place, order, i, j):
    """Distance of the positions at places i and j over what the line allows [m]."""
    a, b = position[order[i]], position[order[j]]
    distance = sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)
    return distance - abs(reach[place[i]] - reach[place[j]])


@kernel
def _neighbours_fit(position, reach, place, order, n):
    """Whether all neighbours are near enough; then, by the triangle inequality, so are all pairs."""
    for j in range(1, n):  # noqa: SIM110 - numba has no generators without allocation
        if _excess(position, reach, place, order, j - 1, j) > 0.0:
            return False
    return True


@kernel
def _worst(position, reach, place, order, n):
    """The place in most pairs that are too far apart; of equal ones that with the greatest excess."""
    worst, most, greatest = 0, -1, -1.0
    for i in range(n):
        misfits = 0
        excess = 0.0
        for j in range(n):
            over = _excess(position, reach, place, order, i, j)
            if j != i and over > 0.0:
                misfits += 1
                excess = max(excess, over)
        if misfits > most or (misfits == most and excess > greatest):
            worst, most, greatest = i, misfits, excess
    return worst


@kernel
def _exchange(position, reach, place, order, n, worst):
    """Exchange the worst place's marker with another if that makes all fit; whether it did."""
    for j in range(n):
        if j != worst:
            order[worst], order[j] = order[j], order[worst]
            if _neighbours_fit(position, reach, place, order, n):
                return True
            order[worst], order[j] = order[j], order[worst]
    return False
