"""What the two linear filters take and give: a line whose markers are at the ends of its bars."""

from __future__ import annotations

from math import pi

import numpy as np
from pydantic import model_validator

from components.contract import Port, Term, quantity
from components.estimator import line, modal
from components.estimator.line import NEAR, Line


class Linear(Line):
    """Markers are at the nodes, from the pivot or from the first bar's end on."""

    interval: float = quantity("s", "between frames: the component's period", gt=0)
    start_force: float = quantity("N*m", "standard deviation of the first modal forces", 0.1, gt=0)

    @model_validator(mode="after")
    def _markers_are_at_the_nodes(self) -> Linear:
        if abs(self.spacing - self.bar) > NEAR * self.length or min(self.first, abs(self.first - self.bar)) > NEAR:
            raise ValueError(
                f"markers {self.spacing:g} m apart, the first at {self.first:g} m, are not at the ends of bars of "
                f"{self.bar:g} m: set spacing to that, and first to it or to 0"
            )
        if any(not abs(angle) < pi for angle in self.angles):
            raise ValueError(f"angles are {self.angles} rad: expected those of a nearly level line, between -pi and pi")
        return self

    def numbers(self, model: modal.Modal) -> np.ndarray:
        """In the order of linear.py."""
        head = [self.bars, self.markers, 1.0 if self.first > 0.5 * self.bar else 0.0, self.bar, self.interval]
        head += [self.gate, self.marker_noise**2, self.takes_covariance, self.chain_noise**2]
        head += [*self.position, bool(self.angles), self.start_angle**2, self.start_rate**2]
        head += [self.start_force**2, self.believed_after]
        angles = self.angles or (0.0,) * self.bars
        return np.concatenate([np.array([*head, *angles], np.float64), *modal.numbers(self, model)])


def outputs(given: Linear) -> tuple[Port, ...]:
    """Those of all estimators: a chord a bar, a marker a reading."""
    return line.outputs(given, given.bars, given.markers)


def terms(given: Linear) -> tuple[Term, ...]:
    """What of the model is on."""
    k = given.spring_factor * given.flexural_rigidity / given.bar
    return (
        Term("springs", k > 0.0, f"{k:g} N m at each joint"),
        Term("spring at the pivot", given.clamp and k > 0.0, f"clamp is {given.clamp}"),
        Term("damping", given.normal_friction > 0.0, f"normal_friction {given.normal_friction:g} N s/m^2"),
        Term("covariance from outside", given.takes_covariance, f"takes_covariance is {given.takes_covariance}"),
        Term("markers beside the chain", given.chain_noise > 0.0, f"chain_noise {given.chain_noise:g} m"),
    )
