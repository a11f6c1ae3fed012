"""A rigid mass on linear springs and dampers: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from components.contract import Parameters, Port, Sizes, Term, choice, law_ports, motion_ports, quantity

NotNegative = Annotated[float, Field(ge=0)]
Vector = tuple[float, float, float]
Three = tuple[NotNegative, NotNegative, NotNegative]
ZERO = (0.0, 0.0, 0.0)


class Mass(Parameters):
    """The simplest body on a line: it moves without turning, and its hook is its centre."""

    mass: float = quantity("kg", "mass, added mass included", tunable=True, gt=0)
    weight: Vector = quantity("N", "constant force, NED: weight less buoyancy, a steady push", ZERO, tunable=True)
    stiffness: Three = quantity("N/m", "of the springs to the rest position, along NED", ZERO, tunable=True)
    damping: Three = quantity("N s/m", "of the dampers, along NED", ZERO, tunable=True)
    rest: Vector = quantity("m", "position where the springs are free, NED", ZERO, tunable=True)
    position: Vector = quantity("m", "at t0, NED", ZERO)
    velocity: Vector = quantity("m/s", "at t0, NED", ZERO)
    acceleration: Vector = quantity(
        "m/s^2", "at t0, NED: zero for a start in balance; the line's force is not known before the first step", ZERO
    )
    takes_force: bool = choice("whether it has the input `force`", False)
    takes_law: bool = choice("whether it has the input `line`, the force law of a bonded line", False)

    def vector(self) -> np.ndarray:
        """Mass, weight, stiffness, damping, rest, position, velocity, acceleration, then the two switches: (24,)."""
        numbers = (self.mass, *self.weight, *self.stiffness, *self.damping, *self.rest)
        start = (*self.position, *self.velocity, *self.acceleration)
        return np.array((*numbers, *start, self.takes_force, self.takes_law), np.float64)


def inputs(mass: Mass) -> tuple[Port, ...]:
    """The forces that the parameters ask for."""
    force = (Port("force", "N", (3,), "NED", "held over the step"),) if mass.takes_force else ()
    return force + (law_ports("line") if mass.takes_law else ())


def outputs(mass: Mass) -> tuple[Port, ...]:
    """The hook's motion; with a law, how it yields to a force."""
    yields = Port("accelerance", "1/kg", (3, 3), "NED", "d acceleration / d force of the hook over a step")
    return motion_ports("hook") + ((yields,) if mass.takes_law else ())


def sizes(_: Mass) -> Sizes:
    """Position, velocity, true and algorithmic acceleration; one 3x3 system as scratch."""
    return Sizes(state=12, workspace=9)


def terms(mass: Mass) -> tuple[Term, ...]:
    """What of the model is on."""
    return (
        Term("springs", any(mass.stiffness), f"stiffness {_listed(mass.stiffness)} N/m"),
        Term("dampers", any(mass.damping), f"damping {_listed(mass.damping)} N s/m"),
        Term("constant force", any(mass.weight), f"weight {_listed(mass.weight)} N"),
        Term("force from outside", mass.takes_force, f"takes_force is {str(mass.takes_force).lower()}"),
        Term("bonded line", mass.takes_law, "the hook is tied by a bond" if mass.takes_law else "no bond"),
    )


def _listed(vector: Vector) -> str:
    return "(" + ", ".join(f"{number:g}" for number in vector) + ")"
