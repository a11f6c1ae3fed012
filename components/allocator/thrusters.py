"""Thrusters as an allocator sees them: where they are, what they can give in which directions, and at what power."""

from __future__ import annotations

from math import pi
from typing import Literal

from pydantic import model_validator

from components.contract import Parameters, choice, quantity

TURN = 2.0 * pi
Arc = tuple[float, float]


class ThrustFactor(Parameters):
    """In a sector of azimuths a thruster gives `factor` times its thrust: by the hull, another's wake, the current."""

    sector: Arc = quantity("rad", "from one azimuth clockwise to another")
    factor: float = quantity("1", "thrust over that in open water at the same power", gt=0, le=1)


class Thruster(Parameters):
    """One actuator. Azimuths are directions of the force on the vessel, clockwise from the bow seen from above.

    Power is max_power (T / max_thrust)^(3/2), which is exact in bollard pull (van Daalen et al. 2011, eqs. 4 and 5).
    """

    kind: Literal["azimuth", "tunnel", "fixed", "rudder"] = choice(
        "azimuth: turns; tunnel: across, both ways; fixed: along `direction`; rudder: a main propeller, whose force a "
        "rudder deflects while it drives ahead"
    )
    x: float = quantity("m", "position forward of the reference point")
    y: float = quantity("m", "position to starboard of the reference point")
    max_thrust: float = quantity("N", "largest thrust in bollard pull", gt=0)
    max_power: float = quantity("W", "power at the largest thrust", gt=0)
    reverse_thrust: float | None = quantity(
        "N",
        "largest thrust backwards, at the same power; none: a tunnel's is that forward, others have none",
        None,
        ge=0,
    )
    direction: float | None = quantity("rad", "of a fixed thruster or a propeller's force; none: 90 deg or ahead", None)
    rudder_angle: float = quantity("rad", "by which the rudder turns the force, largest, both ways", 0.0, ge=0, lt=1.5)
    forbidden: tuple[Arc, ...] = quantity("rad", "azimuths that an azimuth thruster may not have, clockwise", ())
    factors: tuple[ThrustFactor, ...] = choice("sectors with less thrust; they may not overlap", ())
    loss_factor: float = quantity("1", "thrust in place over that in open water, everywhere", 1.0, gt=0, le=1)
    zero_thrust_speed: float | None = quantity(
        "m/s",
        "of the water against the thrust, at which the propeller gives none at full shaft speed, J_0 n D; none: moving "
        "water makes no difference",
        None,
        gt=0,
    )
    zero_torque_speed: float | None = quantity(
        "m/s", "the same for its torque; none: 1.15 times zero_thrust_speed", None, gt=0
    )
    wake_diameter: float | None = quantity(
        "m", "of the propeller, whose jet takes thrust from those that it meets; none: it takes none", None, gt=0
    )
    azimuth_rate: float | None = quantity("rad/s", "fastest turn; none: no limit", None, gt=0)
    thrust_rate: float | None = quantity("N/s", "fastest change of thrust, before losses; none: no limit", None, gt=0)

    @model_validator(mode="after")
    def _kind_fits(self) -> Thruster:
        if self.kind != "azimuth" and (self.forbidden or self.factors or self.azimuth_rate):
            raise ValueError(f"forbidden, factors and azimuth_rate are an azimuth thruster's; this one is {self.kind}")
        if self.kind == "azimuth" and (self.reverse_thrust or self.direction is not None):
            raise ValueError("reverse_thrust and direction are not an azimuth thruster's: it turns instead")
        if (self.kind == "rudder") != (self.rudder_angle > 0.0):
            raise ValueError("rudder_angle belongs to kind rudder, and only there")
        for one in self.factors:
            if any(overlaps(one.sector, other.sector) for other in self.factors if other is not one):
                raise ValueError("sectors of `factors` overlap")
        return self

    @property
    def heading(self) -> float:
        """Direction of the force forward of what cannot turn."""
        if self.direction is not None:
            return self.direction
        return 0.5 * pi if self.kind == "tunnel" else 0.0

    @property
    def backwards(self) -> float:
        """Largest thrust in reverse."""
        if self.reverse_thrust is not None:
            return self.reverse_thrust
        return self.max_thrust if self.kind == "tunnel" else 0.0


def width(arc: Arc) -> float:
    """Of an arc from its first azimuth clockwise to its second, in (0, 2 pi]: equal ends are a whole turn."""
    return (arc[1] - arc[0]) % TURN or TURN


def contains(arc: Arc, azimuth: float) -> bool:
    """Whether an azimuth lies inside an arc or on its edge."""
    return (azimuth - arc[0]) % TURN <= width(arc)


def overlaps(a: Arc, b: Arc) -> bool:
    """Whether the insides of two arcs meet."""
    return (b[0] - a[0]) % TURN < width(a) or (a[0] - b[0]) % TURN < width(b)


def allowed(thruster: Thruster) -> list[tuple[Arc, float]]:
    """Arcs that are not forbidden, each with its thrust factor, clockwise; one whole turn from 0 where all is alike."""
    cuts = {azimuth % TURN for arc in thruster.forbidden for azimuth in arc}
    cuts |= {azimuth % TURN for one in thruster.factors for azimuth in one.sector}
    if not cuts:
        return [] if thruster.forbidden else [((0.0, TURN), 1.0)]
    edges = sorted(cuts)
    arcs = list(zip(edges, [*edges[1:], edges[0] + TURN], strict=True))
    kept = [(arc, _factor(thruster, 0.5 * (arc[0] + arc[1]))) for arc in arcs]
    return _joined([(arc, factor) for arc, factor in kept if factor > 0.0])


def _factor(thruster: Thruster, azimuth: float) -> float:
    if any(contains(arc, azimuth) for arc in thruster.forbidden):
        return 0.0
    return next((one.factor for one in thruster.factors if contains(one.sector, azimuth)), 1.0)


def _joined(arcs: list[tuple[Arc, float]]) -> list[tuple[Arc, float]]:
    """Neighbours of the same factor made one, across north too."""
    found: list[tuple[Arc, float]] = []
    for arc, factor in arcs:
        if found and found[-1][1] == factor and abs(found[-1][0][1] - arc[0]) < 1e-12:
            found[-1] = (found[-1][0][0], arc[1]), factor
        else:
            found.append((arc, factor))
    if len(found) > 1 and found[0][1] == found[-1][1] and abs(found[-1][0][1] - TURN - found[0][0][0]) < 1e-12:
        last, factor = found.pop()
        found[0] = (last[0] - TURN, found[0][0][1]), factor
    return found
