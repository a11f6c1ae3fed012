"""Markers that leave their own trajectory and come back: jumps that neither they nor their neighbours accelerate into.

The second difference of a marker's positions in time is its acceleration and its noise. A sample is judged by its own,
studentised: against the record's median (the noise), the median of its neighbours in the same frame (a snap that runs
through the line) and the largest of its last samples (a swing); and against the most violent motion of the whole line
in the record, so that at a rate which does not resolve the motion no motion is taken for a jump. One that stands out
is left out, with those that follow it, where the marker jumps back to where its earlier motion leads; so are the few
between a jump and a time unseen.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from pipeline.analysis.compiled import kernel

# At 4 none of the 195 000 clean markers of the pool scenes is left out at any rate from 50 to 1 Hz.
LIMIT = 4.0
VIOLENT = 0.995  # of the frames are no more violent than the record counts as: a frame seen askew is no motion
NEAR = 2  # neighbours on each side that tell how violent the motion is
UNSEEN = 3.5  # median periods: over a longer gap a motion is not followed
LONGEST = 10  # samples off the trajectory, one after the other; over more the way back cannot be foretold
MAXWELL_MEDIAN = 1.5382  # of the length of a vector of three standard normal numbers
SHORT_END = 3  # samples between a jump and a time unseen, which no jump back tells to be off
RETURN = 1.0 / 3.0  # of the jump: the way back ends this near to where the earlier motion leads


def second_differences(t_ns: np.ndarray, position: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Distance of each sample from the line through the marker's last two: (k, m) [m], NaN where there are none.

    Reduced to equal steps of the median period, so that its clean part is the acceleration times the period squared.
    """
    found = np.full(valid.shape, np.nan)
    if len(t_ns) > 2:
        _second_differences((t_ns - t_ns[0]) / _period(t_ns), position, valid, found)
    return found


def noise_of(t_ns: np.ndarray, position: np.ndarray, valid: np.ndarray) -> float:
    """Standard deviation of a marker along each axis [m], by the median second difference; 0 if nothing tells.

    Motion adds to it, so that it is an upper bound; an outlier, or a marker that is off all the time, hardly does.
    """
    difference = second_differences(t_ns, position, valid)
    known = difference[np.isfinite(difference)]
    return float(np.median(known)) / (MAXWELL_MEDIAN * sqrt(6.0)) if len(known) else 0.0


