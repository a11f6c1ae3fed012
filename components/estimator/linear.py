"""What the two linear filters share: their numbers in p, the first state, chords as measurements, and the outputs.

The state: modal angles and rates in turn, then modal forces (n each); the angles' root of covariance B = H S.
"""

from math import atan2, cos, sin, sqrt
from typing import Any, NamedTuple

from components.compiled import kernel
from components.contract import HEADER
from components.estimator.chords import MISSING, REFUSED, SHORT, USED, across, between, is_there, spread
from components.estimator.layout import outputs_of
from components.estimator.roots import project
from components.matrices import table

(BARS, MARKERS, FIRST_NODE, BAR, INTERVAL, GATE, VARIANCE, TAKES_COVARIANCE, CHAIN_VARIANCE, NORTH, EAST, DOWN, GIVEN,
 P_ANGLE, P_RATE, P_FORCE, BELIEVED_AFTER) = range(HEADER, HEADER + 17)  # fmt: skip
ANGLES = HEADER + 17
# A node's record in the scratch vector: north, down, covariance (3), whether its marker is used.
X, Z, COV, THERE, NODE = 0, 1, 2, 5, 6
# A chord's: first and second node, angle, its variance, covariance with the next one's angle, whether it is believed.
A, B, ANGLE, D, OFF, BELIEVED, CHORD = 0, 1, 2, 3, 4, 5, 6
WRONG_INTERVAL = 1
OFF_BY = 1e-6  # of the interval, by which the period may differ from it


class Model(NamedTuple):
    """Bars n, states N, and tables in p.

    L: modes (n, n); TL: the bars' own angles by the modal ones (n, n); phi: Phi (N, N); noise: of a step (N, N); W:
    moments of the weight about the joints (n) [N m]; k: springs (n) [N m].
    """

    n: int
    N: int
    L: Any
    TL: Any
    phi: Any
    noise: Any
    W: Any
    k: Any


@kernel
def model_of(p):
    """The model whose numbers p holds, see modal.numbers."""
    n = int(p[BARS])
    N = 3 * n
    a = ANGLES + n
    b, c = a + n * n, a + 2 * n * n
    d = c + N * N
    end = d + N * N
    return Model(
        n,
        N,
        table(p, a, n, n),
        table(p, b, n, n),
        table(p, c, N, N),
        table(p, d, N, N),
        p[end : end + n],
        p[end + n : end + 2 * n],
    )


@kernel
def gather(p, u, w):
    """Write the nodes' records: the markers that are there, and the pivot where the first marker is beyond it."""
    n, count, first = int(p[BARS]), int(p[MARKERS]), int(p[FIRST_NODE])
    for k in range(n + 1):
        for j in range(NODE):
            w[k * NODE + j] = 0.0
    if first == 1:
        w[X], w[Z], w[THERE] = p[NORTH], p[DOWN], 1.0
    for i in range(count):
        if is_there(u, i, count):
            at = (first + i) * NODE
            w[at + X], w[at + Z], w[at + THERE] = u[3 * i], u[3 * i + 2], 1.0
            w[at + COV], w[at + COV + 1], w[at + COV + 2] = spread(
                u, i, count, p[TAKES_COVARIANCE] > 0.0, p[VARIANCE], p[CHAIN_VARIANCE]
            )


@kernel
def mean_row(m, a, b, row):
    """Write the row (N) of the mean angle of the bars between nodes a and b."""
    for j in range(m.N):
        row[j] = 0.0
    for k in range(a, b):
        for j in range(m.n):
            row[2 * j] += m.TL[k, j] / (b - a)


@kernel
def expected(m, x, a, b):
    """The mean angle of the bars between nodes a and b."""
    total = 0.0
    for k in range(a, b):
        for j in range(m.n):
            total += m.TL[k, j] * x[2 * j]
    return total / (b - a)


