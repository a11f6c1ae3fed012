"""A stick held in the hand: a programme of moves or a table, its parameters and port.

The law of motion, stated before any result of a line was looked at. Drupt et al. 2022 say only: a stick moved by an
operator, "in various directions with slow and rapid motion", abrupt changes of direction among it. So the hand
- sweeps to both sides of its home by strokes of least jerk, as unconstrained arm movements are found to be, at any
  speed and also in the vertical (Flash and Hogan 1985; Atkeson and Hollerbach 1985, J. Neurosci. 5, 2318-2330);
- reverses abruptly at constant speed, goes round circles and figures of eight;
- follows all this as a low-pass filter: voluntary movement of the whole arm stays below a few hertz (the shoulder's
  accelerations in aimed movements reach 5.6 Hz: IEEE Trans. SMC 24, June 1994), less with a stick in water. The default
  of 2 Hz turns 1 m/s round in about 0.3 s;
- adds a small random unsteadiness, within the same band.
The default speeds: 0.3 m/s is slow for an arm; at 1.0 m/s a stick of 20 mm, 1.5 m under water, already takes
rho C_D d l v^2 / 2 = 18 N (C_D = 1.2), so that it is not moved much faster for long.
"""

from math import factorial

import numpy as np
from pydantic import model_validator
from scipy.interpolate import make_interp_spline

from components.contract import Parameters, Port, Sizes, Term, choice, motion_ports, quantity
from components.motion.hand.moves import segment
from components.motion.hand.spline import CONTROLS

# Spacing of the spline's knots times the frequency that it halves: (sin(pi x)/(pi x))^6 = 1/2.
HALVED = 0.26193816997

# Bound of the control points' uniform noise over the rms of the spline: sqrt(3 / B_11(0)), B_11(0) = 655177/1663200.
BOUND = 2.75964707

FEWEST_ROWS = 2


class Hand(Parameters):
    """Either moves with their durations, repeated without end, or a table; both relative to the centre."""

    centre: tuple[float, float, float] = quantity("m", "home of the hand, NED", (0.0, 0.0, 0.0))
    moves: tuple[str, ...] = choice("'rest' or '<slow|fast> <sweep|reversal|circle|eight> <axes>', in order", ())
    durations: tuple[float, ...] = quantity("s", "of the moves; what whole cycles leave over is rest", ())
    reach: float = quantity("m", "farthest the moves go from the centre", 0.5, gt=0)
    slow: float = quantity("m/s", "highest speed of a slow move", 0.3, gt=0)
    fast: float = quantity("m/s", "highest speed of a fast move", 1.0, gt=0)
    bandwidth: float = quantity("Hz", "frequency that the hand follows with half the amplitude", 2.0, ge=0.1, le=100)
    tremor: float = quantity("m", "rms of the random unsteadiness along each axis", 0.0, ge=0)
    table: tuple[tuple[float, ...], ...] | None = choice("rows of time [s] and north, east, down [m], or none", None)

    @model_validator(mode="after")
    def _one_source(self):
        if (self.table is None) == (not self.moves):
            raise ValueError("give either moves with durations, or a table")
        if self.table is None:
            self._programme()
        else:
            _check_rows(self.table)
        return self

    @property
    def knot_ns(self) -> int:
        """Spacing of the control points [ns]."""
        return round(HALVED / self.bandwidth * 1e9)

    def _programme(self) -> list[float]:
        """Number of segments, period [ns], and the segments."""
        if len(self.moves) != len(self.durations):
            raise ValueError(f"{len(self.moves)} moves, but {len(self.durations)} durations: give one for each")
        numbers: list[float] = []
        start_ns = 0
        for i, (move, duration) in enumerate(zip(self.moves, self.durations, strict=True)):
            if round(duration * 1e9) < 1:
                raise ValueError(f"durations.{i} is {duration:g} s: it must be positive")
            try:
                numbers += segment(move, start_ns, duration, self.reach, {"slow": self.slow, "fast": self.fast})
            except ValueError as error:
                raise ValueError(f"moves.{i} '{move}': {error}") from None
            start_ns += round(duration * 1e9)
        return [len(self.moves), start_ns, *numbers]

    def vector(self) -> np.ndarray:
        """Whether there is a table, knot spacing, bound of the tremor, centre; then the programme or the table."""
        source = self._programme() if self.table is None else _pieces(np.array(self.table))
        head = [self.table is not None, self.knot_ns, BOUND * self.tremor, *self.centre]
        return np.concatenate([np.array(head, np.float64), source])


def _check_rows(rows: tuple[tuple[float, ...], ...]) -> None:
    if len(rows) < FEWEST_ROWS:
        raise ValueError(f"table has {len(rows)} rows: a motion needs at least {FEWEST_ROWS}")
    last_ns = -1
    for i, row in enumerate(rows):
        if len(row) != 4:
            raise ValueError(f"table.{i} has {len(row)} numbers: expected time, north, east, down")
        if not np.isfinite(row).all():
            raise ValueError(f"table.{i} is {row}: expected finite numbers")
        if row[0] < 0.0 or round(row[0] * 1e9) <= last_ns:
            raise ValueError(f"table.{i}: time {row[0]:g} s: expected times from 0 s on, each later than the last")
        last_ns = round(row[0] * 1e9)


def _pieces(rows: np.ndarray) -> np.ndarray:
    """Number of pieces, end [ns], pieces as in track.py: the quintic spline through rows (n, 4), at rest outside."""
    knots_ns = np.round(rows[:, 0] * 1e9)
    still = [(1, np.zeros(3)), (2, np.zeros(3))]
    spline = make_interp_spline((knots_ns - knots_ns[0]) * 1e-9, rows[:, 1:], k=5, bc_type=(still, still))
    starts = (knots_ns[:-1] - knots_ns[0]) * 1e-9
    taylor = np.stack([spline(starts, nu=k) / factorial(k) for k in range(6)], axis=-1)  # (pieces, axes, powers)
    coefficients = taylor.reshape(len(starts), -1)
    return np.concatenate([[len(rows) - 1, knots_ns[-1]], np.column_stack([knots_ns[:-1], coefficients]).ravel()])


def outputs(_: Hand) -> tuple[Port, ...]:
    """The stick's end."""
    return motion_ports("motion")


def sizes(_: Hand) -> Sizes:
    """No state; the control points around the time, by axis, are scratch."""
    return Sizes(workspace=3 * CONTROLS)


def terms(hand: Hand) -> tuple[Term, ...]:
    """What of the model is on."""
    rows = 0 if hand.table is None else len(hand.table)
    wobbles = hand.tremor > 0.0 and not rows
    return (
        Term("programme of moves", not rows, f"{len(hand.moves)} moves"),
        Term("unsteadiness", wobbles, "a table is followed as it is" if rows else f"tremor {hand.tremor:g} m"),
        Term("table", rows > 0, f"{rows} rows" if rows else "no table"),
    )
