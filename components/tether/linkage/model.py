"""A chain of rigid segments in a plane, such as a floating boom: parameters, ports and sizes."""

from __future__ import annotations

from math import hypot, pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.constants import SEA_WATER_DENSITY
from components.contract import Parameters, Port, Sizes, Term, choice, motion_ports, quantity
from components.tether.linkage import validity
from components.tether.linkage.chain import ARC, DRIVEN, FREE, GIVEN, PULLED, SCRATCH, STATE, STEADY

Vector = tuple[float, float, float]
End = Literal["driven", "pulled", "free"]
ENDS = {"driven": DRIVEN, "pulled": PULLED, "free": FREE}
STARTS = {"steady": STEADY, "arc": ARC, "given": GIVEN}
# What given angles may miss a driven end b by, over the length.
MISS = 0.01


class Linkage(Parameters):
    """n equal rigid segments with revolute joints, in a plane; a term that is not asked for is off."""

    length: float = quantity("m", "of all segments", gt=0)
    segments: Annotated[int, Field(ge=1)] = choice("number of equal segments", 20)
    plane: Literal["surface", "vertical"] = choice("north and east (afloat), or north and down", "surface")
    normal_friction: float = quantity(
        "N*s/m^2", "c_S: linear drag across, per length and speed", 0.0, tunable=True, ge=0
    )
    tangential_friction: float = quantity(
        "N*s/m^2", "c_V: linear drag along, per length and speed", 0.0, tunable=True, ge=0
    )
    drag_diameter: float = quantity("m", "diameter that quadratic drag refers to", 0.0, tunable=True, ge=0)
    normal_drag: float = quantity("1", "C_n of rho d C_n |v_n| v_n / 2 per length", 1.2, tunable=True, ge=0)
    tangential_drag: float = quantity("1", "C_t of rho pi d C_t |v_t| v_t / 2 per length", 0.0, tunable=True, ge=0)
    fluid_density: float = quantity("kg/m^3", "density of the fluid", SEA_WATER_DENSITY, tunable=True, ge=0)
    mass_per_length: float = quantity("kg/m", "with the water it moves; 0: quasi-static", 0.0, ge=0)
    joint_stiffness: float = quantity("N*m", "of the spring at each joint, per radian", 0.0, tunable=True, ge=0)
    flexural_rigidity: float = quantity("N*m^2", "EI, from which the springs are instead", 0.0, tunable=True, ge=0)
    spring_factor: float = quantity(
        "1", "K of a joint over EI / l0: 1 for many segments; gamma K_theta = 2.21 in (6)", 1.0, tunable=True, gt=0
    )
    weight: float = quantity("N/m", "weight in water per length, in the vertical plane", 0.0, tunable=True)
    seabed: float | None = quantity("m", "depth (z in NED) of a level, frictionless seabed; none: no seabed", None)
    seabed_stiffness: float | None = quantity("N/m^2", "of the seabed, per length of line", None, gt=0)
    seabed_damping_time: float = quantity("s", "tau of the seabed's damping, stiffness times tau", 0.02, ge=0)
    end_a: End = choice("the first end: driven by a motion, pulled by a force, or free", "driven")
    end_b: End = choice("the last end, likewise", "driven")
    parted_a: float = quantity(
        "1", "1 once the tow line at end a has parted: then the end is free", 0, tunable=True, ge=0, le=1
    )
    parted_b: float = quantity("1", "1 once the tow line at end b has parted", 0, tunable=True, ge=0, le=1)
    start: Literal["steady", "arc", "given"] = choice(
        "shape at t0: a steady tow's at the driven ends' mean velocity (if at rest as it hangs, where drag resists; "
        "an arc if it has no weight), an arc, or `angles`",
        "steady",
    )
    side: Literal["starboard", "port"] = choice("where an arc bulges to, seen from end a to end b", "starboard")
    angles: tuple[float, ...] = quantity("rad", "of the segments from north (towards east, or down) at t0", ())
    chord: Vector = quantity("m", "from end a to end b at t0 unless both are driven, NED", (0.0, 0.0, 0.0))
    position: Vector = quantity("m", "of end a at t0 where neither end is driven, NED", (0.0, 0.0, 0.0))
    tolerance: float = quantity(
        "rad", "last correction of an angle in a step; what remains is a few percent", 1e-6, gt=0
    )
    max_iterations: Annotated[int, Field(ge=1)] = choice("Newton iterations of a step", 40)
    shift_tolerance: float = quantity("1", "shift of the shape, over the length, at the border of validity", 0.01, gt=0)
    virtual_mass: float | None = quantity("kg/m", "dry plus added mass per length, to judge validity by", None, gt=0)

    @model_validator(mode="after")
    def _fits(self) -> Linkage:
        if self.weight and self.plane == "surface":
            raise ValueError(
                f"weight is {self.weight:g} N/m, but a line afloat hangs in no plane: set plane to vertical"
            )
        if self.joint_stiffness and self.flexural_rigidity:
            raise ValueError("joint_stiffness beside flexural_rigidity, which gives it: leave one out")
        if (self.seabed is None) != (self.seabed_stiffness is None):
            raise ValueError("a seabed takes its depth (seabed) and seabed_stiffness: give both, or none")
        if self.seabed is not None and self.plane == "surface":
            raise ValueError("a line afloat does not touch the seabed: set plane to vertical, or leave seabed out")
        if self.virtual_mass and self.mass_per_length:
            raise ValueError(
                "virtual_mass judges what a quasi-static line leaves out: leave it out beside mass_per_length"
            )
        if (self.start == "given") != bool(self.angles):
            raise ValueError(
                f"start is {self.start} with {len(self.angles)} angles: give angles with start: given alone"
            )
        if self.angles and len(self.angles) != self.segments:
            raise ValueError(f"{len(self.angles)} angles for {self.segments} segments: give one for each")
        return self

    @model_validator(mode="after")
    def _is_determined(self) -> Linkage:
        c_S, c_V, k_S, k_V = self.drag()
        driven = (self.end_a == "driven") + (self.end_b == "driven")
        if self.mass_per_length == 0.0:
            if c_S == k_S == 0.0:
                raise ValueError("without mass_per_length something must resist: give normal_friction or drag_diameter")
            if not driven and c_V == k_V == 0.0:
                raise ValueError("nothing holds the line along itself: drive an end, or give tangential drag or a mass")
        if driven < 2 and self.start == "steady":
            raise ValueError("a steady start is one between two driven ends: set start to arc (with chord) or given")
        if hypot(*self.chord) > self.length:
            raise ValueError(f"chord is {hypot(*self.chord):g} m long, the line {self.length:g} m")
        return self

    def drag(self) -> tuple[float, float, float, float]:
        """c_S, c_V [N s/m^2], k_S and k_V [N s^2/m^3]: linear and quadratic drag per length, across and along."""
        pressure = 0.5 * self.fluid_density * self.drag_diameter
        square = pressure * self.normal_drag, pi * pressure * self.tangential_drag
        return self.normal_friction, self.tangential_friction, *square

    def spring(self) -> float:
        """Of a joint [N m]: as given, or from EI as in Trigo et al. 2014, (6), K = gamma K_theta EI / l.

        Their factor 0.85 * 2.6 is of two fixed-guided beams in series, which bend into an S; of a line that bends over
        many segments the energy is that of a beam where K = EI / l, so that theirs is 2.21 times too stiff.
        """
        return self.joint_stiffness or self.spring_factor * self.flexural_rigidity * self.segments / self.length

    def bed(self) -> tuple[float, float, float]:
        """Stiffness [N/m^2] (0: no bed), onset [m] and damping time [s] of the bed.

        The onset is twice the depth to which the line's weight sinks in, so that a segment at rest lies within it.
        """
        if self.seabed_stiffness is None:
            return 0.0, 1.0, 0.0
        onset = max(2.0 * abs(self.weight) / self.seabed_stiffness, 1e-6 * self.length)
        return self.seabed_stiffness, onset, self.seabed_damping_time

    @property
    def second(self) -> int:
        """Index of the plane's second axis in NED."""
        return 1 if self.plane == "surface" else 2

    def vector(self) -> np.ndarray:
        """The constants in the order of chain.py, and the angles: (29 + n,) float64."""
        line = [self.length, self.segments, *self.drag(), self.mass_per_length, self.spring(), self.weight]
        line += [self.second, ENDS[self.end_a], ENDS[self.end_b], self.parted_a, self.parted_b]
        line += [self.tolerance, self.max_iterations, self.shift_tolerance * self.length, self.virtual_mass or 0.0]
        line += [STARTS[self.start], self.chord[0], self.chord[self.second], *self.position]
        line += [1.0 if self.side == "starboard" else -1.0, self.seabed or 0.0, *self.bed()]
        return np.array([*line, *self.angles], np.float64)