@kernel
def string(p, m, w, at):
    """Write the chords' records at w[at] from node to node, their noise included; how many.

    No bar of a line that is nearly level has turned beyond south, so that no whole turns are to be told.
    """
    n, count, last = m.n, 0, -1
    for k in range(n + 1):
        if not w[k * NODE + THERE] > 0.0:
            continue
        if last >= 0:
            c, a, b = at + count * CHORD, last * NODE, k * NODE
            dx, dz = w[b + X] - w[a + X], w[b + Z] - w[a + Z]
            length, angle = sqrt(dx * dx + dz * dz), atan2(dz, dx)
            co, si, over = cos(angle), sin(angle), 1.0 / max(length, 1e-9)
            C_a = w[a + COV], w[a + COV + 1], w[a + COV + 2]
            C_b = w[b + COV], w[b + COV + 1], w[b + COV + 2]
            w[c + A], w[c + B], w[c + ANGLE] = last, k, angle
            w[c + D] = (across(co, si, C_a) + across(co, si, C_b)) * over * over
            w[c + OFF] = 0.0
            along = sqrt(across(-si, co, C_a) + across(-si, co, C_b))
            span, slack = (k - last) * p[BAR], p[GATE] * along
            w[c + BELIEVED] = 1.0 if SHORT * span - slack < length < span + slack + 1e-9 * span else 0.0
            if count > 0:
                before = c - CHORD
                angle_before = w[before + ANGLE]
                ax, az = w[a + X] - w[int(w[before + A]) * NODE + X], w[a + Z] - w[int(w[before + A]) * NODE + Z]
                shared = between(angle_before, angle, C_a)
                w[before + OFF] = -shared * over / max(sqrt(ax * ax + az * az), 1e-9)
            count += 1
        last = k
    return count


@kernel
def refuse(p, m, impossible, x, s, refusals, w, at, count, row, by):
    """Mark as not there the nodes none of whose chords is believed; whether any is.

    Not where they are most, nor one that was refused BELIEVED_AFTER times in a row: then it is not that marker that is
    wrong. But while markers are `impossible` none is believed for that: it may be what they were taken for. refusals:
    (n + 1).
    """
    n, gate = m.n, p[GATE] * p[GATE]
    for k in range(count):
        c = at + k * CHORD
        mean_row(m, int(w[c + A]), int(w[c + B]), row)
        gap = w[c + ANGLE] - expected(m, x, int(w[c + A]), int(w[c + B]))
        if gap * gap > gate * (project(s, row, by) + w[c + D]):
            w[c + BELIEVED] = 0.0
    seen = bad = 0
    for turn in range(2):
        for k in range(n + 1):
            if not w[k * NODE + THERE] > 0.0 or (k == 0 and p[FIRST_NODE] > 0.0):
                continue
            chords = believed = 0
            for i in range(count):
                c = at + i * CHORD
                if w[c + A] == k or w[c + B] == k:
                    chords += 1
                    believed += 1 if w[c + BELIEVED] > 0.0 else 0
            if turn == 0:
                seen += 1
                bad += 1 if chords > 0 and believed == 0 else 0
            elif chords == 0 or believed > 0 or 2 * bad > seen:
                refusals[k] = 0.0
            elif impossible or refusals[k] < p[BELIEVED_AFTER]:
                refusals[k] += 0.0 if impossible else 1.0
                w[k * NODE + THERE] = REFUSED
    return 0 < 2 * bad <= seen


@kernel
def mark(p, w, y):
    """Write which markers are used."""
    n, first, count = int(p[BARS]), int(p[FIRST_NODE]), int(p[MARKERS])
    at = outputs_of(n).innovation + n + 3
    for i in range(count):
        there = w[(first + i) * NODE + THERE]
        y[at + i] = USED if there > 0.0 else (REFUSED if there < 0.0 else MISSING)


