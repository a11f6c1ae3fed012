"""A current over depth that varies slowly: its parameters, ports and sizes."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Parameters, Port, Sizes, Term, choice, quantity


class Level(Parameters):
    """The current at a depth."""

    depth: float = quantity("m", "below the mean surface", ge=0)
    speed: float = quantity("m/s", "of the water", ge=0)
    direction: float = quantity("rad", "that it runs to, clockwise from north", 0.0)


class Stream(Parameters):
    """A steady profile, linear between its levels, times a factor, plus a slow variation alike at all depths."""

    profile: Annotated[tuple[Level, ...], Field(min_length=1)] = choice(
        "from the top down", (Level(depth=0.0, speed=0.0),)
    )
    factor: float = quantity("1", "by which the profile's speeds are multiplied", 1.0, tunable=True)
    turn: float = quantity("rad", "by which the profile is turned clockwise", 0.0, tunable=True)
    variation: float = quantity("m/s", "standard deviation of the slow variation, north and east each", 0.0, ge=0)
    variation_time: float = quantity("s", "its time constant", 600.0, gt=0)
    depths: Annotated[tuple[float, ...], Field(min_length=1)] = quantity("m", "at which the current is given", (0.0,))

    @model_validator(mode="after")
    def _goes_down(self) -> Stream:
        depths = [level.depth for level in self.profile]
        if any(low >= high for low, high in pairwise(depths)):
            raise ValueError(f"profile has the depths {depths}: expected each below the last")
        return self

    def vector(self) -> np.ndarray:
        """Factor, turn, variation, its time, depths m, levels n, depths (m), levels (n, 4)."""
        rows = [
            (one.depth, one.speed * np.cos(one.direction), one.speed * np.sin(one.direction), 0.0)
            for one in self.profile
        ]
        head = [self.factor, self.turn, self.variation, self.variation_time, len(self.depths), *self.depths]
        return np.concatenate([head, [len(rows)], np.ravel(rows)])


def outputs(stream: Stream) -> tuple[Port, ...]:
    """The water's motion."""
    return (
        Port("surface", "m/s", (3,), "NED", "velocity at the surface"),
        Port("velocity", "m/s", (len(stream.depths), 3), "NED", "at the depths"),
        Port("variation", "m/s", (3,), "NED", "what varies slowly of it"),
    )


def sizes(_: Stream) -> Sizes:
    """Counter and variation."""
    return Sizes(state=3)


def terms(stream: Stream) -> tuple[Term, ...]:
    """What can be off."""
    on = stream.variation > 0.0
    return (Term("slow variation", on, f"variation is {stream.variation:g} m/s"),)
