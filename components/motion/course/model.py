"""A course through points at given times, uniform before the first and after the last: its parameters and port."""

from __future__ import annotations

from itertools import pairwise
from math import factorial, isfinite

import numpy as np
from pydantic import model_validator
from scipy.interpolate import make_interp_spline

from components.contract import Parameters, Port, Term, choice, motion_ports, quantity

FEWEST_ROWS = 2


class Course(Parameters):
    """The quintic spline through the rows; two rows are a straight course at one speed."""

    origin: tuple[float, float, float] = quantity("m", "what the rows are relative to, NED", (0.0, 0.0, 0.0))
    table: tuple[tuple[float, ...], ...] = choice(
        "rows of time [s] and north, east, down [m]; before the second and after the last but one about uniform, and "
        "exactly so outside them all, at the mean velocity of the first and last interval"
    )

    @model_validator(mode="after")
    def _rows_fit(self) -> Course:
        if len(self.table) < FEWEST_ROWS:
            raise ValueError(f"table has {len(self.table)} rows: a course needs at least {FEWEST_ROWS}")
        for i, row in enumerate(self.table):
            if len(row) != 4 or not all(map(isfinite, row)):
                raise ValueError(f"table.{i} is {row}: expected four finite numbers: time, north, east, down")
        for i, (before, row) in enumerate(pairwise(self.table)):
            if round(before[0] * 1e9) >= round(row[0] * 1e9):
                raise ValueError(f"table.{i + 1}: time {row[0]:g} s: expected times that increase")
        return self

    def vector(self) -> np.ndarray:
        """Origin; number of pieces; the pieces as in track.py, the first and the last uniform: (4 + 19 k,) float64."""
        rows = np.array(self.table)
        knots_ns = np.round(rows[:, 0] * 1e9)
        seconds = (knots_ns - knots_ns[0]) * 1e-9
        slopes = np.diff(rows[:, 1:], axis=0) / np.diff(seconds)[:, None]
        ends = [[(1, slope), (2, np.zeros(3))] for slope in (slopes[0], slopes[-1])]
        spline = make_interp_spline(seconds, rows[:, 1:], k=5, bc_type=(ends[0], ends[1]))
        taylor = np.stack([spline(seconds[:-1], nu=k) / factorial(k) for k in range(6)], axis=-1)
        uniform = np.zeros((2, 3, 6))
        uniform[:, :, 0], uniform[:, :, 1] = rows[[0, -1], 1:], slopes[[0, -1]]
        pieces = np.concatenate([uniform[:1], taylor, uniform[1:]]).reshape(len(rows) + 1, -1)
        starts_ns = [knots_ns[0], *knots_ns]
        return np.concatenate([self.origin, [len(pieces)], np.column_stack([starts_ns, pieces]).ravel()])


def outputs(_: Course) -> tuple[Port, ...]:
    """The vessel's motion."""
    return motion_ports("motion")


def terms(course: Course) -> tuple[Term, ...]:
    """What of the model is on."""
    rows = len(course.table)
    return (Term("manoeuvre", rows > FEWEST_ROWS, f"{rows} rows"),)
