"""Control of a towed line's shape: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from components.contract import Parameters, Port, Sizes, motion_ports, quantity
from components.controller.shape.layout import STATES, scratch

MOST = 100


class Shape(Parameters):
    """Drives both ends of a line of equal segments to where the segments have the angles asked for."""

    angles: tuple[float, ...] = quantity(
        "rad", "of the segments from the left end on, clockwise from north", tunable=True, min_length=1, max_length=MOST
    )
    length: float = quantity("m", "of the line", gt=0)
    normal_drag: float = quantity("N s/m^2", "c_S, per metre across the line", gt=0)
    tangential_drag: float = quantity("N s/m^2", "c_V, per metre along the line", ge=0)
    gain: float = quantity("1/s", "K: rate of a segment over its error", 0.1, tunable=True, gt=0)
    max_speed: float = quantity("m/s", "of the ends", tunable=True, gt=0)
    damping: float = quantity("1", "of the pseudo-inverse, over the root mean square of its columns", 0.01, ge=0)

    @model_validator(mode="after")
    def _has_drag(self) -> Shape:
        if self.normal_drag < self.tangential_drag:
            raise ValueError("normal_drag is below tangential_drag: a line is dragged more across than along")
        return self

    def vector(self) -> np.ndarray:
        """Segments, length, drag (2), gain, max_speed, damping, angles."""
        numbers = [self.length, self.normal_drag, self.tangential_drag, self.gain, self.max_speed, self.damping]
        return np.array([len(self.angles), *numbers, *self.angles], np.float64)


def inputs(shape: Shape) -> tuple[Port, ...]:
    """The line."""
    return (Port("nodes", "m", (len(shape.angles) + 1, 3), "NED", "from the left end to the right one"),)


def outputs(shape: Shape) -> tuple[Port, ...]:
    """Where the ends go, and how far the shape is from the one asked for."""
    return (
        *motion_ports("left"),
        *motion_ports("right"),
        Port("error.angles", "rad", (len(shape.angles),), "NED", "asked for less present, between -180 and 180 deg"),
        Port("error.largest", "rad", (), "", "of these"),
        Port("limited", "1", (), "", "1: the ends would have to be faster"),
    )


def sizes(shape: Shape) -> Sizes:
    """See layout.py."""
    return Sizes(state=STATES, workspace=scratch(len(shape.angles)))
