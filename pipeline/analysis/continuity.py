"""Markers that cannot stand where they were seen: off their own trajectory, or further apart than the line is long.

Labels that were exchanged are exchanged back, first by the markers' motion, then by their order on the line; a marker
off its trajectory or off the line is left out. What is too near is possible: a line bends.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from pipeline.analysis.compiled import kernel
from pipeline.analysis.labels import tracked_labels
from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.trajectories import noise_of, off_trajectory

KNOWN_SLACK = 0.05  # of the arc between two markers: 12 mm of the chain's 245 mm
# Without arcs the median distance of neighbours stands for the arc between them; it is up to 4 % less for a line that
# turns by a radian from marker to marker, and bends to and fro as it moves.
ESTIMATED_SLACK = 0.25
# What the record shows neighbours to do most of the time is allowed where no arcs are known: markers may be noisy.
# Of the deviation of their distance, which is 1.4826 times its median absolute deviation.
DEVIATIONS = 6.0
NOISES = 6.0 * sqrt(2.0)  # where arcs are known: of a marker's noise, which the distance of two has sqrt(2) times
LEAST_FRAMES = 5  # fewer give no median that an outlier does not move
MOST_EXCHANGES = 4  # of two labels each, in one frame: four swapped pairs, or a cycle of five


@dataclass(frozen=True)
class Continuity:
    """order: (k, m) int, the position to take at each place on the line in turn, filled up with -1.

    left_out, swapped: (k,) markers seen but not on the line, markers whose labels were exchanged back.
    note: what was mended, or why nothing was checked; "" where there is nothing to say.
    """

    order: np.ndarray
    left_out: np.ndarray
    swapped: np.ndarray
    note: str = ""


def check_continuity(frames: MarkerFrames) -> Continuity:
    """Order the visible markers of every frame along the line, without those that cannot be on it."""
    reach, note = _reach(frames)
    k, m = frames.valid.shape
    labels = tracked_labels(frames.t_ns, frames.position, frames.valid, reach)
    rows = np.arange(k)[:, None]
    position, valid = (np.ascontiguousarray(one[rows, labels]) for one in (frames.position, frames.valid))
    off = off_trajectory(frames.t_ns, position, valid)
    order, left_out = np.empty((k, m), np.int64), off.sum(axis=1)
    swapped = ((labels != np.arange(m)) & valid & ~off).sum(axis=1)
    often = _misfits(position, valid & ~off, reach)
    place, scratch = np.empty(m, np.int64), np.empty(m, np.int64)
    _check_all(position, valid & ~off, reach, often, place, scratch, order, left_out, swapped)
    order = np.where(order < 0, -1, np.take_along_axis(labels, np.maximum(order, 0), axis=1))
    return Continuity(order, left_out, swapped, "; ".join(filter(None, (note, _mended(left_out, swapped)))))


def _mended(left_out: np.ndarray, swapped: np.ndarray) -> str:
    """How many markers were left out and exchanged, and in how many frames; "" if none were."""
    counts = {"left out, off their trajectory or the line": left_out, "given back their exchanged labels": swapped}
    return "; ".join(
        f"{int(count.sum())} markers in {int((count > 0).sum())} frames were {what}"
        for what, count in counts.items()
        if count.any()
    )


def _reach(frames: MarkerFrames) -> tuple[np.ndarray, str]:
    """How far along the line the markers can be from the first, slack included: (m,) [m], infinite steps if unknown."""
    pairs = frames.valid[:, 1:] & frames.valid[:, :-1]
    distance = np.where(pairs, np.linalg.norm(np.diff(frames.position, axis=1), axis=2), np.nan)
    often = pairs.sum(axis=0) >= LEAST_FRAMES
    middle, deviation = np.zeros(len(often)), np.zeros(len(often))
    if often.any():
        middle[often] = np.nanmedian(distance[:, often], axis=0)
        deviation[often] = 1.4826 * np.nanmedian(np.abs(distance - middle)[:, often], axis=0)
    if frames.arc is not None:
        noise = noise_of(frames.t_ns, frames.position, frames.valid)
        if often.any():  # which motion adds to less, at low rates
            noise = min(noise, float(np.median(deviation[often])) / sqrt(2.0))
        step = (1.0 + KNOWN_SLACK) * np.diff(frames.arc) + NOISES * noise
        return np.concatenate([[0.0], np.cumsum(step)]), ""
    if not often.any():
        reason = f"fewer than {LEAST_FRAMES} frames and no spacing given"
        return np.arange(frames.markers) * 1e300, f"markers far off were not looked for: {reason}"
    step = (1.0 + ESTIMATED_SLACK) * np.where(often, middle, middle.max())
    return np.concatenate([[0.0], np.cumsum(np.maximum(step, middle + DEVIATIONS * deviation))]), ""


def _misfits(position: np.ndarray, valid: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """In how many frames each marker is too far from a neighbour: (m,)."""
    far = np.linalg.norm(np.diff(position, axis=1), axis=2) > np.diff(reach)
    count = (far & valid[:, 1:] & valid[:, :-1]).sum(axis=0)
    return np.concatenate([[0], count]) + np.concatenate([count, [0]])


@kernel
def _check_all(position, valid, reach, often, place, scratch, order, left_out, swapped):
    """All frames; often (m,): frames in which a marker is too far from a neighbour.

    place, scratch: (m,), the labels of the markers in `order`, and a copy of `order`.
    """
    m = valid.shape[1]
    for f in range(valid.shape[0]):
        n = 0
        for j in range(m):
            if valid[f, j]:
                place[n] = j
                order[f, n] = j
                n += 1
        while n > 1 and not _neighbours_fit(position[f], reach, place, order[f], n):
            moved = _exchange(position[f], reach, often, place, order[f], n, scratch)
            if moved > 0:
                swapped[f] += moved
                break
            worst = _worst(position[f], reach, often, place, order[f], n)
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
def _worst(position, reach, often, place, order, n):
    """The place in most pairs that are too far apart; of equal ones the marker more often so, then the farther off."""
    worst, most, greatest = 0, -1, -1.0
    for i in range(n):
        misfits = 0
        excess = 0.0
        for j in range(n):
            over = _excess(position, reach, place, order, i, j)
            if j != i and over > 0.0:
                misfits += 1
                excess = max(excess, over)
        usual, usual_worst = often[place[i]], often[place[worst]]
        worse = usual > usual_worst or (usual == usual_worst and excess > greatest)
        if misfits > most or (misfits == most and worse):
            worst, most, greatest = i, misfits, excess
    return worst


@kernel
def _total_excess(position, reach, place, order, n):
    """Sum over all neighbours of what is too far [m]."""
    total = 0.0
    for j in range(1, n):
        total += max(0.0, _excess(position, reach, place, order, j - 1, j))
    return total


@kernel
def _exchange(position, reach, often, place, order, n, scratch):
    """Exchange pairs of markers, at each turn the worst with what helps most, if that makes all fit: how many moved."""
    for j in range(n):
        scratch[j] = order[j]
    for _ in range(MOST_EXCHANGES):
        worst = _worst(position, reach, often, place, order, n)
        least, with_ = _total_excess(position, reach, place, order, n), -1
        for j in range(n):
            order[worst], order[j] = order[j], order[worst]
            total = _total_excess(position, reach, place, order, n)
            order[worst], order[j] = order[j], order[worst]
            if total < least:
                least, with_ = total, j
        if with_ < 0:
            break
        order[worst], order[with_] = order[with_], order[worst]
        if _neighbours_fit(position, reach, place, order, n):
            moved = 0
            for j in range(n):
                moved += order[j] != scratch[j]
            return moved
    for j in range(n):
        order[j] = scratch[j]
    return 0
