"""How far a step was inside the model's range: measures that are at most 1 where the line can be believed."""

from math import acos

from components.compiled import kernel
from components.environment.waves import elevation
from components.tether.cable.line import ASKED, DIR, KE, SCRATCH, TC, Q
from components.tether.cable.part import part

# T = EA e holds for small strain: at 5 % the engineering strain is 2.5 % off the true one, and so is what follows it.
SMALL_STRAIN = 0.05
# The method of multipliers leaves an inextensible line a strain of 1e-11 times its tension over its weight: beyond this
# the ends are farther apart than it is long, and its tension means nothing.
NO_STRAIN = 1e-6
# A chord that turns by theta from one segment to the next is theta^2 / 24 shorter than its arc: 1 % at half a radian.
LARGEST_TURN = 0.5
# Where rounding is all that an iteration can do (a stiff line far from the origin), an imbalance of so much of the
# line's weight and largest tension still passes.
ROUNDED = 0.01
# The bed is level and the line in the water but for so much of the length, by which catenaries are judged too.
SHIFT = 0.01
MEASURES = 9


@kernel
def strain(line, w):
    """Largest strain by the tension over the small one; of an inextensible line by the lengths, over what is none."""
    worst = 0.0
    for i in range(line.n):
        s, b = part(line, i), i * SCRATCH
        if not line.inextensible:
            worst = max(worst, abs(w[b + TC]) / (s.k * s.l0 * SMALL_STRAIN))
        elif w[b + KE] > 0.0:
            worst = max(worst, abs(w[b + ASKED]) / (w[b + KE] * s.l0 * NO_STRAIN))
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
def sinking(line, w):
    """How deep the line is in the bed, over what it may be."""
    deepest = 0.0
    if line.bed:
        for i in range(line.n + 1):
            deepest = max(deepest, w[i * SCRATCH + Q + 2] - line.bed_depth)
    return deepest / (SHIFT * line.length)


@kernel
def emerging(line, w):
    """How high the line is above the waves, over what it may be; without waves nobody knows where the surface is."""
    highest = 0.0
    if line.waves:
        for i in range(line.n + 1):
            b = i * SCRATCH + Q
            highest = max(highest, -w[b + 2] - elevation(line.table, line.waves, w[b], w[b + 1], line.t))
    return highest / (SHIFT * line.length)


@kernel
def measure(line, w, account, y, k):
    """Write the largest measure and each of them to y[k:], in the order of the model's ports; account: of the step."""
    load = shown(line, w)
    y[k + 1] = max(account.excess, account.residual / (ROUNDED * load))
    y[k + 2] = account.error / line.accuracy
    y[k + 3] = account.snap / load
    y[k + 4] = strain(line, w)
    y[k + 5] = turn(line, w)
    y[k + 6] = sinking(line, w)
    y[k + 7] = emerging(line, w)
    y[k + 8] = account.again
    y[k] = max(y[k + 1], y[k + 2], y[k + 3], y[k + 4], y[k + 5], y[k + 6], y[k + 7], y[k + 8])
