"""A line at rest in a current or towed steadily: parameters, ports, sizes and validity range."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.constants import SEA_WATER_DENSITY
from components.contract import Parameters, Port, Sizes, Term, choice, motion_ports, quantity
from components.tether.quasistatic import mesh, validity

Vector = tuple[float, float, float]


class Quasistatic(Parameters):
    """A uniform elastic line under weight and drag, at rest in the frame of its ends at every instant."""

    length: float = quantity("m", "unstretched length", tunable=True, gt=0)
    weight: float = quantity("N/m", "weight in water per unstretched length; negative: buoyant", tunable=True)
    axial_stiffness: float = quantity("N", "EA", tunable=True, gt=0)
    segments: Annotated[int, Field(ge=1)] = choice("number of equal segments; twice as many are solved as well", 50)
    drag_diameter: float = quantity("m", "diameter that drag refers to", tunable=True, ge=0)
    normal_drag: float = quantity("1", "C_n of rho d C_n |v_n| v_n / 2 per length", 1.2, tunable=True, ge=0)
    tangential_drag: float = quantity("1", "C_t of rho pi d C_t |v_t| v_t / 2 per length", 0.0, tunable=True, ge=0)
    fluid_density: float = quantity("kg/m^3", "density of the fluid", SEA_WATER_DENSITY, tunable=True, ge=0)
    current_depth: tuple[float, ...] = quantity("m", "depths (z in NED) of the current's table, increasing", ())
    current: tuple[Vector, ...] = quantity("m/s", "current at these depths, NED; linear between, constant beyond", ())
    current_input: bool = choice("whether an input `current` adds a current that is the same at all depths", False)
    end_b: Literal["driven", "free"] = choice("the last end: driven by a motion, or free with a body on it", "driven")
    body_weight: float = quantity("N", "weight in water of the body at a free end", 0.0, tunable=True)
    body_drag_area: float = quantity("m^2", "C_d A of the body at a free end", 0.0, tunable=True, ge=0)
    tolerance: float = quantity("1", "shift of the shape, over the length, at the border of validity", 0.01, gt=0)
    virtual_mass: float | None = quantity("kg/m", "dry plus added mass per length, to judge validity by", None, gt=0)
    bending_stiffness: float | None = quantity("N m^2", "EI, to judge validity by", None, gt=0)

    @model_validator(mode="after")
    def _fits(self) -> Quasistatic:
        if len(self.current_depth) != len(self.current):
            raise ValueError(
                f"current_depth has {len(self.current_depth)} depths and current {len(self.current)} velocities: "
                "give one velocity for each depth"
            )
        if any(b <= a for a, b in zip(self.current_depth, self.current_depth[1:], strict=False)):
            raise ValueError("current_depth does not increase: list the depths downwards, each once")
        if self.end_b == "driven" and (self.body_weight or self.body_drag_area):
            raise ValueError("body_weight and body_drag_area belong to a free end: set end_b to free, or drop them")
        return self

    def vector(self) -> np.ndarray:
        """The constants in the order of line.py, the validity's five and the current's table: (16 + 4 k,) float64."""
        pressure = 0.5 * self.fluid_density
        drag = pressure * self.drag_diameter
        flexibility = 1.0 / self.axial_stiffness
        line = [self.length, self.segments, flexibility, self.weight, drag * self.normal_drag]
        line += [drag * pi * self.tangential_drag, self.end_b == "free", self.body_weight]
        line += [pressure * self.body_drag_area, self.current_input]
        shift = self.tolerance * self.length
        limits = validity.numbers(shift, self.virtual_mass, 0.0, self.bending_stiffness, flexibility)
        table = [number for z, u in zip(self.current_depth, self.current, strict=True) for number in (z, *u)]
        return np.array([*line, *limits, len(self.current_depth), *table], np.float64)


def inputs(line: Quasistatic) -> tuple[Port, ...]:
    """The motions of the driven ends (a common velocity is a steady tow), and a current if wanted."""
    ports = motion_ports("end_a") + (motion_ports("end_b") if line.end_b == "driven" else ())
    current = Port("current", "m/s", (3,), "NED", "added to the table's, the same at all depths")
    return (*ports, current) if line.current_input else ports


def outputs(line: Quasistatic) -> tuple[Port, ...]:
    """Shape, tension, forces on the holders, the solver's account, and the validity as far as it is known."""
    nodes = line.segments + 1
    ports = (
        Port("nodes", "m", (nodes, 3), "NED", "positions from end a to end b"),
        Port("tension", "N", (nodes,), "", "at the nodes"),
        Port("force_a", "N", (3,), "NED", "of the line on what holds end a"),
        Port("force_b", "N", (3,), "NED", "of the line on what holds end b; zero at a free end"),
        Port("converged", "1", (), "", "1 if both meshes were solved, else 0: then the shape is not in balance"),
        Port("residual", "1", (), "", "largest imbalance of a node over all load, or misfit over the length"),
        Port("iterations", "1", (), "", "Newton iterations on both meshes"),
        Port("error", "m", (), "", "estimated error of the nodes: that of the finer mesh, by which they are improved"),
        Port("tension_error", "N", (), "", "estimated error of the tension, likewise"),
    )
    return ports + validity.ports(line.virtual_mass is not None, line.bending_stiffness is not None)


def sizes(line: Quasistatic) -> Sizes:
    """No state; the records of the finer mesh and both meshes' results as scratch."""
    return Sizes(workspace=mesh.workspace(line.segments))


def terms(line: Quasistatic) -> tuple[Term, ...]:
    """What of the model is on."""
    pressure = line.fluid_density * line.drag_diameter
    along, across = line.tangential_drag * pressure, line.normal_drag * pressure
    return (
        Term("normal drag", across > 0.0, f"normal_drag {line.normal_drag:g} on {line.drag_diameter:g} m"),
        Term("tangential drag", along > 0.0, f"tangential_drag {line.tangential_drag:g} on {line.drag_diameter:g} m"),
        Term("current profile", bool(line.current), f"{len(line.current)} depths of current"),
        Term("current from outside", line.current_input, f"current_input is {str(line.current_input).lower()}"),
        Term("body at a free end", line.end_b == "free", f"end_b is {line.end_b}"),
    )
