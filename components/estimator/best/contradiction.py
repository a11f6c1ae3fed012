"""Markers that cannot be where they are said to be: farther apart than the line between them is long."""

from math import sqrt

from components.compiled import kernel
from components.estimator.best.layout import GATE, MARKERS, READING, ROOT, STATUS, VALUE, WHERE
from components.estimator.chords import REFUSED, USED

# Of the length between two markers, beyond which it is no error of the images' scale that they are apart: neighbours
# that are taken for each other are twice as far from the next ones.
STRETCH = 1.2


@kernel
def contradict(p, w, a, b):
    """Whether the markers with records at w[a] and w[b] are too far apart, their noise considered."""
    north, down = w[a + VALUE] - w[b + VALUE], w[a + VALUE + 1] - w[b + VALUE + 1]
    variance = 0.0
    for k in range(3):
        variance += w[a + ROOT + k] * w[a + ROOT + k] + w[b + ROOT + k] * w[b + ROOT + k]
    reach = STRETCH * abs(w[a + WHERE] - w[b + WHERE]) + p[GATE] * sqrt(variance)
    return not north * north + down * down <= reach * reach


@kernel
def refuse_impossible(p, m, w):
    """Refuse the markers that contradict others, those first that contradict the most.

    All, where no more than half would be left: then nothing tells which are right.
    """
    count, seen, left = int(p[MARKERS]), 0, 0
    for i in range(count):
        seen += 1 if w[m.records + i * READING + STATUS] == USED else 0
    left = seen
    while left > 0:
        worst, most = 0, 0
        for i in range(count):
            a, apart = m.records + i * READING, 0
            for j in range(count if w[a + STATUS] == USED else 0):
                b = m.records + j * READING
                if j != i and w[b + STATUS] == USED and contradict(p, w, a, b):
                    apart += 1
            if apart > most:
                worst, most = a, apart
        if most == 0:
            break
        w[worst + STATUS] = REFUSED
        left -= 1
    for i in range(count if left < seen and 2 * left <= seen else 0):
        at = m.records + i * READING
        if w[at + STATUS] == USED:
            w[at + STATUS] = REFUSED
