"""Newton's correction of the chain in O(n): a sweep of compliances from end a to end b, and the way back.

All that lies before node i answers the joint's force h_i by a shift of the node, dr_i = s_i - S_i h_i with S symmetric
and 2x2 (the articulated-body recursion in its compliant form, which begins with S = 0 at a driven end). With the
segment's load (t, n), impedance diag(d_t, d_n) against shifting, d between shifting and turning, and e against turning,

    S' = (S^-1 + diag(d_t, d_n))^-1,   b = l0 n - d S' n,   w = e - d^2 S'_nn,   S_{i+1} = S' + b b' / w.

This holds for every chain; where hinges are free and something resists along the line, hinged.py is faster. A joint's
spring makes the angle before it part of the answer: kappa is the spring in series with that angle's own
compliance, g what the force turns it. On the way back h_i = A h_{i+1} + alpha, and the angle's correction is
beta h_{i+1} + beta_0: shifts are not carried back, which would amplify rounding.

Velocities are v = c (r - r_k) + k u, so that dv = c dr. Of what the directions' change does to the load only the
tension's stiffness is in the matrix, which so is symmetric and positive; a correction leaves some percent of itself.
"""

from components.compiled import kernel
from components.tether.linkage.chain import (
    ALPHA,
    BETA,
    BETA_0,
    DELTA,
    DRIVEN,
    HN,
    KAPPA,
    LAST,
    OVER,
    PRELOAD,
    PULLED,
    RN,
    SCRATCH,
    STATE,
    THETA,
    TN,
    A,
    G,
    K,
    T,
)
from components.tether.linkage.rotation import rotate
from components.tether.linkage.segment import load_segment, place_node

# Part of a free end's impedance across it that it has along it at least.
LEAST_ALONG = 1e-9
# Ratio of the closure's two compliances below which the ends' distance says nothing of the force between them.
RANK = 1e-12


@kernel
def keep_law(w, a, A_tt, A_tn, A_nt, A_nn, alpha_t, alpha_n, beta_t, beta_n, beta_0):
    """Write the laws of joint force and correction, in the segment's axes."""
    w[a + A], w[a + A + 1], w[a + A + 2], w[a + A + 3] = A_tt, A_tn, A_nt, A_nn
    w[a + ALPHA], w[a + ALPHA + 1] = alpha_t, alpha_n
    w[a + BETA], w[a + BETA + 1], w[a + BETA_0] = beta_t, beta_n, beta_0


