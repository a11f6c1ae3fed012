"""An ROV in surge, sway, heave and yaw: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from components.constants import GRAVITY
from components.contract import Parameters, Port, Sizes, Term, choice, law_ports, motion_ports, quantity
from components.vessel.rov.layout import WORKSPACE

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector = tuple[float, float, float]
ZERO = (0.0, 0.0, 0.0)


class Rov(Parameters):
    """M nu_r' + C(nu_r) nu_r + (D + D_n |nu_r|) nu_r = tau; Fossen 2011, eq. 6.111; roll and pitch are held level."""

    mass: float = quantity("kg", "dry", tunable=True, gt=0)
    yaw_inertia: float = quantity("kg m^2", "dry", tunable=True, gt=0)
    added_mass: tuple[NotNegative, NotNegative, NotNegative] = quantity("kg", "surge, sway, heave", ZERO, tunable=True)
    added_yaw_inertia: float = quantity("kg m^2", "added", 0.0, tunable=True, ge=0)
    damping: tuple[NotNegative, NotNegative, NotNegative] = quantity("N s/m", "surge, sway, heave", ZERO, tunable=True)
    yaw_damping: float = quantity("N m s", "linear", 0.0, tunable=True, ge=0)
    quadratic: tuple[NotNegative, NotNegative, NotNegative] = quantity("kg/m", "surge, sway, heave", ZERO, tunable=True)
    yaw_quadratic: float = quantity("kg m^2", "quadratic", 0.0, tunable=True, ge=0)
    volume: float = quantity("m^3", "displaced", tunable=True, ge=0)
    water_density: float = quantity("kg/m^3", "of the water", 1025.97, gt=0)
    max_speed: float = quantity("m/s", "through the water up to which the coefficients hold", gt=0)

    position: Vector = quantity("m", "at t0, NED", ZERO)
    heading: float = quantity("rad", "at t0, clockwise from north", 0.0)
    velocity: Vector = quantity("m/s", "at t0, surge, sway and heave over the ground", ZERO)
    yaw_rate: float = quantity("rad/s", "at t0", 0.0)
    hook: Vector = quantity("m", "where the tether is made fast: forward, starboard, down", ZERO)
    takes_thrust: bool = choice("whether it has the input `thrust`", False)
    takes_current: bool = choice("whether it has the input `current`", False)
    takes_force: bool = choice("whether it has the input `force`, at the hook", False)
    takes_law: bool = choice("whether a power bond ties the hook to a line", False)

    @property
    def wet_weight(self) -> float:
        """Weight less buoyancy [N], down."""
        return (self.mass - self.water_density * self.volume) * GRAVITY

    def vector(self) -> np.ndarray:
        """Masses (5), linear and quadratic damping (4 each), wet weight, start (8), hook, max_speed, switches (4)."""
        surge, sway, heave = (self.mass + added for added in self.added_mass)
        masses = (surge, sway, heave, self.yaw_inertia + self.added_yaw_inertia, 0.0)
        start = (*self.position, self.heading, *self.velocity, self.yaw_rate)
        switches = (self.takes_thrust, self.takes_current, self.takes_force, self.takes_law)
        numbers = (
            *masses, *self.damping, self.yaw_damping, *self.quadratic, self.yaw_quadratic, self.wet_weight, *start,
            *self.hook, self.max_speed, *switches,
        )  # fmt: skip
        return np.array(numbers, np.float64)


def inputs(rov: Rov) -> tuple[Port, ...]:
    """The forces and the water that the parameters ask for; what is held, is held over the step."""
    ports: tuple[Port, ...] = ()
    if rov.takes_thrust:
        ports += (
            Port("thrust.force", "N", (3,), "body", "surge, sway, heave"),
            Port("thrust.moment", "N*m", (), "body", "yaw"),
        )
    if rov.takes_current:
        ports += (Port("current", "m/s", (3,), "NED", "velocity of the water"),)
    if rov.takes_force:
        ports += (Port("force", "N", (3,), "NED", "at the hook"),)
    return ports + (law_ports("line") if rov.takes_law else ())


def outputs(rov: Rov) -> tuple[Port, ...]:
    """Motion of the vehicle and of the hook, and how far the model may be believed."""
    ports = (
        Port("position", "m", (3,), "NED", "of the reference point"),
        Port("attitude", "rad", (3,), "NED", "roll and pitch, which are 0, and heading, continuous"),
        Port("velocity", "m/s", (3,), "body", "over the ground"),
        Port("rates", "rad/s", (3,), "body", "of roll, pitch, yaw"),
        Port("water_velocity", "m/s", (3,), "body", "through the water"),
        *motion_ports("hook"),
        Port("validity.range", "1", (), "", "the largest of those below"),
        Port("validity.speed", "1", (), "", "through the water over max_speed"),
        Port("validity.depth", "1", (), "", "1 at the surface, where it would float up out of the water, and above"),
        Port("validity.balance", "1", (), "", "change of the accelerations in the last iteration over 1e-8 of them"),
    )
    yields = Port("accelerance", "1/kg", (3, 3), "NED", "d acceleration / d force of the hook over a step")
    return ports + ((yields,) if rov.takes_law else ())


def sizes(_: Rov) -> Sizes:
    """State: positions, rates, accelerations and algorithmic ones (4 each). Scratch: see layout.py."""
    return Sizes(state=16, workspace=WORKSPACE)


def terms(rov: Rov) -> tuple[Term, ...]:
    """What can be off."""
    return (
        Term("current", rov.takes_current, f"takes_current is {str(rov.takes_current).lower()}"),
        Term("wet weight", rov.wet_weight != 0.0, f"{rov.wet_weight:.3g} N down"),
        Term("bonded tether", rov.takes_law, "at the hook" if rov.takes_law else "none"),
    )
