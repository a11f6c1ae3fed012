"""Waypoint control of an ROV: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from components.contract import Port, Sizes, Term, choice, quantity
from components.controller.layout import AXES, STATES
from components.controller.tuning import Tuning

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Three = tuple[Positive, Positive, Positive]


class RovControl(Tuning):
    """Keeps position, depth and heading, or goes to waypoints, within the thrust that there is in each direction."""

    mass: Three = quantity("kg", "surge, sway, heave, added mass included")
    yaw_inertia: float = quantity("kg m^2", "added inertia included", gt=0)
    linear_damping: tuple[NotNegative, NotNegative, NotNegative] = quantity("N s/m", "of these", (0.0, 0.0, 0.0))
    yaw_damping: float = quantity("N m s", "linear", 0.0, ge=0)
    frequency: Three = quantity("rad/s", "natural frequencies of surge, sway and heave under control")
    yaw_frequency: float = quantity("rad/s", "of yaw", gt=0)
    damping_ratio: float = quantity("1", "of all", 0.9, gt=0)
    depth: float = quantity("m", "to keep", 0.0, tunable=True)
    max_force: Three = quantity("N", "that the thrusters give in surge, sway, heave, both ways", tunable=True)
    max_moment: float = quantity("N*m", "that they give in yaw, both ways", tunable=True, gt=0)
    takes_line: bool = choice("whether it has the input `line_force`, which it works against", False)
    hook: tuple[float, float] = quantity("m", "where the line pulls: forward, starboard", (0.0, 0.0))

    def vector(self) -> np.ndarray:
        """Largest loads (4), switch, hook (2), then the numbers of layout.py."""
        masses, damping = [*self.mass, self.yaw_inertia], [*self.linear_damping, self.yaw_damping]
        own = [*self.max_force, self.max_moment, self.takes_line, *self.hook]
        ratios = [self.damping_ratio] * AXES
        return np.array(
            [*own, *self.numbers(masses, damping, [*self.frequency, self.yaw_frequency], ratios, self.depth)]
        )


def inputs(rov: RovControl) -> tuple[Port, ...]:
    """How the vehicle moves, and the line's pull where the parameters name it."""
    ports = (
        Port("vehicle.position", "m", (3,), "NED"),
        Port("vehicle.attitude", "rad", (3,), "NED", "roll, pitch, heading"),
        Port("vehicle.velocity", "m/s", (3,), "body", "over the ground"),
        Port("vehicle.rates", "rad/s", (3,), "body", "of roll, pitch, yaw"),
    )
    line = Port("line_force", "N", (3,), "NED", "of the line on the vehicle at the hook")
    return ports + ((line,) if rov.takes_line else ())


def outputs(_: RovControl) -> tuple[Port, ...]:
    """Thrust within its limits, the reference, and how far the vehicle is from it."""
    return (
        Port("thrust.force", "N", (3,), "body", "surge, sway, heave"),
        Port("thrust.moment", "N*m", (), "body", "yaw"),
        Port("reference.position", "m", (3,), "NED"),
        Port("reference.heading", "rad", (), "NED", "continuous"),
        Port("error.position", "m", (3,), "body", "from the vehicle to the reference"),
        Port("error.heading", "rad", (), "body"),
        Port("waypoint", "1", (), "", "which is gone to, from 0"),
        Port("arrived", "1", (), "", "1: it is reached"),
        Port("limited", "1", (), "", "1: the thrust is at a limit"),
        Port("held", "1", (), "", "1: an input was no number, and the last thrust is held"),
    )


def sizes(_: RovControl) -> Sizes:
    """State: see layout.py, then the last thrust (4). Scratch: position, velocity, error (4 each)."""
    return Sizes(state=STATES + AXES, workspace=3 * AXES)


def terms(rov: RovControl) -> tuple[Term, ...]:
    """What can be off."""
    count = len(rov.waypoints)
    return (
        Term("line feed-forward", rov.takes_line, f"takes_line is {rov.takes_line}".lower()),
        Term("waypoints", count > 0, f"{count} of them" if count else "it keeps position, depth and heading"),
    )
