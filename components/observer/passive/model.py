"""The nonlinear passive observer: its parameters, ports and sizes."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.contract import Sizes, quantity
from components.observer.layout import RECORD, RECORDS, STATES
from components.observer.ship import ShipObserver

Positive = Annotated[float, Field(gt=0)]
Three = tuple[Positive, Positive, Positive]


class Passive(ShipObserver):
    """Gains in closed form instead of a covariance; each is that of north or surge, east or sway, heading or yaw.

    Fossen and Strand 1999 (Automatica 35, 3-16): stable at all headings where 1 / bias_time is well below slow_rate,
    that below the waves' frequency, and that below the cut-off.
    """

    cut_off: Three = quantity("1", "frequency of the position's filter over that of the waves", (1.22, 1.22, 1.22))
    notch: Three = quantity("1", "damping ratio of the notch at the waves' frequency", (1.0, 1.0, 1.0))
    velocity_gain: Three = quantity(
        "rad/s", "square root of the acceleration per error of position", (0.11, 0.11, 0.11), tunable=True
    )
    slow_rate: Three = quantity("rad/s", "slow load's growth over the correcting load", (0.03, 0.03, 0.03))
    gate: float = quantity("m", "innovation of a position beyond which it is wild", 10.0, tunable=True, gt=0)
    gate_speed: float = quantity("m/s", "its growth without a position", 0.2, tunable=True, ge=0)
    heading_gate: float = quantity("rad", "innovation of a heading beyond which it is wild", 0.2, tunable=True, gt=0)
    heading_gate_speed: float = quantity("rad/s", "its growth without a heading", 0.01, tunable=True, ge=0)

    @model_validator(mode="after")
    def _notch_is_wider(self) -> Passive:
        if min(self.notch) <= self.wave_damping:
            raise ValueError("notch must be above wave_damping")
        if min(self.cut_off) <= 1.0:
            raise ValueError("cut_off must be above 1: above the waves' frequency")
        return self

    def vector(self) -> np.ndarray:
        """Gains (4, 3), gates (3), their speeds (3), then the numbers of all observers."""
        level = 0.5 * (self.surge_mass + self.sway_mass)
        masses = (level, level, self.yaw_inertia)
        to_velocity = [gain**2 for gain in self.velocity_gain]
        to_slow = [rate * k * m for rate, k, m in zip(self.slow_rate, to_velocity, masses, strict=True)]
        gates = [self.gate, self.gate, self.heading_gate, self.gate_speed, self.gate_speed, self.heading_gate_speed]
        numbers = [*self.cut_off, *self.notch, *to_velocity, *to_slow, *gates, *self.block()]
        return np.array(numbers, np.float64)


def sizes(passive: Passive) -> Sizes:
    """State: the estimate, what all observers keep, when a heading was used last. Scratch: see component.py."""
    return Sizes(state=STATES + RECORDS + RECORD * (len(passive.references) + 1) + 1, workspace=16)
