"""An irregular sea: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from components.constants import GRAVITY
from components.contract import Parameters, Port, Sizes, Term, choice, quantity
from components.environment.sea.spectrum import cut, peakedness, spreading
from components.environment.waves import DEEP

QUANTILES = 64


class Sea(Parameters):
    """JONSWAP as a sum of Airy waves, whose frequencies, phases and directions are drawn once."""

    height: float = quantity("m", "significant wave height", ge=0, le=25)
    period: float = quantity("s", "of the spectrum's peak", gt=0)
    direction: float = quantity("rad", "that the waves come from, clockwise from north")
    gamma: float | None = quantity("1", "peakedness; none: by height and period (DNV-RP-C205)", None, ge=1, le=10)
    spread: float = quantity("1", "exponent n of spreading cos^n; 0: long-crested", 0.0, ge=0, le=50)
    components: Annotated[int, Field(ge=1, le=1000)] = choice("of the sum", 100)
    water_depth: float | None = quantity("m", "none: deep", None, gt=0)
    place: tuple[float, float] = quantity("m", "north and east, where the elevation is given", (0.0, 0.0))

    @property
    def peak(self) -> float:
        """gamma."""
        return peakedness(self.height, self.period) if self.gamma is None else self.gamma

    def vector(self) -> np.ndarray:
        """Components n, direction they run to, depth, gravity, place (2), angles (QUANTILES), edges (n + 1), a (n)."""
        edges, amplitudes = cut(self.height, self.period, self.peak, self.components)
        angle, share = spreading(self.spread)
        shares = np.sin(np.linspace(0.0, 0.5 * np.pi, QUANTILES)) ** 2  # close together where the tails are thin
        quantiles = np.interp(shares, share, angle)
        head = [self.components, self.direction + np.pi, self.water_depth or DEEP, GRAVITY, *self.place]
        return np.concatenate([head, quantiles, edges, amplitudes])


def outputs(sea: Sea) -> tuple[Port, ...]:
    """Components, which stay as they are, and the surface."""
    n = sea.components
    return (
        Port("waves.amplitude", "m", (n,)),
        Port("waves.frequency", "rad/s", (n,)),
        Port("waves.wave_number", "rad/m", (n,)),
        Port("waves.direction", "rad", (n,), "NED", "that it runs to, clockwise from north"),
        Port("waves.phase", "rad", (n,), "", "of a cos(k x - omega t + phase) at the origin"),
        Port("elevation", "m", (), "", "of the surface at the place, upwards"),
    )


def sizes(sea: Sea) -> Sizes:
    """The components: amplitude, frequency, wave number, direction, phase (n each)."""
    return Sizes(state=5 * sea.components)


def terms(sea: Sea) -> tuple[Term, ...]:
    """What can be off."""
    return (Term("spreading", sea.spread > 0.0, f"spread is {sea.spread:g}"),)
