"""Allocations beside the exact optimum by Clarabel's conic solver: power, miss, overload and microseconds."""

from __future__ import annotations

import ctypes
import itertools
import statistics
import time
from collections.abc import Iterator
from math import radians

import clarabel
import numpy as np
from scipy import sparse

from components.allocator.exact.component import COMPONENT as EXACT
from components.allocator.exact.convex_pieces import pieces
from components.allocator.exact.model import Switchboard
from components.allocator.exact.response import (
    A_REVERSE,
    DISC,
    E0X,
    E0Y,
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    LEAST,
    LINE,
    MOST,
    MOST_REVERSE,
    NOTHING,
    SLICE,
    A,
    X,
    Y,
)
from components.allocator.newton.component import COMPONENT as NEWTON
from components.allocator.published.component import COMPONENT as PUBLISHED
from components.allocator.quadratic.component import COMPONENT as QUADRATIC
from components.allocator.thrusters import Thruster
from components.compiled import bind, kernel
from components.contract import Component
from pipeline.native_loop import call

_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
DEMANDS, EXHAUSTED, BOARDED = 300, 40, 1000  # against the conic optimum; all choices of sides tried; with boards
REPEATS, CALLS = 5, 20
SEED = 7


def _azimuth(
    x: float, y: float, thrust: float, power: float, *zones: tuple[float, float], loss: float = 1.0
) -> Thruster:
    forbidden = tuple((radians(a), radians(b)) for a, b in zones)
    return Thruster(kind="azimuth", x=x, y=y, max_thrust=thrust, max_power=power, forbidden=forbidden, loss_factor=loss)


def _tunnel(x: float, y: float, thrust: float, power: float, loss: float = 1.0) -> Thruster:
    return Thruster(kind="tunnel", x=x, y=y, max_thrust=thrust, max_power=power, loss_factor=loss)


# van Daalen et al. 2011, Table 1: pontoons of 97.5 x 23.2 m, 32.8 m apart. Positions are not tabulated; ours are on the
# pontoons' centre lines, 56 m apart, and each thruster may not blow at its neighbours within 20 degrees.
_PLACES = [(x, y) for y in (-28.0, 28.0) for x in (-41.0, -14.0, 14.0, 41.0)]
_ZONES = [[(160, 200)], [(160, 200), (-20, 20)], [(160, 200), (-20, 20)], [(-20, 20)]]
LAYOUTS = {
    "semi-submersible": tuple(_azimuth(x, y, 496e3, 3e6, *_ZONES[i % 4]) for i, (x, y) in enumerate(_PLACES)),
    # DP Capability Tool, tutorial 1 (shared/data/dp_capability/ship.yaml).
    "ship": (
        _azimuth(-108.6, -8.2, 694.428e3, 4.5e6, (71, 109), loss=0.9),
        _azimuth(-108.6, 8.2, 694.428e3, 4.5e6, (251, 289), loss=0.9),
        *(_tunnel(x, 0.0, 252.36e3, 2.2e6, 0.9) for x in (102.8, 96.8, 90.2)),
    ),
    "mixed sizes": (
        _azimuth(-40.0, -6.0, 600e3, 4e6, (70, 110)),
        _azimuth(-40.0, 6.0, 600e3, 4e6, (-110, -70)),
        _tunnel(35.0, 0.0, 150e3, 1.2e6),
        _azimuth(28.0, 0.0, 300e3, 2e6, (-30, 30)),
    ),
    "barely controllable": (
        _azimuth(-30.0, 0.0, 200e3, 1.5e6, (45, 135)),
        _tunnel(28.0, 0.0, 80e3, 0.7e6),
        Thruster(kind="fixed", x=-29.0, y=3.0, max_thrust=100e3, max_power=0.8e6, reverse_thrust=60e3),
    ),
}


WEIGHTS = (1.0, 1.0, 10.0)  # of the miss: the parameters' default


def two_boards(layout: tuple[Thruster, ...], part: float = 0.35) -> tuple[Switchboard, ...]:
    """Every other thruster on one switchboard, the rest on another, each with a part of what they could draw."""
    groups = [tuple(range(first, len(layout), 2)) for first in (0, 1)]
    return tuple(
        Switchboard(thrusters=group, spare_power=part * sum(layout[i].max_power for i in group)) for group in groups
    )


