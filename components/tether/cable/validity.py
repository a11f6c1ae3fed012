"""How far a step was inside the model's range: measures that are at most 1 where the line can be believed."""

from math import acos

from components.compiled import kernel
from components.tether.cable.line import DIR, SCRATCH, TC
from components.tether.cable.part import part

# T = EA e holds for small strain: at 5 % the engineering strain is 2.5 % off the true one, and so is what follows it.
SMALL_STRAIN = 0.05
# A chord that turns by theta from one segment to the next is theta^2 / 24 shorter than its arc: 1 % at half a radian.
LARGEST_TURN = 0.5
MEASURES = 6


@kernel
def strain(line, w):
    """Largest strain by the tension over the small one."""
    worst = 0.0
    if not line.inextensible:
        for i in range(line.n):
            s = part(line, i)
            worst = max(worst, abs(w[i * SCRATCH + TC]) / (s.k * s.l0 * SMALL_STRAIN))
    return worst


@kernel
def turn(line, w):
    """Largest angle between segments that meet, over the largest that they resolve."""
    least = 1.0
    for i in range(line.n - 1):
        if i == line.cut or i + 1 == line.cut:
            continue
        a = i * SCRATCH + DIR
        b = a + SCRATCH
        least = min(least, w[a] * w[b] + w[a + 1] * w[b + 1] + w[a + 2] * w[b + 2])
    return acos(max(least, -1.0)) / LARGEST_TURN


@kernel
def shown(line, w):
    """Largest tension in the nodes, and the line's weight: what an unresolved impact is held against [N]."""
    largest = 0.0
    for i in range(line.n):
        largest = max(largest, w[i * SCRATCH + TC])
    return largest + line.dry_weight


@kernel
def measure(line, w, excess, error, snap, y, k):
    """Write the largest measure and each of them to y[k:], in the order of the model's ports."""
    y[k + 1] = excess
    y[k + 2] = error / line.accuracy
    y[k + 3] = snap / shown(line, w)
    y[k + 4] = strain(line, w)
    y[k + 5] = turn(line, w)
    y[k] = max(y[k + 1], y[k + 2], y[k + 3], y[k + 4], y[k + 5])
