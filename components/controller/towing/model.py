"""A boat that tows along a path, abeam of another one: its parameters, ports and sizes."""

from __future__ import annotations

from itertools import chain
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Port, Sizes, Term, choice, quantity
from components.controller.path import BEFORE, CURVATURE, LENGTH, lay
from components.controller.towing.layout import SCRATCH, STATES
from components.vessel.linear import LinearVessel

Level = tuple[float, float]


class Towing(LinearVessel):
    """Steers a boat with two propellers along a path, at a distance beside it, at a speed, and abeam of a partner."""

    path: Annotated[tuple[Level, ...], Field(min_length=2)] = quantity("m", "corners in turn, north and east")
    turn_radius: float = quantity("m", "of the arcs that round the corners", gt=0)
    is_closed: bool = choice("whether the path leads from its last corner to the first, round and round", False)
    offset: float = quantity("m", "of the boat's way to starboard of the path", 0.0, tunable=True)
    speed: float = quantity("m/s", "along the path", tunable=True, ge=0)
    max_speed: float = quantity(
        "m/s", "that the boat is asked for, to catch up or outside of a turn", tunable=True, gt=0
    )
    max_acceleration: float = quantity("m/s^2", "of the speed asked for", gt=0)
    takes_partner: bool = choice("whether it has the input `partner`, whom it keeps abeam of", False)
    gathering: float = quantity("1/s", "change of speed over the way that it is behind its partner", 0.1, ge=0)
    lookahead: float = quantity("m", "to the point on the path that is steered for", gt=0)
    integral: float = quantity("1", "way aside steered for, over the integral of the error along the way", 0.1, ge=0)
    drift_time: float = quantity("s", "over which the drift's angle is taken", 2.0, gt=0)
    turn_frequency: float = quantity("rad/s", "natural frequency of the heading under control", gt=0)
    turn_damping_ratio: float = quantity("1", "of the heading", 1.0, gt=0)
    max_turn_rate: float = quantity("rad/s", "that the boat is asked for", gt=0)
    speed_frequency: float = quantity("rad/s", "natural frequency of the speed under control", gt=0)
    speed_damping_ratio: float = quantity("1", "of the speed", 1.0, gt=0)
    square_damping: float = quantity("kg/m", "-X_|u|u, fed forward", 0.0, ge=0)
    arm: float = quantity("m", "of each propeller from the middle line", gt=0)
    max_thrust: float = quantity("N", "of each", tunable=True, gt=0)
    reverse_thrust: float = quantity("N", "of each, astern", 0.0, tunable=True, ge=0)
    takes_line: bool = choice("whether it has the input `line_force`, which it works against", False)
    hook: Level = quantity("m", "where the line pulls: forward, starboard", (0.0, 0.0))
    line_share: float = quantity("1", "part of the line's pull that is fed forward", 1.0, tunable=True, ge=0, le=1)
    radius: float = quantity("m", "from the end of the path within which the boat has arrived", 0.5, ge=0)

    @model_validator(mode="after")
    def _can_be_gone(self) -> Towing:
        pieces = lay(self.path, self.turn_radius, self.is_closed)
        if abs(self.offset) >= self.turn_radius and any(piece[CURVATURE] for piece in pieces):
            raise ValueError(
                f"offset is {self.offset:g} m, turn_radius {self.turn_radius:g} m: in a turn the inner boat must be "
                "nearer to the path than that"
            )
        if self.speed > self.max_speed:
            raise ValueError(f"speed is {self.speed:g} m/s, above max_speed ({self.max_speed:g} m/s)")
        return self

    def vector(self) -> np.ndarray:
        """As layout.py names them, and the pieces of path.py."""
        pieces = lay(self.path, self.turn_radius, self.is_closed)
        way = pieces[-1][BEFORE] + pieces[-1][LENGTH]
        stiffness = 2.0 * self.turn_damping_ratio * self.turn_frequency
        yaw_gain = max(stiffness * self.yaw_inertia - self.yaw_damping, 0.0)
        # Yaw is I r' + d r = gain (turn - r) + d turn with turn = share * error: share by the stiffness K_p = I w^2.
        share = self.yaw_inertia * self.turn_frequency**2 / (yaw_gain + self.yaw_damping)
        surge_gain = 2.0 * self.speed_damping_ratio * self.speed_frequency * self.surge_mass - self.surge_damping
        numbers = [
            self.takes_partner, self.takes_line, self.offset, self.speed, self.max_speed, self.gathering,
            self.lookahead, self.integral, self.drift_time, share, yaw_gain, self.yaw_damping, self.max_turn_rate,
            max(surge_gain, 0.0), self.surge_mass * self.speed_frequency**2, self.max_acceleration, self.surge_mass,
            self.surge_damping, self.square_damping, self.arm, self.max_thrust, self.reverse_thrust, self.line_share,
            *self.hook, self.radius, self.is_closed, way, len(pieces),
        ]  # fmt: skip
        return np.array([*numbers, *chain(*pieces)], np.float64)


def inputs(towing: Towing) -> tuple[Port, ...]:
    """Where the boat is, where its partner is, and the line's pull, as the parameters name them."""
    ports = (
        Port("estimate.position", "m", (2,), "NED", "north and east"),
        Port("estimate.heading", "rad", (), "NED"),
        Port("estimate.velocity", "m/s", (2,), "body", "surge and sway over the ground"),
        Port("estimate.yaw_rate", "rad/s", (), "body"),
    )
    if towing.takes_partner:
        ports += (Port("partner", "m", (2,), "NED", "the other boat's position, north and east"),)
    if towing.takes_line:
        ports += (Port("line_force", "N", (3,), "NED", "of the line on the boat at the hook"),)
    return ports


def outputs(_: Towing) -> tuple[Port, ...]:
    """Commands of the propellers, port and starboard, what is steered for, and how far the boat is from it."""
    return (
        Port("command.thrust", "N", (2,), "", "port, starboard; negative in reverse"),
        Port("command.azimuth", "rad", (2,), "body", "ahead"),
        Port("reference.heading", "rad", (), "NED", "that is steered"),
        Port("reference.speed", "m/s", (), "body", "in surge"),
        Port("error.across", "m", (), "", "of the boat to starboard of its way"),
        Port("error.along", "m", (), "", "way that it is ahead of its partner"),
        Port("error.heading", "rad", (), "body", "from the boat to the reference"),
        Port("error.speed", "m/s", (), "body", "from the boat to the reference"),
        Port("integral.across", "m", (), "", "of the steering"),
        Port("integral.force", "N", (), "body", "in surge"),
        Port("progress", "m", (), "", "way along the path from its begin, rounds included"),
        Port("arrived", "1", (), "", "1: at the end of an open path"),
        Port("limited", "1", (), "", "1: the propellers cannot give what is asked for"),
        Port("held", "1", (), "", "1: an input was no number, and the last thrust is held"),
        Port("alone", "1", (), "", "1: the partner's position was no number, and the last way ahead of it is held"),
    )


def sizes(_: Towing) -> Sizes:
    """State and scratch: see layout.py."""
    return Sizes(state=STATES, workspace=SCRATCH)


def terms(towing: Towing) -> tuple[Term, ...]:
    """What can be off."""
    switches = {"formation": "takes_partner", "line feed-forward": "takes_line"}
    return (
        *(
            Term(what, getattr(towing, on), f"{on} is {str(getattr(towing, on)).lower()}")
            for what, on in switches.items()
        ),
        Term("integral line of sight", towing.integral > 0.0, f"integral is {towing.integral:g}"),
    )
