"""Rows of convex sets from a thruster's description: its convex pieces, and one set that covers them all."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from components.allocator.exact.response import (
    A_REVERSE,
    BOARD,
    DISC,
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    LINE,
    MOST,
    MOST_REVERSE,
    NOTHING,
    SECTOR,
    SET,
    UNFED,
    A,
    X,
    Y,
)
from components.allocator.thrusters import TURN, Arc, Thruster, allowed, width


def pieces(thruster: Thruster) -> list[np.ndarray]:
    """Convex sets (SET,) whose union is what the thruster can give [N; N W^(-2/3) ...]; one that is nothing if none."""
    if thruster.kind == "azimuth":
        return [row for arc, factor in allowed(thruster) for row in _of_arc(thruster, arc, factor)] or [_row(thruster)]
    line = _directed(_row(thruster, LINE), thruster.heading, thruster.heading)
    back = thruster.backwards * thruster.loss_factor
    line[MOST_REVERSE], line[A_REVERSE] = back, _coefficient(thruster.max_power, back)
    if thruster.kind != "rudder":
        return [line]
    ahead = _directed(
        _row(thruster, SECTOR), thruster.heading - thruster.rudder_angle, thruster.heading + thruster.rudder_angle
    )
    if back == 0.0:
        return [ahead]
    line[MOST] = 0.0
    return [ahead, line]


def cover(found: list[np.ndarray]) -> np.ndarray:
    """One convex set that contains all, at a power that is nowhere above theirs: (SET,)."""
    if len(found) == 1:
        return found[0]
    row = found[0].copy()
    row[KIND] = DISC
    row[MOST] = max(max(one[MOST], one[MOST_REVERSE]) for one in found)
    row[A] = min(min(one[A], one[A_REVERSE]) for one in found)
    return row


def _coefficient(power: float, thrust: float) -> float:
    return power / thrust**1.5 if thrust > 0.0 else 1.0


def _row(thruster: Thruster, kind: float = NOTHING, factor: float = 1.0) -> np.ndarray:
    row = np.zeros(SET)
    most = thruster.max_thrust * thruster.loss_factor * factor
    row[[KIND, MOST, X, Y]] = kind, most, thruster.x, thruster.y
    row[[A, A_REVERSE]] = _coefficient(thruster.max_power, most)
    row[BOARD] = UNFED
    return row


def _directed(row: np.ndarray, start: float, end: float) -> np.ndarray:
    row[[E1X, E1Y, E2X, E2Y]] = cos(start), sin(start), cos(end), sin(end)
    return row


def _of_arc(thruster: Thruster, arc: Arc, factor: float) -> list[np.ndarray]:
    """An arc of more than half a turn is two half discs, from either end; a whole turn is a disc."""
    start, end = arc
    if width(arc) >= TURN - 1e-12:
        return [_row(thruster, DISC, factor)]
    if width(arc) <= pi:
        return [_directed(_row(thruster, SECTOR, factor), start, end)]
    first = _directed(_row(thruster, SECTOR, factor), start, start + pi)
    return [first, _directed(_row(thruster, SECTOR, factor), end - pi, end)]
