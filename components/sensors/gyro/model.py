"""A gyrocompass: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Parameters, Port, Sizes, quantity
from components.sensors import instrument
from components.sensors.instrument import Sensor, channel


class Gyro(Sensor):
    """Heading, and the rate of turn."""

    heading_noise: float = quantity("rad", "standard deviation", 0.0, tunable=True, ge=0)
    heading_bias: float = quantity("rad", "standard deviation of the slow error", 0.0, tunable=True, ge=0)
    bias_time: float = quantity("s", "time constant of the slow error", 1800.0, gt=0)
    rate_noise: float = quantity("rad/s", "standard deviation", 0.0, tunable=True, ge=0)
    wild: float = quantity("rad", "size of wild points of the heading", 0.5, tunable=True)
    offset: float = quantity("rad", "added to the heading", 0.0, tunable=True)

    def vector(self) -> np.ndarray:
        """The instrument's numbers."""
        heading = channel(self.heading_noise, self.heading_bias, self.bias_time, self.wild, self.offset, wraps=True)
        return np.array(self.block([heading, channel(self.rate_noise)]))


def inputs(_: Parameters) -> tuple[Port, ...]:
    """The vessel's attitude and its rates."""
    return (
        Port("vessel.attitude", "rad", (3,), "NED", "roll, pitch, heading"),
        Port("vessel.rates", "rad/s", (3,), "body", "of roll, pitch, yaw"),
    )


def outputs(_: Parameters) -> tuple[Port, ...]:
    """Heading and rate."""
    return (
        Port("heading", "rad", (), "NED", "between -180 and 180 deg"),
        Port("yaw_rate", "rad/s", (), "body"),
        Port("valid", "1", (), "", "1 where there are values, else 0 and zeros"),
        Port("time", "s", (), "", "at which the values were taken"),
    )


def sizes(gyro: Gyro) -> Sizes:
    """See instrument.py."""
    return instrument.sizes(2, gyro.delay)
