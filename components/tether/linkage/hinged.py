"""The sweep of a chain with free hinges and some impedance along it, in less than half of the general one's arithmetic.

Each segment is a two-port: the forces h_i and -h_{i+1} on its nodes shift them, in the segment's axes, by

    dr_a = e_a + E_a h_i - F h_{i+1},   dr_b = e_b + F h_i - E_b h_{i+1}

with diagonal E_a, E_b and F, the inverse of its impedance. With dr = s - S h of what lies before, M = S + E_a,

    h_i = M^-1 (s - e_a + F h_{i+1}),   S_{i+1} = E_b - F M^-1 F,   s_{i+1} = e_b + F M^-1 (s - e_a).
"""

from components.compiled import kernel
from components.tether.linkage.chain import DELTA, DRIVEN, HN, PULLED, RN, SCRATCH, STATE, TN, T
from components.tether.linkage.rotation import rotate
from components.tether.linkage.segment import PUSHED, load_segment, place_node
from components.tether.linkage.sweep import keep_law


@kernel
def sweep_hinged(chain, scheme, x, w, pull_x, pull_y):
    """As sweep.sweep."""
    over_l0 = 1.0 / chain.l0
    S_tt = S_tn = S_nn = s_t = s_n = 0.0
    before_x, before_y = 1.0, 0.0
    rx, ry = w[RN], w[RN + 1]
    ux, uy = place_node(chain, scheme, x, w, 0, rx, ry)
    # Linear drag alone has the same impedance for all segments, but for the tension's.
    plain = chain.k_S == chain.k_V == chain.mass == chain.weight == chain.bed.bed_stiffness == 0.0
    along, across = 0.5 * chain.c_V * chain.l0, chain.c_S * chain.l0 / 6.0
    E_plain = 1.0 / (2.0 * along * scheme.c) if plain else 0.0
    ab_plain = across * scheme.c
    det_plain, least = 3.0 * ab_plain * ab_plain, -0.5 * PUSHED * ab_plain
    for i in range(chain.n):
        a, k = i * SCRATCH, i * STATE
        tx, ty = rotate(x[k + T], x[k + T + 1], w[a + DELTA])
        w[a + TN], w[a + TN + 1] = tx, ty
        rx, ry = rx + chain.l0 * tx, ry + chain.l0 * ty
        vx, vy = place_node(chain, scheme, x, w, i + 1, rx, ry)
        if plain:
            n_a, n_b, h = tx * uy - ty * ux, tx * vy - ty * vx, a + SCRATCH + HN
            R_t = -along * (tx * (ux + vx) + ty * (uy + vy))
            R_na, R_nb = -across * (2.0 * n_a + n_b), -across * (n_a + 2.0 * n_b)
            g = max((0.5 * R_t - tx * w[h] - ty * w[h + 1]) * over_l0, least)
            over = 1.0 / (det_plain + 6.0 * ab_plain * g)
            E_a, F, E_t = (2.0 * ab_plain + g) * over, (g - ab_plain) * over, E_plain
            E_b = E_a
        else:
            R_t, R_na, R_nb, d_t, aa, ab, bb = load_segment(chain, scheme, w, i, tx, ty, over_l0)
            det = aa * bb - ab * ab
            inverse = 1.0 / (det * d_t)
            E_t, over = det * inverse, d_t * inverse
            E_a, E_b, F = bb * over, aa * over, -ab * over
        ux, uy = vx, vy
        e_t, e_a, e_b = E_t * R_t, E_a * R_na + F * R_nb, F * R_na + E_b * R_nb
        if i == 0 and chain.end_a != DRIVEN:
            B_tt = B_tn = B_nn = h_t = h_n = 0.0
            if chain.end_a == PULLED:
                h_t, h_n = tx * pull_x + ty * pull_y, tx * pull_y - ty * pull_x
        else:
            # What lies before, in this segment's axes.
            co, si = before_x * tx + before_y * ty, before_x * ty - before_y * tx
            cc, cs, ss = co * co, co * si, si * si
            M_tt = cc * S_tt + 2.0 * cs * S_tn + ss * S_nn + E_t
            M_tn = cs * (S_nn - S_tt) + (cc - ss) * S_tn
            M_nn = ss * S_tt - 2.0 * cs * S_tn + cc * S_nn + E_a
            s_t, s_n = co * s_t + si * s_n - e_t, co * s_n - si * s_t - e_a
            over = 1.0 / (M_tt * M_nn - M_tn * M_tn)
            B_tt, B_tn, B_nn = M_nn * over, -M_tn * over, M_tt * over
            h_t, h_n = B_tt * s_t + B_tn * s_n, B_tn * s_t + B_nn * s_n
        before_x, before_y = tx, ty
        A_tt, A_tn, A_nt, A_nn = B_tt * E_t, B_tn * F, B_tn * E_t, B_nn * F
        turn_a, turn_b = (F - E_a) * over_l0, (F - E_b) * over_l0
        beta_0 = (e_b - e_a) * over_l0 + turn_a * h_n
        keep_law(w, a, A_tt, A_tn, A_nt, A_nn, h_t, h_n, turn_a * A_nt, turn_a * A_nn + turn_b, beta_0)
        S_tt, S_tn, S_nn = E_t - E_t * A_tt, -E_t * A_tn, E_b - F * A_nn
        s_t, s_n = e_t + E_t * h_t, e_b + F * h_n
    tx, ty = before_x, before_y
    txx, txy, tyy = tx * tx, tx * ty, ty * ty
    Sxx = txx * S_tt - 2.0 * txy * S_tn + tyy * S_nn
    Sxy = txy * (S_tt - S_nn) + (txx - tyy) * S_tn
    return Sxx, Sxy, S_tt + S_nn - Sxx, tx * s_t - ty * s_n, ty * s_t + tx * s_n
