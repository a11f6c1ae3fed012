"""What controllers of position have in common: gains, the reference's limits and waypoints."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from components.contract import Parameters, choice, quantity

Positive = Annotated[float, Field(gt=0)]
Level = tuple[float, float]


class Waypoint(Parameters):
    """Where to go, and how long to stay."""

    position: Level = quantity("m", "north and east")
    depth: float = quantity("m", "of an ROV", 0.0)
    heading: float = quantity("rad", "clockwise from north", 0.0)
    stay: float = quantity("s", "from arrival on", 0.0, ge=0)
    speed: float | None = quantity("m/s", "of the reference on the way; none: max_speed", None, gt=0)


class Tuning(Parameters):
    """PID gains by pole placement: K_p = m w^2, K_d = 2 zeta w m - d, K_i = share w K_p (Fossen 2011, alg. 12.1)."""

    integral_share: float = quantity("1", "of each natural frequency: how fast the integral is", 0.1, ge=0, le=0.5)
    position: Level = quantity("m", "to keep: north and east", (0.0, 0.0), tunable=True)
    heading: float = quantity("rad", "to keep", 0.0, tunable=True)
    waypoints: tuple[Waypoint, ...] = choice("to go to in turn instead", ())
    repeats: bool = choice("whether it goes to the first waypoint after the last", False)
    radius: float = quantity("m", "within which a waypoint is reached", gt=0)
    angle: float = quantity("rad", "within which its heading is reached", 0.05, gt=0)
    reference_frequency: float = quantity("rad/s", "of the reference on its way", gt=0)
    max_speed: float = quantity("m/s", "of the reference", tunable=True, gt=0)
    max_acceleration: float = quantity("m/s^2", "of the reference", tunable=True, gt=0)
    turn_frequency: float = quantity("rad/s", "of the reference as it turns", gt=0)
    max_turn_rate: float = quantity("rad/s", "of the reference", tunable=True, gt=0)
    max_turn_acceleration: float = quantity("rad/s^2", "of the reference", tunable=True, gt=0)

    @model_validator(mode="after")
    def _repeats_something(self) -> Tuning:
        if self.repeats and len(self.waypoints) < 2:
            raise ValueError("repeats needs two waypoints at least")
        return self

    def numbers(
        self, masses: list[float], damping: list[float], frequencies: list[float], ratios: list[float], depth: float
    ) -> list[float]:
        """The numbers of layout.py, of four axes each."""
        proportional = [m * w * w for m, w in zip(masses, frequencies, strict=True)]
        integral = [k * w * self.integral_share for k, w in zip(proportional, frequencies, strict=True)]
        axes = zip(masses, damping, frequencies, ratios, strict=True)
        derivative = [max(2.0 * zeta * w * m - d, 0.0) for m, d, w, zeta in axes]
        rows = [
            number
            for one in self.waypoints
            for number in (*one.position, one.depth, one.heading, one.stay, one.speed or self.max_speed)
        ]
        return [
            *proportional, *integral, *derivative, *masses, *damping,
            self.reference_frequency, self.max_speed, self.max_acceleration,
            self.turn_frequency, self.max_turn_rate, self.max_turn_acceleration, self.radius, self.angle,
            self.repeats, len(self.waypoints), *self.position, depth, self.heading, *rows,
        ]  # fmt: skip
