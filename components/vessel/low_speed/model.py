"""A vessel at low speed in surge, sway and yaw: its parameters, ports and sizes."""

from __future__ import annotations

from math import pi
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.constants import GRAVITY
from components.contract import Parameters, Port, Sizes, Term, choice, law_ports, motion_ports, quantity
from components.vessel.linear import LinearVessel
from components.vessel.loads import load_ports
from components.vessel.low_speed.closed_form import table
from components.vessel.low_speed.layout import WORKSPACE
from components.vessel.windage import AIR, Windage, windage_numbers

NotNegative = Annotated[float, Field(ge=0)]
Vector = tuple[float, float, float]
STRIPS = 20
SEA_WATER = 1026.9  # of EOS-80 at 10 degC and salinity 35 [kg/m^3]


class Damping(Parameters):
    """Damping beyond the linear one, by products of velocities; positive where it resists."""

    surge_surge: float = quantity("kg/m", "-X_|u|u", 0.0, ge=0)
    surge_cubed: float = quantity("kg s/m^2", "-X_uuu", 0.0, ge=0)
    sway_sway: float = quantity("kg/m", "-Y_|v|v", 0.0, ge=0)
    sway_turning: float = quantity("kg", "-Y_|r|v", 0.0)
    sway_drifting: float = quantity("kg", "-Y_|v|r", 0.0)
    sway_yaw: float = quantity("kg m", "-Y_|r|r", 0.0)
    yaw_sway: float = quantity("kg", "-N_|v|v", 0.0)
    yaw_turning: float = quantity("kg m", "-N_|r|v", 0.0)
    yaw_drifting: float = quantity("kg m", "-N_|v|r", 0.0)
    yaw_yaw: float = quantity("kg m^2", "-N_|r|r", 0.0, ge=0)


class CrossFlow(Parameters):
    """Drag across the hull by strips of equal draught, instead of sway_sway and its like."""

    length: float = quantity("m", "of the hull under water", gt=0)
    draught: float = quantity("m", "mean", gt=0)
    coefficient: float = quantity("1", "C_D of a section across the flow", gt=0)
    centre: float = quantity("m", "of the hull, ahead of the reference point", 0.0)


class Hull(Parameters):
    """A hull in waves as a box: see closed_form.py."""

    length: float = quantity("m", "at the waterline", gt=0)
    beam: float = quantity("m", "at the waterline", gt=0)
    draught: float = quantity("m", "mean", gt=0)
    roll_period: float = quantity("s", "natural period of roll", gt=0)
    roll_damping: float = quantity("1", "of roll, over the critical one", gt=0, lt=1)
    bow: float = quantity("1", "part of the short waves that the ends throw back along the vessel", 1.0, ge=0, le=1)
    lever: float = quantity("m", "where the drift force across acts, ahead of the reference point", 0.0)


class Response(Parameters):
    """One line of a table of transfer functions: Re(a H exp(i theta)), theta = k x - omega t + phase.

    Amplitudes per metre of wave amplitude; a phase is by how much the motion's theta is ahead of the wave's at the
    reference point. drift: mean force over the amplitude squared.
    """

    frequency: float = quantity("rad/s", "of the waves", gt=0)
    direction: float = quantity("rad", "that they run to, from the bow: 0 from astern, 180 deg from ahead", ge=0)
    shift: Vector = quantity("1", "amplitudes of surge, sway and heave (down)")
    shift_phase: Vector = quantity("rad", "their phases")
    turn: Vector = quantity("rad/m", "amplitudes of roll, pitch and yaw")
    turn_phase: Vector = quantity("rad", "their phases")
    drift_force: tuple[float, float] = quantity("N/m^2", "surge, sway", (0.0, 0.0))
    drift_moment: float = quantity("N/m", "yaw", 0.0)

    def cell(self) -> list[float]:
        """The table's numbers (15)."""
        amplitudes, phases = (*self.shift, *self.turn), (*self.shift_phase, *self.turn_phase)
        pairs = [(a * np.cos(e), a * np.sin(e)) for a, e in zip(amplitudes, phases, strict=True)]
        return [*np.ravel(pairs), *self.drift_force, self.drift_moment]


