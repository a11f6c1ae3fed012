"""What all estimators of a line have in common: the chain of bars that stands for it, its markers, its outputs."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Parameters, Port, choice, quantity
from components.tether.linkage.lagrangian import constants

NEAR = 1e-9  # of the length: markers reach the end by a rounding


class Line(Parameters):
    """A part of a line that hangs in the vertical plane north and down from its pivot, as a chain of equal bars.

    Trigo et al. 2014, figure 11: the last bar's second end is where the rest of the line pulls. The water that the line
    moves weighs the same along and across (`mass_per_length` holds it), and drags across only.

    `chain_noise` is for markers known better than a chain can follow: images tell them to 0.1 mm, and an arc that turns
    by phi along a bar of l is l phi^2 / 24 longer than its chord, 0.2 mm for 0.2 m and 0.15 rad. It is 0 unless given,
    as no parameter tells the curvature; without `takes_covariance` it belongs to `marker_noise`, to which it adds.
    """

    length: float = quantity("m", "of all bars", gt=0)
    bars: Annotated[int, Field(ge=1, le=100)] = choice("number of equal bars", 5)
    mass_per_length: float = quantity("kg/m", "with the water it moves", gt=0)
    weight: float = quantity("N/m", "in water, per length")
    flexural_rigidity: float = quantity("N*m^2", "EI, of which the joints' springs are", 0.0, ge=0)
    spring_factor: float = quantity("1", "K of a joint over EI / l, gamma K_theta of (6); 1 for many bars", 2.21, gt=0)
    clamp: bool = choice("whether the first bar has a spring towards north, K of (4): twice a joint's", False)
    gamma: float = quantity(
        "1", "centres of mass lie gamma l / 2 behind a bar's first joint, (9); 1: uniform bars", 1.0, gt=0, le=2
    )
    normal_friction: float = quantity("N*s/m^2", "linear drag across, per length and speed", 0.0, ge=0)
    markers: Annotated[int, Field(ge=1, le=200)] = choice("number of markers", 6)
    spacing: float = quantity("m", "of the markers along the line", gt=0)
    first: float = quantity("m", "of the first marker from the pivot along the line", 0.0, ge=0)
    marker_noise: float = quantity("m", "standard deviation of a marker's position, north and down", tunable=True, gt=0)
    takes_covariance: bool = choice("whether it has the input `covariance`, of each marker, instead", False)
    chain_noise: float = quantity(
        "m", "standard deviation of a marker from the chain, whose bars are no arcs: adds to its covariance", 0.0, ge=0
    )
    position: tuple[float, float, float] = quantity("m", "of the pivot at t0, NED", (0.0, 0.0, 0.0))
    angles: tuple[float, ...] = quantity("rad", "of the bars from north to down at t0; none: by the markers", ())
    start_angle: float = quantity("rad", "standard deviation of the first angles", 0.3, gt=0)
    start_rate: float = quantity("rad/s", "of the first rates of turn", 1.0, gt=0)
    gate: float = quantity(
        "1", "deviations of its innovation beyond which a marker is refused, unless most are", 5.0, tunable=True, gt=0
    )

    believed_after: Annotated[int, Field(ge=1)] = choice("frames in a row for which a reading is refused at most", 14)

    @model_validator(mode="after")
    def _markers_are_on_it(self) -> Line:
        reach = self.first + (self.markers - 1) * self.spacing
        if reach > self.length * (1.0 + NEAR):
            raise ValueError(
                f"the last of {self.markers} markers would be {reach:g} m along a line of {self.length:g} m: "
                "expected fewer markers, a smaller spacing or a smaller first"
            )
        if self.angles and len(self.angles) != self.bars:
            raise ValueError(f"{len(self.angles)} angles for {self.bars} bars: give one for each, or none")
        return self

    @property
    def bar(self) -> float:
        """Length of a bar [m]."""
        return self.length / self.bars

    def springs(self) -> np.ndarray:
        """(n,) of the joints [N m], the first the pivot's: (4) and (6)."""
        k = np.full(self.bars, self.spring_factor * self.flexural_rigidity / self.bar)
        k[0] *= 2.0 if self.clamp else 0.0
        return k

    def chain(self, quadratic: float = 0.0) -> np.ndarray:
        """The numbers of `lagrangian.constants`; quadratic: drag across per length [N s^2/m^3]."""
        l = self.bar
        mass, weight = self.mass_per_length * l, self.weight * l
        springs, c, J = self.springs(), 0.5 * self.gamma * l, mass * l * l / 12.0
        return constants(self.bars, l, mass, weight, springs, c, J, self.normal_friction, quadratic, 0.0)

    def places(self) -> np.ndarray:
        """(m,) of the markers from the pivot along the line [m]."""
        return self.first + self.spacing * np.arange(self.markers)


def inputs(line: Line) -> tuple[Port, ...]:
    """What a tracker or a camera gives of the markers."""
    m = line.markers
    ports = (
        Port("position", "m", (m, 3), "NED", "of the markers, from the pivot on; its second number is not used"),
        Port("valid", "1", (m,), "", "1 where there is a position"),
    )
    if line.takes_covariance:
        ports += (Port("covariance", "m^2", (m, 2, 2), "NED", "of each position, north and down"),)
    return ports


def doubts() -> tuple[Port, ...]:
    """Whether what an estimator says is to be believed, see contradiction.py."""
    return (
        Port("contradiction", "1", (), "", "frames in a row in which sensors contradict each other or the estimate"),
        Port("beginnings", "1", (), "", "times that it began anew from the markers"),
    )


def outputs(line: Line, innovations: int, readings: int) -> tuple[Port, ...]:
    """The estimate, how sure it is, and how well it met what was measured.

    innovations: how many scalars at most; readings: of how many sensors it tells whether they were used.
    """
    n = line.bars
    return (
        Port("nodes", "m", (n + 1, 3), "NED", "ends of the bars"),
        Port("angle", "rad", (n,), "", "of each bar from north towards down"),
        Port("rate", "rad/s", (n,), "", "of turn"),
        Port("moment", "N*m", (n,), "", "of the springs at the joints, the first the pivot's"),
        Port("tension", "N", (n,), "", "of each bar, the mean of its ends'"),
        Port("end_tension", "N", (), "", "at the end away from the pivot"),
        Port("deviation.nodes", "m", (n + 1, 2), "NED", "standard deviations, north and down"),
        Port("deviation.angle", "rad", (n,), ""),
        Port("deviation.rate", "rad/s", (n,), ""),
        Port("deviation.moment", "N*m", (n,), ""),
        Port("deviation.tension", "N", (n,), ""),
        Port("deviation.end_tension", "N", (), ""),
        Port("innovation", "1", (innovations,), "", "normalised, one after the other: independent and normal"),
        Port("freedom", "1", (), "", "number of innovations"),
        Port("nis", "1", (), "", "sum of their squares: chi-square of `freedom` where the filter fits"),
        Port("log_density", "1", (), "", "of what was measured, given all before; its sum is the likelihood"),
        Port("used", "1", (readings,), "", "of each sensor: 1 used, 0 missing, -1 refused"),
    )
