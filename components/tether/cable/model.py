"""A 3D elastic line between two ends: its parameters, ports and sizes."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.constants import GRAVITY
from components.contract import Parameters, Port, Sizes, choice, law_ports, motion_ports, quantity
from components.tether.cable.pieces import Clump, Level, Section, Wave
from components.tether.cable.table import numbers, places, spans

End = Literal["driven", "free"]
Winch = Literal["none", "a", "b"]


class Cable(Parameters):
    """A line lumped into nodes, ends driven, bonded or free; a term that is not asked for is off."""

    length: float = quantity("m", "unstretched length", gt=0)
    segments: Annotated[int, Field(ge=1)] = choice("number of equal segments", 50)
    mass_per_length: float = quantity("kg/m", "dry mass per length", tunable=True, gt=0)
    volume_per_length: float = quantity("m^2", "displaced volume per length", tunable=True, ge=0)
    drag_diameter: float = quantity("m", "diameter that drag refers to", tunable=True, ge=0)
    axial_stiffness: float | None = quantity(
        "N", "EA; none: inextensible, or on a bond as stiff as 1e7 times the line's weight", None, tunable=True, gt=0
    )
    damping_time: float = quantity(
        "s", "tau of T = EA (e + tau de/dt), whatever the mesh; without it impacts ring on", 0.0, tunable=True, ge=0
    )
    tension_only: bool | None = choice(
        "a chain or rope takes no compression, T = max(0, T); by default unless `bending_stiffness` is given", None
    )
    normal_drag: float = quantity("1", "C_n of rho d C_n |v_n| v_n / 2 per length", 1.2, tunable=True, ge=0)
    tangential_drag: float = quantity("1", "C_t of rho pi d C_t |v_t| v_t / 2 per length", 0.0, tunable=True, ge=0)
    normal_added_mass: float = quantity("1", "added over displaced mass, across", 1.0, tunable=True, ge=0)
    tangential_added_mass: float = quantity("1", "added over displaced mass, along", 0.0, tunable=True, ge=0)
    fluid_density: float = quantity("kg/m^3", "density of the fluid", 1025.0, tunable=True, ge=0)
    gravity: float = quantity("m/s^2", "acceleration of gravity, down", GRAVITY, tunable=True)
    end_a: End = choice("the first end: driven by a motion, or free", "driven")
    end_b: End = choice("the last end: driven by a motion, or free", "driven")
    bond_a: bool = choice("whether a power bond ties the first end to a body", False)
    bond_b: bool = choice("whether a power bond ties the last end to a body", False)
    rho_inf: float = quantity(
        "1",
        "spectral radius of generalised-alpha at infinite frequency; 0 is taken on a bond and where slack",
        0.5,
        ge=0,
        le=1,
    )
    sub_steps: Annotated[int, Field(ge=0)] = choice("steps of the line within its period; 0: as `accuracy` asks", 0)
    tolerance: float = quantity("1", "imbalance of a node, relative to dry weight plus tension", 1e-6, gt=0)
    max_iterations: Annotated[int, Field(ge=1)] = choice("Newton iterations before a step is tried again in parts", 60)

    bending_stiffness: float = quantity("N*m^2", "EI", 0.0, tunable=True, ge=0)
    clamp_a: tuple[float, float, float] | None = quantity(
        "1", "direction from end a to b in which end a is clamped, NED; none: hinged", None
    )
    clamp_b: tuple[float, float, float] | None = quantity(
        "1", "direction from end a to b in which end b is clamped, NED; none: hinged", None
    )
    current: tuple[float, float, float] = quantity("m/s", "of the water, NED, the same at all depths", (0.0,) * 3)
    current_profile: tuple[Level, ...] = choice("current at several depths instead, linear between", ())
    current_input: bool = choice("whether another component gives a current on top", False)
    current_depths: tuple[float, ...] = quantity(
        "m", "depths at which that one is given, linear between; none: it is the same at all", ()
    )
    waves: tuple[Wave, ...] = choice("Airy waves that are summed up; the mean surface is at z = 0", ())
    water_depth: float | None = quantity("m", "for the waves; none: deep", None, gt=0)
    seabed: float | None = quantity("m", "depth (z in NED) of a level seabed; none: no seabed", None)
    seabed_stiffness: float | None = quantity(
        "N/m^2",
        "upward force per length and depth of sinking; by default the line sinks by 0.1 drag diameters",
        None,
        gt=0,
    )
    seabed_damping_time: float | None = quantity(
        "s", "tau of k (s + tau ds/dt); by default a node that lands is damped critically", None, ge=0
    )
    seabed_friction: float = quantity("1", "Coulomb's coefficient between line and seabed", 0.0, ge=0)
    sections: tuple[Section, ...] = choice("parts of other properties, from end a; they sum up to the length", ())
    clumps: tuple[Clump, ...] = choice("clump weights and floats on the line", ())

    @property
    def slackens(self) -> bool:
        """Whether the line takes no compression."""
        return self.bending_stiffness == 0.0 if self.tension_only is None else self.tension_only

    @model_validator(mode="after")
    def _sections_fit(self) -> Cable:
        if self.sections:
            length, segments = sum(s.length for s in self.sections), sum(s.segments for s in self.sections)
            if abs(self.length - length) > 1e-9 * length or self.segments != segments:
                raise ValueError(
                    f"sections sum up to {length:g} m in {segments} segments, but length is {self.length:g} m and "
                    f"segments {self.segments}: write there what they sum up to"
                )
        own = [i for i, s in enumerate(self.sections) if s.axial_stiffness is not None]
        if own and self.axial_stiffness is None:
            raise ValueError(
                f"sections.{own[0]} has an axial_stiffness, but a line that has none is inextensible as a whole: "
                "give the line's too"
            )
        for i, clump in enumerate(self.clumps):
            if clump.at > self.length * (1.0 + 1e-9):
                raise ValueError(f"clumps.{i} is at {clump.at:g} m of a line of {self.length:g} m")
        return self

    @model_validator(mode="after")
    def _water_fits(self) -> Cable:
        if any(self.current) and self.current_profile:
            raise ValueError("give either current or current_profile")
        profile = [level.depth for level in self.current_profile]
        for name, depths in (("current_profile has the depths", profile), ("current_depths are", self.current_depths)):
            if any(low >= high for low, high in pairwise(depths)):
                raise ValueError(f"{name} {list(depths)}: expected each below the last")
        if self.current_depths and not self.current_input:
            raise ValueError("current_depths are those of the input `current`: set current_input, or leave them out")
        if self.waves and self.gravity <= 0.0:
            raise ValueError(f"waves need gravity, which is {self.gravity:g} m/s^2")
        return self

    @model_validator(mode="after")
    def _bed_fits(self) -> Cable:
        if self.seabed is None:
            if self.seabed_friction > 0.0:
                raise ValueError("seabed_friction without a seabed: give its depth as seabed, or leave it out")
            return self
        weight = sum(s.weight * s.segments for s in spans(self))
        if self.seabed_stiffness is None and (weight == 0.0 or self.drag_diameter == 0.0):
            raise ValueError("seabed_stiffness has no default for a line without weight or drag_diameter: give it")
        return self

    @model_validator(mode="after")
    def _clamps_fit(self) -> Cable:
        for name, clamp, kind in (("clamp_a", self.clamp_a, self.end_a), ("clamp_b", self.clamp_b, self.end_b)):
            if clamp is None:
                continue
            if abs(sum(c * c for c in clamp) - 1.0) > 1e-6:
                raise ValueError(f"{name} is {clamp}: expected a direction of length 1")
            if kind == "free":
                raise ValueError(f"{name} clamps a free end: make it driven")
            if self.bending_stiffness == 0.0 and not any(s.bending_stiffness for s in self.sections):
                raise ValueError(f"{name} clamps a line without bending_stiffness: give it, or leave {name} out")
        return self

    # stepping, winch, break
    accuracy: float = quantity(
        "1", "position error that a sub-step may make, over the length; a tension may err by EA times it", 1e-5, gt=0
    )
    breaking_load: float = quantity("N", "tension at which the line breaks; 0: it never does", 0.0, tunable=True, ge=0)
    cut: int = quantity("1", "segment to cut now, the first at end a being 1; 0: none", 0, tunable=True, ge=0)
    winch: Winch = choice("the end at which a winch pays the line out and hauls it in", "none")
    shortest: float = quantity("1", "length at which the winch stops hauling in, over `length`", 0.05, gt=0, le=1)

    @model_validator(mode="after")
    def _ends_fit(self) -> Cable:
        if self.end_a == self.end_b == "free":
            raise ValueError("end_a and end_b are both free: a line held nowhere has no equilibrium to start from")
        for end, kind, bond in (("a", self.end_a, self.bond_a), ("b", self.end_b, self.bond_b)):
            if bond and kind == "free":
                raise ValueError(f"bond_{end} ties an end to a body that end_{end} leaves free: make it driven")
        if (self.bond_a or self.bond_b) and self.sub_steps > 1:
            raise ValueError(f"sub_steps is {self.sub_steps}, but a bonded line takes 1: its law is for one step")
        if self.cut > self.segments:
            raise ValueError(f"cut is {self.cut}, but the line has {self.segments} segments")
        if self.winch != "none" and (self.sections or self.clumps):
            raise ValueError("a winch moves material past the nodes: it takes no sections and no clumps")
        if self.winch != "none" and getattr(self, f"end_{self.winch}") == "free":
            raise ValueError(f"the winch is at end {self.winch}, which is free: make end_{self.winch} driven")
        return self

    def vector(self) -> np.ndarray:
        """The constants of the discrete line in the order of Line's fields, then the tables of its terms."""
        return numbers(self)


