"""The allocator of least power: its parameters, ports and sizes."""

from __future__ import annotations

from math import inf
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.allocator.exact.convex_pieces import cover, pieces
from components.allocator.exact.response import (
    A_REVERSE,
    E1X,
    E1Y,
    KIND,
    LINE,
    MOST,
    MOST_REVERSE,
    NOTHING,
    SET,
    A,
    X,
    Y,
)
from components.allocator.thrusters import Thruster
from components.contract import Parameters, Port, Sizes, Term, choice, quantity

NotNegative = Annotated[float, Field(ge=0)]
Positive = Annotated[float, Field(gt=0)]
Axes = tuple[Positive, Positive, Positive]
# In p after the header, before the tables: see vector().
(COUNT, PIECES, FORCE, POWER, LEVER, MARGIN, NODES, LIMITED) = range(8)
MISSES, START, TABLES = 8, 11, 20


class Exact(Parameters):
    """Least power that meets the demand; where it cannot be met, the least miss, and the least power at that."""

    thrusters: Annotated[tuple[Thruster, ...], Field(min_length=1, max_length=24)] = choice("the actuators")
    available: tuple[NotNegative, ...] = quantity(
        "1", "for each thruster whether it can be used, 0 or 1; none given: all can", (), tunable=True
    )
    weights: Axes = quantity(
        "1",
        "of surge, sway and yaw in the miss of a demand beyond the thrusters; yaw counts by the moment over the root "
        "mean square distance of the thrusters from the reference point",
        (1.0, 1.0, 10.0),
        tunable=True,
    )
    hysteresis: float = quantity(
        "1",
        "part of the power that must be saved for a thruster to go to another side of its forbidden zone",
        0.0,
        ge=0,
        lt=1,
    )
    most_nodes: Annotated[int, Field(ge=1)] = choice("convex problems that a step may solve", 10_000)

    @model_validator(mode="after")
    def _fits(self) -> Exact:
        if self.available and len(self.available) != len(self.thrusters):
            raise ValueError(f"available has {len(self.available)} values for {len(self.thrusters)} thrusters")
        return self

    @property
    def lever(self) -> float:
        """Root mean square distance of the thrusters from the reference point, 1 m at least [m]."""
        return max(float(np.sqrt(np.mean([t.x**2 + t.y**2 for t in self.thrusters]))), 1.0)

    @property
    def is_limited(self) -> bool:
        """Whether a rate is limited."""
        return any(t.azimuth_rate or t.thrust_rate for t in self.thrusters)

    def tables(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of each thruster the cover of its pieces (n, SET) and the first piece (n + 1,); pieces (m, SET); scaled."""
        found = [pieces(thruster) for thruster in self.thrusters]
        covers = np.array([cover(rows) for rows in found])
        flat = np.array([row for rows in found for row in rows])
        first = np.cumsum([0, *(len(rows) for rows in found)]).astype(np.float64)
        for i, usable in enumerate(self.available):
            if usable == 0.0:
                covers[i, KIND] = NOTHING
                flat[int(first[i]) : int(first[i + 1]), KIND] = NOTHING
        force, power = self.scales
        for rows in (covers, flat):
            rows[:, [MOST, MOST_REVERSE]] /= force
            rows[:, [A, A_REVERSE]] *= force**1.5 / power
            rows[:, [X, Y]] /= self.lever
        return covers, first, flat

    @property
    def scales(self) -> tuple[float, float]:
        """Sums of largest thrusts [N] and powers [W]."""
        return sum(t.max_thrust for t in self.thrusters), sum(t.max_power for t in self.thrusters)

    def vector(self) -> np.ndarray:
        """Counts and scales (8), 1 / weights^2 (3), start (3, 3), rates (n, 2), first (n + 1), covers, pieces."""
        covers, first, flat = self.tables()
        force, power = self.scales
        head = [len(covers), len(flat), force, power, self.lever, self.hysteresis, self.most_nodes, self.is_limited]
        rates = [(t.azimuth_rate or inf, (t.thrust_rate or inf) / force) for t in self.thrusters]
        misses = [1.0 / weight**2 for weight in self.weights]
        parts = [head, misses, _start(covers), np.array(rates), first, covers, flat]
        return np.concatenate([np.ravel(np.asarray(part, np.float64)) for part in parts])


def _start(covers: np.ndarray) -> np.ndarray:
    """(3, 3) prices per demand if all thrusters gave force in proportion to them, up to their largest at once."""
    total = np.zeros((3, 3))
    for row in covers[covers[:, KIND] != NOTHING]:
        arms = np.array([[1.0, 0.0], [0.0, 1.0], [-row[Y], row[X]]])
        e = row[[E1X, E1Y]]
        ways = np.outer(e, e) if row[KIND] == LINE else np.eye(2)
        most, a = max((row[MOST], row[A]), (row[MOST_REVERSE], row[A_REVERSE]))
        total += arms @ ways @ arms.T * np.sqrt(most) / (1.5 * a)
    return np.linalg.inv(total + 1e-6 * max(np.trace(total), 1e-6) * np.eye(3))


def inputs(_: Exact) -> tuple[Port, ...]:
    """The demand about the reference point."""
    return (
        Port("demand.force", "N", (2,), "body", "surge and sway"),
        Port("demand.moment", "N*m", (), "body", "yaw"),
    )


def outputs(exact: Exact) -> tuple[Port, ...]:
    """Commands, what they achieve, and which limits were active."""
    n = len(exact.thrusters)
    return (
        Port("thrust", "N", (n,), "", "of each thruster, negative in reverse"),
        Port("azimuth", "rad", (n,), "body", "direction of its force when thrust is positive; continuous in time"),
        Port("power", "W", (n,), "", "of each thruster, in bollard pull"),
        Port("achieved.force", "N", (2,), "body"),
        Port("achieved.moment", "N*m", (), "body"),
        Port("limit.thrust", "1", (n,), "", "1: at its largest thrust"),
        Port("limit.azimuth", "1", (n,), "", "1: at the edge of a forbidden zone, or turning through it"),
        Port("limit.rate", "1", (n,), "", "1: kept from its optimum by a rate"),
        Port("met", "1", (), "", "1: the demand is met"),
        Port("held", "1", (), "", "1: the demand was no number, and the last command is held"),
        Port("proven", "1", (), "", "1: no better choice of sides is possible; 0: most_nodes was reached"),
        Port("nodes", "1", (), "", "convex problems solved"),
    )


def sizes(exact: Exact) -> Sizes:
    """State: of each thruster force (2), azimuth, thrust and side chosen. Scratch: see component.py."""
    n, depth = len(exact.thrusters), 3 + sum(max(len(pieces(t)) - 1, 0) for t in exact.thrusters)
    scratch = 2 * n + n * SET + 20 + 5 * n + depth * (4 + n)
    return Sizes(state=5 * n, workspace=scratch)


def terms(exact: Exact) -> tuple[Term, ...]:
    """What can be off."""
    zones = [i for i, t in enumerate(exact.thrusters) if len(pieces(t)) > 1]
    rates = [i for i, t in enumerate(exact.thrusters) if t.azimuth_rate or t.thrust_rate]
    failed = [i for i, usable in enumerate(exact.available) if not usable]
    return (
        Term("forbidden zones", bool(zones), f"thrusters {zones} have sides to choose from" if zones else "none given"),
        Term("rate limits", bool(rates), f"thrusters {rates} have one" if rates else "no azimuth_rate, no thrust_rate"),
        Term("hysteresis", exact.hysteresis > 0.0, f"hysteresis is {exact.hysteresis:g}"),
        Term("failures", bool(failed), f"thrusters {failed} are not available" if failed else "all are available"),
    )
