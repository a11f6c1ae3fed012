"""A demand that is played from a record: its parameters and ports."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator
from scipy.interpolate import CubicSpline

from components.contract import Parameters, Port, choice
from components.vessel.loads import load_ports

Row = tuple[float, float, float, float]


class Record(Parameters):
    """Rows of a demand through time, with a natural cubic spline between; before and after it is the first and last."""

    table: tuple[Row, ...] = choice("rows of time [s], surge and sway [N], yaw [N m]")

    @model_validator(mode="after")
    def _goes_forward(self) -> Record:
        if len(self.table) < 2:
            raise ValueError(f"table has {len(self.table)} rows; expected two at least")
        times = np.array(self.table)[:, 0]
        if (np.diff(times) <= 0.0).any():
            raise ValueError(f"times of table do not grow at row {int(np.argmax(np.diff(times) <= 0.0)) + 2}")
        return self

    def vector(self) -> np.ndarray:
        """Knots n, times (n), then for each interval and axis four coefficients, the cubic one first (n - 1, 3, 4)."""
        rows = np.array(self.table)
        spline = CubicSpline(rows[:, 0], rows[:, 1:], bc_type="natural")
        return np.concatenate([[len(rows)], rows[:, 0], np.ravel(np.moveaxis(spline.c, 0, 2))])


def outputs(_: Record) -> tuple[Port, ...]:
    """The demand."""
    return load_ports("demand")
