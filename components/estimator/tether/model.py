"""A tether's shape and tensions from the ship, its ROV's position and the tension: parameters, ports and sizes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import hypot, pi
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.constants import SEA_WATER_DENSITY
from components.contract import Parameters, Port, Sizes, Term, choice, quantity
from components.estimator.tether.layout import LINE_NUMBERS, state_size, workspace

Vector = tuple[float, float, float]


class Tether(Parameters):
    """The line, and standard deviations of what the filter's model and the sensors leave open."""

    whole_length: float = quantity("m", "unstretched length, with what is on the drum", tunable=True, gt=0)
    weight: float = quantity("N/m", "weight in water per unstretched length; negative: buoyant", tunable=True)
    axial_stiffness: float = quantity("N", "EA", tunable=True, gt=0)
    segments: Annotated[int, Field(ge=2)] = choice("number of equal segments", 20)
    drag_diameter: float = quantity("m", "diameter that drag refers to", tunable=True, ge=0)
    normal_drag: float = quantity("1", "C_n of rho d C_n |v_n| v_n / 2 per length", 1.2, tunable=True, ge=0)
    tangential_drag: float = quantity("1", "C_t of rho pi d C_t |v_t| v_t / 2 per length", 0.0, tunable=True, ge=0)
    fluid_density: float = quantity("kg/m^3", "density of the fluid", SEA_WATER_DENSITY, tunable=True, ge=0)
    current_depth: tuple[float, ...] = quantity("m", "depths (z in NED) of the assumed current, increasing", (0.0,))
    current: tuple[Vector, ...] = quantity(
        "m/s", "assumed at these depths, NED; linear between, constant beyond", ((0.0, 0.0, 0.0),)
    )
    offset_share: tuple[float, ...] = quantity("1", "of the current's offset at these depths; none: 1 at all", ())
    following_time: float = quantity("s", "over which end b's velocity is smoothed for the line to follow", 60.0, gt=0)
    hook: Vector = quantity("m", "where the line leaves the ship: forward, starboard, down", (0.0, 0.0, 0.0))
    transceiver: Vector = quantity("m", "of the USBL: forward, starboard, down", (0.0, 0.0, 0.0))
    start: Vector = quantity("m", "where end b is at t0, NED", (0.0, 0.0, 0.0))
    start_place: float = quantity("m", "of that, each way", 10.0, gt=0)
    start_speed: float = quantity("m/s", "of its first velocity, each way", 0.5, gt=0)
    agitation: float = quantity("m/s^1.5", "white acceleration of end b: change of its velocity in 1 s", 0.05, gt=0)
    offset_along: float = quantity("m/s", "of the current's offset along the assumed one", 0.1, tunable=True, gt=0)
    offset_across: float = quantity("m/s", "of the current's offset across it", 0.03, tunable=True, gt=0)
    offset_time: float = quantity("s", "the offset's time constant", 600.0, gt=0)
    range_noise: float = quantity("m", "of the USBL's range", tunable=True, gt=0)
    angle_noise: float = quantity("rad", "of its angles, with what the ship's attitude is off by", tunable=True, gt=0)
    angle_bias: float = quantity("rad", "of their slow error, with the compass's", 0.001, tunable=True, gt=0)
    angle_time: float = quantity("s", "its time constant", 1800.0, gt=0)
    cell_noise: float = quantity("N", "of the load cell", tunable=True, gt=0)
    swing: float = quantity("N", "of the tension about that of the line at rest: heave, and lag", tunable=True, gt=0)
    swing_time: float = quantity("s", "its time constant, half a wave's period or so", 4.0, gt=0)
    transfer: float = quantity("N", "of what the swing at end b differs by from that at end a", 5.0, tunable=True, ge=0)
    gate: float = quantity("1", "standard deviations beyond which a measurement is refused", 5.0, tunable=True, gt=0)
    longest_age: float = quantity("s", "of a USBL value that is used", 10.0, tunable=True, gt=0)
    largest_tension: float = quantity("N", "that the ends may stretch the line to, else its shape is held", 5e3, gt=0)

    @model_validator(mode="after")
    def _fits(self) -> Tether:
        depths = self.current_depth
        if len(depths) != len(self.current) or not depths:
            raise ValueError(
                f"current_depth has {len(depths)} depths and current {len(self.current)} velocities: "
                "give one velocity for each depth, and one depth at least"
            )
        if any(b <= a for a, b in pairwise(depths)):
            raise ValueError("current_depth does not increase: list the depths downwards, each once")
        if self.offset_share and len(self.offset_share) != len(depths):
            raise ValueError(f"offset_share has {len(self.offset_share)} numbers: give one for each of the depths")
        return self

    def vector(self) -> np.ndarray:
        """A quasi-static line's numbers (line.py of tether/quasistatic), the offset's shares, then layout.py's own."""
        pressure = 0.5 * self.fluid_density * self.drag_diameter
        head = np.zeros(LINE_NUMBERS)
        head[:6] = (
            self.whole_length, self.segments, 1.0 / self.axial_stiffness, self.weight, pressure * self.normal_drag,
            pressure * pi * self.tangential_drag,
        )  # fmt: skip
        head[-1] = len(self.current_depth)
        table = [number for z, u in zip(self.current_depth, self.current, strict=True) for number in (z, *u)]
        ways = [number for way in self._ways() for number in way]
        own = [
            self.agitation**2, self.cell_noise**2, self.range_noise**2, self.angle_noise**2, self.angle_bias**2,
            self.angle_time, self.offset_along**2, self.offset_across**2, self.offset_time, self.swing**2,
            self.swing_time, self.transfer**2, self.gate**2, self.longest_age, self.largest_tension,
            self.start_place**2, self.start_speed**2, self.following_time, *self.hook, *self.transceiver, *self.start,
        ]  # fmt: skip
        return np.array([*head, *table, *ways, *own], np.float64)

    def _ways(self) -> Iterator[tuple[float, float]]:
        """North and east, at each depth, of an offset of 1 m/s along the current; where there is none, to the north."""
        shares = self.offset_share or (1.0,) * len(self.current_depth)
        for share, (north, east, _) in zip(shares, self.current, strict=True):
            speed = hypot(north, east)
            yield (share * north / speed, share * east / speed) if speed > 0.0 else (share, 0.0)


