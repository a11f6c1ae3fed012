"""Closed-form shape of an elastic line under its own weight, given the force in it.

Everything here and in the solvers is dimensionless: lengths in units of the unstretched length L, forces in units of
its weight w L. At unstretched arc length s from end a, 0 <= s <= 1, the line carries the horizontal force H >= 0 and
the upward force V + s - 1/2, V being that of its middle. e = w L / EA is its elasticity (0: inextensible).
Irvine 1981, "Cable Structures", section 1.2.
"""

from math import hypot, log1p

from components.compiled import kernel


@kernel
def angle(H, alpha, beta):
    """asinh(beta/H) - asinh(alpha/H), for alpha <= beta and H > 0, without cancellation.

    With S = hypot(H, alpha) + hypot(H, beta) and s = beta - alpha it is 2 artanh(s/S) = log1p(2 s/(S - s)), and S - s
    is summed from terms that are none of them negative.
    """
    s = beta - alpha
    excess = 2.0 * min(abs(alpha), abs(beta)) if alpha * beta > 0.0 else 0.0
    excess += H * (H / (hypot(H, alpha) + abs(alpha))) + H * (H / (hypot(H, beta) + abs(beta)))
    return log1p(2.0 * s / excess)


@kernel
def reach(H, V, s, e):
    """Horizontal and upward distance (x, z) from end a to unstretched arc length s, V being that of the middle."""
    if s <= 0.0:
        return 0.0, 0.0
    alpha = V - 0.5
    beta = alpha + s
    x = e * H * s
    if H > 0.0:
        x += H * angle(H, alpha, beta)
    mean = V + 0.5 * (s - 1.0)
    return x, s * mean * (e + 2.0 / (hypot(H, alpha) + hypot(H, beta)))
