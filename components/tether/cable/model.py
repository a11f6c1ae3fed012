"""A 3D elastic line between two ends: its parameters, ports and sizes."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.constants import GRAVITY
from components.contract import Parameters, Port, Sizes, choice, law_ports, motion_ports, quantity
from components.tether.cable.line import BONDED, DRIVEN, FREE, ON_MESH, RATE, SCALE, SCRATCH, STATE, Line

End = Literal["driven", "free"]
Winch = Literal["none", "a", "b"]


class Cable(Parameters):
    """A uniform line without bending stiffness, lumped into nodes, in still fluid; ends driven, bonded or free."""

    length: float = quantity("m", "unstretched length", gt=0)
    segments: Annotated[int, Field(ge=1)] = choice("number of equal segments", 50)
    mass_per_length: float = quantity("kg/m", "dry mass per length", tunable=True, gt=0)
    volume_per_length: float = quantity("m^2", "displaced volume per length", tunable=True, ge=0)
    drag_diameter: float = quantity("m", "diameter that drag refers to", tunable=True, ge=0)
    axial_stiffness: float = quantity("N", "EA", tunable=True, gt=0)
    damping_time: float = quantity(
        "s", "tau of T = EA (e + tau de/dt): axial damping EA tau [N s], whatever the mesh", 0.0, tunable=True, ge=0
    )
    tension_only: bool = choice("a chain or rope takes no compression: T = max(0, T)", True)
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

    # stepping, winch, break
    accuracy: float = quantity("1", "position error that a sub-step may make, over the length", 3e-5, gt=0)
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
        if self.winch != "none" and getattr(self, f"end_{self.winch}") == "free":
            raise ValueError(f"the winch is at end {self.winch}, which is free: make end_{self.winch} driven")
        return self

    def vector(self) -> np.ndarray:
        """The constants of the discrete line, in the order of Line's fields."""
        l0 = self.length / self.segments
        displaced = self.fluid_density * self.volume_per_length
        pressure = 0.5 * self.fluid_density * self.drag_diameter * l0 / 2
        line = Line(
            n=self.segments,
            end_a=_kind(self.end_a, self.bond_a),
            end_b=_kind(self.end_b, self.bond_b),
            l0=l0,
            k=self.axial_stiffness / l0,
            tau=self.damping_time,
            mass=self.mass_per_length * l0 / 2,
            added_n=displaced * self.normal_added_mass * l0 / 2,
            added_t=displaced * self.tangential_added_mass * l0 / 2,
            weight=(self.mass_per_length - displaced) * self.gravity * l0 / 2,
            drag_n=pressure * self.normal_drag,
            drag_t=pressure * pi * self.tangential_drag,
            tension_only=self.tension_only,
            rho_inf=0.0 if self.bond_a or self.bond_b else self.rho_inf,
            sub_steps=self.sub_steps,
            tolerance=self.tolerance,
            max_iterations=self.max_iterations,
            dry_weight=self.mass_per_length * GRAVITY * self.length,
            length=self.length,
            accuracy=self.accuracy * self.length,
            breaking_load=self.breaking_load,
            winch={"none": 0, "a": 1, "b": -1}[self.winch],
            least_scale=self.shortest,
            event_cut=self.cut,
            scale=1.0,
            payout=0.0,
            payout_change=0.0,
            cut=-1,
        )
        return np.array(line[: Line._fields.index("scale")], np.float64)


def _kind(end: End, bond: bool) -> int:
    return FREE if end == "free" else BONDED if bond else DRIVEN


def inputs(cable: Cable) -> tuple[Port, ...]:
    """A motion bundle for each driven end."""
    ports = motion_ports("end_a") if cable.end_a == "driven" else ()
    ports += motion_ports("end_b") if cable.end_b == "driven" else ()
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
        Port("validity.balance", "1", (), "", "largest imbalance of a node over the tolerance"),
        Port("validity.error", "1", (), "", "`error` over what `accuracy` allows"),
        Port("validity.snap", "1", (), "", "tension of an impact that no step shows, over largest tension and weight"),
        Port("validity.strain", "1", (), "", "largest strain over 5 %, where T = EA e ceases to hold"),
        Port("validity.turn", "1", (), "", "largest angle between neighbouring segments over 0.5 rad"),
    )
    for end, bond in (("a", cable.bond_a), ("b", cable.bond_b)):
        if bond:
            ports += law_ports(f"law_{end}") + law_ports(f"accepted_{end}")
    if cable.bond_a and cable.bond_b:
        ports += (Port("accepted_ab", "kg", (3, 3), "NED", "-dF_a / d acceleration_b about the motion just accepted"),)
    return ports


def sizes(cable: Cable) -> Sizes:
    """A record for each node in both vectors, a copy of the state in w, and what the steps and the winch remember."""
    node = SCRATCH + STATE + (ON_MESH if cable.winch != "none" else 0)
    memory = SCALE if cable.winch == "none" else RATE + 1
    return Sizes(state=STATE * (cable.segments + 1) + memory, workspace=node * (cable.segments + 1))
