"""A load cell under a winch or a sheave: its parameters, ports and sizes."""

from __future__ import annotations

import numpy as np

from components.contract import Parameters, Port, Sizes, quantity
from components.sensors import instrument
from components.sensors.instrument import Sensor, channel


class LoadCell(Sensor):
    """A line's tension."""

    noise: float = quantity("N", "standard deviation", 0.0, tunable=True, ge=0)
    bias: float = quantity("N", "standard deviation of the slow error", 0.0, tunable=True, ge=0)
    bias_time: float = quantity("s", "time constant of the slow error", 1800.0, gt=0)
    wild: float = quantity("N", "size of wild points", 1000.0, tunable=True)
    offset: float = quantity("N", "added to the tension", 0.0, tunable=True)

    def vector(self) -> np.ndarray:
        """The instrument's numbers."""
        return np.array(self.block([channel(self.noise, self.bias, self.bias_time, self.wild, self.offset)]))


def inputs(_: Parameters) -> tuple[Port, ...]:
    """The true tension."""
    return (Port("line.tension", "N", (), "", "at the cell"),)


def outputs(_: Parameters) -> tuple[Port, ...]:
    """The measured one, below zero too where noise and bias put it there."""
    return (
        Port("tension", "N"),
        Port("valid", "1", (), "", "1 where there is a value, else 0 and zero"),
        Port("time", "s", (), "", "at which the value was taken"),
    )


def sizes(cell: LoadCell) -> Sizes:
    """See instrument.py."""
    return instrument.sizes(1, cell.delay)
