"""A motion reference unit: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Parameters, Port, Sizes, quantity
from components.sensors import instrument
from components.sensors.instrument import Sensor, channel


class Mru(Sensor):
    """Roll, pitch and heave of the reference point, and the rates of turn."""

    angle_noise: float = quantity("rad", "standard deviation of roll and pitch", 0.0, tunable=True, ge=0)
    angle_bias: float = quantity("rad", "standard deviation of their slow error", 0.0, tunable=True, ge=0)
    heave_noise: float = quantity("m", "standard deviation", 0.0, tunable=True, ge=0)
    heave_bias: float = quantity("m", "standard deviation of the slow error", 0.0, tunable=True, ge=0)
    bias_time: float = quantity("s", "time constant of the slow errors", 60.0, gt=0)
    rate_noise: float = quantity("rad/s", "standard deviation of the rates", 0.0, tunable=True, ge=0)
    wild_angle: float = quantity("rad", "size of wild points of roll and pitch", 0.2, tunable=True)
    wild_heave: float = quantity("m", "size of wild points of heave", 5.0, tunable=True)
    offset_angle: float = quantity("rad", "added to roll and pitch", 0.0, tunable=True)
    offset_heave: float = quantity("m", "added to heave", 0.0, tunable=True)

    def vector(self) -> np.ndarray:
        """The instrument's numbers."""
        angle = channel(self.angle_noise, self.angle_bias, self.bias_time, self.wild_angle, self.offset_angle, True)
        heave = channel(self.heave_noise, self.heave_bias, self.bias_time, self.wild_heave, self.offset_heave)
        return np.array(self.block([angle, angle, heave, *[channel(self.rate_noise)] * 3]))


def inputs(_: Parameters) -> tuple[Port, ...]:
    """The vessel's position, attitude and rates."""
    return (
        Port("vessel.position", "m", (3,), "NED", "of the reference point"),
        Port("vessel.attitude", "rad", (3,), "NED", "roll, pitch, heading"),
        Port("vessel.rates", "rad/s", (3,), "body", "of roll, pitch, yaw"),
    )


def outputs(_: Parameters) -> tuple[Port, ...]:
    """Angles, heave and rates."""
    return (
        Port("roll_pitch", "rad", (2,), "NED"),
        Port("heave", "m", (), "NED", "down"),
        Port("rates", "rad/s", (3,), "body", "of roll, pitch, yaw"),
        Port("valid", "1", (), "", "1 where there are values, else 0 and zeros"),
        Port("time", "s", (), "", "at which the values were taken"),
    )


def sizes(mru: Mru) -> Sizes:
    """See instrument.py."""
    return instrument.sizes(6, mru.delay)
