"""Where a line is made fast on a body that yaws: the point's motion, and the line's force on the body.

The point is at s in the body frame, and may move there, s(t), as a hull does that heaves, rolls and pitches in waves.
"""

from components.compiled import kernel
from components.vessel.mass.translation import reach
from components.vessel.yawing import COS, FREE, SIN, WIDE, R, eliminate

LAW = 15  # of a force law: force (3), acceleration (3), mass (3, 3)
OFFSET = 9  # of a point: s (3), s' (3), s'' (3)


@kernel
def turned(s, r, alpha):
    """Acceleration of the point against the reference point, in the body frame (2).

    s'' + 2 omega x s' + omega x (omega x s) + alpha x s.
    """
    return s[6] - 2.0 * r * s[4] - r * r * s[0] - alpha * s[1], s[7] + 2.0 * r * s[3] - r * r * s[1] + alpha * s[0]


@kernel
def follow(eta, rate, acc, m, s, y):
    """Write the point's position, velocity and acceleration (9), NED; m: the motion that was settled."""
    c, sn, r = m[COS], m[SIN], rate[3]
    ahead, across = turned(s, r, acc[3])
    speed, drift = s[3] - r * s[1], s[4] + r * s[0]
    y[0] = eta[0] + c * s[0] - sn * s[1]
    y[1] = eta[1] + sn * s[0] + c * s[1]
    y[2] = eta[2] + s[2]
    y[3] = rate[0] + c * speed - sn * drift
    y[4] = rate[1] + sn * speed + c * drift
    y[5] = rate[2] + s[5]
    y[6] = acc[0] + c * ahead - sn * across
    y[7] = acc[1] + sn * ahead + c * across
    y[8] = acc[2] + s[8]


@kernel
def carry(north, east, down, m, s, f):
    """Take a force (3), NED, at the point out of the balance f (4)."""
    ahead, across = m[COS] * north + m[SIN] * east, m[COS] * east - m[SIN] * north
    f[0] -= ahead
    f[1] -= across
    f[2] -= down
    f[3] -= s[0] * across - s[1] * ahead


@kernel
def yields(acc, m, s, h, a):
    """Set a (3, FREE) to the slope of the point's acceleration, NED, to the body's accelerations (4)."""
    q_acc, v_acc = reach(h)
    c, sn, r = m[COS], m[SIN], m[R]
    ahead, across = turned(s, r, acc[3])
    along = -s[1] - v_acc * (2.0 * s[4] + 2.0 * r * s[0]) - q_acc * across
    beside = s[0] + v_acc * (2.0 * s[3] - 2.0 * r * s[1]) + q_acc * ahead
    for i in range(3 * FREE):
        a[i] = 0.0
    a[0] = a[FREE + 1] = a[2 * FREE + 2] = 1.0
    a[3], a[FREE + 3] = c * along - sn * beside, sn * along + c * beside


@kernel
def follow_law(law, acc, m, s, h, a, f, jac):
    """Take the line's force F - G (point's acceleration - reference) out of the balance f and add to its slope jac.

    law: (15); a: (3, FREE) scratch.
    """
    q_acc, _ = reach(h)
    c, sn = m[COS], m[SIN]
    yields(acc, m, s, h, a)
    ahead, across = turned(s, m[R], acc[3])
    d0 = acc[0] + c * ahead - sn * across - law[3]
    d1 = acc[1] + sn * ahead + c * across - law[4]
    d2 = acc[2] + s[8] - law[5]
    north = law[0] - law[6] * d0 - law[7] * d1 - law[8] * d2
    east = law[1] - law[9] * d0 - law[10] * d1 - law[11] * d2
    down = law[2] - law[12] * d0 - law[13] * d1 - law[14] * d2
    carry(north, east, down, m, s, f)
    forward, side = c * north + sn * east, c * east - sn * north
    for j in range(FREE):
        g0 = law[6] * a[j] + law[7] * a[FREE + j] + law[8] * a[2 * FREE + j]
        g1 = law[9] * a[j] + law[10] * a[FREE + j] + law[11] * a[2 * FREE + j]
        g2 = law[12] * a[j] + law[13] * a[FREE + j] + law[14] * a[2 * FREE + j]
        x, y = c * g0 + sn * g1, c * g1 - sn * g0
        if j == 3:
            x, y = x - q_acc * side, y + q_acc * forward  # the force turns against the body
        jac[j] += x
        jac[WIDE + j] += y
        jac[2 * WIDE + j] += g2
        jac[3 * WIDE + j] += s[0] * y - s[1] * x


@kernel
def write_accelerance(jac, acc, m, s, h, is_free_to_heave, a, y):
    """Write the point's accelerance (3, 3), NED, to y; jac: (4, WIDE), the slope of the balance without lines.

    The part that is not symmetric, by drag and turning, is left out: it is of the order of h times the rest.
    """
    c, sn = m[COS], m[SIN]
    for j in range(3):
        north, east = 1.0 if j == 0 else 0.0, 1.0 if j == 1 else 0.0
        x, z = c * north + sn * east, c * east - sn * north
        jac[FREE + j], jac[WIDE + FREE + j] = x, z
        jac[2 * WIDE + FREE + j] = 1.0 if j == 2 and is_free_to_heave else 0.0
        jac[3 * WIDE + FREE + j] = s[0] * z - s[1] * x
    eliminate(jac, 3)
    yields(acc, m, s, h, a)
    for i in range(3):
        for j in range(3):
            y[3 * i + j] = 0.0
            for n in range(FREE):
                row = WIDE * n + FREE
                y[3 * i + j] += 0.5 * (a[FREE * i + n] * jac[row + j] + a[FREE * j + n] * jac[row + i])
