"""A static line that lies partly on a level seabed: one equation for the horizontal tension where it touches down.

Dimensionless as in shape.py. A part of arc length s hangs from each end down to where it touches; what lies between
carries the horizontal tension H alone, or, with Coulomb friction mu and one end anchored on the seabed, H less mu for
each length from the touchdown point on until nothing is left. Irvine 1981, section 1.2, with the seabed as in Jonkman
2007, NREL/TP-500-41958, eqs. 2-37.
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
    if e == 0.0:
        return s
    for _ in range(_ITERATIONS):
        T = sqrt(H * H + s * s)
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
    turn = asinh(s / H)
    return H * turn - s, turn - s / T - lift * lift / (s * (1.0 / T + e))


@kernel
def lost(H, lying, mu):
    """Integral over the lying part of the tension H that friction takes away, and its derivatives to H and `lying`."""
    if mu * lying <= H:
        return 0.5 * mu * lying * lying, 0.0, mu * lying
    return H * lying - 0.5 * H * (H / mu), lying - H / mu, H


@kernel
def growth(H, s, e):
    """How the length s that hangs grows with H."""
    if s <= 0.0:
        return 0.0
    T = hypot(H, s)
    return s * s / (T * (T + H)) / (s * (1.0 / T + e))


@kernel
def touchdown(h, p_a, p_b, e, mu, H):
    """(status, H, s_a, s_b): horizontal tension and lengths hanging from the ends, p_a and p_b above the seabed.

    H: to begin with, that of the line hanging free, which would be below the seabed. With friction one of p_a, p_b is
    0. The result is 0 where there is line enough to hang straight down from both ends; where the rest then lies is not
    determined.
    """
    s_a = hanging_length(0.0, p_a, e)
    s_b = hanging_length(0.0, p_b, e)
    if h <= 1.0 - s_a - s_b:
        return 0, 0.0, s_a, s_b
    low = 0.0
    high = inf
    H = H if H > 0.0 else h
    for _ in range(_ITERATIONS):
        s_a = hanging_length(H, p_a, e)
        s_b = hanging_length(H, p_b, e)
        less_a, slope_a = slack(H, s_a, e)
        less_b, slope_b = slack(H, s_b, e)
        loss, loss_H, loss_lying = lost(H, max(1.0 - s_a - s_b, 0.0), mu)
        excess = 1.0 + e * (H - loss) + less_a + less_b - h
        grown = growth(H, s_a, e) + growth(H, s_b, e)
        dH = -excess / (e * (1.0 - loss_H + loss_lying * grown) + slope_a + slope_b)
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
def lying_tension(line, s):
    """Tension of the lying part at unstretched arc length s."""
    return max(line.H - line.mu_a * (1.0 - line.s_b - s) - line.mu_b * (s - line.s_a), 0.0)


@kernel
def lying_extent(line, r):
    """Horizontal extent of the first length r of the lying part, from the touchdown point towards the anchor."""
    mu = line.mu_a + line.mu_b
    loaded = min(r, line.H / mu)
    return r + line.e * loaded * (line.H - 0.5 * mu * loaded)


@kernel
def lying_reach(line, s):
    """Horizontal distance from end a to unstretched arc length s on the seabed.

    A heap without horizontal tension is drawn evenly between the feet of the hanging parts.
    """
    x_a, x_b = run(line.H, line.s_a, line.e), run(line.H, line.s_b, line.e)
    if line.H > 0.0 and line.mu_a > 0.0:
        return line.h - x_b - lying_extent(line, 1.0 - line.s_b - s)
    if line.H > 0.0 and line.mu_b > 0.0:
        return x_a + lying_extent(line, s - line.s_a)
    lying = 1.0 - line.s_a - line.s_b
    return x_a + ((line.h - x_a - x_b) * ((s - line.s_a) / lying) if lying > 0.0 else 0.0)


@kernel
def grounded_reach(line, s):
    """Horizontal and upward distance (x, z) from end a to unstretched arc length s of a line that rests on the seabed.

    line: a line.Rest that touches.
    """
    H, e = line.H, line.e
    if s < line.s_a:
        r = line.s_a - s
        return run(H, line.s_a, e) - run(H, r, e), r * r * (1.0 / (hypot(H, r) + H) + 0.5 * e) - line.p_a
    if s <= 1.0 - line.s_b:
        return lying_reach(line, s), -line.p_a
    r = s - (1.0 - line.s_b)
    return line.h - run(H, line.s_b, e) + run(H, r, e), r * r * (1.0 / (hypot(H, r) + H) + 0.5 * e) - line.p_a
