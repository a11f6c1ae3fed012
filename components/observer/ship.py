"""What all observers of a vessel in the horizontal plane have in common: parameters, inputs, outputs, numbers."""

from __future__ import annotations

from math import pi
from typing import Annotated

import numpy as np
from pydantic import Field

from components.contract import Port, Term, choice, quantity
from components.observer.instruments import (
    Reference,
    compass_ports,
    mru_ports,
    reference_ports,
    wind_ports,
)
from components.vessel.linear import LinearVessel
from components.vessel.loads import load_ports
from components.vessel.windage import AIR, Windage, windage_numbers


class ShipObserver(LinearVessel):
    """Low-frequency motion of a vessel told from its motion with the waves (Fossen 2011, section 11.1)."""

    references: Annotated[tuple[Reference, ...], Field(min_length=1, max_length=6)] = choice("position references")
    windage: Windage | None = choice("what the wind meets, for its load; none: no anemometer", None)
    air_density: float = quantity("kg/m^3", "of the air", AIR, gt=0)
    wind_time: float = quantity("s", "time constant of the filter of the wind's load", 5.0, tunable=True, ge=0)
    takes_mru: bool = choice("whether it has the input `mru`, for what roll and pitch do to antennas", False)
    takes_thrust: bool = choice("whether it has the input `thrust`", True)
    wave_period: float = quantity("s", "peak period of the motion in waves", tunable=True, gt=0)
    wave_damping: float = quantity("1", "damping ratio of the model of that motion", 0.1, tunable=True, gt=0, lt=1)
    bias_time: float = quantity("s", "time constant of the slow forces", 1000.0, tunable=True, gt=0)
    position: tuple[float, float] = quantity("m", "north and east until a reference gives a position", (0.0, 0.0))
    heading: float = quantity("rad", "until the compass gives one", 0.0)
    frozen_after: Annotated[int, Field(ge=0)] = choice(
        "times that a value comes again, to the last bit, before it is taken as frozen; 0: never", 2
    )
    longest_age: float = quantity("s", "older values are not used", 10.0, tunable=True, gt=0)
    believed_after: float = quantity(
        "s", "of nothing but wild values, after which the estimate begins anew with the next", 30.0, tunable=True, gt=0
    )

    def fastest(self) -> float:
        """The largest rate [1/s] at which the linear model's velocities decay, or grow."""
        return float(np.abs(np.linalg.eigvals(np.linalg.solve(self.mass_matrix(), self.damping_matrix()))).max())

    def block(self) -> list[float]:
        """The numbers of layout.py up to START, start (3), M^-1 (9), D (9), windage (8), references (n, 8)."""
        switches = [self.takes_mru, self.windage is not None, self.takes_thrust]
        waves = [2.0 * pi / self.wave_period, self.wave_damping]
        matrices = [*np.linalg.inv(self.mass_matrix()).ravel(), *self.damping_matrix().ravel()]
        rows = [number for reference in self.references for number in reference.numbers()]
        return [
            len(self.references), *switches, self.frozen_after, self.longest_age, self.wind_time, *waves,
            self.bias_time, self.believed_after, 2.0 * self.fastest(), *self.position, self.heading, *matrices,
            *windage_numbers(self.windage, self.air_density), *rows,
        ]  # fmt: skip


def inputs(observer: ShipObserver) -> tuple[Port, ...]:
    """The instruments that the parameters name, and the thrusters' load."""
    ports = [port for i, one in enumerate(observer.references) for port in reference_ports(i, one)]
    ports += compass_ports()
    if observer.takes_mru:
        ports += mru_ports()
    if observer.windage is not None:
        ports += wind_ports()
    if observer.takes_thrust:
        ports += load_ports("thrust")
    return tuple(ports)


def outputs(observer: ShipObserver) -> tuple[Port, ...]:
    """Motion without the waves' part and that part, loads, and what became of each instrument's value."""
    n = len(observer.references)
    status = "0 used, 1 no new one, 2 none, or of a wrong time, 3 frozen, 4 wild"
    return (
        Port("estimate.position", "m", (2,), "NED", "north and east without the waves' part"),
        Port("estimate.heading", "rad", (), "NED", "without the waves' part, continuous"),
        Port("estimate.velocity", "m/s", (2,), "body", "surge and sway over the ground"),
        Port("estimate.yaw_rate", "rad/s", (), "body"),
        Port("wave.position", "m", (2,), "NED", "the waves' part"),
        Port("wave.heading", "rad", (), "NED", "the waves' part"),
        Port("slow.force", "N", (2,), "NED", "current, drift of the waves, and what else is slow"),
        Port("slow.moment", "N*m", (), "NED", "the same"),
        *load_ports("wind_load"),
        Port("dead_reckoning", "s", (), "", "since a position was last used"),
        Port("status.references", "1", (n,), "", f"of their values: {status}"),
        Port("status.compass", "1", (), "", "the same"),
        Port("innovation.references", "m", (n, 2), "NED", "measured less expected; zero where no new value is"),
        Port("innovation.compass", "rad", (), "NED", "the same"),
    )


def terms(observer: ShipObserver) -> tuple[Term, ...]:
    """What can be off."""
    return (
        Term("wind load", observer.windage is not None, "windage" if observer.windage else "no windage"),
        Term("roll and pitch", observer.takes_mru, f"takes_mru is {str(observer.takes_mru).lower()}"),
        Term("thrust", observer.takes_thrust, f"takes_thrust is {str(observer.takes_thrust).lower()}"),
    )
