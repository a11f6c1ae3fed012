"""Parameters, ports and state that the allocators without the exact method share."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.allocator.thrusters import Thruster
from components.contract import Parameters, Port, choice

KINDS = ("azimuth", "tunnel", "fixed")
EXACT_ONLY = ("factors", "azimuth_rate", "thrust_rate", "zero_thrust_speed", "wake_diameter")


class Plain(Parameters):
    """Thrusters whose limits the method knows nothing of, or only in part."""

    thrusters: Annotated[tuple[Thruster, ...], Field(min_length=1, max_length=24)] = choice("the actuators")

    @model_validator(mode="after")
    def _fits(self) -> Plain:
        for i, thruster in enumerate(self.thrusters):
            if thruster.kind not in KINDS or any(getattr(thruster, name) for name in EXACT_ONLY):
                raise ValueError(f"thrusters.{i}: rudders, factors, losses and rates are for allocator.exact only")
        return self

    def table(self) -> np.ndarray:
        """(n, 7) position [m], power coefficient [W/N^(3/2)], largest thrust [N], direction, whether it cannot turn."""
        rows = []
        for t in self.thrusters:
            most, is_fixed = t.max_thrust * t.loss_factor, t.kind != "azimuth"
            rows.append((t.x, t.y, t.max_power / most**1.5, most, np.cos(t.heading), np.sin(t.heading), is_fixed))
        return np.array(rows, np.float64)

    def vector(self) -> np.ndarray:
        """Number of thrusters, table (n, 7)."""
        return np.concatenate([[len(self.thrusters)], self.table().ravel()])


def inputs(_: Plain) -> tuple[Port, ...]:
    """The demand about the reference point."""
    return (
        Port("demand.force", "N", (2,), "body", "surge and sway"),
        Port("demand.moment", "N*m", (), "body", "yaw"),
    )


def outputs(plain: Plain) -> tuple[Port, ...]:
    """Commands, limits or not, and what they would achieve."""
    n = len(plain.thrusters)
    return (
        Port("thrust", "N", (n,), "", "of each thruster, negative in reverse"),
        Port("azimuth", "rad", (n,), "body", "direction of its force when thrust is positive"),
        Port("power", "W", (n,), "", "of each thruster, in bollard pull"),
        Port("achieved.force", "N", (2,), "body", "if the thrusters gave what is commanded"),
        Port("achieved.moment", "N*m", (), "body", "the same"),
        Port("converged", "1", (), "", "1: the method came to its end; 0: what it had when it could not go on"),
        Port("overload", "1", (), "", "largest thrust commanded over what the thruster has"),
    )