@kernel
def sweep(chain, scheme, x, w, pull_x, pull_y):
    """Place the chain by the angles' increments and write the law of each joint.

    pull_x, pull_y: force on a pulled end a [N]. Returns the compliance (xx, xy, yy) and the shift (x, y) of end b
    without a force there.
    """
    l0 = chain.l0
    over_l0 = 1.0 / l0
    S_tt = S_tn = S_nn = s_t = s_n = 0.0
    g_t = g_n = s_theta = S_theta = kappa = preload = q_t = 0.0
    before_x, before_y = 1.0, 0.0
    rx, ry = w[RN], w[RN + 1]
    place_node(chain, scheme, x, w, 0, rx, ry)
    for i in range(chain.n):
        a, k = i * SCRATCH, i * STATE
        tx, ty = rotate(x[k + T], x[k + T + 1], w[a + DELTA])
        w[a + TN], w[a + TN + 1] = tx, ty
        rx, ry = rx + l0 * tx, ry + l0 * ty
        place_node(chain, scheme, x, w, i + 1, rx, ry)
        R_t, R_na, R_nb, d_t, aa, ab, bb = load_segment(chain, scheme, w, i, tx, ty, over_l0)
        R_n, d_n, d, e = R_na + R_nb, aa + 2.0 * ab + bb, l0 * (ab + bb), l0 * l0 * bb
        # What lies before, in this segment's axes.
        co, si = before_x * tx + before_y * ty, before_x * ty - before_y * tx
        before_x, before_y = tx, ty
        s_t, s_n = co * s_t + si * s_n, co * s_n - si * s_t
        det = S_tt * S_nn - S_tn * S_tn
        cc, cs, ss = co * co, co * si, si * si
        S_tt, S_tn, S_nn = (
            cc * S_tt + 2.0 * cs * S_tn + ss * S_nn,
            cs * (S_nn - S_tt) + (cc - ss) * S_tn,
            ss * S_tt - 2.0 * cs * S_tn + cc * S_nn,
        )
        q_n = d
        if chain.spring > 0.0 and i > 0:
            kappa = chain.spring / (1.0 + chain.spring * S_theta)
            g_t, g_n = co * g_t + si * g_n, co * g_n - si * g_t
            psi = x[k + THETA] + w[a + DELTA] - x[k - STATE + THETA] - w[a - SCRATCH + DELTA]
            preload = kappa * (psi - s_theta)
            s_t, s_n = s_t + preload * g_t, s_n + preload * g_n
            S_tt, S_tn, S_nn = S_tt - kappa * g_t * g_t, S_tn - kappa * g_t * g_n, S_nn - kappa * g_n * g_n
            det = S_tt * S_nn - S_tn * S_tn
            q_t, q_n = kappa * d_t * g_t, d + kappa * d_n * g_n
            e += kappa * (1.0 + d * g_n + q_t * g_t + q_n * g_n)
        # S' = N / den and w = W / den, both by one division.
        N_tt, N_nn = S_tt + det * d_n, S_nn + det * d_t
        den = 1.0 + S_tt * d_t + N_nn * d_n
        if i == 0 and chain.end_a != DRIVEN:
            d_t = max(d_t, LEAST_ALONG * d_n)
            N_tt, S_tn, N_nn, den = 1.0 / d_t, 0.0, 1.0 / d_n, 1.0
        W = e * den - q_n * q_n * N_nn
        if chain.spring > 0.0:
            W -= q_t * (q_t * N_tt + 2.0 * q_n * S_tn)
        inverse = 1.0 / (den * W)
        o, over = W * inverse, den * den * inverse
        S_tt, S_tn, S_nn = N_tt * o, S_tn * o, N_nn * o
        if i == 0 and chain.end_a != DRIVEN:
            s_t = s_n = 0.0
            if chain.end_a == PULLED:
                s_t, s_n = (tx * pull_x + ty * pull_y) * S_tt, (tx * pull_y - ty * pull_x) * S_nn
        else:
            s_t, s_n = s_t - S_tt * d_t * s_t - S_tn * d_n * s_n, s_n - S_tn * d_t * s_t - S_nn * d_n * s_n
        c_t, c_n = -S_tn * q_n, -S_nn * q_n
        if chain.spring > 0.0:
            c_t, c_n = c_t + kappa * g_t - S_tt * q_t, c_n + kappa * g_n - S_tn * q_t
        b_t, b_n = c_t, l0 + c_n
        zeta = -R_na * l0 - preload - q_t * s_t - q_n * s_n
        beta_t, beta_n, beta_0 = -b_t * over, -b_n * over, (b_t * R_t + b_n * R_n + zeta) * over
        # h = diag(d_t, d_n) (s' + S' f + c turn) + d n turn - f, f being the load less the next joint's force.
        k_t, k_n = d_t * c_t, d_n * c_n + d
        B_tt, B_tn, B_nt, B_nn = 1.0 - d_t * S_tt, -d_t * S_tn, -d_n * S_tn, 1.0 - d_n * S_nn
        keep_law(
            w, a,
            B_tt + k_t * beta_t, B_tn + k_t * beta_n, B_nt + k_n * beta_t, B_nn + k_n * beta_n,
            d_t * s_t + k_t * beta_0 - B_tt * R_t - B_tn * R_n,
            d_n * s_n + k_n * beta_0 - B_nt * R_t - B_nn * R_n,
            beta_t, beta_n, beta_0,
        )  # fmt: skip
        S_tt, S_tn, S_nn = S_tt + b_t * b_t * over, S_tn + b_t * b_n * over, S_nn + b_n * b_n * over
        s_t, s_n = s_t + S_tt * R_t + S_tn * R_n + b_t * zeta * over, s_n + S_tn * R_t + S_nn * R_n + b_n * zeta * over
        if chain.spring > 0.0:
            w[a + K], w[a + K + 1], w[a + OVER] = k_t, k_n, over
            w[a + KAPPA], w[a + PRELOAD], w[a + G], w[a + G + 1] = kappa, preload, g_t, g_n
            S_theta, s_theta, g_t, g_n = over, beta_0, b_t * over, b_n * over
    tx, ty = before_x, before_y
    txx, txy, tyy = tx * tx, tx * ty, ty * ty
    Sxx = txx * S_tt - 2.0 * txy * S_tn + tyy * S_nn
    Sxy = txy * (S_tt - S_nn) + (txx - tyy) * S_tn
    return Sxx, Sxy, S_tt + S_nn - Sxx, tx * s_t - ty * s_n, ty * s_t + tx * s_n


