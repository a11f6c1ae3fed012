"""What the sensors say of the chain, by kinds: each a prediction and its slope by the state; and their use.

A kind is a branch of `expect` and a few lines of `gather`; the rest is the same for all.
"""

from math import cos, floor, log, pi, sin, sqrt

from components.compiled import kernel
from components.estimator.best.layout import (
    BELIEVED_AFTER,
    CHAIN_VARIANCE,
    DOWN,
    END_VARIANCE,
    GATE,
    GYRO,
    GYRO_VARIANCE,
    GYROS,
    ITERATIONS,
    KIND,
    MARKER_VARIANCE,
    MARKERS,
    NORTH,
    PLACE,
    READING,
    ROOT,
    SQUARE,
    STATUS,
    TAKES_COVARIANCE,
    TENSION,
    TENSION_VARIANCE,
    TILT,
    TILT_VARIANCE,
    TILTS,
    VALUE,
    WHERE,
    tables_of,
)
from components.estimator.chords import FAR, MISSING, REFUSED, USED, is_there, spread
from components.estimator.contradiction import TAKEN, WITNESS, bear_witness, refuse_impossible
from components.estimator.roots import correct, log_density, project
from components.matrices import table

# Deviations by which measurements may differ between the line and its tangent until they are taken anew.
CURVED = 0.01


@kernel
def expect(p, m, l, kind, where, x, one, two):
    """What a sensor of this kind at `where` [m] would say (2 numbers), and the rows (N) of its slope."""
    n = m.n
    for j in range(m.N):
        one[j] = two[j] = 0.0
    bar = min(int(where / l), n - 1)
    if kind == TILT:
        one[bar] = 1.0
        return x[bar], 0.0
    if kind == GYRO:
        one[n + bar] = 1.0
        return x[n + bar], 0.0
    if kind == TENSION:
        F = sqrt(x[m.F] * x[m.F] + x[m.F + 1] * x[m.F + 1])
        if F > 0.0:
            one[m.F], one[m.F + 1] = x[m.F] / F, x[m.F + 1] / F
        return F, 0.0
    north, down = p[NORTH], p[DOWN]
    if m.loads > 2:
        north, down = x[m.place], x[m.place + 1]
        one[m.place] = two[m.place + 1] = 1.0
    for i in range(bar + 1):
        part = l if i < bar else where - bar * l
        c, s = cos(x[i]), sin(x[i])
        north, down = north + part * c, down + part * s
        one[i], two[i] = -part * s, part * c
    return north, down


@kernel
def put(w, at, kind, where, one, two, cov):
    """Write a reading's record; cov: (variance, both, variance) of its numbers."""
    w[at + KIND], w[at + WHERE], w[at + VALUE], w[at + VALUE + 1] = kind, where, one, two
    w[at + ROOT] = sqrt(cov[0])
    w[at + ROOT + 1] = cov[1] / w[at + ROOT]
    w[at + ROOT + 2] = sqrt(max(cov[2] - w[at + ROOT + 1] * w[at + ROOT + 1], 1e-12 * cov[2]))
    w[at + STATUS], w[at + SQUARE] = USED, 0.0


@kernel
def refuse_where_no_line_is(p, m, w):
    """Refuse the markers that no line of this length has; whether there are any. A pivot at rest is a witness."""
    count, pivots, places = int(p[MARKERS]), 1 if m.loads == 2 else 0, tables_of(p)[1]
    for i in range(count):
        at, variance = m.records + i * READING, 0.0
        for k in range(3):
            variance += w[at + ROOT + k] * w[at + ROOT + k]
        bear_witness(w, m.rows + i * WITNESS, w[at + VALUE], w[at + VALUE + 1], p[places + i], variance, w[at + STATUS])
    bear_witness(w, m.rows + count * WITNESS, p[NORTH], p[DOWN], 0.0, 0.0, USED)
    if not refuse_impossible(w, m.rows, count, pivots, p[GATE], True):
        return False
    for i in range(count):
        w[m.records + i * READING + STATUS] = w[m.rows + i * WITNESS + TAKEN]
    return True


