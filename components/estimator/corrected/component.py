"""Binds the corrected linear filter to the contract."""

from math import log, sqrt

from components.compiled import kernel
from components.contract import Component
from components.estimator import line, straight
from components.estimator.chords import NARROW, REFUSED
from components.estimator.contradiction import BEGINNINGS, BEYOND, FRAMES, KEPT, highest, keep
from components.estimator.corrected import model
from components.estimator.corrected.starting import LOST, farthest, forget, refuse_where_no_line_is, runs_back
from components.estimator.layout import outputs_of
from components.estimator.linear import (
    ANGLE,
    BAR,
    BELIEVED_AFTER,
    CHORD,
    GATE,
    GIVEN,
    INTERVAL,
    MARKERS,
    NODE,
    OFF,
    OFF_BY,
    WRONG_INTERVAL,
    A,
    B,
    D,
    begin,
    chords_of,
    expected,
    gather,
    mark,
    mean_row,
    model_of,
    string,
    write_estimate,
    write_fit,
    write_tension,
)
from components.estimator.roots import correct, keep_triangle, log_density, multiply, triangulate
from components.matrices import table

LARGEST = 1e9  # deviation of a tension that nothing tells of [N], and what a NIS is given as at most


@kernel
def measure(m, w, y, state, s, at, count, rows):
    """Use the chords, whose noise is made independent by one pass (its covariance is a band); write how that went.

    With R = G G', G lower and of two diagonals, row and angle of G^-1 follow from the chord before.
    """
    n, N = m.n, m.N
    row, before, by = rows[:N], rows[N : 2 * N], rows[2 * N : 3 * N]
    out = outputs_of(n).innovation
    for j in range(N):
        before[j] = 0.0
    for k in range(n):
        y[out + k] = 0.0
    angle = below = nis = density = 0.0
    for k in range(count):
        c = at + k * CHORD
        diagonal = sqrt(max(w[c + D] - below * below, NARROW * w[c + D]))
        mean_row(m, int(w[c + A]), int(w[c + B]), row)
        angle = (w[c + ANGLE] - below * angle) / diagonal
        innovation = angle
        for j in range(N):
            row[j] = before[j] = (row[j] - below * before[j]) / diagonal
            innovation -= row[j] * state[j]
        y[out + k], log_v = correct(state, s, row, innovation, by)
        nis += y[out + k] * y[out + k]
        density += log_density(y[out + k], log_v, log(diagonal))
        below = w[c + OFF] / diagonal
    write_fit(n, y, count, nis, density)


@kernel
def pull(p, m, state, root, w):
    """Tension by (13)-(17) with the modal forces, least squares over the bars, and its deviation; w: scratch, 4 n.

    Psi_i - W_i = F l s_i, s_i the sum of theta_n - theta_j from i on, theta the bars' own angles.
    """
    n, N, L, TL, l = m.n, m.N, m.L, m.TL, p[BAR]
    q, s, by_q, by_s = w[:n], w[n : 2 * n], w[2 * n : 3 * n], w[3 * n : 4 * n]
    qs = ss = reach = 0.0
    last = expected(m, state, n - 1, n)
    for i in range(n - 1, -1, -1):
        reach += last - expected(m, state, i, i + 1)
        s[i], q[i] = l * reach, -m.W[i]
        for j in range(n):
            q[i] += L[i, j] * state[2 * n + j]
        qs, ss = qs + q[i] * s[i], ss + s[i] * s[i]
    if ss == 0.0:
        return 0.0, LARGEST
    F = qs / ss
    for i in range(n):
        by_q[i], by_s[i] = s[i] / ss, (q[i] - 2.0 * F * s[i]) / ss
    square = 0.0
    for c in range(N):
        total = reach = end = 0.0
        for j in range(n):
            end += TL[n - 1, j] * root[2 * j, c]
        for i in range(n - 1, -1, -1):
            force = turn = 0.0
            for j in range(n):
                force, turn = force + L[i, j] * root[2 * n + j, c], turn + TL[i, j] * root[2 * j, c]
            reach += end - turn
            total += by_q[i] * force + by_s[i] * l * reach
        square += total * total
    return F, min(sqrt(square), LARGEST)