def inputs(_: Tether) -> tuple[Port, ...]:
    """The ship as its observer and its motion reference unit have it, the USBL, the load cell and the drum."""
    return (
        Port("estimate.position", "m", (2,), "NED", "of the ship, without the waves' part"),
        Port("estimate.heading", "rad", (), "NED", "without the waves' part"),
        Port("wave.position", "m", (2,), "NED", "the waves' part"),
        Port("wave.heading", "rad", (), "NED", "the waves' part"),
        Port("mru.roll_pitch", "rad", (2,), "NED"),
        Port("mru.heave", "m", (), "NED", "down"),
        Port("mru.valid", "1"),
        Port("usbl.range", "m", (), "", "from transceiver to transponder, which is at end b"),
        Port("usbl.across", "rad", (), "body", "angle of the way to it from straight down, to starboard"),
        Port("usbl.along", "rad", (), "body", "angle of the way to it from straight down, forward"),
        Port("usbl.valid", "1"),
        Port("usbl.time", "s", (), "", "at which the values were taken"),
        Port("load_cell.tension", "N", (), "", "at the ship's end"),
        Port("load_cell.valid", "1"),
        Port("load_cell.time", "s", (), "", "at which the value was taken"),
        Port("stored", "m", (), "", "line on the drum"),
    )


def outputs(given: Tether) -> tuple[Port, ...]:
    """The line, and how sure it is."""
    status = "0 used, 1 no new one, 2 none, or of a wrong time, 3 refused"
    return (
        Port("nodes", "m", (given.segments + 1, 3), "NED", "from the ship's end to end b"),
        Port("tension", "N", (2,), "", "at the ship's end and at end b, the swing included"),
        Port("deviation.tension", "N", (2,), "", "standard deviations"),
        Port("end_b.position", "m", (3,), "NED"),
        Port("deviation.end_b", "m", (3,), "NED", "standard deviation of its position"),
        Port("end_b.velocity", "m/s", (3,), "NED"),
        Port("current", "m/s", (2,), "", "offset of the current, along the assumed one and to the right of it"),
        Port("deviation.current", "m/s", (2,), "", "standard deviations"),
        Port("mean_tension", "N", (2,), "", "at both ends, of the line at rest"),
        Port("held", "1", (), "", "1 where no line fits the ends and the length: then the last shape is given"),
        Port("status", "1", (2,), "", f"of the USBL's value and the load cell's: {status}"),
        Port("nis", "1", (2,), "", "normalised innovation squared of both; zero where no value is judged"),
        Port("freedom", "1", (2,), "", "degrees of freedom of these: 3 and 1, zero where no value is judged"),
    )


def sizes(given: Tether) -> Sizes:
    """State: estimate, covariance, and what is kept of line and ship. Scratch: see layout.py."""
    n, points = given.segments, len(given.current_depth)
    return Sizes(state=state_size.py_func(n), workspace=workspace.py_func(n, points))


def terms(given: Tether) -> tuple[Term, ...]:
    """What of the model is on."""
    flow = any(any(one) for one in given.current)
    return (
        Term("normal drag", given.normal_drag * given.drag_diameter > 0.0, f"normal_drag {given.normal_drag:g}"),
        Term("tangential drag", given.tangential_drag > 0.0, f"tangential_drag {given.tangential_drag:g}"),
        Term("assumed current", flow, f"{len(given.current)} depths of current"),
    )