def inputs(cable: Cable) -> tuple[Port, ...]:
    """A motion bundle for each driven end, and the current if another component gives it."""
    ports = motion_ports("end_a") if cable.end_a == "driven" else ()
    ports += motion_ports("end_b") if cable.end_b == "driven" else ()
    if cable.current_input:
        shape = (len(cable.current_depths), 3) if cable.current_depths else (3,)
        ports += (Port("current", "m/s", shape, "NED", "velocity of the water, on top of the parameters'"),)
    if cable.winch != "none":
        ports += (Port("payout_rate", "m/s", (), "", "unstretched length per time that the winch lets out"),)
    return ports


def outputs(cable: Cable) -> tuple[Port, ...]:
    """Shape, tensions, end forces, the solver's account, for each bonded end its two laws, and how the ends couple."""
    ports = (
        Port("nodes", "m", (cable.segments + 1, 3), "NED", "node positions from end a to end b"),
        Port("tension", "N", (cable.segments,), "", "of each segment"),
        Port("force_a", "N", (3,), "NED", "of the line on what holds end a; zero at a free end"),
        Port("force_b", "N", (3,), "NED", "of the line on what holds end b; zero at a free end"),
        Port("converged", "1", (), "", "1 if all balances of the step met the tolerance, else 0"),
        Port("residual", "N", (), "", "largest imbalance of a node in the step"),
        Port("iterations", "1", (), "", "Newton iterations of the step, trials for the law not counted"),
        Port("sub_steps", "1", (), "", "steps of the line in the period"),
        Port("error", "m", (), "", "largest estimated error that a sub-step made in a node's position"),
        Port("broken_segment", "1", (), "", "the segment that broke or was cut, the first at end a being 1; 0: none"),
        Port("unstretched_length", "m", (), "", "between the ends, what a winch let out or took in counted"),
        Port("validity.range", "1", (), "", "the largest of those below; above 1 the step is not to be believed"),
        Port(
            "validity.balance", "1", (), "", "largest imbalance of a node over the tolerance, or over 1 % of the load"
        ),
        Port("validity.error", "1", (), "", "`error` over what `accuracy` allows"),
        Port("validity.snap", "1", (), "", "tension of an impact that no step shows, over largest tension and weight"),
        Port(
            "validity.strain",
            "1",
            (),
            "",
            "largest strain over 5 %, where T = EA e ceases to hold; of an inextensible line over 1e-6",
        ),
        Port("validity.turn", "1", (), "", "largest angle between neighbouring segments over 0.5 rad"),
        Port("validity.sinking", "1", (), "", "largest depth in the seabed over 1 % of the length"),
        Port("validity.emerging", "1", (), "", "largest height above the waves over 1 % of the length"),
        Port("validity.again", "1", (), "", "of a broken line, which breaks but once: tension over breaking_load"),
    )
    for end, bond in (("a", cable.bond_a), ("b", cable.bond_b)):
        if bond:
            ports += law_ports(f"law_{end}") + law_ports(f"accepted_{end}")
    if cable.bond_a and cable.bond_b:
        ports += (Port("accepted_ab", "kg", (3, 3), "NED", "-dF_a / d acceleration_b about the motion just accepted"),)
    return ports


def sizes(cable: Cable) -> Sizes:
    """A record for each node in both vectors, and what the terms need."""
    where = places(cable)
    return Sizes(state=where.state, workspace=where.workspace)


def axial_spring(cable: Cable) -> float:
    """Axial stiffness between the ends [N/m]; of an inextensible line the method's own."""
    return 1.0 / sum(s.segments / s.k for s in spans(cable))