@kernel
def begin_anew(p, m, u, x, y, w, at, rows):
    """Take the frame alone for true, but for the markers that cannot be where they are."""
    n, N = m.n, m.N
    gather(p, u, w)
    refuse_where_no_line_is(p, m, w, at)
    mark(p, w, y)
    begin(p, m, False, w, NODE * (n + 1), x[:N])
    forget(p, m, table(x, N, N, N))
    for i in range(n + 1):
        x[N + N * N + i] = 0.0
    measure(m, w, y, x[:N], table(x, N, N, N), at, string(p, m, w, at), rows)


@kernel
def read(p, u, x, y, w, first):
    """Use a frame and write all outputs.

    It begins anew where the NIS is beyond the gate and a chord is far from where it was expected, or the NIS has been
    for BELIEVED_AFTER frames in a row: what it believes is not what is seen. At t0, where nothing is learned yet,
    whenever the `first` angles are contradicted.
    """
    m = model_of(p)
    n, N = m.n, m.N
    state, s, kept = x[:N], table(x, N, N, N), x[N + N * N + n + 1 :]
    at, out = NODE * (n + 1) + n, outputs_of(n).innovation + n
    rows = w[at + CHORD * n :]
    gather(p, u, w)
    contradicted = impossible = refuse_where_no_line_is(p, m, w, at)
    count = chords_of(p, m, impossible, state, s, x[N + N * N :], w, at, rows[:N], rows[N : 2 * N])
    mark(p, w, y)
    for i in range(int(p[MARKERS])):
        contradicted = contradicted or y[out + 3 + i] == REFUSED
    contradicted = contradicted or runs_back(p, m, w, at, count)
    apart = farthest(m, state, w, at, count)
    measure(m, w, y, state, s, at, count, rows)
    nis = y[out + 1]
    improbable, beyond = not nis <= highest(count, p[GATE]), not nis <= p[GATE] * p[GATE] * count
    anew = (beyond and (not apart <= LOST or kept[BEYOND] >= p[BELIEVED_AFTER])) or (first and improbable)
    if anew:
        begin_anew(p, m, u, x, y, w, at, rows)
        y[out + 1] = nis if nis < LARGEST else LARGEST
    keep(kept, contradicted or improbable, beyond, anew)
    end = out + 3 + int(p[MARKERS])
    y[end], y[end + 1] = kept[FRAMES], kept[BEGINNINGS]
    write_estimate(p, m, state, s, N, rows, y)
    tension, spread = pull(p, m, state, s, rows)
    write_tension(n, y, tension, spread)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the first frame."""
    m = model_of(p)
    n, N = m.n, m.N
    if abs(dt_ns * 1e-9 - p[INTERVAL]) > OFF_BY * p[INTERVAL]:
        return WRONG_INTERVAL
    for i in range(n + 1 + KEPT):
        x[N + N * N + i] = 0.0
    gather(p, u, w)
    refuse_where_no_line_is(p, m, w, NODE * (n + 1) + n)
    begin(p, m, p[GIVEN] > 0.0, w, NODE * (n + 1), x[:N])
    forget(p, m, table(x, N, N, N))
    read(p, u, x, y, w, True)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """(29), and (30) as Phi P Phi' + Q_d; then the frame at the step's end."""
    m = model_of(p)
    N, phi, state, fresh = m.N, m.phi, x[: m.N], w[: m.N]
    s, wide = table(x, N, N, N), table(w, NODE * (m.n + 1) + m.n + CHORD * m.n + 6 * N, N, 2 * N)
    for i in range(N):
        fresh[i] = 0.0
        for j in range(N):
            fresh[i] += phi[i, j] * state[j]
    for i in range(N):
        state[i] = fresh[i]
    multiply(m.phi, s, wide)
    for i in range(N):
        for j in range(N):
            wide[i, N + j] = m.noise[i, j]
    triangulate(wide, N, 2 * N, N)
    keep_triangle(wide, s)
    read(p, u, x, y, w, False)
    return 0


COMPONENT = Component(
    name="estimator.corrected",
    parameters=model.Corrected,
    inputs=line.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    status_text={WRONG_INTERVAL: "the period is not `interval`, for which the filter was made: make them equal"},
    terms=straight.terms,
    assumptions="Bars nearly straight and level, that swing little about a pivot at rest; all forces, weight and "
    "tension among them, are random walks; noise is white. A chord over a missing marker has its bars' mean angle.",
)
