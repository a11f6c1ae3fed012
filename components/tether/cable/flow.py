"""The moving water along the line: its velocity and acceleration at the nodes, and the force of its acceleration."""

from components.compiled import kernel
from components.environment.current import LEVEL, current
from components.environment.waves import orbit
from components.tether.cable.line import DIR, SCRATCH, WATER, Q, R
from components.tether.cable.part import part


@kernel
def hear(line, u, w):
    """Keep the current that another component gives, as a table of levels behind the last node's water."""
    if not line.heard:
        return
    k = line.water + WATER * (line.n + 1)
    w[k] = line.table[line.heard_depths]
    for i in range(int(w[k])):
        level = k + 1 + LEVEL * i
        w[level] = line.table[line.heard_depths + 1 + i]
        for c in range(3):
            w[level + 1 + c] = u[line.heard + 3 * i + c]


@kernel
def sample(line, w, t, waves):
    """The water's motion where the nodes are, at the time t [s].

    Taken once a step where the nodes are predicted: their error there is of third order in the step, below the
    scheme's, so that the water need not be asked again in each iteration. waves: whether they are counted.
    """
    for i in range(line.n + 1):
        b, k = i * SCRATCH, line.water + WATER * i
        vn, ve, vd, an, ae, ad = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if waves and line.waves:
            vn, ve, vd, an, ae, ad = orbit(line.table, line.waves, w[b + Q], w[b + Q + 1], w[b + Q + 2], t)
        if line.current:
            cn, ce, cd = current(line.table, line.current, w[b + Q + 2])
            vn, ve, vd = vn + cn, ve + ce, vd + cd
        if line.heard:
            cn, ce, cd = current(w, line.water + WATER * (line.n + 1), w[b + Q + 2])
            vn, ve, vd = vn + cn, ve + ce, vd + cd
        w[k], w[k + 1], w[k + 2] = vn, ve, vd
        w[k + 3], w[k + 4], w[k + 5] = an, ae, ad


@kernel
def pushed(s, tx, ty, tz, ax, ay, az):
    """Force (3) on half a segment in water that accelerates by a: Froude-Krylov's and that of the added mass.

    rho V (1 + Ca) a, across and along: Morison et al. 1950, with the node's own acceleration in the balance.
    """
    m = s.displaced + s.added_n
    d = (s.added_t - s.added_n) * (tx * ax + ty * ay + tz * az)
    return m * ax + d * tx, m * ay + d * ty, m * az + d * tz


@kernel
def push(line, w):
    """Add to R the force of the water's acceleration, along the tangents assembled last."""
    for i in range(line.n):
        b, k = i * SCRATCH, line.water + WATER * i
        s = part(line, i)
        for j in range(2):
            o, m = b + j * SCRATCH, k + j * WATER
            fx, fy, fz = pushed(s, w[b + DIR], w[b + DIR + 1], w[b + DIR + 2], w[m + 3], w[m + 4], w[m + 5])
            w[o + R] += fx
            w[o + R + 1] += fy
            w[o + R + 2] += fz
