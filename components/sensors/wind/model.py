"""An anemometer on a moving vessel: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Parameters, Port, Sizes, quantity
from components.sensors import instrument
from components.sensors.instrument import Sensor, channel


class WindSensor(Sensor):
    """Speed and direction of the wind that the vessel feels."""

    speed_noise: float = quantity("m/s", "standard deviation", 0.0, tunable=True, ge=0)
    speed_bias: float = quantity("m/s", "standard deviation of the slow error", 0.0, tunable=True, ge=0)
    direction_noise: float = quantity("rad", "standard deviation", 0.0, tunable=True, ge=0)
    direction_bias: float = quantity("rad", "standard deviation of the slow error", 0.0, tunable=True, ge=0)
    bias_time: float = quantity("s", "time constant of the slow errors (shelter by the mast)", 600.0, gt=0)
    wild_speed: float = quantity("m/s", "size of wild points of the speed", 20.0, tunable=True)
    wild_direction: float = quantity("rad", "size of wild points of the direction", 1.0, tunable=True)
    offset_direction: float = quantity("rad", "added to the direction", 0.0, tunable=True)

    def vector(self) -> np.ndarray:
        """The instrument's numbers."""
        speed = channel(self.speed_noise, self.speed_bias, self.bias_time, self.wild_speed)
        bias, wild = self.direction_bias, self.wild_direction
        direction = channel(self.direction_noise, bias, self.bias_time, wild, self.offset_direction, wraps=True)
        return np.array(self.block([speed, direction]))


def inputs(_: Parameters) -> tuple[Port, ...]:
    """The air, and the vessel in it."""
    return (
        Port("wind", "m/s", (3,), "NED", "velocity of the air"),
        Port("vessel.velocity", "m/s", (3,), "body", "of the vessel over the ground"),
        Port("vessel.attitude", "rad", (3,), "NED", "roll, pitch, heading"),
    )


def outputs(_: Parameters) -> tuple[Port, ...]:
    """The wind relative to the vessel."""
    return (
        Port("speed", "m/s", (), "", "relative, at least 0"),
        Port("direction", "rad", (), "body", "that it comes from, clockwise from the bow, between -180 and 180 deg"),
        Port("valid", "1", (), "", "1 where there are values, else 0 and zeros"),
        Port("time", "s", (), "", "at which the values were taken"),
    )


def sizes(sensor: WindSensor) -> Sizes:
    """See instrument.py."""
    return instrument.sizes(2, sensor.delay)