@kernel
def close(Sxx, Sxy, Syy, miss_x, miss_y):
    """The force h that shifts end b by what it misses, S h = miss, and whether the ends' distance determines it.

    In a straight chain it does not: the force is then the least one, without a part along the chain.
    """
    mean, half = 0.5 * (Sxx + Syy), 0.5 * (Sxx - Syy)
    det = Sxx * Syy - Sxy * Sxy
    if det > 4.0 * RANK * mean * mean:
        over = 1.0 / det
        return (Syy * miss_x - Sxy * miss_y) * over, (Sxx * miss_y - Sxy * miss_x) * over, True
    largest = mean + (half * half + Sxy * Sxy) ** 0.5
    # S is (almost) largest times the dyad of its direction, whose square is S / largest.
    x, y = (Sxx * miss_x + Sxy * miss_y) / largest, (Sxy * miss_x + Syy * miss_y) / largest
    return x / largest, y / largest, False


@kernel
def substitute(chain, w, h_x, h_y):
    """Correct all angles' increments and write the joints' forces, from the force h at end b back to end a.

    Returns the largest correction of an angle [rad], what the corrections shift end b by against end a (x, y) [m], and
    what they shorten the chain by (x, y) [m], which is of their second order.
    """
    largest = turn_x = turn_y = bent_x = bent_y = m = 0.0
    last = chain.n * SCRATCH
    w[last + HN], w[last + HN + 1] = h_x, h_y
    for i in range(chain.n - 1, -1, -1):
        a = i * SCRATCH
        tx, ty = w[a + TN], w[a + TN + 1]
        f_t, f_n = tx * h_x + ty * h_y, tx * h_y - ty * h_x
        turn = w[a + BETA] * f_t + w[a + BETA + 1] * f_n + w[a + BETA_0]
        h_t = w[a + A] * f_t + w[a + A + 1] * f_n + w[a + ALPHA]
        h_n = w[a + A + 2] * f_t + w[a + A + 3] * f_n + w[a + ALPHA + 1]
        if chain.spring > 0.0:
            part = -m * w[a + OVER]
            turn, h_t, h_n = turn + part, h_t + part * w[a + K], h_n + part * w[a + K + 1]
            if i > 0:
                m = -w[a + PRELOAD] - w[a + KAPPA] * (turn + w[a + G] * h_t + w[a + G + 1] * h_n)
        h_x, h_y = tx * h_t - ty * h_n, ty * h_t + tx * h_n
        w[a + LAST] = turn
        w[a + DELTA] += turn
        w[a + HN], w[a + HN + 1] = h_x, h_y
        largest = max(largest, abs(turn))
        turn_x, turn_y = turn_x - turn * ty, turn_y + turn * tx
        bent_x, bent_y = bent_x + turn * turn * tx, bent_y + turn * turn * ty
    l0 = chain.l0
    return largest, l0 * turn_x, l0 * turn_y, 0.5 * l0 * bent_x, 0.5 * l0 * bent_y
