"""What an observer takes from each instrument: its parameters, its inputs, and its numbers for reading.py."""

from __future__ import annotations

from typing import Literal

from components.contract import Parameters, Port, choice, quantity

Vector = tuple[float, float, float]
Kind = Literal["gnss", "hydroacoustic"]


class Reference(Parameters):
    """A position reference: a satellite receiver, or hydroacoustics to a transponder on the bed."""

    kind: Kind = choice("gnss: gives its antenna's position; hydroacoustic: gives the way to a transponder")
    place: Vector = quantity("m", "of antenna or transceiver: forward, starboard, down", (0.0, 0.0, 0.0))
    transponder: Vector = quantity("m", "its known position, NED", (0.0, 0.0, 0.0))
    noise: float = quantity("m", "standard deviation of its positions, each way", gt=0)

    def numbers(self) -> list[float]:
        """As in layout.py."""
        return [self.kind == "hydroacoustic", *self.place, *self.transponder, self.noise]


def reference_ports(index: int, reference: Reference) -> tuple[Port, ...]:
    """Inputs of the bundle `reference_<n>`, n from 1, as the instrument gives them."""
    name = f"reference_{index + 1}"
    what = (
        Port(f"{name}.position", "m", (3,), "NED", "of the antenna")
        if reference.kind == "gnss"
        else Port(f"{name}.offset", "m", (3,), "body", "from transceiver to transponder, in the tilting hull")
    )
    return (what, *_marks(name))


def compass_ports() -> tuple[Port, ...]:
    """Inputs from a gyrocompass."""
    return (Port("compass.heading", "rad", (), "NED"), *_marks("compass"))


def mru_ports() -> tuple[Port, ...]:
    """Inputs from a motion reference unit."""
    return (Port("mru.roll_pitch", "rad", (2,), "NED"), Port("mru.valid", "1"))


def wind_ports() -> tuple[Port, ...]:
    """Inputs from an anemometer."""
    return (
        Port("wind.speed", "m/s", (), "", "relative to the vessel"),
        Port("wind.direction", "rad", (), "body", "that it comes from, clockwise from the bow"),
        Port("wind.valid", "1"),
    )


def _marks(name: str) -> tuple[Port, ...]:
    return (
        Port(f"{name}.valid", "1", (), "", "1 where there is a value"),
        Port(f"{name}.time", "s", (), "", "at which it was taken"),
    )
