"""Hydroacoustic positioning by an ultra-short baseline: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Parameters, Port, Sizes, quantity
from components.sensors import instrument
from components.sensors.instrument import Sensor, channel

Vector = tuple[float, float, float]


class Hydroacoustic(Sensor):
    """A transceiver under the hull measures range and two angles to a transponder on the bed or on an ROV."""

    transceiver: Vector = quantity("m", "forward, starboard and down of the reference point", (0.0, 0.0, 0.0))
    max_range: float = quantity("m", "beyond which there is no reply", 1e4, tunable=True, gt=0)
    range_noise: float = quantity("m", "standard deviation", 0.0, tunable=True, ge=0)
    range_bias: float = quantity("m", "standard deviation of the slow error (sound speed)", 0.0, tunable=True, ge=0)
    angle_noise: float = quantity("rad", "standard deviation of both angles", 0.0, tunable=True, ge=0)
    angle_bias: float = quantity("rad", "standard deviation of their slow error (alignment)", 0.0, tunable=True, ge=0)
    bias_time: float = quantity("s", "time constant of the slow errors", 1800.0, gt=0)
    wild_range: float = quantity("m", "size of wild points of the range (reflections)", 20.0, tunable=True)
    wild_angle: float = quantity("rad", "size of wild points of the angles", 0.2, tunable=True)
    offset_range: float = quantity("m", "added to the range", 0.0, tunable=True)

    def vector(self) -> np.ndarray:
        """The instrument's numbers, the transceiver (3), the largest range."""
        reach = channel(self.range_noise, self.range_bias, self.bias_time, self.wild_range, self.offset_range)
        angle = channel(self.angle_noise, self.angle_bias, self.bias_time, self.wild_angle)
        return np.array([*self.block([reach, angle, angle]), *self.transceiver, self.max_range])


def inputs(_: Parameters) -> tuple[Port, ...]:
    """Where vessel and transponder are."""
    return (
        Port("vessel.position", "m", (3,), "NED", "of the vessel's reference point"),
        Port("vessel.attitude", "rad", (3,), "NED", "roll, pitch, heading"),
        Port("transponder", "m", (3,), "NED", "its position"),
    )


def outputs(_: Parameters) -> tuple[Port, ...]:
    """What is measured, and the same as a vector."""
    return (
        Port("range", "m", (), "", "from transceiver to transponder"),
        Port("across", "rad", (), "body", "angle of the way to it from straight down, to starboard"),
        Port("along", "rad", (), "body", "angle of the way to it from straight down, forward"),
        Port("offset", "m", (3,), "body", "from transceiver to transponder, in the tilting hull"),
        Port("valid", "1", (), "", "1 where there are values, else 0 and zeros"),
        Port("time", "s", (), "", "at which the values were taken"),
    )


def sizes(usbl: Hydroacoustic) -> Sizes:
    """See instrument.py."""
    return instrument.sizes(3, usbl.delay)
