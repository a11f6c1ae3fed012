"""The static line between two points: parameters, ports and validity range."""

import numpy as np
from pydantic import model_validator

from components.contract import Parameters, Port, choice, motion_ports, quantity


class Catenary(Parameters):
    """A uniform line that hangs in still water between two points, at rest at every instant."""

    length: float = quantity("m", "unstretched length", tunable=True, gt=0)
    weight: float = quantity("N/m", "weight in water per unstretched length; negative: buoyant", tunable=True)
    axial_stiffness: float | None = quantity("N", "EA; none: inextensible", None, gt=0)
    segments: int = choice("number of equal parts (of unstretched length) between the nodes", 20)
    seabed: float | None = quantity("m", "depth (z in NED) of a level seabed without friction; none: no seabed", None)

    @model_validator(mode="after")
    def _fits(self):
        if self.segments < 1:
            raise ValueError(f"segments is {self.segments}: a line has at least 1")
        if self.seabed is not None and self.weight <= 0.0:
            raise ValueError(f"weight is {self.weight:g} N/m: only a line heavier than water can lie on a seabed")
        return self

    def vector(self) -> np.ndarray:
        """Length, weight, elasticity w L/EA, segments, whether there is a seabed, its depth."""
        flexibility = 0.0 if self.axial_stiffness is None else 1.0 / self.axial_stiffness
        seabed = (0.0, 0.0) if self.seabed is None else (1.0, self.seabed)
        return np.array([self.length, self.weight, flexibility, self.segments, *seabed], np.float64)


def inputs(_: Catenary) -> tuple[Port, ...]:
    """The motions of both ends, of which the positions matter."""
    return motion_ports("end_a") + motion_ports("end_b")


def outputs(parameters: Catenary) -> tuple[Port, ...]:
    """Shape, tension, and what the line does to the things that hold its ends."""
    nodes = parameters.segments + 1
    return (
        Port("nodes", "m", (nodes, 3), "NED", "positions from end a to end b"),
        Port("tension", "N", (nodes,), "", "at the nodes"),
        Port("force_a", "N", (3,), "NED", "of the line on what holds end a"),
        Port("force_b", "N", (3,), "NED", "of the line on what holds end b"),
        Port("horizontal_tension", "N", (), "", "the same all along the line"),
        Port("catenary_parameter", "1/m", (), "", "C = |w|/H, Drupt et al. 2022, eq. 4; the largest double if H = 0"),
        Port("sag", "m", (), "", "lowest point below the lower end (buoyant: highest point above the higher end)"),
        Port("touches_seabed", "1", (), "", "1 where a part of the line lies on the seabed, else 0"),
        Port("grounded_length", "m", (), "", "unstretched length that lies on the seabed"),
    )
