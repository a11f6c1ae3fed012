"""A static line that lies partly on a level, frictionless seabed: one equation for its horizontal tension.

Dimensionless as in shape.py. A part of arc length s hangs from each end down to where it touches; what lies between
carries the horizontal tension H alone. Irvine 1981, section 1.2, with the seabed as in Jonkman 2007, NREL/TP-500-41958,
eqs. 2-37, without friction.
"""

from math import asinh, hypot, inf, sqrt

from components.compiled import kernel
from components.tether.catenary.status import NOT_CONVERGED

_ITERATIONS = 100
# Newton's error is squared by a step: after a step of 1e-9 the next one is below rounding.
_SMALL_STEP = 1e-9
# One rounding of the length: a horizontal force far smaller than the weight is not settled beyond that.
_ROUNDING = 2.220446049250313e-16


@kernel
def hanging_length(H, p, e):
    """Unstretched length s that hangs from height p >= 0 to a level touch, under H: s^2/(T + H) + e s^2/2 = p."""
    if p <= 0.0:
        return 0.0
    s = sqrt(p * (p + 2.0 * H))  # the inextensible length, which is not too short: Newton's steps only fall
    for _ in range(_ITERATIONS):
        T = hypot(H, s)
        ds = (s * s * (1.0 / (T + H) + 0.5 * e) - p) / (s / T + e * s)
        s -= ds
        if ds <= _SMALL_STEP * s:
            break
    return s


@kernel
def slack(H, s, e):
    """How much less than its length the hanging part spans, H asinh(s/H) - s, and that term's derivative to H."""
    if s <= 0.0:
        return 0.0, 0.0
    T = hypot(H, s)
    lift = s * (s / (T * (T + H)))  # 1 - H/T
    return H * asinh(s / H) - s, asinh(s / H) - s / T - lift * lift / (s * (1.0 / T + e))


@kernel
def touchdown(h, p_a, p_b, e):
    """(status, H, s_a, s_b): horizontal tension and lengths hanging from the ends, p_a and p_b above the seabed.

    To be asked only where the line hanging free would be below the seabed. H is 0 where there is line enough to hang
    straight down from both ends; where the rest then lies is not determined.
    """
    s_a = hanging_length(0.0, p_a, e)
    s_b = hanging_length(0.0, p_b, e)
    if h <= 1.0 - s_a - s_b:
        return 0, 0.0, s_a, s_b
    low = 0.0
    high = inf
    H = h
    for _ in range(_ITERATIONS):
        s_a = hanging_length(H, p_a, e)
        s_b = hanging_length(H, p_b, e)
        less_a, slope_a = slack(H, s_a, e)
        less_b, slope_b = slack(H, s_b, e)
        excess = 1.0 + e * H + less_a + less_b - h
        dH = -excess / (e + slope_a + slope_b)
        if abs(dH) <= _SMALL_STEP * H or abs(excess) <= _ROUNDING:
            H += dH
            return 0, H, hanging_length(H, p_a, e), hanging_length(H, p_b, e)
        if excess > 0.0:
            high = H
        else:
            low = H
        if low < H + dH < high:
            H += dH
        else:
            H = 0.5 * (low + high) if high < inf else 4.0 * H
    return NOT_CONVERGED, H, s_a, s_b


@kernel
def run(H, r, e):
    """Horizontal extent of a part of length r that rises from a level touch."""
    return e * H * r + H * asinh(r / H) if H > 0.0 else 0.0


@kernel
def grounded_reach(H, s, s_a, s_b, h, p_a, e):
    """Horizontal and upward distance (x, z) from end a to unstretched arc length s of a line that rests on the seabed.

    A heap without horizontal tension is drawn evenly between the feet of the hanging parts.
    """
    if s < s_a:
        r = s_a - s
        T = hypot(H, r)
        x_full, x_rest = run(H, s_a, e), run(H, r, e)
        return x_full - x_rest, r * r * (1.0 / (T + H) + 0.5 * e) - p_a
    lying = 1.0 - s_a - s_b
    x_a = run(H, s_a, e)
    along = (h - x_a - run(H, s_b, e)) * ((s - s_a) / lying) if lying > 0.0 else 0.0
    if s <= 1.0 - s_b:
        return x_a + along, -p_a
    r = s - (1.0 - s_b)
    return h - run(H, s_b, e) + run(H, r, e), r * r * (1.0 / (hypot(H, r) + H) + 0.5 * e) - p_a
