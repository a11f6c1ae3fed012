"""Loads of wind, and of the sea and the current that come with it, from a vessel's own coefficients."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
from pydantic import model_validator

from components.constants import GRAVITY
from components.contract import Parameters, choice, quantity
from components.environment.sea.spectrum import jonswap, peakedness
from components.vessel.low_speed.model import LowSpeed
from components.vessel.low_speed.standing import SCRATCH, drift, stand
from pipeline.capability.loads import Loads

# The loads go with the square of the wind and its sea with the fourth power: between these [m/s] a line is within 1e-3.
WIND_STEP = 0.5
# Of the spectrum's peak: below the first lies 1e-60 of its energy, above the second 1e-4.
FREQUENCIES = np.linspace(0.3, 10.0, 1500)


class SeaOfWind(Parameters):
    """The sea that comes with a wind."""

    wind: float = quantity("m/s", "mean, at 10 m", ge=0)
    height: float = quantity("m", "significant", ge=0)
    period: float = quantity("s", "of the spectrum's peak", gt=0)


class Weather(Parameters):
    """Wind, sea and current from one direction, or with offsets; all directions of it are tried in turn."""

    max_wind: float = quantity("m/s", "largest that is tried", 40.0, gt=0)
    current: float = quantity("m/s", "at any wind", 0.0, ge=0)
    current_offset: float = quantity("rad", "direction that it comes from, clockwise from the wind's", 0.0)
    waves: bool = choice("whether there are any", True)
    seas: tuple[SeaOfWind, ...] = choice("by growing wind, linear between; none: fully grown (Pierson, Moskowitz)", ())
    sea_offset: float = quantity("rad", "direction that waves come from, clockwise from the wind's", 0.0)
    heading_step: float = quantity("rad", "between the directions that are tried", pi / 18.0, gt=0, le=pi)

    @model_validator(mode="after")
    def _goes_round(self) -> Weather:
        turns = 2.0 * pi / self.heading_step
        if abs(turns - round(turns)) > 1e-6:
            raise ValueError("heading_step does not go into 360 deg")
        winds = [sea.wind for sea in self.seas]
        if any(after <= before for before, after in pairwise(winds)):
            raise ValueError("the winds of seas do not grow from one to the next")
        if winds and self.max_wind > winds[-1]:
            raise ValueError(f"max_wind is above {winds[-1]:g} m/s, where seas ends; its default is 40 m/s")
        return self

    def sea(self, wind: float) -> tuple[float, float]:
        """Significant height [m] and peak period [s] with a wind [m/s]; below the first of `seas` they are its own.

        Fully grown: Pierson and Moskowitz 1964, H_s = 0.21 V^2 / g and omega_p = 0.877 g / V, V at 19.5 m.
        """
        if not self.seas:
            return 0.21 * wind**2 / GRAVITY, 2.0 * pi * wind / (0.877 * GRAVITY)
        winds = [sea.wind for sea in self.seas]
        return (
            float(np.interp(wind, winds, [sea.height for sea in self.seas])),
            float(np.interp(wind, winds, [sea.period for sea in self.seas])),
        )


def mismatch(vessel: LowSpeed, weather: Weather) -> str:
    """What the vessel lacks for the weather, in words; empty where it lacks nothing."""
    if vessel.windage is None:
        return "windage is missing: what the wind meets"
    if weather.waves and vessel.hull is None and not vessel.responses:
        return "hull or responses is missing, by which waves drive it off; without any: weather: {waves: false}"
    if weather.current > vessel.max_speed:
        return f"a current of {weather.current:g} m/s is above its max_speed, {vessel.max_speed:g} m/s"
    return ""


def standing_loads(vessel: LowSpeed, weather: Weather) -> Loads:
    """Of each wind in steps of WIND_STEP from none, and each direction that it comes from, clockwise from the bow."""
    q = vessel.model_copy(update={"waves": int(weather.waves)}).vector()
    speeds = WIND_STEP * np.arange(int(np.ceil(weather.max_wind / WIND_STEP)) + 1)
    speeds[-1] = weather.max_wind
    headings = weather.heading_step * np.arange(round(2.0 * pi / weather.heading_step))
    table, scratch = np.zeros((len(headings), len(speeds), 3)), np.zeros(SCRATCH)
    for k, wind in enumerate(speeds):
        frequencies, squares = _spectrum(*weather.sea(wind)) if weather.waves else (np.empty(0), np.empty(0))
        for h, angle in enumerate(headings):
            stand(q, wind, angle, weather.current, angle + weather.current_offset, scratch, table[h, k])
            if weather.waves:
                drift(q, frequencies, squares, angle + weather.sea_offset + pi, scratch, table[h, k])
    return Loads(speeds, np.degrees(headings), table)


def _spectrum(height: float, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and the squared amplitudes [m^2] of a wave at each; none where there is no sea."""
    if height == 0.0 or period == 0.0:
        return np.empty(0), np.empty(0)
    frequencies = FREQUENCIES * 2.0 * pi / period
    spacing = frequencies[1] - frequencies[0]
    return frequencies, 2.0 * spacing * jonswap(frequencies, height, period, peakedness(height, period))
