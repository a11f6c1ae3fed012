"""The static line in its own units: dispatch to the solver that fits, and the numbers a user asks for."""

from math import hypot

from components.compiled import kernel
from components.tether.catenary.elastic import elastic
from components.tether.catenary.inextensible import inextensible
from components.tether.catenary.seabed import touchdown
from components.tether.catenary.status import END_BELOW_SEABED, NEUTRAL_SLACK, TAUT, TOO_SHORT

LARGEST = 1.7976931348623157e308


@kernel
def neutral(h, v, flexibility):
    """(status, H, V): force [N] in a straight line without weight; h, v in lengths, flexibility 1/EA [1/N]."""
    c = hypot(h, v)
    if c < 1.0:
        return NEUTRAL_SLACK, 0.0, 0.0
    if flexibility == 0.0:
        return (TAUT if c == 1.0 else TOO_SHORT), 0.0, 0.0
    T = (c - 1.0) / flexibility
    return 0, T * h / c, T * v / c


@kernel
def hanging(h, v, e):
    """(status, H, V) of a line hanging free; dimensionless as in shape.py."""
    return elastic(h, v, e) if e > 0.0 else inextensible(h, v)


@kernel
def sag(H, V, e):
    """How far the lowest point lies below the lower end (0 where that end is the lowest point), in lengths."""
    if abs(V) >= 0.5:
        return 0.0
    s = min(0.5 - V, 0.5 + V)  # from the lower end, which carries the smaller share, to the level point
    return s * s * (1.0 / (hypot(H, s) + H) + 0.5 * e)


@kernel
def parameter(H, weight):
    """Catenary parameter C = |w|/H [1/m], Drupt et al. 2022, eq. 4; the largest double where it is beyond it."""
    weight = abs(weight)
    return weight / H if weight < H * LARGEST else LARGEST


@kernel
def rest(h, v, e, p_a, p_b):
    """(status, touches, H, V, s_a, s_b): a line above a seabed at p_a and p_b below its ends (infinite: no seabed).

    s_a and s_b: the lengths that hang from the ends, signed. Where the line touches, 1 - s_a - s_b lies on the seabed
    and V has no meaning; else V is as in shape.py.
    """
    if p_a < 0.0 or p_b < 0.0:
        return END_BELOW_SEABED, False, 0.0, 0.0, 0.0, 0.0
    status, H, V = hanging(h, v, e)
    if status == 0 and sag(H, V, e) > min(p_a, p_b):
        status, H, s_a, s_b = touchdown(h, p_a, p_b, e)
        return status, True, H, V, s_a, s_b
    return status, False, H, V, 0.5 - V, 0.5 + V


@kernel
def upward_force(s, touches, s_a, s_b):
    """Upward force in the line at unstretched arc length s."""
    if s < s_a or not touches:
        return s - s_a
    return max(s - (1.0 - s_b), 0.0)
