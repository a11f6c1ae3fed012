"""An extended Kalman filter of a vessel's motion: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from components.contract import Port, Sizes, quantity
from components.observer import ship
from components.observer.layout import RECORD, RECORDS, STATES
from components.observer.ship import ShipObserver

Positive = Annotated[float, Field(gt=0)]
Three = tuple[Positive, Positive, Positive]


class Kalman(ShipObserver):
    """States as in van Daalen et al. 2011, figure 1, and Fossen 2011, section 11.3: motion, waves, slow loads.

    Standard deviations of what drives the model: white loads, slow loads, and the motion in waves.
    """

    heading_noise: float = quantity("rad", "standard deviation of the compass", gt=0)
    disturbance_force: float = quantity("N", "white force each way: standard deviation of its mean over a second", gt=0)
    disturbance_moment: float = quantity("N*m", "the same of the moment", gt=0)
    slow_force: float = quantity("N", "of the slow force, north and east", gt=0)
    slow_moment: float = quantity("N*m", "of the slow moment", gt=0)
    wave_motion: float = quantity("m", "of the motion in waves, north and east", tunable=True, gt=0)
    wave_turn: float = quantity("rad", "of the heading in waves", tunable=True, gt=0)
    start_position: float = quantity("m", "of the first position, each way", 10.0, gt=0)
    start_heading: float = quantity("rad", "of the first heading", 0.1, gt=0)
    start_speed: float = quantity("m/s", "of the first surge and sway", 0.5, gt=0)
    start_turning: float = quantity("rad/s", "of the first rate of turn", 0.005, gt=0)
    gate: float = quantity(
        "1", "standard deviations of an innovation beyond which a value is wild", 5.0, tunable=True, gt=0
    )

    def vector(self) -> np.ndarray:
        """White loads' variance of the rates (9) [1/s], variances, gate, then the numbers of all observers."""
        inverse = np.linalg.inv(self.mass_matrix())
        white = np.array([self.disturbance_force, self.disturbance_force, self.disturbance_moment]) ** 2
        slow, waves = [self.slow_force**2] * 2, [self.wave_motion**2] * 2
        place, speed = [self.start_position**2] * 2, [self.start_speed**2] * 2
        numbers = [
            *(inverse @ np.diag(white) @ inverse.T).ravel(), *slow, self.slow_moment**2, *waves, self.wave_turn**2,
            *place, self.start_heading**2, *speed, self.start_turning**2, self.heading_noise**2, self.gate**2,
            *self.block(),
        ]  # fmt: skip
        return np.array(numbers, np.float64)


def outputs(kalman: Kalman) -> tuple[Port, ...]:
    """Those of all observers, and how sure the filter is."""
    n = len(kalman.references)
    return (
        *ship.outputs(kalman),
        Port("deviation.position", "m", (2,), "NED", "standard deviation of the estimate"),
        Port("deviation.heading", "rad", (), "NED", "the same"),
        Port("nis.references", "1", (n,), "", "normalised innovation squared: chi-square of two where the filter fits"),
        Port("nis.compass", "1", (), "", "chi-square of one"),
    )


def sizes(kalman: Kalman) -> Sizes:
    """State: see component.py. Scratch: 9 x 9 slopes twice, two covariances, three rows, and 24 numbers."""
    n = len(kalman.references)
    state = STATES + STATES**2 + RECORDS + RECORD * (n + 1)
    return Sizes(state=state, workspace=2 * 81 + 2 * STATES**2 + 3 * STATES + 24)
