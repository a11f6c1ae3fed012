"""How fast two boats can tow: their propellers' thrust at speed, less what the hulls take."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np
from scipy.optimize import brentq

from components.thrusters.propulsion.model import Propulsion
from components.thrusters.propulsion.propeller import FASTEST, thrust_of
from components.vessel.low_speed.model import LowSpeed
from pipeline.analysis.coverage.drag import Drag
from pipeline.analysis.coverage.steady import Tow

Law = Callable[[float], float]


@dataclass(frozen=True)
class Boat:
    """thrust: the most, resistance: of the hull, each by the speed ahead [m/s] in N. fastest: at which to stop looking.

    thrust(0) is the bollard pull.
    """

    thrust: Law
    resistance: Law
    fastest: float


def boat_of(propulsion: Propulsion, vessel: LowSpeed) -> Boat:
    """A boat with all its propellers ahead at their largest speed, which the water meets as the boat goes."""
    numbers = [np.array(one.numbers()) for one in propulsion.thrusters]
    d = vessel.damping

    def resistance(v: float) -> float:
        return vessel.surge_damping * v + d.surge_surge * v * v + d.surge_cubed * v**3

    return Boat(lambda v: sum(thrust_of(k, k[FASTEST], v) for k in numbers), resistance, vessel.max_speed)


def speed(boat: Boat, drag: Drag, coefficient: float, length: float, one: Tow) -> float:
    """The speed [m/s] at which a boat's thrust just balances hull and line; coefficient: the drag's c in SI.

    The thrust points outwards as far as the line pulls inwards; what the hull's drift adds is left out. The boat's
    `fastest` where it could go faster.
    """

    def lack(v: float) -> float:
        force = coefficient * v**drag.power * length * one.force
        ahead = force * sin(one.angle) + boat.resistance(v)
        return hypot(force * cos(one.angle), ahead) - boat.thrust(v)

    if lack(boat.fastest) <= 0.0:
        return boat.fastest
    return float(brentq(lack, 0.0, boat.fastest, xtol=1e-12))  # pyright: ignore
