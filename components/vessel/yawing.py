"""A body that translates and turns about the vertical: its motion through the water, its inertia, and their slopes.

Four degrees of freedom: north, east, down and heading in the world; surge, sway, heave and yaw in the body. The
balance is taken at a step's end by the scheme of a bonded line, see mass/translation.py, and solved for the
accelerations there.
"""

from math import cos, sin

from components.compiled import kernel
from components.vessel.mass.translation import predict, reach

FREE = 4
# A trial motion: velocity through the water and its rate in the body frame, then cosine and sine of the heading.
U, V, W, R, DU, DV, DW, DR, COS, SIN = range(10)
TRIAL = 10
# Mass in water, added mass included: surge, sway, heave [kg], yaw [kg m^2], and what couples sway and yaw [kg m].
SURGE, SWAY, HEAVE, YAW, SWAY_YAW = range(5)
MASSES = 5
# Matrices are flat: a slope to the accelerations has rows of the accelerations and of three right sides.
WIDE = FREE + 3
ITERATIONS = 25
# Accelerations [m/s^2, rad/s^2] are solved for to this part and this much; a ship's are 1e-4 to 1.
RELATIVE, ABSOLUTE = 1e-11, 1e-13
# A balance whose last change is this many times greater than that is not to be believed.
UNSOLVED = 1e3


@kernel
def advance(eta, rate, algorithmic, h):
    """Positions (4) and rates (4) at the end of the step but for the accelerations there."""
    for i in range(FREE):
        eta[i], rate[i] = predict(eta[i], rate[i], algorithmic[i], h)


@kernel
def settle(eta, rate, acc, algorithmic, h):
    """The same with the accelerations (4) found, and the scheme's algorithmic ones."""
    q_acc, v_acc = reach(h)
    for i in range(FREE):
        eta[i] += q_acc * acc[i]
        rate[i] += v_acc * acc[i]
        algorithmic[i] = 0.5 * (acc[i] + algorithmic[i])


@kernel
def relate(eta, rate, acc, current, h, m):
    """Fill the trial motion m that the accelerations acc lead to; current: (3) of the water [m/s], NED.

    The current's own rate is left out: the water moves steadily (Fossen 2011, section 8.3).
    """
    q_acc, v_acc = reach(h)
    psi = eta[3] + q_acc * acc[3]
    c, s = cos(psi), sin(psi)
    north = rate[0] + v_acc * acc[0] - current[0]
    east = rate[1] + v_acc * acc[1] - current[1]
    r = rate[3] + v_acc * acc[3]
    u, v = c * north + s * east, c * east - s * north
    m[U], m[V], m[W], m[R] = u, v, rate[2] + v_acc * acc[2] - current[2], r
    m[DU], m[DV] = c * acc[0] + s * acc[1] + r * v, c * acc[1] - s * acc[0] - r * u
    m[DW], m[DR], m[COS], m[SIN] = acc[2], acc[3], c, s


@kernel
def resist_acceleration(mass, m, f, g):
    """Set f (4) to M nu' + C(nu) nu in the body frame and g (4, FREE) to the slope of C(nu) nu to nu.

    Kirchhoff 1869: momenta p = M nu turn with the body, so that X = p_u' - r p_v, Y = p_v' + r p_u and
    N = p_r' + u p_v - v p_u, which is C(nu) nu of Fossen 2011, eqs. 6.43 and 6.53, for the sum of both masses.
    """
    u, v, r = m[U], m[V], m[R]
    m11, m22, m26 = mass[SURGE], mass[SWAY], mass[SWAY_YAW]
    pu, pv = m11 * u, m22 * v + m26 * r
    f[0] = m11 * m[DU] - r * pv
    f[1] = m22 * m[DV] + m26 * m[DR] + r * pu
    f[2] = mass[HEAVE] * m[DW]
    f[3] = m26 * m[DV] + mass[YAW] * m[DR] + u * pv - v * pu
    for i in range(FREE * FREE):
        g[i] = 0.0
    g[1], g[3] = -r * m22, -pv - r * m26
    g[FREE], g[FREE + 3] = r * m11, pu
    g[3 * FREE], g[3 * FREE + 1], g[3 * FREE + 3] = pv - v * m11, u * m22 - pu, u * m26


@kernel
def slope(mass, m, g, h, jac):
    """Set jac (4, WIDE) to the slope of the balance in the body frame to the accelerations, g being that to nu."""
    q_acc, v_acc = reach(h)
    c, s, u, v, r = m[COS], m[SIN], m[U], m[V], m[R]
    ahead, across = m[DU] - r * v, m[DV] + r * u  # the acceleration's parts along the body
    for j in range(FREE):
        du = dv = dw = dr = to_ahead = to_across = dd = da = 0.0
        if j == 0:
            du, dv, to_ahead, to_across = v_acc * c, -v_acc * s, c, -s
        elif j == 1:
            du, dv, to_ahead, to_across = v_acc * s, v_acc * c, s, c
        elif j == 2:
            dw, dd = v_acc, 1.0
        else:
            du, dv, dr, da = q_acc * v, -q_acc * u, v_acc, 1.0
            to_ahead, to_across = q_acc * across, -q_acc * ahead
        ddu = to_ahead + r * dv + v * dr
        ddv = to_across - r * du - u * dr
        jac[j] = mass[SURGE] * ddu
        jac[WIDE + j] = mass[SWAY] * ddv + mass[SWAY_YAW] * da
        jac[2 * WIDE + j] = mass[HEAVE] * dd
        jac[3 * WIDE + j] = mass[SWAY_YAW] * ddv + mass[YAW] * da
        for i in range(FREE):
            k = FREE * i
            jac[WIDE * i + j] += g[k] * du + g[k + 1] * dv + g[k + 2] * dw + g[k + 3] * dr


@kernel
def eliminate(m, columns):
    """Gauss-Jordan with partial pivoting on m (4, WIDE): its first `columns` right sides become the solutions."""
    n = FREE
    for j in range(n):
        pivot = j
        for i in range(j + 1, n):
            if abs(m[WIDE * i + j]) > abs(m[WIDE * pivot + j]):
                pivot = i
        for c in range(n + columns):
            m[WIDE * j + c], m[WIDE * pivot + c] = m[WIDE * pivot + c], m[WIDE * j + c]
        scale = 1.0 / m[WIDE * j + j]
        for c in range(n + columns):
            m[WIDE * j + c] *= scale
        for i in range(n):
            factor = m[WIDE * i + j]
            if i != j:
                for c in range(n + columns):
                    m[WIDE * i + c] -= factor * m[WIDE * j + c]


@kernel
def correct(jac, f, acc):
    """One Newton step of the accelerations for the balance f (4) with its slope jac (4, WIDE); the largest excess.

    At most 1: all changes were within RELATIVE and ABSOLUTE, and the balance is solved.
    """
    for i in range(FREE):
        jac[WIDE * i + FREE] = f[i]
    eliminate(jac, 1)
    excess = 0.0
    for i in range(FREE):
        change = jac[WIDE * i + FREE]
        acc[i] -= change
        excess = max(excess, abs(change) / (ABSOLUTE + RELATIVE * abs(acc[i])))
    return excess
