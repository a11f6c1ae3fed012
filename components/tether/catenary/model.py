"""The static line between two points: parameters, ports and validity range."""

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.constants import SEA_WATER_DENSITY
from components.contract import Parameters, Port, Term, choice, motion_ports, quantity
from components.tether.catenary import validity

Vector = tuple[float, float, float]


class Catenary(Parameters):
    """A uniform line under a uniform load between two points, at rest at every instant."""

    length: float = quantity("m", "unstretched length", tunable=True, gt=0)
    weight: float | None = quantity(
        "N/m", "weight in water per unstretched length, down; negative: buoyant", None, tunable=True
    )
    load: Vector | None = quantity(
        "N/m",
        "all load per unstretched length (weight, buoyancy, steady drag), NED, instead of weight",
        None,
        tunable=True,
    )
    load_input: bool = choice("whether an input `load` adds a steady load from outside", False)
    axial_stiffness: float | None = quantity("N", "EA; none: inextensible", None, tunable=True, gt=0)
    segments: Annotated[int, Field(ge=1)] = choice(
        "number of equal parts (of unstretched length) between the nodes", 20
    )
    seabed: float | None = quantity("m", "depth (z in NED) of a level seabed; none: no seabed", None)
    seabed_friction: float = quantity(
        "1", "Coulomb's mu between the seabed and the line, one end of which is anchored on it", 0.0, ge=0
    )
    tolerance: float = quantity("1", "shift of the shape, over the length, at the border of validity", 0.01, gt=0)
    virtual_mass: float | None = quantity(
        "kg/m", "dry plus added mass per length, to judge validity by; none: weight/g", None, gt=0
    )
    drag_diameter: float | None = quantity("m", "diameter that drag refers to, to judge validity by", None, gt=0)
    normal_drag: float = quantity("1", "C_n of rho d C_n |v_n| v_n / 2 per length, for the same", 1.2, ge=0)
    fluid_density: float = quantity("kg/m^3", "density of the fluid, for the same", SEA_WATER_DENSITY, ge=0)
    bending_stiffness: float | None = quantity("N m^2", "EI, to judge validity by", None, gt=0)

    @model_validator(mode="after")
    def _fits(self):
        if (self.weight is None) == (self.load is None):
            given = "neither" if self.weight is None else "both"
            raise ValueError(f"weight and load: {given} of them is given; exactly one says what the line carries")
        if self.seabed_friction > 0.0 and self.seabed is None:
            raise ValueError(f"seabed_friction is {self.seabed_friction:g} without a seabed; give the seabed's depth")
        if self.seabed is not None:
            self._can_lie()
        return self

    def _can_lie(self):
        north, east, down = self.load_vector()
        if north != 0.0 or east != 0.0:
            raise ValueError(
                f"load is ({north:g}, {east:g}, {down:g}) N/m: on a level seabed the load must be vertical, "
                "(0, 0, weight); leave the seabed out or take tether.cable"
            )
        if down <= 0.0:
            name = "weight" if self.load is None else "load"
            raise ValueError(f"{name} is {down:g} N/m down: only a line heavier than water can lie on a seabed")
        if self.load_input:
            raise ValueError("load_input is true: on a seabed the load must be vertical and known beforehand")

    def load_vector(self) -> Vector:
        """The load per unstretched length from the parameters [N/m], NED."""
        return self.load if self.load is not None else (0.0, 0.0, self.weight or 0.0)

    def assessed(self) -> tuple[bool, bool, bool]:
        """Whether drag, bending and strain can be judged."""
        given = (self.drag_diameter, self.bending_stiffness, self.axial_stiffness)
        drag, bending, strain = (value is not None for value in given)
        return drag, bending, strain

    def vector(self) -> np.ndarray:
        """Length, 1/EA, segments, seabed (whether, depth, friction), load (3), whether more comes in, validity (5)."""
        flexibility = 0.0 if self.axial_stiffness is None else 1.0 / self.axial_stiffness
        seabed = (0.0, 0.0) if self.seabed is None else (1.0, self.seabed)
        drag = 0.5 * self.fluid_density * (self.drag_diameter or 0.0) * self.normal_drag
        shift = self.tolerance * self.length
        limits = validity.numbers(shift, self.virtual_mass, drag, self.bending_stiffness, flexibility)
        numbers = [self.length, flexibility, self.segments, *seabed, self.seabed_friction, *self.load_vector()]
        return np.array([*numbers, self.load_input, *limits], np.float64)


def inputs(parameters: Catenary) -> tuple[Port, ...]:
    """The motions of both ends, of which the positions matter (the rest for the validity), and a load if wanted."""
    load = (Port("load", "N/m", (3,), "NED", "steady load per unstretched length, added to the parameters'"),)
    return motion_ports("end_a") + motion_ports("end_b") + (load if parameters.load_input else ())


def outputs(parameters: Catenary) -> tuple[Port, ...]:
    """Shape, tension, what the line does to the things that hold its ends, and its validity as far as it is known."""
    nodes = parameters.segments + 1
    shape = (
        Port("nodes", "m", (nodes, 3), "NED", "positions from end a to end b"),
        Port("tension", "N", (nodes,), "", "at the nodes"),
        Port("force_a", "N", (3,), "NED", "of the line on what holds end a"),
        Port("force_b", "N", (3,), "NED", "of the line on what holds end b"),
        Port("horizontal_tension", "N", (), "", "across the load, the same all along the line but for seabed friction"),
        Port("catenary_parameter", "1/m", (), "", "C = |q|/H, Drupt et al. 2022, eq. 4; the largest double if H = 0"),
        Port("sag", "m", (), "", "how far the line goes beyond the end that is farther along the load"),
        Port("touches_seabed", "1", (), "", "1 where a part of the line lies on the seabed, else 0"),
        Port("grounded_length", "m", (), "", "unstretched length that lies on the seabed"),
    )
    return shape + validity.ports(*parameters.assessed())


def terms(line: Catenary) -> tuple[Term, ...]:
    """What of the model is on."""
    q = line.load_vector()
    ea, bed = line.axial_stiffness, line.seabed
    return (
        Term("elasticity", ea is not None, "no axial_stiffness" if ea is None else f"axial_stiffness {ea:g} N"),
        Term("inclined load", q[0] != 0.0 or q[1] != 0.0, f"load ({q[0]:g}, {q[1]:g}, {q[2]:g}) N/m"),
        Term("load from outside", line.load_input, f"load_input is {str(line.load_input).lower()}"),
        Term("seabed", bed is not None, "no seabed" if bed is None else f"seabed at {bed:g} m"),
        Term("seabed friction", line.seabed_friction > 0.0, f"seabed_friction is {line.seabed_friction:g}"),
    )
