"""Binds the iterated extended filter of a chain of bars to the contract."""

from math import inf, isfinite

from components.compiled import kernel
from components.contract import Component
from components.estimator.best import model
from components.estimator.best.deriving import deviations
from components.estimator.best.layout import (
    DOWN,
    EAST,
    GATE,
    GIVEN,
    NORTH,
    READING,
    STATUS,
    layout_of,
    tables_of,
)
from components.estimator.best.measuring import gather, use_all
from components.estimator.best.prediction import predict
from components.estimator.best.starting import begin, is_lost, is_unlikely, unwind
from components.estimator.chords import REFUSED
from components.estimator.contradiction import BEGINNINGS, FRAMES, KEPT, highest, keep
from components.estimator.layout import outputs_of
from components.estimator.roots import deviation, keep_triangle, multiply, triangulate
from components.matrices import table

NOT_FINITE = 1
LARGEST = 1e12  # that a NIS is given as


@kernel
def read(p, m, gate, u, x, y, w):
    """Use what the sensors say and write all outputs but the last; whether something is contradicted."""
    n, N = m.n, m.N
    state, s, l = x[:N], table(x, N, N, N), p[tables_of(p)[2] + 1]
    out = outputs_of(n)
    contradicted = impossible = gather(p, m, l, u, state, w)
    count, nis, density, times = use_all(p, m, l, gate, impossible, state, s, x[N + N * N :], w, y, out.innovation)
    end = out.innovation + 2 * m.R
    y[end], y[end + 1], y[end + 2] = count, nis, density
    for i in range(m.R):
        y[end + 3 + i] = w[m.records + i * READING + STATUS]
        contradicted = contradicted or y[end + 3 + i] == REFUSED
    write(p, m, state, s, w, y)
    at = end + 3 + m.R
    y[at], y[at + 1], y[at + 2] = state[m.F], 0.0, state[m.F + 1]
    y[at + 3], y[at + 4], y[at + 5] = deviation(s, m.F), deviation(s, m.F + 1), times
    return contradicted or is_unlikely(p, m, state)


@kernel
def write(p, m, state, s, w, y):
    """Write the estimate and its deviations."""
    n, a, size = m.n, m.derived, 4 * m.n + 1
    out, d = outputs_of(n), w[a : a + 2 * size]
    ahead, behind = w[a + 2 * size : a + 3 * size], w[a + 3 * size : a + 4 * size]
    deviations(p, m, state, s, w, d, ahead, behind, w[m.rows : m.rows + m.N])
    moves = m.loads > 2
    y[0], y[1], y[2] = (state[m.place] if moves else p[NORTH]), p[EAST], (state[m.place + 1] if moves else p[DOWN])
    for j in range(2):
        y[out.d_nodes + j] = deviation(s, m.place + j) if moves else 0.0
    for i in range(n):
        k = 3 * i + 3
        y[k], y[k + 1], y[k + 2] = d[2 * i], p[EAST], d[2 * i + 1]
        y[out.angle + i], y[out.rate + i] = state[i], state[n + i]
        y[out.moment + i], y[out.tension + i] = d[2 * n + i], d[3 * n + i]
        y[out.d_nodes + 2 * i + 2], y[out.d_nodes + 2 * i + 3] = d[size + 2 * i], d[size + 2 * i + 1]
        y[out.d_angle + i], y[out.d_rate + i] = deviation(s, i), deviation(s, n + i)
        y[out.d_moment + i], y[out.d_tension + i] = d[size + 2 * n + i], d[size + 3 * n + i]
    y[out.end], y[out.d_end] = d[4 * n], d[size + 4 * n]


@kernel
def tell(p, m, x, y, contradicted, anew):
    """Count and write contradictions, those of the NIS among them."""
    at = outputs_of(m.n).innovation + 2 * m.R
    kept, end = x[m.N + m.N * m.N + m.R :], at + 9 + m.R
    keep(kept, contradicted or not y[at + 1] <= highest(y[at], p[GATE]), anew, anew)
    y[end], y[end + 1] = kept[FRAMES], kept[BEGINNINGS]


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with what the sensors say first."""
    m, l = layout_of(p), p[tables_of(p)[2] + 1]
    gather(p, m, l, u, x[: m.N], w)
    begin(p, m, l, p[GIVEN] > 0.0, w, x[: m.N], table(x, m.N, m.N, m.N))
    for i in range(m.R + KEPT):
        x[m.N + m.N * m.N + i] = 0.0
    # Far from the first state, where bars could fold either way, no sensor is to be refused.
    contradicted = read(p, m, inf, u, x, y, w)
    tell(p, m, x, y, contradicted, False)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Move the estimate on, then use what the sensors say; where that is beyond the gate and far off, begin anew."""
    m = layout_of(p)
    N = m.N
    s, wide, moves = table(x, N, N, N), table(w, m.wide, N, N + m.K), table(w, m.moves, N, N + m.K)
    predict(p, x[:N], dt_ns * 1e-9, w)
    unwind(p, m, x[:N])
    multiply(moves, s, wide)
    for i in range(N):
        for j in range(N, N + m.K):
            wide[i, j] = moves[i, j]
    triangulate(wide, N, N + m.K, N + m.K)
    keep_triangle(wide, s)
    contradicted = read(p, m, p[GATE] * p[GATE], u, x, y, w)
    at, l = outputs_of(m.n).innovation + 2 * m.R, p[tables_of(p)[2] + 1]
    nis = y[at + 1]
    beyond = not nis <= p[GATE] * p[GATE] * y[at]
    anew = beyond and is_lost(p, m, l, dt_ns * 1e-9, w, x)
    if anew:
        begin(p, m, l, False, w, x[:N], s)
        read(p, m, inf, u, x, y, w)
        y[at + 1] = nis if isfinite(nis) else LARGEST
    tell(p, m, x, y, contradicted, anew)
    for i in range(N + N * N):
        if not isfinite(x[i]):
            return NOT_FINITE
    return 0


COMPONENT = Component(
    name="estimator.best",
    parameters=model.Best,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    status_text={NOT_FINITE: "the estimate became non-finite: shorten the period or lower the noises of its model"},
    terms=model.terms,
    assumptions="A line in the vertical plane without stretch, with bars short against its curvature; water at rest "
    "drags across it only, and moves with it alike along and across; what the model lacks are white moments on the "
    "bars; the force on its end and the pivot's acceleration are Ornstein-Uhlenbeck processes; noise is white.",
)
