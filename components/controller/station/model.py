"""Dynamic positioning: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Port, Sizes, Term, choice, quantity
from components.controller.layout import AXES, STATES
from components.controller.tuning import Tuning
from components.vessel.linear import LinearVessel
from components.vessel.loads import load_ports

Positive = Annotated[float, Field(gt=0)]
Three = tuple[Positive, Positive, Positive]


class Station(Tuning, LinearVessel):
    """Keeps station, changes heading, or goes to waypoints, with what winds and lines do fed forward."""

    frequency: Three = quantity("rad/s", "natural frequencies of surge, sway and yaw under control")
    damping_ratio: Three = quantity("1", "of these", (0.9, 0.9, 0.9))
    takes_achieved: bool = choice("whether it has the input `achieved`, for the integral's bounds", True)
    takes_wind: bool = choice("whether it has the input `wind_load`, which it works against", False)
    wind_share: float = quantity("1", "part of the wind's load that is fed forward", 1.0, tunable=True, ge=0, le=1)
    takes_line: bool = choice("whether it has the input `line_force`, which it works against", False)
    hook: tuple[float, float] = quantity("m", "where the line pulls: forward, starboard", (0.0, 0.0))
    line_share: float = quantity("1", "part of the line's pull that is fed forward", 1.0, tunable=True, ge=0, le=1)

    @model_validator(mode="after")
    def _is_level(self) -> Station:
        if any(one.depth for one in self.waypoints):
            raise ValueError("depth is an ROV's; a vessel's waypoints have none")
        return self

    def vector(self) -> np.ndarray:
        """Switches and shares (5), hook (2), then the numbers of layout.py."""
        surge, sway, yaw = self.frequency
        masses = [self.surge_mass, self.sway_mass, 0.0, self.yaw_inertia]
        damping = [self.surge_damping, self.sway_damping, 0.0, self.yaw_damping]
        ratios = [self.damping_ratio[0], self.damping_ratio[1], 0.0, self.damping_ratio[2]]
        own = [self.takes_achieved, self.takes_wind, self.wind_share, self.takes_line, self.line_share, *self.hook]
        numbers = self.numbers(masses, damping, [surge, sway, 0.0, yaw], ratios, 0.0)
        return np.array([*own, *numbers], np.float64)


def inputs(station: Station) -> tuple[Port, ...]:
    """Where the vessel is, and the loads that the parameters name."""
    ports = (
        Port("estimate.position", "m", (2,), "NED", "north and east"),
        Port("estimate.heading", "rad", (), "NED"),
        Port("estimate.velocity", "m/s", (2,), "body", "surge and sway over the ground"),
        Port("estimate.yaw_rate", "rad/s", (), "body"),
    )
    if station.takes_achieved:
        ports += load_ports("achieved")
    if station.takes_wind:
        ports += load_ports("wind_load")
    if station.takes_line:
        ports += (Port("line_force", "N", (3,), "NED", "of the line on the vessel at the hook"),)
    return ports


def outputs(_: Station) -> tuple[Port, ...]:
    """The demand, the reference, and how far the vessel is from it."""
    return (
        *load_ports("demand"),
        Port("reference.position", "m", (2,), "NED", "north and east"),
        Port("reference.heading", "rad", (), "NED", "continuous"),
        Port("reference.velocity", "m/s", (2,), "NED"),
        Port("reference.yaw_rate", "rad/s", (), "body"),
        Port("error.position", "m", (2,), "body", "from the vessel to the reference"),
        Port("error.heading", "rad", (), "body"),
        Port("integral.force", "N", (2,), "NED", "against slow loads"),
        Port("integral.moment", "N*m", (), "NED"),
        Port("waypoint", "1", (), "", "which is gone to, from 0"),
        Port("arrived", "1", (), "", "1: it is reached"),
        Port("held", "1", (), "", "1: an input was no number, and the last demand is held"),
    )


def sizes(_: Station) -> Sizes:
    """State: see layout.py, then the last demand (3). Scratch: position, velocity, error, achieved (4 each)."""
    return Sizes(state=STATES + 3, workspace=4 * AXES)


def terms(station: Station) -> tuple[Term, ...]:
    """What can be off."""
    names = {"anti-windup": "takes_achieved", "wind feed-forward": "takes_wind", "line feed-forward": "takes_line"}
    count = len(station.waypoints)
    return (
        *(
            Term(what, getattr(station, on), f"{on} is {str(getattr(station, on)).lower()}")
            for what, on in names.items()
        ),
        Term("waypoints", count > 0, f"{count} of them" if count else "it keeps position and heading"),
    )
