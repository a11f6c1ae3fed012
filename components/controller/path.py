"""A path of straight legs and circular arcs over the water, and where a vessel is along it and beside it.

Fossen 2011, section 10.3: waypoints whose corners are rounded by arcs of one radius.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, pi, sin, sqrt, tan

from components.compiled import kernel
from components.kinematics import wrapped

# Of a piece: where it begins, its heading there, its curvature (positive to starboard), its length, and the way before.
NORTH, EAST, HEADING, CURVATURE, LENGTH, BEFORE = range(6)
PIECE = 6
SHORT = 1e-9  # of the radius: a leg that two arcs leave nothing of
BACK = 1e-3  # rad: corners that turn back by less than this have no arc

Point = tuple[float, float]


def lay(corners: Sequence[Point], radius: float, is_closed: bool) -> list[tuple[float, ...]]:
    """The pieces (6 numbers each) of a path through corners (north, east) [m], each rounded by an arc of the radius.

    A closed path ends where it begins, amid its first leg; a square with arcs of half its side is a circle. Raises
    ValueError where two corners are one, a corner turns back, or a leg is too short for its arcs.
    """
    least = 3 if is_closed else 2
    if len(corners) < least:
        raise ValueError(f"path has {len(corners)} corners; expected {least} at least{' where closed' * is_closed}")
    if is_closed:
        start = tuple(0.5 * (a + b) for a, b in zip(corners[0], corners[1], strict=True))
        corners = [(start[0], start[1]), *corners[1:], corners[0], (start[0], start[1])]
    legs = [_leg(corners, i) for i in range(len(corners) - 1)]
    turns = [0.0, *(_turn(legs[i][0], legs[i + 1][0], i + 2) for i in range(len(legs) - 1)), 0.0]
    cuts = [radius * tan(0.5 * abs(turn)) for turn in turns]
    pieces, before = [], 0.0
    for i, (heading, length) in enumerate(legs):
        straight = length - cuts[i] - cuts[i + 1]
        if straight < -SHORT * radius:
            raise ValueError(
                f"leg {i + 1} of path is {length:g} m long, the arcs of turn_radius {radius:g} m at its ends need "
                f"{cuts[i] + cuts[i + 1]:g} m"
            )
        c, s = cos(heading), sin(heading)
        north, east = corners[i]
        if straight > SHORT * radius:
            pieces.append((north + c * cuts[i], east + s * cuts[i], heading, 0.0, straight, before))
            before += straight
        turn = turns[i + 1]
        if turn != 0.0:
            north, east = corners[i + 1]
            begin = (north - c * cuts[i + 1], east - s * cuts[i + 1])
            pieces.append((*begin, heading, (1.0 if turn > 0.0 else -1.0) / radius, abs(turn) * radius, before))
            before += abs(turn) * radius
    return pieces


def _leg(corners: Sequence[Point], i: int) -> tuple[float, float]:
    """Heading and length from corner i to the next."""
    north, east = corners[i + 1][0] - corners[i][0], corners[i + 1][1] - corners[i][1]
    if north == 0.0 and east == 0.0:
        raise ValueError(f"corners {i + 1} and {i + 2} of path are the same point")
    return atan2(east, north), hypot(north, east)


def _turn(heading: float, then: float, corner: int) -> float:
    turn = (then - heading + pi) % (2.0 * pi) - pi
    if pi - abs(turn) < BACK:
        raise ValueError(f"corner {corner} of path turns back; give two corners, 2 turn_radius apart, to turn about")
    return turn


@kernel
def beside(k, north, east):
    """How far along a piece k (6) a point [m] is, to starboard of it, and the path's heading there."""
    dn, de = north - k[NORTH], east - k[EAST]
    c, s = cos(k[HEADING]), sin(k[HEADING])
    if k[CURVATURE] == 0.0:
        return c * dn + s * de, c * de - s * dn, k[HEADING]
    R = 1.0 / k[CURVATURE]
    # From the centre, which is R to starboard of the piece's begin; at the centre itself, as at the begin.
    dn, de = dn + R * s, de - R * c
    away = sqrt(dn * dn + de * de)
    side = 1.0 if R > 0.0 else -1.0
    heading = atan2(side * dn, -side * de) if away > 0.0 else k[HEADING]
    middle = k[HEADING] + 0.5 * k[LENGTH] / R
    heading = middle + wrapped(heading - middle)
    return R * (heading - k[HEADING]), R - side * away, heading


@kernel
def nearest(q, count, north, east):
    """The piece that is nearest to a point; q: the pieces one after the other."""
    found, least = 0, 1e300
    for i in range(count):
        k = q[PIECE * i : PIECE * (i + 1)]
        along, across, _ = beside(k, north, east)
        over = max(0.0, -along, along - k[LENGTH])
        if over * over + across * across < least:
            found, least = i, over * over + across * across
    return found


@kernel
def goes_on(q, count, is_closed, i, north, east):
    """The piece on which a point is now that was last on piece i, and by how many rounds it went on."""
    rounds = 0
    for _ in range(count):
        k = q[PIECE * i : PIECE * (i + 1)]
        along, _, _ = beside(k, north, east)
        if along > k[LENGTH] and (is_closed or i + 1 < count):
            i += 1
        elif along < 0.0 and (is_closed or i > 0):
            i -= 1
        else:
            break
        if i == count:
            i, rounds = 0, rounds + 1
        elif i < 0:
            i, rounds = count - 1, rounds - 1
    return i, rounds