class LowSpeed(LinearVessel):
    """M nu_r' + C(nu_r) nu_r + D nu_r + D_n(|nu_r|) nu_r = tau; Fossen 2011, eq. 6.111 and chapter 7."""

    damping: Damping = choice("beyond the linear one", Damping())
    cross_flow: CrossFlow | None = choice("drag across by strips", None)
    windage: Windage | None = choice("what the wind meets; none: it blows over", None)
    hull: Hull | None = choice("the hull in waves, in closed form", None)
    responses: tuple[Response, ...] = choice(
        "the hull in waves, as a table instead: each frequency with each direction, these evenly from 0 to 180 deg", ()
    )
    water_density: float = quantity("kg/m^3", "of the sea", SEA_WATER, gt=0)
    air_density: float = quantity("kg/m^3", "of the air", AIR, gt=0)
    max_speed: float = quantity("m/s", "through the water up to which the coefficients hold", gt=0)

    position: tuple[float, float] = quantity("m", "at t0, north and east", (0.0, 0.0))
    heading: float = quantity("rad", "at t0, clockwise from north", 0.0)
    velocity: tuple[float, float] = quantity("m/s", "at t0, surge and sway over the ground", (0.0, 0.0))
    yaw_rate: float = quantity("rad/s", "at t0", 0.0)
    hook_a: Vector = quantity("m", "a point that lines are made fast to: forward, starboard, down", (0.0, 0.0, 0.0))
    hook_b: Vector = quantity("m", "another one", (0.0, 0.0, 0.0))
    takes_thrust: bool = choice("whether it has the input `thrust`", False)
    takes_wind: bool = choice("whether it has the input `wind`", False)
    takes_current: bool = choice("whether it has the input `current`", False)
    waves: Annotated[int, Field(ge=0)] = choice("components of the input `sea`; 0: it has none", 0)
    takes_load: bool = choice("whether it has the input `load`", False)
    takes_force_a: bool = choice("whether it has the input `force_a`", False)
    takes_force_b: bool = choice("whether it has the input `force_b`", False)
    takes_law_a: bool = choice("whether a power bond ties hook_a to a line", False)
    takes_law_b: bool = choice("whether a power bond ties hook_b to a line", False)

    @model_validator(mode="after")
    def _meets_what_it_takes(self) -> LowSpeed:
        if self.takes_wind and self.windage is None:
            raise ValueError("takes_wind needs windage, what the wind meets")
        if self.waves and self.hull is None and not self.responses:
            raise ValueError("waves needs hull or responses, how the vessel moves in them")
        if self.hull is not None and self.responses:
            raise ValueError("give either hull or responses")
        return self

    @model_validator(mode="after")
    def _responses_are_a_grid(self) -> LowSpeed:
        rows = self.responses
        if not rows:
            return self
        frequencies, directions = sorted({r.frequency for r in rows}), sorted({r.direction for r in rows})
        even = np.linspace(0.0, pi, len(directions))
        if len(rows) != len(frequencies) * len(directions) or min(len(frequencies), len(directions)) < 2:
            raise ValueError(
                f"responses has {len(rows)} lines for {len(frequencies)} frequencies and {len(directions)} directions: "
                "expected one for each pair, and two of each at least"
            )
        if np.abs(np.array(directions) - even).max() > 1e-6:
            raise ValueError("the directions of responses must go evenly from 0 to 180 deg")
        return self

    def response_table(self) -> np.ndarray:
        """The table of seakeeping.look_up; empty where there are no waves."""
        if not self.waves:
            return np.empty(0)
        if self.hull is not None:
            h = self.hull
            return table(
                h.length, h.beam, h.draught, 2.0 * pi / h.roll_period, h.roll_damping, h.bow, h.lever,
                self.water_density, GRAVITY,
            )  # fmt: skip
        rows = sorted(self.responses, key=lambda r: (r.direction, r.frequency))
        frequencies = sorted({r.frequency for r in rows})
        cells = np.array([r.cell() for r in rows])
        return np.concatenate([[len(frequencies), len(rows) // len(frequencies)], frequencies, cells.ravel()])

    def strips(self) -> np.ndarray:
        """(STRIPS, 2) or (0, 2): x [m] and rho C_D T dx / 2 [kg/m]."""
        if self.cross_flow is None:
            return np.empty((0, 2))
        c = self.cross_flow
        x = c.centre + c.length * ((np.arange(STRIPS) + 0.5) / STRIPS - 0.5)
        weight = 0.5 * self.water_density * c.coefficient * c.draught * c.length / STRIPS
        return np.column_stack([x, np.full(STRIPS, weight)])

    def vector(self) -> np.ndarray:
        """Masses (5), damping (15), windage (8), start (6), hooks (6), max_speed, switches (9), strips, table.

        The places of these are named in layout.py.
        """
        masses = (self.surge_mass, self.sway_mass, 1.0, self.yaw_inertia, self.sway_yaw_mass)
        linear = (
            self.surge_damping, self.sway_damping, self.sway_yaw_damping, self.yaw_sway_damping, self.yaw_damping,
        )  # fmt: skip
        start = (*self.position, self.heading, *self.velocity, self.yaw_rate)
        switches = (
            self.takes_thrust, self.takes_wind, self.takes_current, self.waves, self.takes_load, self.takes_force_a,
            self.takes_force_b, self.takes_law_a, self.takes_law_b,
        )  # fmt: skip
        strips = self.strips()
        parts = [
            masses, linear, self.damping.vector(), windage_numbers(self.windage, self.air_density), start,
            self.hook_a, self.hook_b, [self.max_speed], switches, [len(strips)], strips.ravel(), self.response_table(),
        ]  # fmt: skip
        return np.concatenate([np.asarray(part, np.float64) for part in parts])


def sea_ports(bundle: str, n: int) -> tuple[Port, ...]:
    """Components of a sea, see seakeeping.py."""
    return (
        Port(f"{bundle}.amplitude", "m", (n,)),
        Port(f"{bundle}.frequency", "rad/s", (n,)),
        Port(f"{bundle}.wave_number", "rad/m", (n,)),
        Port(f"{bundle}.direction", "rad", (n,), "NED", "that it runs to, clockwise from north"),
        Port(f"{bundle}.phase", "rad", (n,), "", "at the origin at t = 0"),
    )


def inputs(vessel: LowSpeed) -> tuple[Port, ...]:
    """The forces and the surroundings that the parameters ask for; what is held, is held over the step."""
    ports = load_ports("thrust") if vessel.takes_thrust else ()
    if vessel.takes_wind:
        ports += (Port("wind", "m/s", (3,), "NED", "velocity of the air"),)
    if vessel.takes_current:
        ports += (Port("current", "m/s", (3,), "NED", "velocity of the water about the hull"),)
    if vessel.waves:
        ports += sea_ports("sea", vessel.waves)
    if vessel.takes_load:
        ports += load_ports("load")
    for name, on in (("force_a", vessel.takes_force_a), ("force_b", vessel.takes_force_b)):
        if on:
            ports += (Port(name, "N", (3,), "NED", f"at hook_{name[-1]}"),)
    for name, on in (("line_a", vessel.takes_law_a), ("line_b", vessel.takes_law_b)):
        if on:
            ports += law_ports(name)
    return ports


def outputs(vessel: LowSpeed) -> tuple[Port, ...]:
    """Motion with the waves' part and without, loads, the two hooks, and how far the model may be believed."""
    ports = (
        Port("position", "m", (3,), "NED", "of the reference point, waves included"),
        Port("attitude", "rad", (3,), "NED", "roll, pitch, heading; waves included, heading continuous"),
        Port("velocity", "m/s", (3,), "body", "over the ground, waves included"),
        Port("rates", "rad/s", (3,), "body", "of roll, pitch, yaw, waves included"),
        Port("low.position", "m", (2,), "NED", "north and east without the waves' part"),
        Port("low.heading", "rad", (), "NED", "without the waves' part"),
        Port("low.velocity", "m/s", (2,), "body", "surge and sway over the ground"),
        Port("low.yaw_rate", "rad/s", (), "body"),
        Port("water_velocity", "m/s", (2,), "body", "surge and sway through the water"),
        *load_ports("wind_load"),
        *load_ports("drift_load"),
        *motion_ports("hook_a"),
        *motion_ports("hook_b"),
        Port("validity.range", "1", (), "", "the largest of those below"),
        Port("validity.speed", "1", (), "", "through the water over max_speed"),
        Port("validity.slope", "1", (), "", "largest of roll and pitch over 0.35 rad, where sin(x) = x is 2 % off"),
        Port("validity.balance", "1", (), "", "change of the accelerations in the last iteration over 1e-8 of them"),
    )
    for name, on in (("accelerance_a", vessel.takes_law_a), ("accelerance_b", vessel.takes_law_b)):
        if on:
            ports += (Port(name, "1/kg", (3, 3), "NED", f"d acceleration / d force of hook_{name[-1]} over a step"),)
    return ports


def sizes(_: LowSpeed) -> Sizes:
    """State: positions, rates, accelerations and algorithmic ones (4 each). Scratch: see layout.py."""
    return Sizes(state=16, workspace=WORKSPACE)


def terms(vessel: LowSpeed) -> tuple[Term, ...]:
    """What can be off."""
    how = "hull in closed form" if vessel.hull else f"table of {len(vessel.responses)} responses"
    lines = [name for name in ("a", "b") if getattr(vessel, f"takes_law_{name}")]
    return (
        Term("wind", vessel.takes_wind, "takes_wind" if vessel.takes_wind else "takes_wind is false"),
        Term("current", vessel.takes_current, "takes_current" if vessel.takes_current else "takes_current is false"),
        Term("waves", vessel.waves > 0, f"{vessel.waves} components, {how}" if vessel.waves else "waves is 0"),
        Term("cross-flow drag", vessel.cross_flow is not None, "cross_flow" if vessel.cross_flow else "none given"),
        Term("bonded lines", bool(lines), f"at hooks {', '.join(lines)}" if lines else "none"),
    )
