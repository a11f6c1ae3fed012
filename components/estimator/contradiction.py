"""Sensors that contradict each other or the estimate: which markers cannot be where they are said to be, how long.

Two that are taken for each other are consistent with themselves frame after frame, so that no innovation tells of them
for long; the line does, on which they are farther apart than it is long between them. What agrees with itself and with
the line is not told: a camera that is turned, a picture that stands still, a marker in the place of a missing one.
"""

from math import sqrt

from components.compiled import kernel
from components.estimator.chords import REFUSED, SHORT, USED

# Of the length between two markers, beyond which it is no error of the images' scale that they are apart: neighbours
# that are taken for each other are twice as far from the next ones.
STRETCH = 1.2
NEAR = 3  # witnesses from one another: farther ones may be close on a line that is bent
# A witness: north, down, place along the line, variance of its position (both ways together), whether it is used, and
# how many others it contradicts.
PLACE, VARIANCE, TAKEN, OTHERS, WITNESS = 2, 3, 4, 5, 6
# What is kept in x: frames in a row that are contradicted, those whose NIS is beyond the gate, and new beginnings.
FRAMES, BEYOND, BEGINNINGS, KEPT = 0, 1, 2, 3


@kernel
def bear_witness(w, at, north, down, place, variance, status):
    """Write a marker's record, or that of a pivot which is known."""
    w[at], w[at + 1], w[at + PLACE], w[at + VARIANCE], w[at + TAKEN] = north, down, place, variance, status


@kernel
def contradict(w, at, i, j, gate, shortest):
    """Whether witnesses i and j are too far apart, or as near neighbours too close, their noise considered."""
    a, b = at + i * WITNESS, at + j * WITNESS
    if w[a + TAKEN] != USED or w[b + TAKEN] != USED:
        return False
    north, down, between = w[a] - w[b], w[a + 1] - w[b + 1], abs(w[a + PLACE] - w[b + PLACE])
    noise, square = gate * sqrt(w[a + VARIANCE] + w[b + VARIANCE]), north * north + down * down
    farthest, nearest = STRETCH * between + noise, shortest * between - noise
    return not square <= farthest * farthest or (abs(i - j) <= NEAR and nearest > 0.0 and square < nearest * nearest)


@kernel
def count_others(w, at, count, gate, shortest):
    """Write how many others each witness contradicts; whether any does."""
    found = False
    for i in range(count):
        w[at + i * WITNESS + OTHERS] = 0.0
        for j in range(i):
            if contradict(w, at, i, j, gate, shortest):
                w[at + i * WITNESS + OTHERS] += 1.0
                w[at + j * WITNESS + OTHERS] += 1.0
                found = True
    return found


@kernel
def refuse_impossible(w, at, markers, pivots, gate, folds):
    """Refuse the markers that contradict others, those first that contradict the most; whether any does.

    All, where no more than half would be left: then nothing tells which are right. Behind the markers stands the pivot
    where it is known, which is refused last. A line that `folds` may bring its markers together; only where some are
    too far apart do those that are too close tell which of them are wrong.
    """
    count, seen = markers + pivots, 0
    if folds and not count_others(w, at, count, gate, 0.0):
        return False
    if not count_others(w, at, count, gate, SHORT):
        return False
    for i in range(markers):
        seen += 1 if w[at + i * WITNESS + TAKEN] == USED else 0
    left = seen
    while True:
        worst, most = 0, 0.0
        for i in range(count):
            others = w[at + i * WITNESS + OTHERS]
            if others > most:
                worst, most = i, others
        if most == 0.0:
            break
        for j in range(count):
            if j != worst and contradict(w, at, worst, j, gate, SHORT):
                w[at + j * WITNESS + OTHERS] -= 1.0
        w[at + worst * WITNESS + TAKEN], w[at + worst * WITNESS + OTHERS] = REFUSED, 0.0
        left -= 1 if worst < markers else 0
    for i in range(markers if left < seen and 2 * left <= seen else 0):
        if w[at + i * WITNESS + TAKEN] == USED:
            w[at + i * WITNESS + TAKEN] = REFUSED
    return True


@kernel
def highest(freedom, gate):
    """The NIS that noise exceeds as rarely as one number exceeds `gate` deviations: Wilson and Hilferty 1931."""
    if freedom == 0.0:
        return 0.0
    part = 2.0 / (9.0 * freedom)
    root = 1.0 - part + gate * sqrt(part)
    return freedom * root * root * root


@kernel
def keep(kept, contradicted, beyond, anew):
    """Count a frame; kept: (KEPT)."""
    kept[FRAMES] = kept[FRAMES] + 1.0 if contradicted else 0.0
    kept[BEYOND] = kept[BEYOND] + 1.0 if beyond and not anew else 0.0
    kept[BEGINNINGS] += 1.0 if anew else 0.0
