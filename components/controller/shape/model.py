"""Control of a towed line's shape: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Parameters, Port, Sizes, Term, choice, motion_ports, quantity
from components.controller.shape.layout import EDGE, PLAN, law_scratch, plan_scratch

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

    horizon: float | None = quantity("s", "that is planned ahead; none: only the law's next step", None, gt=0)
    knots: Annotated[int, Field(ge=2, le=20)] = choice("of the planned velocities", 8)
    steps: Annotated[int, Field(ge=2, le=200)] = choice("of the line over the horizon", 40)
    passes: Annotated[int, Field(ge=1)] = choice("by which each step betters the plan", 1)
    effort: float = quantity("s^2/m^2", "of the ends' mean square speed, beside the mean square error", 1e-4, gt=0)

    @model_validator(mode="after")
    def _has_drag(self) -> Shape:
        if self.normal_drag < self.tangential_drag:
            raise ValueError("normal_drag is below tangential_drag: a line is dragged more across than along")
        return self

    def vector(self) -> np.ndarray:
        """Segments, length, drag (2), gain, max_speed, damping, horizon, knots, steps, passes, effort, angles."""
        numbers = [self.length, self.normal_drag, self.tangential_drag, self.gain, self.max_speed, self.damping]
        numbers += [self.horizon or 0.0, self.knots, self.steps, self.passes, self.effort]
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
    n = len(shape.angles)
    if shape.horizon is None:
        return Sizes(state=PLAN, workspace=law_scratch(n))
    scratch = law_scratch(n) + plan_scratch(n, shape.knots, shape.steps)
    return Sizes(state=PLAN + EDGE * shape.knots, workspace=scratch)


def terms(shape: Shape) -> tuple[Term, ...]:
    """What can be off."""
    planned = f"{shape.horizon} s ahead" if shape.horizon else "no horizon: Bhattacharya et al. 2011, eq. 25"
    return (Term("planning", shape.horizon is not None, planned),)
