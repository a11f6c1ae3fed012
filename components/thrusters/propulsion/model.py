"""Propellers and thrusters that follow commands: their parameters, ports and sizes."""

from __future__ import annotations

from math import inf, pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.contract import Parameters, Port, Sizes, Term, choice, quantity
from components.thrusters.propulsion.propeller import AZIMUTH_KIND, RUDDER_KIND, STRAIGHT

KINDS = {"azimuth": AZIMUTH_KIND, "tunnel": STRAIGHT, "fixed": STRAIGHT, "rudder": RUDDER_KIND}


class Actuator(Parameters):
    """One propeller. Azimuths are directions of the force on the vessel, clockwise from the bow seen from above."""

    kind: Literal["azimuth", "tunnel", "fixed", "rudder"] = choice("as the allocator's")
    x: float = quantity("m", "position forward of the reference point")
    y: float = quantity("m", "position to starboard of the reference point")
    max_thrust: float = quantity("N", "in bollard pull and open water at max_speed", gt=0)
    max_power: float = quantity("W", "of the shaft there", gt=0)
    max_speed: float = quantity("rad/s", "of the shaft", gt=0)
    reverse_thrust: float | None = quantity(
        "N", "at max_speed backwards, at the same power; none: a tunnel's is that forward, others have none", None, ge=0
    )
    direction: float | None = quantity("rad", "of the force of a tunnel or fixed one; none: 90 deg or ahead", None)
    rudder_angle: float = quantity("rad", "by which a rudder turns the force, both ways", 0.0, ge=0, lt=1.5)
    loss_factor: float = quantity("1", "thrust in place over that in open water", 1.0, gt=0, le=1)
    diameter: float | None = quantity(
        "m", "of the propeller; none: water that comes to it makes no difference", None, gt=0
    )
    zero_thrust_advance: float = quantity("1", "J_0 = V / (n D) at which there is no thrust", 0.9, gt=0)
    zero_torque_advance: float = quantity("1", "J at which there is no torque, over J_0", 1.15, ge=1)
    speed_time: float = quantity("s", "time constant of the shaft's speed", 1.0, ge=0)
    speed_rate: float | None = quantity("rad/s^2", "fastest change of the shaft's speed; none: no limit", None, gt=0)
    azimuth_time: float = quantity("s", "time constant of the azimuth or rudder", 1.0, ge=0)
    azimuth_rate: float | None = quantity("rad/s", "fastest turn; none: no limit", None, gt=0)

    @model_validator(mode="after")
    def _kind_fits(self) -> Actuator:
        if (self.kind == "rudder") != (self.rudder_angle > 0.0):
            raise ValueError("rudder_angle belongs to kind rudder, and only there")
        if self.kind == "azimuth" and (self.reverse_thrust or self.direction is not None):
            raise ValueError("reverse_thrust and direction are not an azimuth thruster's: it turns instead")
        return self

    def numbers(self) -> list[float]:
        """As propeller.py names them."""
        heading = self.direction if self.direction is not None else 0.5 * pi if self.kind == "tunnel" else 0.0
        back = self.reverse_thrust
        if back is None:
            back = self.max_thrust if self.kind == "tunnel" else 0.0
        n = self.max_speed
        power = self.max_power / n**3
        slip = 0.0 if self.diameter is None else 2.0 * pi / (self.zero_thrust_advance * self.diameter)
        return [
            KINDS[self.kind], self.x, self.y, heading, self.rudder_angle, self.max_thrust / n**2, back / n**2, power,
            power, n, self.loss_factor, slip, 1.0 / self.zero_torque_advance, self.speed_time, self.speed_rate or inf,
            self.azimuth_time, self.azimuth_rate or inf,
        ]  # fmt: skip


class Propulsion(Parameters):
    """Actuators in the order of the allocator's."""

    thrusters: Annotated[tuple[Actuator, ...], Field(min_length=1, max_length=24)] = choice("the actuators")
    failure: tuple[int, ...] = quantity(
        "1",
        "of each: 0 none, 1 stops, 2 keeps its speed, 3 runs to its largest speed, 4 cannot turn; none given: none",
        (),
        tunable=True,
    )
    meets_water: bool = choice(
        "whether it has the inputs `water_velocity` and `yaw_rate`, the vessel's in the water", False
    )

    @model_validator(mode="after")
    def _fits(self) -> Propulsion:
        if self.failure and len(self.failure) != len(self.thrusters):
            raise ValueError(f"failure has {len(self.failure)} values for {len(self.thrusters)} thrusters")
        if any(code not in range(5) for code in self.failure):
            raise ValueError(f"failure is {self.failure}: expected 0, 1, 2, 3 or 4 for each thruster")
        return self

    def vector(self) -> np.ndarray:
        """Count, whether it meets water, failures (n), numbers (n, 17)."""
        n = len(self.thrusters)
        failures = self.failure or (0,) * n
        rows = np.array([thruster.numbers() for thruster in self.thrusters])
        return np.concatenate([[n, self.meets_water], np.array(failures, np.float64), rows.ravel()])


def inputs(propulsion: Propulsion) -> tuple[Port, ...]:
    """Commands, and the water if it matters."""
    n = len(propulsion.thrusters)
    ports = (
        Port("command.thrust", "N", (n,), "", "asked for in place, in still water; negative in reverse"),
        Port("command.azimuth", "rad", (n,), "body", "asked for; what cannot turn takes no notice"),
    )
    if propulsion.meets_water:
        ports += (
            Port("water_velocity", "m/s", (2,), "body", "of the reference point through the water"),
            Port("yaw_rate", "rad/s", (), "body"),
        )
    return ports


def outputs(propulsion: Propulsion) -> tuple[Port, ...]:
    """State and force of each, what they make together, and which obey."""
    n = len(propulsion.thrusters)
    return (
        Port("thrust", "N", (n,), "", "of each on the vessel, negative in reverse"),
        Port("azimuth", "rad", (n,), "body", "direction of a positive thrust, continuous"),
        Port("speed", "rad/s", (n,), "", "of the shaft"),
        Port("power", "W", (n,), "", "of the shaft"),
        Port("total.force", "N", (2,), "body", "surge and sway"),
        Port("total.moment", "N*m", (), "body", "yaw"),
        Port("running", "1", (n,), "", "1: obeys its commands; 0: has failed"),
    )


def sizes(propulsion: Propulsion) -> Sizes:
    """Speed and azimuth of each."""
    return Sizes(state=2 * len(propulsion.thrusters))


def terms(propulsion: Propulsion) -> tuple[Term, ...]:
    """What can be off."""
    losing = [i for i, t in enumerate(propulsion.thrusters) if t.diameter is not None] if propulsion.meets_water else []
    failed = [i for i, code in enumerate(propulsion.failure) if code]
    return (
        Term("loss by speed", bool(losing), f"thrusters {losing}" if losing else "no meets_water or no diameter"),
        Term("failures", bool(failed), f"thrusters {failed}" if failed else "none has failed"),
    )
