"""The static line in its own units: dispatch to the solver that fits, and the numbers a user asks for."""

from math import hypot
from typing import NamedTuple

from components.compiled import kernel
from components.tether.catenary.elastic import elastic
from components.tether.catenary.inextensible import inextensible
from components.tether.catenary.seabed import grounded_reach, lying_tension, touchdown
from components.tether.catenary.shape import reach
from components.tether.catenary.status import END_BELOW_SEABED, NEUTRAL_SLACK, NO_ANCHOR, TAUT, TOO_SHORT

LARGEST = 1.7976931348623157e308


class Rest(NamedTuple):
    """A line at rest, dimensionless as in shape.py, over span h and rise v.

    H: horizontal tension of the hanging parts; V: upward force at the middle, without meaning where the line touches.
    s_a, s_b: lengths that hang from the ends, signed; where the line touches 1 - s_a - s_b lies on the seabed.
    mu_a, mu_b: friction by which the tension of the lying part falls towards end a (b), one of them 0.
    """

    h: float
    v: float
    e: float
    p_a: float
    touches: bool
    H: float
    V: float
    s_a: float
    s_b: float
    mu_a: float
    mu_b: float


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
def rest(h, v, e, p_a, p_b, mu):
    """(status, Rest): a line above a seabed at p_a and p_b below its ends (infinite: none) with friction mu.

    Friction needs an anchor: the end that lies on the seabed itself, a if both do.
    """
    nothing = Rest(h, v, e, p_a, False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p_a < 0.0 or p_b < 0.0:
        return END_BELOW_SEABED, nothing
    status, H, V = hanging(h, v, e)
    sinks = status == 0 and sag(H, V, e) > min(p_a, p_b)
    if not sinks:
        return status, Rest(h, v, e, p_a, False, H, V, 0.5 - V, 0.5 + V, 0.0, 0.0)
    if mu > 0.0 and p_a > 0.0 and p_b > 0.0:
        return NO_ANCHOR, nothing
    status, H, s_a, s_b = touchdown(h, p_a, p_b, e, mu, H)
    mu_a, mu_b = (mu, 0.0) if p_a == 0.0 else (0.0, mu)
    return status, Rest(h, v, e, p_a, True, H, V, s_a, s_b, mu_a, mu_b)


@kernel
def point(line, s):
    """(x, z, H, V): place along and against the load from end a, and force, at unstretched arc length s."""
    if not line.touches:
        x, z = reach(line.H, line.V, s, line.e)
        return x, z, line.H, s - line.s_a
    x, z = grounded_reach(line, s)
    if s < line.s_a:
        return x, z, lying_tension(line, line.s_a), s - line.s_a
    if s <= 1.0 - line.s_b:
        return x, z, lying_tension(line, s), 0.0
    return x, z, lying_tension(line, 1.0 - line.s_b), s - (1.0 - line.s_b)


@kernel
def end_tensions(line):
    """Horizontal tension at end a and at end b; friction on the seabed makes them differ."""
    if not line.touches:
        return line.H, line.H
    return lying_tension(line, line.s_a), lying_tension(line, 1.0 - line.s_b)
