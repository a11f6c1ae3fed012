"""The chain filter's first state, and when it is to begin anew."""

from math import atan2, cos, pi, sin

from components.compiled import kernel
from components.estimator.best.layout import (
    DOWN,
    FORCE_SPREAD,
    GATE,
    MARKERS,
    NORTH,
    P_ANGLE,
    P_PLACE,
    P_RATE,
    P_SPEED,
    PIVOT_SPREAD,
    READING,
    STATUS,
    VALUE,
    tables_of,
)
from components.estimator.best.prediction import mean_load
from components.estimator.chords import USED
from components.kinematics import wrapped
from components.tether.linkage.lagrangian import bars_at

LOST = 1.0  # from the chord of the markers about a bar [rad]
WOUND = 1.5 * pi  # of a joint [rad]: a line that is folded back on itself may come to somewhat more than pi


@kernel
def is_used(m, w, i):
    """Whether marker i has a position that is used, by its record."""
    return w[m.records + i * READING + STATUS] == USED


@kernel
def chord_angle(m, w, a, b):
    """Angle from marker a to marker b [rad]."""
    one, two = m.records + a * READING + VALUE, m.records + b * READING + VALUE
    return atan2(w[two + 1] - w[one + 1], w[two] - w[one])


@kernel
def chord_at(p, m, w, where):
    """The pair of used markers around a place on the line, or the nearest: (first, second), -1 where there are none."""
    count, places, before, after = int(p[MARKERS]), tables_of(p)[1], -1, -1
    for i in range(count):
        if not is_used(m, w, i):
            continue
        if before < 0 or (p[places + i] <= where and after < 0):
            before = i
        elif after < 0 and p[places + i] > where:
            after = i
        elif after < 0:
            before = i
    if after < 0:
        # The last two.
        after, before = before, -1
        for i in range(after):
            if is_used(m, w, i):
                before = i
    return before, after


@kernel
def begin(p, m, l, given, w, x, s):
    """The first state: at rest, loads at their means, angles as `given` or by the readings; and its root s (N, N)."""
    n, places = m.n, tables_of(p)[1]
    for j in range(m.N):
        x[j] = 0.0
    for i in range(n):
        x[i] = p[tables_of(p)[0] + i]
        if not given:
            a, b = chord_at(p, m, w, (i + 0.5) * l)
            if a >= 0:
                x[i] = chord_angle(m, w, a, b)
                # No joint turns by more than half a turn.
                x[i] = x[i - 1] + wrapped(x[i] - x[i - 1]) if i > 0 else x[i]
    for j in range(m.loads):
        x[m.F + j] = mean_load(p, j)
    if m.loads > 2:
        x[m.place], x[m.place + 1] = p[NORTH], p[DOWN]
        for k in range(int(p[MARKERS])):
            if not given and is_used(m, w, k):
                at = m.records + k * READING + VALUE
                x[m.place], x[m.place + 1], left = w[at], w[at + 1], p[places + k]
                for i in range(n):
                    part = min(l, left)
                    left -= part
                    x[m.place], x[m.place + 1] = x[m.place] - part * cos(x[i]), x[m.place + 1] - part * sin(x[i])
                break
    for i in range(m.N):
        for j in range(m.N):
            s[i, j] = 0.0
        s[i, i] = p[P_ANGLE] if i < n else (p[P_RATE] if i < 2 * n else p[FORCE_SPREAD])
    if m.loads > 2:
        for j in range(2):
            s[m.F + 2 + j, m.F + 2 + j] = p[PIVOT_SPREAD]
            s[m.place + j, m.place + j], s[m.speed + j, m.speed + j] = p[P_PLACE], p[P_SPEED]


@kernel
def is_unlikely(p, m, x):
    """Whether a load is farther from its mean than the gate's deviations of its spread.

    What a right filter finds spreads by less than the load itself: once in two million times at a gate of 5. Markers
    that are numbered from the wrong end of a line whose pivot moves tell of themselves by nothing else, see model.Best.
    """
    for i in range(m.loads):
        spread = p[FORCE_SPREAD] if i < 2 else p[PIVOT_SPREAD]
        if not abs(x[m.F + i] - mean_load(p, i)) <= p[GATE] * spread:
            return True
    return False


@kernel
def unwind(p, m, x):
    """Take whole turns off the joints with springs, of which no marker tells: beyond WOUND the line is not that way."""
    bars, before = bars_at(p, tables_of(p)[2]), 0.0
    for i in range(m.n):
        joint = x[i] - (before if i > 0 else bars.clamp)
        if bars.k[i] > 0.0 and abs(joint) > WOUND:
            for j in range(i, m.n):
                x[j] -= joint - wrapped(joint)
        before = x[i]


@kernel
def is_lost(p, m, l, h, w, x):
    """Whether a bar is far from where its markers have it, or it or its joint turns half round in a step of h [s]."""
    for i in range(m.n):
        a, b = chord_at(p, m, w, (i + 0.5) * l)
        if a < 0:
            return False
        apart = wrapped(x[i] - chord_angle(m, w, a, b))
        joint = x[i] - x[i - 1] if i > 0 else 0.0
        if not (abs(apart) < LOST and abs(x[m.n + i]) * h < pi and abs(joint) < pi):
            return True
    return False