@kernel
def gather(p, m, l, u, x, w):
    """Write all readings' records, from the inputs; whether there are markers that cannot be there: refused ones."""
    count, tilts, gyros = int(p[MARKERS]), int(p[TILTS]), int(p[GYROS])
    at, places = m.records, tables_of(p)[1]
    takes = p[TAKES_COVARIANCE] > 0.0
    k = (8 if takes else 4) * count
    for i in range(count):
        w[at + STATUS] = MISSING
        if is_there(u, i, count):
            cov = spread(u, i, count, takes, p[MARKER_VARIANCE], p[CHAIN_VARIANCE])
            put(w, at, PLACE, p[places + i], u[3 * i], u[3 * i + 2], cov)
        at += READING
    impossible = refuse_where_no_line_is(p, m, w)
    if p[END_VARIANCE] > 0.0:
        w[at + STATUS] = MISSING
        if u[k + 3] > 0.0 and abs(u[k]) < FAR and abs(u[k + 2]) < FAR:
            put(w, at, PLACE, m.n * l, u[k], u[k + 2], (p[END_VARIANCE], 0.0, p[END_VARIANCE]))
        k, at = k + 4, at + READING
    if p[TENSION_VARIANCE] > 0.0:
        w[at + STATUS] = MISSING
        if u[k + 1] > 0.0 and abs(u[k]) < FAR:
            put(w, at, TENSION, m.n * l, u[k], 0.0, (p[TENSION_VARIANCE], 0.0, 1.0))
        k, at = k + 2, at + READING
    for i in range(tilts):
        w[at + STATUS] = MISSING
        if u[k + tilts + i] > 0.0 and abs(u[k + i]) < FAR:
            where = p[places + count + i]
            own = x[min(int(where / l), m.n - 1)]
            near = u[k + i] + 2.0 * pi * floor((own - u[k + i]) / (2.0 * pi) + 0.5)
            put(w, at, TILT, where, near, 0.0, (p[TILT_VARIANCE], 0.0, 1.0))
        at += READING
    k += 2 * tilts
    for i in range(gyros):
        w[at + STATUS] = MISSING
        if u[k + gyros + i] > 0.0 and abs(u[k + i]) < FAR:
            put(w, at, GYRO, p[places + count + tilts + i], u[k + i], 0.0, (p[GYRO_VARIANCE], 0.0, 1.0))
        at += READING
    return impossible


@kernel
def whiten(w, at, one, two, first, second):
    """Make rows and differences of a reading such that its noise is two independent numbers of variance 1."""
    a, b, c = w[at + ROOT], w[at + ROOT + 1], w[at + ROOT + 2]
    for j in range(len(one)):
        one[j] /= a
        two[j] = (two[j] - b * one[j]) / c
    first /= a
    return first, (second - b * first) / c


@kernel
def judge(p, m, l, gate, impossible, x, s, refusals, w, rows, by):
    """Write the squares of the readings' normalised innovations; refuse those above `gate`.

    Not where they are most, nor one that was refused BELIEVED_AFTER times in a row: then it is not that reading that is
    wrong. But while markers are `impossible` none is believed for that: it may be what they were taken for.
    refusals: (R).
    """
    seen = bad = 0
    for i in range(m.R):
        at = m.records + i * READING
        if w[at + STATUS] != USED:
            continue
        one, two, phi, psi = rows[2 * i], rows[2 * i + 1], by[2 * i], by[2 * i + 1]
        first, second = expect(p, m, l, int(w[at + KIND]), w[at + WHERE], x, one, two)
        first, second = whiten(w, at, one, two, w[at + VALUE] - first, w[at + VALUE + 1] - second)
        a, c, b = 1.0 + project(s, one, phi), 1.0, 0.0
        if w[at + KIND] == PLACE:
            c += project(s, two, psi)
            for j in range(m.N):
                b += phi[j] * psi[j]
        else:
            second = 0.0
        w[at + SQUARE] = (c * first * first - 2.0 * b * first * second + a * second * second) / (a * c - b * b)
        seen += 1
        if not w[at + SQUARE] <= gate:
            bad += 1
    for i in range(m.R):
        at = m.records + i * READING
        if w[at + STATUS] != USED:
            continue
        if w[at + SQUARE] <= gate or 2 * bad > seen:
            refusals[i] = 0.0
        elif impossible or refusals[i] < p[BELIEVED_AFTER]:
            refusals[i] += 0.0 if impossible else 1.0
            w[at + STATUS] = REFUSED


