"""What follows from a state: shape, moments, and tension along the line, from the forces that accelerate its bars."""

from math import sqrt

from components.compiled import kernel
from components.estimator.best.layout import DOWN, NORTH, tables_of
from components.estimator.best.prediction import solve
from components.matrices import table
from components.tether.linkage.lagrangian import FIRST, SECOND, bars_at, evaluate, slopes_at


@kernel
def derive(p, m, x, w, d):
    """Write nodes beyond the pivot (2 n), moments (n), tensions (n) and the end's tension into d (4 n + 1)."""
    n = m.n
    bars, out = bars_at(p, tables_of(p)[2]), slopes_at(w, m.slopes, n)
    l, X = bars.l, table(w, m.columns, n, 3 * n + 6)
    alpha, v, load = w[m.spare : m.spare + n], w[m.spare + n : m.spare + n + 2], w[m.spare + n + 2 : m.spare + n + 6]
    north, down = p[NORTH], p[DOWN]
    v[0] = v[1] = load[2] = load[3] = 0.0
    if m.loads > 2:
        north, down, v[0], v[1] = x[m.place], x[m.place + 1], x[m.speed], x[m.speed + 1]
        load[2], load[3] = x[m.F + 2], x[m.F + 3]
    load[0], load[1] = x[m.F], x[m.F + 1]
    for i in range(n):
        alpha[i] = 0.0
    evaluate(bars, x[:n], x[n : 2 * n], alpha, v, load, out)
    for i in range(n):
        X[i, 0] = -out.r[i]
    solve(out.M, X, 1)
    v_x, v_z, a_x, a_z = v[0], v[1], load[2], load[3]
    for i in range(n):
        c, s, omega = out.cos[i], out.sin[i], x[n + i]
        north, down = north + l * c, down + l * s
        d[2 * i], d[2 * i + 1] = north, down
        d[2 * n + i] = bars.k[i] * (x[i] - (x[i - 1] if i > 0 else bars.clamp))
        # Force that the bar and the water need, kept until the way back: mass times acceleration, less weight and drag.
        across, along = X[i, 0], -omega * omega
        g_x, g_z = a_x + bars.c * (along * c - across * s), a_z + bars.c * (along * s + across * c)
        drag, v_n = 0.0, c * v_z - s * v_x
        for k in range(2):
            u = v_n + (FIRST if k == 0 else SECOND) * l * omega
            drag += 0.5 * l * (bars.c_S + bars.k_S * abs(u)) * u
        X[i, 1], X[i, 2] = bars.mass * g_x - drag * s, bars.mass * g_z - bars.weight + drag * c
        a_x, a_z = a_x + l * (along * c - across * s), a_z + l * (along * s + across * c)
        v_x, v_z = v_x - l * s * omega, v_z + l * c * omega
    f_x, f_z = -load[0], -load[1]
    d[4 * n] = sqrt(f_x * f_x + f_z * f_z)
    for i in range(n - 1, -1, -1):
        last = out.cos[i] * f_x + out.sin[i] * f_z
        f_x, f_z = f_x + X[i, 1], f_z + X[i, 2]
        d[3 * n + i] = -0.5 * (last + out.cos[i] * f_x + out.sin[i] * f_z)


@kernel
def deviations(p, m, x, s, w, d, ahead, behind, other):
    """Write d of the state, and behind its 4 n + 1 numbers their deviations, by central differences along the root.

    d: (8 n + 2); ahead, behind: (4 n + 1); other: (N). The divided differences of second order hold the curvature too
    (Norgaard, Poulsen and Ravn 2000).
    """
    size = 4 * m.n + 1
    derive(p, m, x, w, d)
    for k in range(size):
        d[size + k] = 0.0
    for j in range(m.N):
        for i in range(m.N):
            other[i] = x[i] + s[i, j]
        derive(p, m, other, w, ahead)
        for i in range(m.N):
            other[i] = x[i] - s[i, j]
        derive(p, m, other, w, behind)
        for k in range(size):
            half = 0.5 * (ahead[k] - behind[k])
            d[size + k] += half * half
    for k in range(size):
        d[size + k] = sqrt(d[size + k])
