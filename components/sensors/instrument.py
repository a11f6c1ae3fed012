"""What all instruments have in common: delay, drop-outs, freezes and wild points."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from components.contract import Parameters, Sizes, choice, quantity

CHANNEL = 6  # numbers of a channel, see measurement.py


class Instrument(Parameters):
    """An instrument samples once a period of its own. Random faults come and go at the rates given here."""

    delay: Annotated[int, Field(ge=0, le=1000)] = choice("samples by which a measurement comes late", 0)
    available_time: float = quantity("s", "mean time between drop-outs", 3600.0, tunable=True, gt=0)
    lost_time: float = quantity("s", "mean length of a drop-out; 0: there are none", 0.0, tunable=True, ge=0)
    live_time: float = quantity("s", "mean time between freezes", 3600.0, tunable=True, gt=0)
    freeze_time: float = quantity("s", "mean length of a freeze; 0: there are none", 0.0, tunable=True, ge=0)
    wild_share: float = quantity("1", "part of the samples that are wild points", 0.0, tunable=True, ge=0, le=1)

    def faults(self, channels: int) -> list[float]:
        """What measurement.py begins with: channels, delay, rates (7)."""
        rates = [self.available_time, self.lost_time, self.live_time, self.freeze_time, self.wild_share]
        return [channels, self.delay, *rates]


class Sensor(Instrument):
    """An instrument whose channels fail together, at an event's will too."""

    dropped: float = quantity("1", "1: gives nothing", 0.0, tunable=True, ge=0, le=1)
    frozen: float = quantity("1", "1: repeats its last value, as valid", 0.0, tunable=True, ge=0, le=1)

    def block(self, channels: list[list[float]]) -> list[float]:
        """The numbers of measurement.py: faults (7), dropped, frozen, channels (n, 6)."""
        flat = [number for channel in channels for number in channel]
        return [*self.faults(len(channels)), self.dropped, self.frozen, *flat]


def channel(
    noise: float, bias: float = 0.0, bias_time: float = 1.0, wild: float = 0.0, offset: float = 0.0, wraps: bool = False
) -> list[float]:
    """Numbers of a channel, in its own unit; wraps: an angle, given between -180 and 180 deg."""
    return [noise, bias, bias_time, wild, offset, wraps]


def state(channels: int, delay: int) -> int:
    """Length of an instrument's state."""
    return 3 + 2 * channels + (channels + 1) * (delay + 1)


def sizes(channels: int, delay: int) -> Sizes:
    """Of an instrument with its true values as scratch."""
    return Sizes(state=state(channels, delay), workspace=channels)