@kernel
def chords_of(p, m, impossible, x, s, refusals, w, at, row, by):
    """Gathered markers as chords, without those that the estimate contradicts: how many."""
    count = string(p, m, w, at)
    return string(p, m, w, at) if refuse(p, m, impossible, x, s, refusals, w, at, count, row, by) else count


@kernel
def begin(p, m, given, w, at, x):
    """The first angles: as `given`, else as the chords are (those missing as their neighbours), at rest."""
    n, N, L, angle = m.n, m.N, m.L, w[at : at + m.n]
    for j in range(N):
        x[j] = 0.0
    if given:
        for k in range(n):
            angle[k] = p[ANGLES + k]
    else:
        count = string(p, m, w, at + n)
        for k in range(n):
            angle[k] = 0.0
            for i in range(count):
                c = at + n + i * CHORD
                if w[c + A] <= k or i == 0:
                    angle[k] = w[c + ANGLE]
    for j in range(n):
        for k in range(n):
            phi = angle[k] - (angle[k - 1] if k > 0 else 0.0)
            x[2 * j] += L[k, j] * phi
            x[2 * n + j] += L[k, j] * m.k[k] * phi


@kernel
def write_estimate(p, m, x, root, columns, w, y):
    """Write shape, rates and moments with their deviations; root: (N, columns), root root' the covariance.

    w: scratch, 3 columns.
    """
    n, TL, springs, l = m.n, m.TL, m.k, p[BAR]
    out = outputs_of(n)
    north, down, r_x, r_z = w[:columns], w[columns : 2 * columns], p[NORTH], p[DOWN]
    before = w[2 * columns : 3 * columns]
    for j in range(columns):
        north[j] = down[j] = before[j] = 0.0
    y[out.nodes], y[out.nodes + 1], y[out.nodes + 2] = r_x, p[EAST], r_z
    y[out.d_nodes] = y[out.d_nodes + 1] = last = 0.0
    for k in range(n):
        angle = rate = d_angle = d_rate = d_moment = d_north = d_down = 0.0
        for j in range(n):
            angle, rate = angle + TL[k, j] * x[2 * j], rate + TL[k, j] * x[2 * j + 1]
        c, s = cos(angle), sin(angle)
        for i in range(columns):
            turn = speed = 0.0
            for j in range(n):
                turn, speed = turn + TL[k, j] * root[2 * j, i], speed + TL[k, j] * root[2 * j + 1, i]
            bend = turn - before[i]
            before[i] = turn
            north[i], down[i] = north[i] - l * s * turn, down[i] + l * c * turn
            d_angle, d_rate, d_moment = d_angle + turn * turn, d_rate + speed * speed, d_moment + bend * bend
            d_north, d_down = d_north + north[i] * north[i], d_down + down[i] * down[i]
        r_x, r_z, at = r_x + l * c, r_z + l * s, out.nodes + 3 * k + 3
        y[at], y[at + 1], y[at + 2] = r_x, p[EAST], r_z
        y[out.d_nodes + 2 * k + 2], y[out.d_nodes + 2 * k + 3] = sqrt(d_north), sqrt(d_down)
        y[out.angle + k], y[out.rate + k], y[out.moment + k] = angle, rate, springs[k] * (angle - last)
        y[out.d_angle + k], y[out.d_rate + k] = sqrt(d_angle), sqrt(d_rate)
        y[out.d_moment + k], last = springs[k] * sqrt(d_moment), angle


@kernel
def write_tension(n, y, tension, spread):
    """Write one tension for the whole line, as the linear model has it, and its deviation."""
    out = outputs_of(n)
    for k in range(n):
        y[out.tension + k], y[out.d_tension + k] = tension, spread
    y[out.end], y[out.d_end] = tension, spread


@kernel
def write_fit(n, y, freedom, nis, density):
    """Write how well the measurements were met."""
    at = outputs_of(n).innovation + n
    y[at], y[at + 1], y[at + 2] = freedom, nis, density
