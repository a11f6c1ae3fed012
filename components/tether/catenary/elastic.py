"""The elastic catenary between two points: the force that minimises a convex energy, by Newton's method.

The force f = (H, V) at the middle of the line minimises its complementary energy less f . (end b - end a). The energy
is convex for any stiffness, slack or taut, so a Newton step is shortened only where it overshoots along its line.
"""

from math import hypot

from components.compiled import kernel
from components.tether.catenary.inextensible import VERTICAL, inextensible
from components.tether.catenary.shape import angle
from components.tether.catenary.status import NOT_CONVERGED

# Each of the few terms of the residual is rounded once or twice.
_ROUNDING = 4.0 * 2.220446049250313e-16
_ITERATIONS = 100
_SHORTENINGS = 60
# A step may not bring the horizontal force nearer to zero (where the curvature is infinite) than this in one go.
_KEEP = 0.02
# Newton's error is squared by a step: after a step of 1e-9 the next one is below rounding.
_SMALL_STEP = 1e-9
# Steps granted beyond the rounding of the ends' places, to settle a force much smaller than the weight.
_POLISH = 3


@kernel
def misfit(H, V, e, h, v):
    """End b's place less the wanted (h, v), and the Hessian (xx, xz, zz), for H > 0."""
    alpha = V - 0.5
    beta = V + 0.5
    T_a = hypot(H, alpha)
    T_b = hypot(H, beta)
    phi = angle(H, alpha, beta)
    stiff_z = beta / T_b - alpha / T_a
    r_x = e * H + H * phi - h
    r_z = e * V + 2.0 * V / (T_a + T_b) - v
    return r_x, r_z, e + max(phi - stiff_z, 0.0), H * (1.0 / T_b - 1.0 / T_a), e + stiff_z


@kernel
def taut_tension(c, e, n):
    """Tension of a shallow parabola: e T^3 - (c - 1) T^2 = n^2/24, with c the chord and n = h/c (Irvine 1981, 1.3)."""
    q = n * n / 24.0
    T = max((c - 1.0) / e, 0.0) + (q / e) ** (1.0 / 3.0)  # above the root, from where Newton's steps only fall
    for _ in range(20):
        dT = (T * T * (e * T - (c - 1.0)) - q) / (T * (3.0 * e * T - 2.0 * (c - 1.0)))
        T -= dT
        if dT <= 1e-3 * T:  # only a start
            break
    return T


@kernel
def start(h, v, e):
    """(H, V) to begin with: the inextensible line's where it is slack beyond its stretch, else the parabola's."""
    c = hypot(h, v)
    if c < 1.0:
        status, H, V = inextensible(h, v)
        if status == 0 and e * (hypot(H, V) + 0.5) < 0.3 * (1.0 - c):
            return H, V
    T = taut_tension(c, e, h / c)
    return T * h / c, T * v / c


@kernel
def vertical(v, e):
    """V at the middle of a line whose ends stand above each other; hanging in a bight, or pulled one way."""
    V = v / (e + 2.0)
    if abs(V) > 0.5:
        V = (v - 1.0) / e if v > 0.0 else (v + 1.0) / e
    return V


@kernel
def shortened(H, V, dH, dV, slope, e, h, v):
    """(H, V) after the Newton step, cut where it would end H or climb far up the other side of the valley."""
    size = min(1.0, (_KEEP - 1.0) * H / dH) if dH < 0.0 else 1.0
    for _ in range(_SHORTENINGS):
        r_x, r_z, _xx, _xz, _zz = misfit(H + size * dH, V + size * dV, e, h, v)
        if r_x * dH + r_z * dV <= -0.5 * slope:
            break
        size *= 0.5
    return H + size * dH, V + size * dV


@kernel
def elastic(h, v, e):
    """(status, H, V): force at the middle of a line of unit length and weight over span h >= 0 and rise v; e > 0."""
    if h <= VERTICAL:
        return 0, 0.0, vertical(v, e)
    H, V = start(h, v, e)
    at_rounding = 0
    for _ in range(_ITERATIONS):
        r_x, r_z, xx, xz, zz = misfit(H, V, e, h, v)
        determinant = xx * zz - xz * xz
        dH = (xz * r_z - zz * r_x) / determinant
        dV = (xz * r_x - xx * r_z) / determinant
        if abs(dH) <= _SMALL_STEP * H and abs(dV) <= _SMALL_STEP * hypot(H, V):
            return 0, H + dH, V + dV
        if abs(r_x) + abs(r_z) <= _ROUNDING * (1.0 + h + abs(v)):
            at_rounding += 1
            if at_rounding > _POLISH:
                return 0, H, V
        H, V = shortened(H, V, dH, dV, r_x * dH + r_z * dV, e, h, v)
    return NOT_CONVERGED, H, V
