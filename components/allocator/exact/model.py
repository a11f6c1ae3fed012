"""The allocator of least power: its parameters, ports and sizes."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from components.allocator.exact.boards import COLUMNS
from components.allocator.exact.convex_pieces import cover, pieces
from components.allocator.exact.losses import LOSING
from components.allocator.exact.response import (
    A_REVERSE,
    BOARD,
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
(COUNT, PIECES, FORCE, POWER, LEVER, MARGIN, NODES, LIMITED, BOARDS, LOSES, MEETS_WATER,
 WAKE_TIME) = range(12)  # fmt: skip
MISSES, START, TABLES = 12, 15, 24
DEMAND, FLAGS = 3, 4  # numbers of u before the spare powers; of y at its end: met, held, proven, nodes
FASTER_TORQUE = 1.15  # speed of the water at which torque vanishes over that at which thrust does


class Switchboard(Parameters):
    """What feeds some thrusters, with a power that they may not exceed together."""

    thrusters: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(min_length=1)] = choice(
        "that it feeds, by their places in the list, the first being 0"
    )
    spare_power: float = quantity("W", "for them together, while the input of this name has no wire", ge=0)


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
        "part of the power, or of the miss where there is one, that must be saved for a thruster to go to another side "
        "of its forbidden zone",
        0.0,
        ge=0,
        lt=1,
    )
    most_nodes: Annotated[int, Field(ge=1)] = choice(
        "convex problems that a step may solve; at least until one choice of sides is found", 10_000
    )
    switchboards: tuple[Switchboard, ...] = choice("whose spare power limits thrusters; others have what they need", ())
    meets_water: bool = choice(
        "whether it has the inputs `water_velocity` and `yaw_rate`, the vessel's in the water, for the loss of thrust",
        False,
    )

    wake_time: float = quantity(
        "s",
        "in which a wake grows and fades, as it is carried along; keeps thrusters from chasing each other's",
        10.0,
        gt=0,
    )

    @model_validator(mode="after")
    def _fits(self) -> Exact:
        fed: set[int] = set()
        for b, board in enumerate(self.switchboards):
            for i in board.thrusters:
                if i >= len(self.thrusters):
                    raise ValueError(f"switchboards.{b}: no thruster {i}; the last is {len(self.thrusters) - 1}")
                if i in fed:
                    raise ValueError(f"switchboards.{b}: thruster {i} is fed twice")
                fed.add(i)
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

    @property
    def loses(self) -> bool:
        """Whether thrusters lose thrust by the water or by wakes."""
        by_water = self.meets_water and any(t.zero_thrust_speed for t in self.thrusters)
        return by_water or any(t.wake_diameter for t in self.thrusters)

    def losing(self) -> np.ndarray:
        """(n, LOSING) as losses.py has it; empty where nothing is lost."""
        rows = []
        for t in self.thrusters if self.loses else ():
            stops = t.zero_thrust_speed or inf
            stalls = t.zero_torque_speed or FASTER_TORQUE * stops
            rows.append((1.0 / stops, 1.0 / stalls, (t.wake_diameter or 0.0) / self.lever))
        return np.array(rows).reshape(-1, LOSING)

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
        for b, board in enumerate(self.switchboards):
            for i in board.thrusters:
                covers[i, BOARD] = flat[int(first[i]) : int(first[i + 1]), BOARD] = b
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
        """Counts and scales (12), 1 / weights^2 (3), start (9), rates (n, 2), first (n + 1), covers, pieces, losing."""
        covers, first, flat = self.tables()
        force, power = self.scales
        head = [len(covers), len(flat), force, power, self.lever, self.hysteresis, self.most_nodes, self.is_limited]
        head += [len(self.switchboards), self.loses, self.meets_water, self.wake_time]
        rates = [(t.azimuth_rate or inf, (t.thrust_rate or inf) / force) for t in self.thrusters]
        misses = [1.0 / weight**2 for weight in self.weights]
        parts = [head, misses, _start(covers), np.array(rates), first, covers, flat, self.losing()]
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


def inputs(exact: Exact) -> tuple[Port, ...]:
    """The demand about the reference point, what the switchboards have, and the water if it matters."""
    ports: tuple[Port, ...] = (
        Port("demand.force", "N", (2,), "body", "surge and sway"),
        Port("demand.moment", "N*m", (), "body", "yaw"),
    )
    if exact.switchboards:
        ports += (Port("spare_power", "W", (len(exact.switchboards),), "", "of each switchboard for its thrusters"),)
    if exact.meets_water:
        ports += (
            Port("water_velocity", "m/s", (2,), "body", "of the reference point through the water"),
            Port("yaw_rate", "rad/s", (), "body"),
        )
    return ports


def defaults(exact: Exact) -> Mapping[str, tuple[float, ...]]:
    """The spare powers of the parameters."""
    return {"spare_power": tuple(board.spare_power for board in exact.switchboards)} if exact.switchboards else {}


def outputs(exact: Exact) -> tuple[Port, ...]:
    """Commands, what they achieve, and which limits were active."""
    n, boards = len(exact.thrusters), len(exact.switchboards)
    still: tuple[Port, ...] = ()
    if exact.loses:
        still = (Port("still.thrust", "N", (n,), "", "what the shafts' speeds would give in still and open water"),)
    fed: tuple[Port, ...] = ()
    if boards:
        fed = (
            Port("board.power", "W", (boards,), "", "that its thrusters draw together"),
            Port("limit.board", "1", (boards,), "", "1: at its spare power, or above it where a rate holds thrust up"),
        )
    return (
        Port("thrust", "N", (n,), "", "of each thruster, negative in reverse"),
        Port("azimuth", "rad", (n,), "body", "direction of its force when thrust is positive; continuous in time"),
        Port("power", "W", (n,), "", "of each thruster, in bollard pull"),
        Port("achieved.force", "N", (2,), "body"),
        Port("achieved.moment", "N*m", (), "body"),
        Port("limit.thrust", "1", (n,), "", "1: at its largest thrust"),
        Port("limit.azimuth", "1", (n,), "", "1: at the edge of a forbidden zone, or turning through it"),
        Port("limit.rate", "1", (n,), "", "1: kept from its optimum by a rate"),
        *still,
        *fed,
        Port("met", "1", (), "", "1: the demand is met"),
        Port("held", "1", (), "", "1: an input was no number, or a spare power negative; the last command is held"),
        Port("proven", "1", (), "", "1: no better choice of sides is possible; 0: most_nodes was reached"),
        Port("nodes", "1", (), "", "convex problems solved"),
    )


def sizes(exact: Exact) -> Sizes:
    """State: of each thruster force (2), azimuth, thrust and side; outputs but flags; what wakes and all
    losses leave of each thrust.

    Scratch: see component.py.
    """
    n, depth = len(exact.thrusters), 3 + sum(max(len(pieces(t)) - 1, 0) for t in exact.thrusters)
    scratch = 2 * n + n * SET + 20 + 5 * n + depth * (4 + n) + len(exact.switchboards) * COLUMNS + n
    if exact.loses:
        scratch += 3 + (n + sum(len(pieces(t)) for t in exact.thrusters)) * SET
    held = sum(port.size for port in outputs(exact)) - FLAGS
    return Sizes(state=7 * n + held, workspace=scratch)


def terms(exact: Exact) -> tuple[Term, ...]:
    """What can be off."""
    zones = [i for i, t in enumerate(exact.thrusters) if len(pieces(t)) > 1]
    rates = [i for i, t in enumerate(exact.thrusters) if t.azimuth_rate or t.thrust_rate]
    jets = [i for i, t in enumerate(exact.thrusters) if t.wake_diameter]
    failed = [i for i, usable in enumerate(exact.available) if not usable]
    return (
        Term("forbidden zones", bool(zones), f"thrusters {zones} have sides to choose from" if zones else "none given"),
        Term("rate limits", bool(rates), f"thrusters {rates} have one" if rates else "no azimuth_rate, no thrust_rate"),
        Term(
            "spare power",
            bool(exact.switchboards),
            f"{len(exact.switchboards)} switchboards" if exact.switchboards else "no switchboards given",
        ),
        _water_term(exact),
        Term("wakes", bool(jets), f"thrusters {jets} have a wake_diameter" if jets else "no wake_diameter"),
        Term("hysteresis", exact.hysteresis > 0.0, f"hysteresis is {exact.hysteresis:g}"),
        Term("failures", bool(failed), f"thrusters {failed} are not available" if failed else "all are available"),
    )


def _water_term(exact: Exact) -> Term:
    losing = [i for i, t in enumerate(exact.thrusters) if t.zero_thrust_speed] if exact.meets_water else []
    why = f"thrusters {losing} have a zero_thrust_speed" if losing else "no meets_water or no zero_thrust_speed"
    return Term("loss by water", bool(losing), why)
