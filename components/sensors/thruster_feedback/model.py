"""Feedback of thrusters' speed, azimuth and power: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Port, Sizes, choice, quantity
from components.sensors.instrument import Instrument, channel, state
from components.sensors.measurement import CHANNEL, FIRST

Flag = Annotated[float, Field(ge=0, le=1)]
CHANNELS = 3
BLOCK = FIRST + CHANNELS * CHANNEL


class ThrusterFeedback(Instrument):
    """Each thruster's instruments fail by themselves."""

    thrusters: Annotated[int, Field(ge=1, le=24)] = choice("number of thrusters")
    speed_noise: float = quantity("rad/s", "standard deviation of the shaft's speed", 0.0, tunable=True, ge=0)
    azimuth_noise: float = quantity("rad", "standard deviation", 0.0, tunable=True, ge=0)
    azimuth_bias: float = quantity("rad", "standard deviation of the slow error (alignment)", 0.0, tunable=True, ge=0)
    bias_time: float = quantity("s", "time constant of the slow error", 3600.0, gt=0)
    power_noise: float = quantity("W", "standard deviation", 0.0, tunable=True, ge=0)
    wild_speed: float = quantity("rad/s", "size of wild points of the speed", 10.0, tunable=True)
    wild_azimuth: float = quantity("rad", "size of wild points of the azimuth", 1.0, tunable=True)
    dropped: tuple[Flag, ...] = quantity("1", "of each, 1: gives nothing; none given: all give", (), tunable=True)
    frozen: tuple[Flag, ...] = quantity("1", "of each, 1: repeats its last value; none given: none", (), tunable=True)

    @model_validator(mode="after")
    def _fits(self) -> ThrusterFeedback:
        for name in ("dropped", "frozen"):
            if len(getattr(self, name)) not in (0, self.thrusters):
                raise ValueError(f"{name} has {len(getattr(self, name))} values for {self.thrusters} thrusters")
        return self

    def vector(self) -> np.ndarray:
        """Thrusters n, then an instrument's numbers for each (n, BLOCK)."""
        channels = [
            channel(self.speed_noise, wild=self.wild_speed),
            channel(self.azimuth_noise, self.azimuth_bias, self.bias_time, self.wild_azimuth, wraps=True),
            channel(self.power_noise),
        ]
        none = (0.0,) * self.thrusters
        flags = zip(self.dropped or none, self.frozen or none, strict=True)
        rows = [[*self.faults(CHANNELS), *flag, *np.ravel(channels)] for flag in flags]
        return np.concatenate([[self.thrusters], *rows])


def inputs(feedback: ThrusterFeedback) -> tuple[Port, ...]:
    """What the thrusters do."""
    n = feedback.thrusters
    return (
        Port("thrusters.speed", "rad/s", (n,), "", "of the shafts"),
        Port("thrusters.azimuth", "rad", (n,), "body"),
        Port("thrusters.power", "W", (n,)),
    )


def outputs(feedback: ThrusterFeedback) -> tuple[Port, ...]:
    """The same as measured."""
    n = feedback.thrusters
    return (
        Port("speed", "rad/s", (n,), "", "of the shafts"),
        Port("azimuth", "rad", (n,), "body", "between -180 and 180 deg"),
        Port("power", "W", (n,)),
        Port("valid", "1", (n,), "", "1 where there are values, else 0 and zeros"),
        Port("time", "s", (), "", "at which the values were taken"),
    )


def sizes(feedback: ThrusterFeedback) -> Sizes:
    """An instrument's state for each; true values and measured ones."""
    return Sizes(state=feedback.thrusters * state(CHANNELS, feedback.delay), workspace=2 * CHANNELS)
