"""Wind with gusts that veers: its parameters, ports and sizes."""

from __future__ import annotations

from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from components.contract import Parameters, Port, Sizes, Term, choice, quantity
from components.environment.wind.spectra import amplitudes, bins, mean_at


class Wind(Parameters):
    """A one-hour mean with gusts along it; its direction is where it comes from, clockwise from north."""

    speed: float = quantity("m/s", "one-hour mean at 10 m", tunable=True, ge=0, le=80)
    direction: float = quantity("rad", "that it comes from, at t0", tunable=True)
    veer: float = quantity("rad/s", "how fast it turns clockwise", 0.0, tunable=True)
    rise: float = quantity("m/s^2", "how fast the mean grows; the gusts grow with it", 0.0, tunable=True)
    height: float = quantity("m", "above the sea, for which wind is given", 10.0, ge=1)
    gusts: Literal["none", "npd", "harris", "davenport"] = choice("spectrum of the gusts", "npd")
    harmonics: Annotated[int, Field(ge=1, le=1000)] = choice("that the gusts are made of", 100)
    lowest: float = quantity("Hz", "frequency of the gusts; ISO 19901-1 has them from 1/600", 1.0 / 600.0, gt=0)
    highest: float = quantity("Hz", "frequency of the gusts; above it they are smaller than a vessel", 0.5, gt=0)

    @property
    def has_gusts(self) -> bool:
        """Whether there are any."""
        return self.gusts != "none"

    def vector(self) -> np.ndarray:
        """Mean at the height, direction, veer, rise, harmonics n, edges [rad/s] (n + 1), amplitudes (n).

        The rise is that at 10 m; the ratio of the means at both heights is taken as it is at t0.
        """
        mean = mean_at(self.speed, self.height)
        ratio = mean / self.speed if self.speed > 0.0 else mean_at(1e-9, self.height) / 1e-9
        head = [mean, self.direction, self.veer, self.rise * ratio]
        if not self.has_gusts:
            return np.array([*head, 0.0])
        edges = bins(self.lowest, self.highest, self.harmonics)
        gusts = amplitudes(self.gusts, edges, max(self.speed, REFERENCE), self.height)
        reference = mean_at(max(self.speed, REFERENCE), self.height)
        return np.concatenate([head, [self.harmonics], 2.0 * pi * edges, gusts / reference])


# Below this mean [m/s] gusts are taken in proportion to it, as they are while it rises.
REFERENCE = 5.0


def outputs(_: Wind) -> tuple[Port, ...]:
    """The air's motion at the height."""
    return (
        Port("velocity", "m/s", (3,), "NED", "of the air"),
        Port("speed", "m/s", (), "", "mean and gust"),
        Port("direction", "rad", (), "NED", "that it comes from"),
        Port("mean", "m/s", (), "", "without the gusts"),
    )


def sizes(wind: Wind) -> Sizes:
    """Turn and rise since t0, frequencies and phases."""
    return Sizes(state=2 + 2 * (wind.harmonics if wind.has_gusts else 0))


def terms(wind: Wind) -> tuple[Term, ...]:
    """What can be off."""
    return (Term("gusts", wind.has_gusts, f"gusts is {wind.gusts}"),)