@kernel
def use(p, m, l, x, s, guess, base, w, one, two, by, y, out):
    """Use all readings about the state `guess`; x: before, then after. Returns number, NIS and density's logarithm."""
    count, nis, density = 0, 0.0, 0.0
    for j in range(m.N):
        base[j] = x[j]
    for i in range(m.R):
        at = m.records + i * READING
        if w[at + STATUS] != USED:
            continue
        first, second = expect(p, m, l, int(w[at + KIND]), w[at + WHERE], guess, one, two)
        first, second = whiten(w, at, one, two, w[at + VALUE] - first, w[at + VALUE + 1] - second)
        for k in range(2):
            if k == 1 and w[at + KIND] != PLACE:
                break
            row = one if k == 0 else two
            innovation = first if k == 0 else second
            for j in range(m.N):
                innovation -= row[j] * (x[j] - guess[j])
            normalised, log_v = correct(x, s, row, innovation, by)
            y[out + count] = normalised
            nis += normalised * normalised
            density += log_density(normalised, log_v, log(w[at + ROOT + 2 * k]))
            count += 1
    return count, nis, density


@kernel
def curvature(p, m, l, x, guess, w, one, two):
    """By how many deviations a reading expected at x differs at most from its tangent at `guess`."""
    worst = 0.0
    for i in range(m.R):
        at = m.records + i * READING
        if w[at + STATUS] != USED:
            continue
        kind = int(w[at + KIND])
        there_1, there_2 = expect(p, m, l, kind, w[at + WHERE], x, one, two)
        first, second = expect(p, m, l, kind, w[at + WHERE], guess, one, two)
        first, second = whiten(w, at, one, two, there_1 - first, there_2 - second)
        for j in range(m.N):
            first -= one[j] * (x[j] - guess[j])
            second -= two[j] * (x[j] - guess[j])
        worst = max(worst, abs(first))
        if kind == PLACE:
            worst = max(worst, abs(second))
    return worst


@kernel
def use_all(p, m, l, gate, impossible, x, s, refusals, w, y, out):
    """Use the readings by the iterated extended filter (Bell and Cathey 1993: Gauss-Newton); writes innovations.

    The innovations are those about the prediction, which alone are independent. Returns number, NIS, density's
    logarithm, and the times that measurements were taken. gate: square beyond which a reading is refused.
    """
    N, R = m.N, m.R
    rows, by = table(w, m.rows, 2 * R, N), table(w, m.rows + 2 * R * N, 2 * R, N)
    a = m.spare
    one, two, column, guess, base = (
        w[a : a + N],
        w[a + N : a + 2 * N],
        w[a + 2 * N : a + 3 * N],
        w[a + 3 * N : a + 4 * N],
        w[a + 4 * N : a + 5 * N],
    )
    judge(p, m, l, gate, impossible, x, s, refusals, w, rows, by)
    before = table(w, m.before, N, N)
    for i in range(N):
        guess[i] = x[i]
        for j in range(N):
            before[i, j] = s[i, j]
    for i in range(2 * R):
        y[out + i] = 0.0
    count, nis, density = use(p, m, l, x, s, guess, base, w, one, two, column, y, out)
    times = 1
    while times < int(p[ITERATIONS]) and curvature(p, m, l, x, guess, w, one, two) > CURVED:
        for i in range(N):
            guess[i], x[i] = x[i], base[i]
            for j in range(N):
                s[i, j] = before[i, j]
        use(p, m, l, x, s, guess, base, w, one, two, column, w, m.derived)
        times += 1
    return count, nis, density, times
