"""The elastic catenary between two points: the force that minimises a convex energy, by Newton's method.

The force f = (H, V) at the middle of the line minimises its complementary energy less f . (end b - end a). The energy
is convex for any stiffness, slack or taut, so a Newton step is shortened only where it overshoots along its line.
"""

from math import hypot, log1p

from components.compiled import kernel
from components.tether.catenary.inextensible import VERTICAL, inextensible
from components.tether.catenary.shape import reach, surplus
from components.tether.catenary.status import NOT_CONVERGED

# Each of the few terms of the residual is rounded once or twice.
_ROUNDING = 4.0 * 2.220446049250313e-16
_ITERATIONS = 100
_SHORTENINGS = 60
# A step may not bring the horizontal force nearer to zero (where the curvature is infinite) than this in one go.
_KEEP = 0.02
# Newton's error is squared by a step: what follows a step of 1e-9 is below rounding.
_SMALL_STEP = 1e-9
# Steps taken once the steps or the misfit are that small: one would do for most lines, two more settle those
# that are ill-conditioned (near-taut and very stiff, or with a horizontal force far below the weight).
_SETTLED = 3
# Misfit of a result, in lengths; beyond it the line says that it did not converge.
_ACCEPTED = 2e-14
# Sum of the ends' tensions in weights from which one term of the series of phi S - 2 is as good as a Newton step needs
# (1e-4), and below which the difference is (1e-12).
_STRAIGHT = 100.0
# By how much of the length the parabola's end may miss the catenary's: the tenth part of a rounding.
_SHALLOW = 2e-17


@kernel
def misfit(H, V, e, h, v):
    """End b's place less the wanted (h, v)."""
    x, z = reach(H, V, 1.0, e)
    return x - h, z - v


@kernel
def hessian(H, V, e):
    """(xx, xz, zz, determinant) of the energy: how end b's place changes with the force, for H > 0.

    With S = T_a + T_b and phi = 2 artanh(1/S) the determinant of the inextensible part is
    2 (phi S - 2)/(S^2 - 1) H^2/(T_a T_b), which does not cancel as xx zz - xz^2 does for a nearly straight line.
    """
    T_a = hypot(H, V - 0.5)
    T_b = hypot(H, V + 0.5)
    above = surplus(H, V - 0.5, V + 0.5, T_a, T_b)  # S - 1
    phi = log1p(2.0 / above)
    S = 1.0 + above
    share = 2.0 * (H / T_a) * (H / T_b) / (above * (above + 2.0))
    bend = phi * S - 2.0 if S < _STRAIGHT else 2.0 / (3.0 * S * S)
    zz = S * share
    return e + max(phi - zz, 0.0), H * (1.0 / T_b - 1.0 / T_a), e + zz, e * (e + phi) + bend * share


@kernel
def taut_tension(c, e, n):
    """Tension of a shallow parabola: e T^3 - (c - 1) T^2 = n^2/24, with c the chord and n = h/c (Irvine 1981, 1.3)."""
    q = n * n / 24.0
    T = max((c - 1.0) / e, 0.0) + (q / e) ** (1.0 / 3.0)  # above the root, from where Newton's steps only fall
    for _ in range(_ITERATIONS):
        dT = (T * T * (e * T - (c - 1.0)) - q) / (T * (3.0 * e * T - 2.0 * (c - 1.0)))
        T -= dT
        if dT <= _SMALL_STEP * T:
            break
    return T


@kernel
def start(h, v, e, c, T):
    """(H, V) to begin with: the inextensible line's where it is slack beyond its stretch, else the parabola's."""
    if c < 1.0:
        status, H, V = inextensible(h, v)
        if status == 0 and e * (hypot(H, V) + 0.5) < 0.3 * (1.0 - c):
            return H, V
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
        r_x, r_z = misfit(H + size * dH, V + size * dV, e, h, v)
        if r_x * dH + r_z * dV <= -0.5 * slope:
            break
        size *= 0.5
    return H + size * dH, V + size * dV


@kernel
def elastic(h, v, e):
    """(status, H, V): force at the middle of a line of unit length and weight over span h >= 0 and rise v; e > 0."""
    if h <= VERTICAL:
        return 0, 0.0, vertical(v, e)
    c = hypot(h, v)
    n = h / c
    T = taut_tension(c, e, n)
    if e * T + n * n / (12.0 * T * T) < _SHALLOW * T * T:  # the parabola's tension lacks terms of 1/T^2 of it
        return 0, T * (h / c), T * (v / c)
    H, V = start(h, v, e, c, T)
    settled = 0
    for _ in range(_ITERATIONS):
        r_x, r_z = misfit(H, V, e, h, v)
        xx, xz, zz, determinant = hessian(H, V, e)
        dH = (xz * r_z - zz * r_x) / determinant
        dV = (xz * r_x - xx * r_z) / determinant
        small = abs(dH) <= _SMALL_STEP * H and abs(dV) <= _SMALL_STEP * hypot(H, V)
        if small or abs(r_x) + abs(r_z) <= _ROUNDING * (1.0 + h + abs(v)):
            settled += 1
        rounded = abs(r_x) + abs(r_z) <= _ACCEPTED * (1.0 + h + abs(v))
        if small or (rounded and abs(dH) < 0.5 * H):  # no slope to search along is left above rounding
            H += dH
            V += dV
        else:
            H, V = shortened(H, V, dH, dV, r_x * dH + r_z * dV, e, h, v)
        if settled == _SETTLED:
            break
    r_x, r_z = misfit(H, V, e, h, v)
    converged = abs(r_x) + abs(r_z) <= _ACCEPTED * (1.0 + h + abs(v))
    return (0 if converged else NOT_CONVERGED), H, V