def open_water(layout: tuple[Thruster, ...]) -> tuple[Thruster, ...]:
    """The same without forbidden zones: a convex problem."""
    return tuple(thruster.model_copy(update={"forbidden": ()}) for thruster in layout)


@kernel
def _call_often(address, t_ns, step_ns, vectors, times):
    """Call the step function at an address so often with the same vectors."""
    for _ in range(times):
        call(address, t_ns, step_ns, vectors[0], vectors[1], vectors[2], vectors[3], vectors[4])


class Allocator:
    """A component outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, step_s: float = 0.1, component: Component = EXACT, **parameters):
        self.component, self.parameters = component, component.parameters(**parameters)
        self.p = component.pack(self.parameters)
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        given = component.defaults(self.parameters)
        self.u[3:] = [
            v for port in component.inputs(self.parameters)[2:] for v in given.get(port.name, (0.0,) * port.size)
        ]
        self._entries = bind(component)
        self._step_ns, self._t_ns = round(step_s * 1e9), 0
        self._init, self._step = _FUNCTION(self._entries.init), _FUNCTION(self._entries.step)
        self._addresses = [vector.ctypes.data for vector in (self.p, self.u, self.x, self.y, self.w)]
        self.call(self._init, (0.0, 0.0, 0.0))

    def call(self, function, demand) -> None:
        """One call with a demand (surge, sway [N], yaw [N m]); other inputs stay as they are."""
        self.y[:] = self.w[:] = np.nan
        self.u[:3] = demand
        assert function(self._t_ns, self._step_ns, *self._addresses) == 0

    def step(self, demand) -> None:
        """One step on."""
        self._t_ns += self._step_ns
        self.call(self._step, demand)

    def __getitem__(self, name: str) -> np.ndarray:
        k = 0
        for port in self.component.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)

    def microseconds(self, demands: np.ndarray) -> np.ndarray:
        """Of each demand, the least of some calls from a compiled loop (count,)."""
        us = np.full(len(demands), np.inf)
        for k, demand in enumerate(demands):
            self.step(demand)
            for _ in range(REPEATS):
                began = time.perf_counter_ns()
                _call_often(self._entries.step, self._t_ns, self._step_ns, np.array(self._addresses), CALLS)
                us[k] = min(us[k], (time.perf_counter_ns() - began) / (1e3 * CALLS))
        return us

    @property
    def forces(self) -> np.ndarray:
        """(n, 2) [N], from thrust and azimuth."""
        return self["thrust"][:, None] * np.stack([np.cos(self["azimuth"]), np.sin(self["azimuth"])], axis=1)


def demands(layout: tuple[Thruster, ...], count: int, seed: int = SEED) -> np.ndarray:
    """Random demands (count, 3), from none to beyond all thrusters: a part of what they give together, in each axis."""
    random = np.random.default_rng(seed)
    force = sum(t.max_thrust for t in layout)
    lever = float(np.sqrt(np.mean([t.x**2 + t.y**2 for t in layout])))
    ways = random.normal(size=(count, 3))
    ways *= (random.uniform(0.0, 1.0, count) / np.linalg.norm(ways, axis=1))[:, None]
    return ways * np.array([force, force, force * lever])


class Cone:
    """The same problem over one choice of convex pieces for Clarabel, in units of all thrusters together.

    Per thruster: force (2), thrust T, power T^(3/2) by a power cone. A LINE counts as two thrusters that push one way
    each: they never both do at the optimum. boards: of each switchboard its thrusters and what it has [W].
    """

    def __init__(
        self, rows: list[np.ndarray], force: float, power: float, lever: float, boards: tuple[Switchboard, ...] = ()
    ):
        self.rows = [way for row in rows for way in _ways(row)]
        self.owners = [i for i, row in enumerate(rows) for _ in _ways(row)]
        self.force, self.power, self.lever, self.boards = force, power, lever, boards

    def least_power(self, demand: np.ndarray) -> tuple[float | None, float]:
        """Power [W] that meets the demand, None if it cannot be met; seconds of the solver."""
        problem = _Problem(4 * len(self.rows))
        balance = problem.zero(3)
        for i, row in enumerate(self.rows):
            fx, fy, T, P = range(4 * i, 4 * i + 4)
            self._balance(balance, row, fx, fy)
            self._set(problem, row, fx, fy, T)
            problem.power(P, T)
            problem.cost[P] = self._a(row)
        self._feed(problem)
        problem.rhs[0] = self._scaled(demand)
        status, value, seconds = problem.solve()
        return (value * self.power if status in ("Solved", "AlmostSolved") else None), seconds

    def least_miss(self, demand: np.ndarray, weights: tuple[float, float, float]) -> float:
        """The weighted miss [of all thrusters' force]."""
        n = len(self.rows)
        problem = _Problem(5 * n + 1)
        matrix = np.zeros((3, 5 * n + 1))
        for i, row in enumerate(self.rows):
            fx, fy, T, P = range(4 * i, 4 * i + 4)
            self._balance(matrix, row, fx, fy)
            self._set(problem, row, fx, fy, T)
            if self.boards:
                problem.power_by_roots(P, T, 4 * n + i)
        self._feed(problem)
        block = np.zeros((4, 5 * n + 1))
        block[0, -1] = -1.0
        block[1:] = -np.array(weights)[:, None] * matrix
        problem.add(block, np.r_[0.0, -np.array(weights) * self._scaled(demand)], clarabel.SecondOrderConeT(4))
        problem.cost[-1] = 1.0
        return problem.solve()[1]

    def miss(self, force: np.ndarray, weights: tuple[float, float, float]) -> float:
        """Weighted size of a force (surge, sway [N], yaw [N m]) that is missed [of all thrusters' force]."""
        return float(np.linalg.norm(np.array(weights) * self._scaled(force)))

    def _feed(self, problem: _Problem) -> None:
        """The boards' thrusters together within what each has."""
        for board in self.boards:
            fed = [i for i, owner in enumerate(self.owners) if owner in board.thrusters]
            problem.below({4 * i + 3: self._a(self.rows[i]) for i in fed}, board.spare_power / self.power)

    def _scaled(self, demand: np.ndarray) -> np.ndarray:
        return demand / np.array([self.force, self.force, self.force * self.lever])

    def _a(self, row: np.ndarray) -> float:
        return row[A] * self.force**1.5 / self.power

    def _balance(self, matrix: np.ndarray, row: np.ndarray, fx: int, fy: int) -> None:
        matrix[0, fx] = matrix[1, fy] = 1.0
        matrix[2, fx], matrix[2, fy] = -row[Y] / self.lever, row[X] / self.lever

    def _set(self, problem: _Problem, row: np.ndarray, fx: int, fy: int, T: int) -> None:
        """|f| <= T <= most; a SECTOR between its edges, a LINE along its direction only."""
        e1x, e1y, e2x, e2y = row[[E1X, E1Y, E2X, E2Y]]
        most = 0.0 if row[KIND] == NOTHING else row[MOST] / self.force
        problem.below({T: 1.0}, most)
        problem.second_order(T, fx, fy)
        if row[KIND] == LINE:
            problem.equal({fx: -e1y, fy: e1x})
            problem.below({fx: -e1x, fy: -e1y}, 0.0)
        elif row[KIND] not in (DISC, NOTHING):
            problem.below({fx: e1y, fy: -e1x}, 0.0)
            problem.below({fx: -e2y, fy: e2x}, 0.0)
        if row[KIND] == SLICE:
            problem.below({fx: -row[E0X], fy: -row[E0Y]}, -row[LEAST] / self.force)


def _ways(row: np.ndarray) -> list[np.ndarray]:
    """A LINE as one ahead and one astern, others as they are."""
    if row[KIND] != LINE:
        return [row]
    back = row.copy()
    back[[E1X, E1Y]], back[MOST], back[A] = -row[[E1X, E1Y]], row[MOST_REVERSE], row[A_REVERSE]
    return [row, back]


class _Problem:
    """A cone programme being put together: minimise cost . z, rhs - matrix z in the cones."""

    def __init__(self, size: int):
        self.size, self.cost = size, np.zeros(size)
        self.blocks: list[np.ndarray] = []
        self.rhs: list[np.ndarray] = []
        self.cones: list = []

    def add(self, block: np.ndarray, rhs: np.ndarray, cone: object) -> np.ndarray:
        self.blocks.append(block)
        self.rhs.append(np.asarray(rhs, float))
        self.cones.append(cone)
        return block

    def zero(self, count: int) -> np.ndarray:
        return self.add(np.zeros((count, self.size)), np.zeros(count), clarabel.ZeroConeT(count))

    def _row(self, entries: dict[int, float]) -> np.ndarray:
        row = np.zeros((1, self.size))
        for at, value in entries.items():
            row[0, at] = value
        return row

    def equal(self, entries: dict[int, float]) -> None:
        self.add(self._row(entries), np.zeros(1), clarabel.ZeroConeT(1))

    def below(self, entries: dict[int, float], most: float) -> None:
        self.add(self._row(entries), np.array([most]), clarabel.NonnegativeConeT(1))

    def second_order(self, T: int, fx: int, fy: int) -> None:
        block = np.zeros((3, self.size))
        block[0, T] = block[1, fx] = block[2, fy] = -1.0
        self.add(block, np.zeros(3), clarabel.SecondOrderConeT(3))

    def power(self, P: int, T: int) -> None:
        block = np.zeros((3, self.size))
        block[0, P] = block[2, T] = -1.0
        self.add(block, np.array([0.0, 1.0, 0.0]), clarabel.PowerConeT(2.0 / 3.0))

    def power_by_roots(self, P: int, T: int, root: int) -> None:
        """T^(3/2) <= P by second-order cones, with which the solver gets on where its power cones stall.

        T^2 <= P s and s^2 <= T, each as |(2 a, b - c)| <= b + c for a^2 <= b c.
        """
        block = np.zeros((3, self.size))
        block[0, [P, root]], block[1, T], block[2, [P, root]] = -1.0, -2.0, (-1.0, 1.0)
        self.add(block, np.zeros(3), clarabel.SecondOrderConeT(3))
        block = np.zeros((3, self.size))
        block[0, T], block[1, root], block[2, T] = -1.0, -2.0, -1.0
        self.add(block, np.array([1.0, 0.0, -1.0]), clarabel.SecondOrderConeT(3))

    def solve(self) -> tuple[str, float, float]:
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
        nothing, matrix = sparse.csc_matrix((self.size, self.size)), sparse.csc_matrix(np.vstack(self.blocks))
        began = time.perf_counter()
        solver = clarabel.DefaultSolver(nothing, self.cost, matrix, np.concatenate(self.rhs), self.cones, settings)
        solution = solver.solve()
        return str(solution.status), float(solution.obj_val), time.perf_counter() - began


def cones(layout: tuple[Thruster, ...], boards: tuple[Switchboard, ...] = ()) -> Iterator[Cone]:
    """One problem for each choice of pieces of all thrusters."""
    force, power = sum(t.max_thrust for t in layout), sum(t.max_power for t in layout)
    lever = max(float(np.sqrt(np.mean([t.x**2 + t.y**2 for t in layout]))), 1.0)
    for rows in itertools.product(*(pieces(thruster) for thruster in layout)):
        yield Cone(list(rows), force, power, lever, boards)


def _miss(allocator: Allocator, layout: tuple[Thruster, ...], demand: np.ndarray, cone: Cone) -> float:
    """Of the demand, by what the thrusters can really give of the commands: forces cut to their largest thrusts."""
    most = np.array([t.max_thrust * t.loss_factor for t in layout])
    f = allocator.forces * np.minimum(1.0, most / np.maximum(abs(allocator["thrust"]), 1e-9))[:, None]
    moment = sum(t.x * fy - t.y * fx for t, (fx, fy) in zip(layout, f, strict=True))
    return float(
        np.linalg.norm((np.array([*f.sum(axis=0), moment]) - demand) / np.array([1.0, 1.0, cone.lever])) / cone.force
    )


def _method_row(case: str, layout: tuple[Thruster, ...], component: Component, wanted: np.ndarray, least: list) -> dict:
    """Power above the least where that exists, what is missed where it does, overload, microseconds."""
    allocator, cone = Allocator(component=component, thrusters=layout), next(cones(layout))
    above, missed, overload = [], [], 0.0
    most = np.array([t.max_thrust * t.loss_factor for t in layout])
    for demand, power in zip(wanted, least, strict=True):
        allocator.step(demand)
        overload = max(overload, float((abs(allocator["thrust"]) / most).max()))
        if power is not None and power > 1e-6 * cone.power:
            above.append(float(allocator["power"].sum() / power - 1.0))
            missed.append(_miss(allocator, layout, demand, cone))
    us = allocator.microseconds(wanted[:200])
    return {
        "case": case,
        "method": component.name,
        "error": float(np.median(above)),
        "largest": max(above),
        "missed": max(missed),
        "overload": overload,
        "us": float(np.median(us)),
        "slowest_us": float(us.max()),
    }


def _conic_row(case: str, seconds: list[float]) -> dict:
    row = {"error": 0.0, "largest": 0.0, "missed": 0.0, "overload": 1.0}
    us = {"us": 1e6 * statistics.median(seconds), "slowest_us": 1e6 * max(seconds)}
    return {"case": case, "method": "Clarabel", **row, **us}


def _least(problems: list[Cone], demand: np.ndarray) -> tuple[float | None, float]:
    """The least power over all choices, and the seconds of all."""
    found = [problem.least_power(demand) for problem in problems]
    powers = [power for power, _ in found if power is not None]
    return min(powers, default=None), sum(seconds for _, seconds in found)


def total(allocator: Allocator, layout: tuple[Thruster, ...]) -> np.ndarray:
    """(3,) surge, sway [N] and yaw [N m] of the commands themselves."""
    f = allocator.forces
    return np.array([*f.sum(axis=0), sum(t.x * fy - t.y * fx for t, (fx, fy) in zip(layout, f, strict=True))])


def _board_rows(name: str, layout: tuple[Thruster, ...]) -> list[dict]:
    """Two switchboards with limited power; `residual`: the weighted miss above the least of demands beyond them."""
    boards = two_boards(layout)
    allocator, cone = Allocator(thrusters=layout, switchboards=boards), next(cones(layout, boards))
    wanted, above, residual, seconds, overload = demands(layout, BOARDED), [0.0], [0.0], [], 0.0
    for demand in wanted:
        allocator.step(demand)
        least, spent = cone.least_power(demand)
        seconds.append(spent)
        overload = max(overload, float((allocator["board.power"] / allocator.u[3:]).max()))
        if allocator["met"] == 1.0 and least is not None:
            above.append((allocator["power"].sum() - least) / max(least, 1e-4 * cone.power))
        else:
            residual.append(cone.miss(total(allocator, layout) - demand, WEIGHTS) - cone.least_miss(demand, WEIGHTS))
    us = allocator.microseconds(wanted[:200])
    row = {
        "case": f"{name}, boards",
        "method": EXACT.name,
        "error": float(np.median(above)),
        "largest": max(above),
        "residual": max(residual),
        "overload": overload,
        "us": float(np.median(us)),
        "slowest_us": float(us.max()),
    }
    return [row, _conic_row(row["case"], seconds)]


def rows() -> list[dict]:
    """Four layouts with and without zones; with them the semi-submersible's 4096 choices are left to the tests."""
    table = []
    for name, layout in LAYOUTS.items():
        for case, some in ((name, open_water(layout)), (f"{name}, zones", layout)):
            problems = list(cones(some))
            wanted = demands(some, DEMANDS if len(problems) == 1 else EXHAUSTED if len(problems) < 100 else 2)
            found = [_least(problems, demand) for demand in wanted]
            least = [power for power, _ in found]
            methods = (EXACT, PUBLISHED, NEWTON, QUADRATIC)
            table += [_method_row(case, some, component, wanted, least) for component in methods]
            table.append(_conic_row(case, [seconds for _, seconds in found]))
        table += _board_rows(name, open_water(layout))
    common = {
        "error_unit": "power above the least, part of it, median of demands that can be met; negative where it is not",
        "reference": "Clarabel, power cones, gap 1e-11; with zones the best of all choices of sides",
    }
    return [{**row, **common} for row in table]