def greatest_motion(difference: np.ndarray) -> float:
    """How far the whole line leaves a steady motion from frame to frame [m]: of the frames' medians nearly the largest.

    difference: (k, m) of second_differences. A marker in its snap moves up to 3.3 times as much.
    """
    known = np.isfinite(difference)
    count = known.sum(axis=1)
    ordered = np.sort(np.where(known, difference, np.inf), axis=1)[count > 0]
    if not len(ordered):
        return 0.0
    medians = ordered[np.arange(len(ordered)), (count[count > 0] - 1) // 2]
    return float(np.partition(medians, int(VIOLENT * (len(medians) - 1)))[int(VIOLENT * (len(medians) - 1))])


def off_trajectory(t_ns: np.ndarray, position: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Which visible markers are off their trajectory: (k, m) bool.

    t_ns: (k,) strictly increasing. position: (k, m, 3) [m]. valid: (k, m). Too few frames to tell: none.
    """
    out = np.zeros(valid.shape, bool)
    difference = second_differences(t_ns, position, valid)
    if not np.isfinite(difference).any():
        return out
    scale = np.maximum(np.nanmedian(difference) + _of_neighbours(difference), greatest_motion(difference))
    t = (t_ns - t_ns[0]) / _period(t_ns)
    index = np.empty(len(t), np.int64)
    _scan(t, position, valid, scale, index, out)
    # Copies, contiguous as the others: the kernel is compiled once.
    backward = [np.ascontiguousarray(one[::-1]) for one in (-t, position, valid, scale, out)]
    _scan(*backward[:4], index, backward[4])
    return np.ascontiguousarray(backward[4][::-1])


def _period(t_ns: np.ndarray) -> float:
    return float(np.median(np.diff(t_ns)))


def _of_neighbours(difference: np.ndarray) -> np.ndarray:
    """Median second difference of the NEAR markers on either side in the same frame; 0 where none is known."""
    k, m = difference.shape
    padded = np.full((k, m + 2 * NEAR), np.nan)
    padded[:, NEAR : NEAR + m] = difference
    beside = [padded[:, NEAR + i : NEAR + i + m] for i in range(-NEAR, NEAR + 1) if i]
    ordered = np.sort(np.stack(beside), axis=0)  # NaN last
    count = np.isfinite(ordered).sum(axis=0)
    low, high = (np.take_along_axis(ordered, (np.maximum(count - i, 0) // 2)[None], 0)[0] for i in (1, 0))
    return np.where(count > 0, 0.5 * (low + high), 0.0)


@kernel
def _distance(x, i, a, b, j, step, gap):
    """How far sample i of marker j is from going on as from a to b: step is t_i - t_b, gap t_b - t_a."""
    total = 0.0
    for axis in range(3):
        ahead = x[b, j, axis] + (x[b, j, axis] - x[a, j, axis]) * step / gap
        total += (x[i, j, axis] - ahead) ** 2
    return sqrt(total)


@kernel
def _equal_steps(step, gap):
    """What turns a deviation after unequal steps into that after equal ones of a period; never enlarges it."""
    return 1.0 / max(1.0, 0.5 * step * (step + gap))


@kernel
def _second_differences(t, x, valid, found):
    """t: (k,) in periods."""
    for j in range(valid.shape[1]):
        a, b = -1, -1
        for i in range(valid.shape[0]):
            if not valid[i, j]:
                continue
            if b >= 0 and t[i] - t[b] > UNSEEN:
                b = -1
            if a >= 0 and b >= 0:
                step, gap = t[i] - t[b], t[b] - t[a]
                found[i, j] = _distance(x, i, a, b, j, step, gap) * _equal_steps(step, gap)
            a, b = b, i


@kernel
def _scan(t, x, valid, scale, index, out):
    """All markers along time; index: (k,) scratch."""
    for j in range(valid.shape[1]):
        n = 0
        for i in range(valid.shape[0]):
            if valid[i, j] and not out[i, j]:
                index[n] = i
                n += 1
        _scan_marker(t, x, j, scale, index, n, out)


@kernel
def _scan_marker(t, x, j, scale, index, n, out):
    """Follow one marker: leave out excursions that come back, and short ends behind a jump."""
    a, b = -1, -1  # its last two samples on the trajectory
    past0, past1, past2 = 0.0, 0.0, 0.0  # their second differences, latest first
    before, since, jumped = 0, 0, -1  # samples before the last jump, since then, its place in index
    q = 0
    while q <= n:
        broken = q == n or (b >= 0 and t[index[q]] - t[b] > UNSEEN)
        if broken:
            if jumped >= 0 and since <= SHORT_END and 3 * since <= before:
                for r in range(jumped, q):
                    out[index[r], j] = True
            a, b, before, since, jumped = -1, -1, 0, 0, -1
            past0, past1, past2 = 0.0, 0.0, 0.0
            if q == n:
                return
        i = index[q]
        difference = 0.0
        if a >= 0 and b >= 0:
            step, gap = t[i] - t[b], t[b] - t[a]
            jump = _distance(x, i, a, b, j, step, gap)
            difference = jump * _equal_steps(step, gap)
            if difference > LIMIT * (scale[i, j] + max(past0, past1, past2)):
                back = _return(t, x, j, a, b, index, q, n, jump)
                if back > 0:
                    for r in range(q, back):
                        out[index[r], j] = True
                    q = back
                    i = index[q]
                    difference = max(past0, past1, past2)
                else:
                    before, since, jumped = before + since, 0, q
                    a, b = -1, -1
                    difference = 0.0
        past0, past1, past2 = difference, past0, past1
        since += 1
        a, b = b, i
        q += 1


@kernel
def _return(t, x, j, a, b, index, q, n, jump):
    """The first place in index after q where the marker jumps back to its motion up to b; 0 if it does not."""
    for back in range(q + 1, min(q + 1 + LONGEST, n)):
        w, last = index[back], index[back - 1]
        if t[w] - t[last] > UNSEEN:
            return 0
        after = index[back + 1] if back + 1 < n and t[index[back + 1]] - t[w] <= UNSEEN else -1
        missed, leap = 0.0, 0.0
        for axis in range(3):
            slope = (x[b, j, axis] - x[a, j, axis]) / (t[b] - t[a])
            later = (x[after, j, axis] - x[w, j, axis]) / (t[after] - t[w]) if after >= 0 else slope
            middle = 0.5 * (slope + later)
            missed += (x[w, j, axis] - x[b, j, axis] - middle * (t[w] - t[b])) ** 2
            leap += (x[w, j, axis] - x[last, j, axis] - middle * (t[w] - t[last])) ** 2
        if sqrt(missed) <= RETURN * jump and sqrt(leap) >= (1.0 - RETURN) * jump:
            return back
    return 0
