"""Closed-form shape of an elastic line under its own weight, given the force in it.

Everything here and in the solvers is dimensionless: lengths in units of the unstretched length L, forces in units of
its weight w L. At unstretched arc length s from end a, 0 <= s <= 1, the line carries the horizontal force H >= 0 and
the upward force V + s - 1/2, V being that of its middle. e = w L / EA is its elasticity (0: inextensible).
Irvine 1981, "Cable Structures", section 1.2.
"""

from math import hypot, log1p

from components.compiled import kernel


@kernel
def surplus(H, alpha, beta, T_a, T_b):
    """T_a + T_b - (beta - alpha), for alpha <= beta and H > 0, as a sum of terms that are none of them negative."""
    bent = H * (H / (T_a + abs(alpha))) + H * (H / (T_b + abs(beta)))
    return bent + 2.0 * min(abs(alpha), abs(beta)) if alpha * beta > 0.0 else bent


@kernel
def reach(H, V, s, e):
    """Horizontal and upward distance (x, z) from end a to unstretched arc length s, V being that of the middle.

    The tangent turns by asinh(beta/H) - asinh(alpha/H) = 2 artanh(s/(T_a + T_b)), which does not cancel.
    """
    if s <= 0.0:
        return 0.0, 0.0
    alpha = V - 0.5
    beta = alpha + s
    T_a = hypot(H, alpha)
    T_b = hypot(H, beta)
    x = e * H * s
    if H > 0.0:
        x += H * log1p(2.0 * s / surplus(H, alpha, beta, T_a, T_b))
    mean = V + 0.5 * (s - 1.0)
    return x, s * mean * (e + 2.0 / (T_a + T_b))
