"""An iterated extended Kalman filter of a line as a chain of bars: parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.constants import SEA_WATER_DENSITY
from components.contract import Port, Sizes, Term, choice, quantity
from components.estimator import line
from components.estimator.best.layout import layout, workspace
from components.estimator.contradiction import KEPT
from components.estimator.line import Line

Two = tuple[float, float]


class Best(Line):
    """Nonlinear bars; the force on their free end is an Ornstein-Uhlenbeck process each way, and so the pivot's motion.

    Trigo et al. 2014 have one tension along the last bar and a force at each joint; here the end's force has a
    direction of its own, and white moments on the bars stand for all that the model does not know.

    Markers numbered from the wrong end: a pivot at rest contradicts them. Of one that moves the motion tells little: by
    s -> L - s the equations of a line without stretch are the same, its tension too, and what pulls at the one end is
    what holds it at the other. What is told of the ends differs: `contradiction` counts where the found force or the
    pivot's acceleration is farther from its mean than the gate's deviations of its spread. Where that is too wide, a
    second filter with the markers turned round tells by the sum of `log_density`, as a pivot's acceleration is smooth
    and that of a free end, which white moments drive, is not.

    An inertial unit is a place in `tilts` and the same in `gyros`, whose bias must have been taken off.
    """

    drag_diameter: float = quantity("m", "diameter that quadratic drag refers to", 0.0, ge=0)
    normal_drag: float = quantity("1", "C_n of rho d C_n |v_n| v_n / 2 per length", 1.2, ge=0)
    fluid_density: float = quantity("kg/m^3", "density of the fluid", SEA_WATER_DENSITY, ge=0)
    end_force: Two = quantity("N", "mean force on the end away from the pivot, north and down", tunable=True)
    end_force_spread: float = quantity("N", "its standard deviation each way", tunable=True, gt=0)
    end_force_time: float = quantity("s", "its correlation time", tunable=True, gt=0)
    moment_noise: float = quantity("N*m*s^0.5", "density of the white moment on each bar", tunable=True, gt=0)
    pivot: Literal["fixed", "moving"] = choice("whether the pivot stays where it is", "fixed")
    pivot_acceleration: float = quantity("m/s^2", "standard deviation of a moving pivot's, each way", 0.5, gt=0)
    pivot_time: float = quantity("s", "its correlation time", 0.2, gt=0)
    start_place: float = quantity("m", "standard deviation of a moving pivot's first position", 0.1, gt=0)
    start_speed: float = quantity("m/s", "of its first velocity, each way", 0.2, gt=0)
    end_position_noise: float | None = quantity(
        "m", "standard deviation of the end's position, each way; none: there is no input `end_b`", None, gt=0
    )
    end_tension_noise: float | None = quantity(
        "N", "standard deviation of the end's tension; none: there is no input `end_tension`", None, gt=0
    )
    tilts: Annotated[tuple[float, ...], Field(max_length=100)] = quantity(
        "m", "places of inclinometers from the pivot along the line", ()
    )
    tilt_noise: float = quantity("rad", "standard deviation of an inclinometer", 0.01, tunable=True, gt=0)
    gyros: Annotated[tuple[float, ...], Field(max_length=100)] = quantity(
        "m", "places of rate gyros from the pivot along the line", ()
    )
    gyro_noise: float = quantity("rad/s", "standard deviation of a rate gyro", 0.01, tunable=True, gt=0)
    iterations: Annotated[int, Field(ge=1, le=20)] = choice("times that measurements are taken about a better guess", 5)

    @model_validator(mode="after")
    def _sensors_are_on_it(self) -> Best:
        for name, places in (("tilts", self.tilts), ("gyros", self.gyros)):
            if any(not 0.0 <= place <= self.length for place in places):
                raise ValueError(f"{name} are at {places} m: expected places on the line, 0 to {self.length:g} m")
        return self

    @property
    def readings(self) -> int:
        """Number of sensors."""
        more = (self.end_position_noise is not None) + (self.end_tension_noise is not None)
        return self.markers + len(self.tilts) + len(self.gyros) + more

    def vector(self) -> np.ndarray:
        """In the order of layout.py."""

        def square(noise: float | None) -> float:
            return noise**2 if noise else 0.0

        head = [self.markers, len(self.tilts), len(self.gyros), self.pivot == "moving", self.gate, self.marker_noise**2]
        head += [self.takes_covariance, self.chain_noise**2, *self.position]
        head += [bool(self.angles), self.start_angle, self.start_rate]
        head += [self.moment_noise, *self.end_force, self.end_force_spread, self.end_force_time]
        head += [self.pivot_acceleration, self.pivot_time, self.start_place, self.start_speed]
        head += [square(self.end_position_noise), square(self.end_tension_noise), self.tilt_noise**2]
        head += [self.gyro_noise**2, self.iterations, self.believed_after, self.bars]
        quadratic = 0.5 * self.fluid_density * self.drag_diameter * self.normal_drag
        places = [self.places(), self.tilts, self.gyros]
        tables = [self.angles or (0.0,) * self.bars, *places, self.chain(quadratic)]
        return np.concatenate([np.asarray(part, np.float64) for part in (head, *tables)])


def inputs(given: Best) -> tuple[Port, ...]:
    """Markers, and what other sensors there are."""
    ports = line.inputs(given)
    if given.end_position_noise is not None:
        ports += (Port("end_b.position", "m", (3,), "NED", "of the end away from the pivot"), Port("end_b.valid", "1"))
    if given.end_tension_noise is not None:
        ports += (Port("end_tension.value", "N"), Port("end_tension.valid", "1"))
    if k := len(given.tilts):
        ports += (
            Port("tilt.angle", "rad", (k,), "", "of the line from north towards down"),
            Port("tilt.valid", "1", (k,)),
        )
    if k := len(given.gyros):
        ports += (
            Port("gyro.rate", "rad/s", (k,), "", "of turn from north towards down"),
            Port("gyro.valid", "1", (k,)),
        )
    return ports


def outputs(given: Best) -> tuple[Port, ...]:
    """Those of all estimators: two innovations a reading; the force on the end, and whether it is contradicted."""
    own = (
        Port("force_b", "N", (3,), "NED", "on the end away from the pivot"),
        Port("deviation.force_b", "N", (2,), "NED", "north and down"),
        Port("iterations", "1", (), "", "times that the measurements were taken"),
    )
    return line.outputs(given, 2 * given.readings, given.readings) + own + line.doubts()


def sizes(given: Best) -> Sizes:
    """State: estimate (N), root of its covariance, refusals of each reading, what is kept of contradictions."""
    room = layout.py_func(given.bars, given.pivot == "moving", given.readings)
    return Sizes(state=room.N + room.N**2 + room.R + KEPT, workspace=workspace(room))


def terms(given: Best) -> tuple[Term, ...]:
    """What of the model is on."""
    k = given.spring_factor * given.flexural_rigidity / given.bar
    drag = given.fluid_density * given.drag_diameter * given.normal_drag
    return (
        Term("springs", k > 0.0, f"{k:g} N m at each joint"),
        Term("spring at the pivot", given.clamp and k > 0.0, f"clamp is {given.clamp}"),
        Term("linear drag", given.normal_friction > 0.0, f"normal_friction {given.normal_friction:g} N s/m^2"),
        Term("quadratic drag", drag > 0.0, f"drag_diameter {given.drag_diameter:g} m"),
        Term("moving pivot", given.pivot == "moving", f"pivot is {given.pivot}"),
        Term("end's position", given.end_position_noise is not None, f"end_position_noise {given.end_position_noise}"),
        Term("end's tension", given.end_tension_noise is not None, f"end_tension_noise {given.end_tension_noise}"),
        Term("inclinometers", bool(given.tilts), f"{len(given.tilts)} tilts"),
        Term("rate gyros", bool(given.gyros), f"{len(given.gyros)} gyros"),
        Term("covariance from outside", given.takes_covariance, f"takes_covariance is {given.takes_covariance}"),
        Term("markers beside the chain", given.chain_noise > 0.0, f"chain_noise {given.chain_noise:g} m"),
    )
