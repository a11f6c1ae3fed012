"""The wind up to which a vessel is held, per heading, intact and after each failure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.capability.loads import Loads
from pipeline.capability.ship import Ship
from pipeline.capability.thrusters import Holding

INTACT = "intact"
HALVINGS = 40  # of the distance of two tabulated wind speeds: below 1e-10 m/s for any table
PARTS = 8  # of that distance, tried in order, since beyond a forbidden zone the thrusters may hold again


@dataclass(frozen=True)
class Capability:
    """headings: (h,) [deg]. winds: {case: (h,)} [m/s]; is_more: {case: (h,)} held at the table's highest wind.

    worst: (h,) the single failure with the least wind; "" where none is seen to lose position.
    """

    headings: np.ndarray
    winds: dict[str, np.ndarray]
    is_more: dict[str, np.ndarray]
    worst: list[str]


def capability(ship: Ship, progress: Callable[[float], None]) -> Capability:
    """progress: takes the number of cases done."""
    cases = {INTACT: [True] * len(ship.names), **{name: ship.left_after(lost) for name, lost in ship.failures.items()}}
    winds, is_more = {}, {}
    for done, (case, available) in enumerate(cases.items(), 1):
        holding = Holding(ship.allocator, available)
        winds[case] = np.array([limit(holding, ship.loads, heading) for heading in range(len(ship.loads.headings))])
        is_more[case] = np.isinf(winds[case])
        winds[case][is_more[case]] = ship.loads.speeds[-1]
        progress(done)
    failed = [case for case in cases if case != INTACT]
    worst = [_worst(failed, winds, is_more, h) for h in range(len(ship.loads.headings))] if failed else []
    return Capability(ship.loads.headings, winds, is_more, worst)


def _worst(failed: list[str], winds: dict[str, np.ndarray], is_more: dict[str, np.ndarray], h: int) -> str:
    case = min(failed, key=lambda name: winds[name][h])
    return "" if is_more[case][h] else case


def limit(holding: Holding, loads: Loads, heading: int) -> float:
    """The first wind [m/s] that cannot be held; 0 if it is the table's first, infinity if it is beyond its last.

    Between tabulated speeds the load is linear in the speed.
    """
    speeds, table = loads.speeds, loads.table[heading]
    if not holding.holds(table[0]):
        return 0.0
    for low in range(len(speeds) - 1):
        for part in range(PARTS):
            if not holding.holds(_between(table, low, (part + 1) / PARTS)):
                first = _last_held(holding, table, low, part / PARTS, (part + 1) / PARTS)
                return float(speeds[low] + first * (speeds[low + 1] - speeds[low]))
    return np.inf


def _between(table: np.ndarray, low: int, part: float) -> np.ndarray:
    return (1.0 - part) * table[low] + part * table[low + 1]


def _last_held(holding: Holding, table: np.ndarray, low: int, held: float, lost: float) -> float:
    for _ in range(HALVINGS):
        middle = 0.5 * (held + lost)
        if holding.holds(_between(table, low, middle)):
            held = middle
        else:
            lost = middle
    return held
