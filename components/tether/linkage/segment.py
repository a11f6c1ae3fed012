"""A segment in its place: position and rates of its nodes, its load, and its impedance against shifts of the nodes."""

from components.compiled import kernel
from components.tether.cable.seabed import support
from components.tether.linkage.chain import AN, HN, RN, SCRATCH, STATE, VN, Q, R, U, V
from components.tether.linkage.drag import quadratic

# Part of a segment's own impedance against turning that compression may take away, so that the matrix stays positive.
PUSHED = 0.9


@kernel
def place_node(chain, scheme, x, w, i, rx, ry):
    """Write position, velocity and acceleration of node i; its velocity (x, y)."""
    a, k = i * SCRATCH, i * STATE
    w[a + RN], w[a + RN + 1] = rx, ry
    vx = scheme.c * (rx - x[k + R]) + scheme.k_u * x[k + U]
    vy = scheme.c * (ry - x[k + R + 1]) + scheme.k_u * x[k + U + 1]
    w[a + VN], w[a + VN + 1] = vx, vy
    if chain.mass > 0.0:
        w[a + AN] = scheme.c_a * (vx - x[k + V]) + scheme.k_q * x[k + Q]
        w[a + AN + 1] = scheme.c_a * (vy - x[k + V + 1]) + scheme.k_q * x[k + Q + 1]
    return vx, vy


@kernel
def rest_on_bed(chain, scheme, w, at):
    """The bed's upward force [N] on half a segment at the node whose record begins at `at`, and its impedance [N/m]."""
    sunk = w[at + RN + 1] - chain.bed.bed_depth
    if sunk <= 0.0:
        return 0.0, 0.0
    force, slope, damping = support(sunk, w[at + VN + 1], chain.bed)
    return 0.5 * chain.l0 * force, 0.5 * chain.l0 * (slope + scheme.c * damping)


@kernel
def load_segment(chain, scheme, w, i, tx, ty, over_l0):
    """Load of segment i with direction t: sum along t, both nodes' across; impedances d_t and across aa, ab, bb."""
    a = i * SCRATCH
    b = a + SCRATCH
    l0 = chain.l0
    v_ta, v_tb = tx * w[a + VN] + ty * w[a + VN + 1], tx * w[b + VN] + ty * w[b + VN + 1]
    v_na, v_nb = tx * w[a + VN + 1] - ty * w[a + VN], tx * w[b + VN + 1] - ty * w[b + VN]
    along, across = 0.5 * chain.c_V * l0, chain.c_S * l0 / 6.0
    R_t, R_n, R_nb = -along * (v_ta + v_tb), -3.0 * across * (v_na + v_nb), -across * (v_na + 2.0 * v_nb)
    R_tb = 0.5 * R_t
    d_t, ab = 2.0 * along * scheme.c, across * scheme.c
    aa = bb = 2.0 * ab
    if chain.k_S > 0.0 or chain.k_V > 0.0:
        Q_t, Q_n, Q_nb, q_t, q_aa, q_ab, q_bb = quadratic(chain, v_ta, v_tb, v_na, v_nb)
        R_t, R_n, R_nb, R_tb = R_t + Q_t, R_n + Q_n, R_nb + Q_nb, R_tb + 0.5 * Q_t
        d_t, aa, ab, bb = d_t + scheme.c * q_t, aa + scheme.c * q_aa, ab + scheme.c * q_ab, bb + scheme.c * q_bb
    if chain.mass > 0.0:
        m = chain.mass / 6.0
        a_ta, a_tb = tx * w[a + AN] + ty * w[a + AN + 1], tx * w[b + AN] + ty * w[b + AN + 1]
        a_na, a_nb = tx * w[a + AN + 1] - ty * w[a + AN], tx * w[b + AN + 1] - ty * w[b + AN]
        R_t, R_tb = R_t - 3.0 * m * (a_ta + a_tb), R_tb - m * (a_ta + 2.0 * a_tb)
        R_n, R_nb = R_n - 3.0 * m * (a_na + a_nb), R_nb - m * (a_na + 2.0 * a_nb)
        m *= scheme.c * scheme.c_a
        d_t, aa, ab, bb = d_t + 6.0 * m, aa + 2.0 * m, ab + m, bb + 2.0 * m
    if chain.weight != 0.0:
        R_t, R_tb = R_t + chain.weight * ty, R_tb + 0.5 * chain.weight * ty
        R_n, R_nb = R_n + chain.weight * tx, R_nb + 0.5 * chain.weight * tx
    if chain.bed.bed_stiffness > 0.0:
        B_a, s_a = rest_on_bed(chain, scheme, w, a)
        B_b, s_b = rest_on_bed(chain, scheme, w, b)
        R_t, R_tb = R_t - (B_a + B_b) * ty, R_tb - B_b * ty
        R_n, R_nb = R_n - (B_a + B_b) * tx, R_nb - B_b * tx
        # An upright stiffness has a part between along and across; both are raised by it instead (Gershgorin).
        both = abs(tx) + abs(ty)
        d_t, aa, bb = d_t + (s_a + s_b) * abs(ty) * both, aa + s_a * abs(tx) * both, bb + s_b * abs(tx) * both
    # Against turning by the nodes' shifts; compression cannot take away all of the segment's own.
    g = (R_tb - tx * w[b + HN] - ty * w[b + HN + 1]) * over_l0
    if g < 0.0:
        g = max(g, -PUSHED * (aa * bb - ab * ab) / (aa + 2.0 * ab + bb))
    return R_t, R_n - R_nb, R_nb, d_t, aa + g, ab - g, bb + g
