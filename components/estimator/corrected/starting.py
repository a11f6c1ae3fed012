"""The corrected filter's first state, which markers its line allows, and when it is to begin anew."""

from math import sqrt

from components.compiled import kernel
from components.estimator.chords import USED
from components.estimator.contradiction import TAKEN, WITNESS, bear_witness, refuse_impossible
from components.estimator.linear import (
    ANGLE,
    BAR,
    CHORD,
    COV,
    FIRST_NODE,
    GATE,
    NODE,
    P_ANGLE,
    P_FORCE,
    P_RATE,
    THERE,
    A,
    B,
    X,
    Z,
    expected,
)

LOST = 1.0  # a chord from where the estimate has it [rad]


@kernel
def forget(p, m, s):
    """Write the root (N, N) of the first covariance."""
    for i in range(m.N):
        for j in range(m.N):
            s[i, j] = 0.0
        s[i, i] = sqrt(p[P_FORCE] if i >= 2 * m.n else (p[P_ANGLE] if i % 2 == 0 else p[P_RATE]))


@kernel
def refuse_where_no_line_is(p, m, w, at):
    """Refuse the nodes that no nearly straight line of this length has; whether there are any. w[at]: scratch."""
    pivots = 1 if p[FIRST_NODE] > 0.0 else 0
    markers = m.n + 1 - pivots
    for i in range(m.n + 1):
        # The pivot, where it is known, comes last.
        k = (i + pivots) % (m.n + 1)
        a, there = k * NODE, USED if w[k * NODE + THERE] > 0.0 else 0.0
        variance = w[a + COV] + w[a + COV + 2]
        bear_witness(w, at + i * WITNESS, w[a + X], w[a + Z], k * p[BAR], variance, there)
    if not refuse_impossible(w, at, markers, pivots, p[GATE], False):
        return False
    for i in range(m.n + 1):
        w[(i + pivots) % (m.n + 1) * NODE + THERE] = w[at + i * WITNESS + TAKEN]
    return True


@kernel
def runs_back(p, m, w, at, count):
    """Whether the chords, one after the other, lead back from north: as of markers numbered from the wrong end."""
    if count == 0:
        return False
    a, b = int(w[at + A]) * NODE, int(w[at + (count - 1) * CHORD + B]) * NODE
    return w[b + X] - w[a + X] < -p[GATE] * sqrt(w[a + COV] + w[b + COV])


@kernel
def farthest(m, x, w, at, count):
    """The greatest angle between a chord and the estimate of it."""
    most = 0.0
    for k in range(count):
        c = at + k * CHORD
        most = max(most, abs(w[c + ANGLE] - expected(m, x, int(w[c + A]), int(w[c + B]))))
    return most
