"""A satellite receiver with corrections: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Parameters, Port, Sizes, quantity
from components.sensors import instrument
from components.sensors.instrument import Sensor, channel

Vector = tuple[float, float, float]
ZERO = (0.0, 0.0, 0.0)


class Gnss(Sensor):
    """Position of an antenna. Horizontal errors are per axis."""

    antenna: Vector = quantity("m", "forward, starboard and down of the reference point", ZERO)
    noise: Vector = quantity("m", "standard deviation of a position: north, east, down", ZERO, tunable=True)
    bias: Vector = quantity("m", "standard deviation of the slow error: north, east, down", ZERO, tunable=True)
    bias_time: float = quantity("s", "time constant of the slow error", 300.0, gt=0)
    wild: Vector = quantity("m", "size of wild points", (50.0, 50.0, 50.0), tunable=True)
    offset: Vector = quantity("m", "added to what is measured", ZERO, tunable=True)

    def vector(self) -> np.ndarray:
        """The instrument's numbers, then the antenna (3)."""
        rows = zip(self.noise, self.bias, self.wild, self.offset, strict=True)
        channels = [channel(noise, bias, self.bias_time, wild, offset) for noise, bias, wild, offset in rows]
        return np.array([*self.block(channels), *self.antenna])


def inputs(_: Parameters) -> tuple[Port, ...]:
    """The vessel's position and attitude."""
    return (
        Port("vessel.position", "m", (3,), "NED", "of the reference point"),
        Port("vessel.attitude", "rad", (3,), "NED", "roll, pitch, heading"),
    )


def outputs(_: Parameters) -> tuple[Port, ...]:
    """The antenna's position."""
    return (
        Port("position", "m", (3,), "NED", "of the antenna"),
        Port("valid", "1", (), "", "1 where there are values, else 0 and zeros"),
        Port("time", "s", (), "", "at which the values were taken"),
    )


def sizes(gnss: Gnss) -> Sizes:
    """See instrument.py."""
    return instrument.sizes(3, gnss.delay)