def inputs(line: Linkage) -> tuple[Port, ...]:
    """Motions of driven ends, forces on pulled ones."""
    ports: tuple[Port, ...] = ()
    for name, kind in (("a", line.end_a), ("b", line.end_b)):
        if kind == "driven":
            ports += motion_ports(f"end_{name}")
        if kind == "pulled":
            ports += (Port(f"pull_{name}", "N", (3,), "NED", f"force on end {name}"),)
    return ports


def outputs(line: Linkage) -> tuple[Port, ...]:
    """Shape, tension, forces on the holders, the solver's account, and the validity as far as it is known."""
    n = line.segments
    ports = (
        Port("nodes", "m", (n + 1, 3), "NED", "positions from end a to end b"),
        Port("tension", "N", (n,), "", "of each segment, the mean of its ends'; negative where it is pressed"),
        Port("force_a", "N", (3,), "NED", "of the line on what holds end a; zero at a free end"),
        Port("force_b", "N", (3,), "NED", "of the line on what holds end b; zero at a free end"),
        Port("angle", "rad", (n,), "", "of each segment from north, turns counted"),
        Port("converged", "1", (), "", "1 if the step was solved, else 0"),
        Port("iterations", "1", (), "", "Newton iterations of the step"),
        Port("miss", "m", (), "", "distance of the last node from a driven end b"),
        Port("damped", "1", (), "", "1 where the ends' distance left the force along a straight line open, else 0"),
    )
    return ports + validity.ports(line.virtual_mass is not None)


def sizes(line: Linkage) -> Sizes:
    """A record for each node in both vectors."""
    nodes = line.segments + 1
    return Sizes(state=STATE * nodes, workspace=SCRATCH * nodes)


def terms(line: Linkage) -> tuple[Term, ...]:
    """What of the model is on."""
    c_S, c_V, k_S, k_V = line.drag()
    return (
        Term("linear drag", c_S + c_V > 0.0, f"friction {c_S:g} across and {c_V:g} N s/m^2 along"),
        Term("quadratic drag", k_S + k_V > 0.0, f"{k_S:g} across and {k_V:g} N s^2/m^3 along"),
        Term("inertia", line.mass_per_length > 0.0, f"mass_per_length {line.mass_per_length:g} kg/m"),
        Term("springs", line.spring() > 0.0, f"{line.spring():g} N m at each joint"),
        Term("weight", line.weight != 0.0, f"weight {line.weight:g} N/m"),
        Term(
            "seabed",
            line.seabed is not None,
            "no seabed given" if line.seabed is None else f"seabed at {line.seabed:g} m",
        ),
        Term("force at an end", "pulled" in (line.end_a, line.end_b), f"end_a {line.end_a}, end_b {line.end_b}"),
    )
