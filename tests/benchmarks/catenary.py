"""Microseconds of a static line beside its residual, over a grid of ends, and beside a general root finder."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from decimal import Decimal, localcontext
from itertools import product
from math import asinh, cos, hypot, inf, radians, sin

import numpy as np
from scipy.optimize import root

from components.compiled import kernel
from components.tether.catenary.line import Rest, rest

REPEATS = 7
ROUNDS = 200
SCIPY_LINES = 200
CHORDS = (0.05, 0.3, 0.6, 0.9, 0.99, 0.9999)
TAUT = (*CHORDS, 1.0001, 1.05)
ANGLES = (0.0, 20.0, 60.0, 85.0, 89.9, -40.0)
ELASTICITIES = (1e-9, 1e-4, 1e-2, 1.0)
FRICTIONS = (0.0, 0.5)
Grid = np.ndarray


def _hanging(chords: tuple[float, ...], elasticities: tuple[float, ...]) -> Grid:
    """Rows of (span, rise, e, p_a, p_b, mu) in lengths; the load's direction is in the angles."""
    some = product(chords, ANGLES, elasticities)
    return np.array([(c * cos(radians(a)), c * sin(radians(a)), e, inf, inf, 0.0) for c, a, e in some])


def _drags(row: tuple[float, ...]) -> bool:
    line = rest(*row)[1]
    return line.touches and line.H > 0.0


def _grounded() -> Grid:
    some = product((0.85, 0.9, 0.97), (0.05, 0.2), ELASTICITIES, FRICTIONS)
    lines = [(span, depth, e, 0.0, depth, mu) for span, depth, e, mu in some]
    return np.array([one for one in lines if _drags(one)])


@kernel
def _solve_all(grid, rounds):
    total = 0.0
    for _ in range(rounds):
        for i in range(grid.shape[0]):
            _, line = rest(grid[i, 0], grid[i, 1], grid[i, 2], grid[i, 3], grid[i, 4], grid[i, 5])
            total += line.H
    return total


def _miss(line: Rest, h: float, v: float) -> float:
    """Distance of the far end from where it should be, by the textbook formulae in 50 digits."""
    with localcontext() as context:
        context.prec = 50
        H, e, s_a, s_b, mu = (Decimal(float(value)) for value in (line.H, line.e, line.s_a, line.s_b, line.mu_a))
        x, z = _far_end(H, e, s_a, s_b, mu, line.touches)
        return hypot(float(x - Decimal(h)), float(z - Decimal(v)))


def _far_end(H: Decimal, e: Decimal, s_a: Decimal, s_b: Decimal, mu: Decimal, touches: bool) -> tuple[Decimal, Decimal]:
    """Irvine 1981, section 1.2; on the seabed Jonkman 2007, NREL/TP-500-41958, eqs. 2-37, anchored at end a."""
    T_b = (H * H + s_b * s_b).sqrt()
    hanging = H * ((s_b + T_b) / H).ln() + e * H * s_b
    if touches:
        lying = 1 - s_b
        loaded = min(lying, H / mu) if mu else lying
        return lying + e * loaded * (H - mu * loaded / 2) + hanging, T_b - H + e * s_b * s_b / 2
    T_a = (H * H + s_a * s_a).sqrt()
    return hanging + H * ((s_a + T_a) / H).ln() + e * H * s_a, T_b - T_a + e * (s_b * s_b - s_a * s_a) / 2


def _by_scipy(h: float, v: float, e: float) -> float:
    """Distance missed by scipy's hybrid Powell method on the same two equations; NaN where it failed."""

    def equations(force: np.ndarray) -> tuple[float, float]:
        H, V = max(abs(force[0]), 1e-12), force[1]
        T_a, T_b = hypot(H, V - 0.5), hypot(H, V + 0.5)
        return e * H + H * (asinh((V + 0.5) / H) - asinh((V - 0.5) / H)) - h, e * V + T_b - T_a - v

    tension = max(hypot(h, v) - 1.0, 0.0) / max(e, 1e-3) + 0.3
    found = root(equations, (tension * h / hypot(h, v), tension * v / hypot(h, v)), tol=1e-15)
    miss = hypot(*equations(found.x))
    return miss if miss < 1e-6 else float("nan")


def _seconds(work: Callable[[], object]) -> float:
    spent = []
    for _ in range(REPEATS):
        began = time.thread_time()
        work()
        spent.append(time.thread_time() - began)
    return statistics.median(spent)


def _row(case: str, grid: Grid) -> dict:
    _solve_all(grid, 1)
    took = _seconds(lambda: _solve_all(grid, ROUNDS)) / (ROUNDS * len(grid))
    missed = [_miss(rest(*one)[1], one[0], one[1]) for one in grid]
    return {"case": case, "method": "towline", "lines": len(grid), "us": 1e6 * took, "error": max(missed), "failed": 0}


def _scipy_row(case: str, grid: Grid) -> dict:
    some = grid[:: max(len(grid) // SCIPY_LINES, 1)]
    missed = np.array([_by_scipy(*one[:3]) for one in some])
    began = time.thread_time()
    for one in some:
        _by_scipy(*one[:3])
    took = (time.thread_time() - began) / len(some)
    failed = int(np.isnan(missed).sum())
    return {
        "case": case,
        "method": "scipy.optimize.root",
        "lines": len(some),
        "us": 1e6 * took,
        "error": float(np.nanmax(missed)),
        "failed": failed,
    }


def rows() -> list[dict]:
    """Inextensible, elastic and grounded lines over a grid from nearly coincident to taut ends, level to steep."""
    rigid = _hanging(CHORDS, (0.0,))
    elastic = _hanging(TAUT, ELASTICITIES)
    table = [
        _row("inextensible", rigid),
        _scipy_row("inextensible", rigid),
        _row("elastic", elastic),
        _scipy_row("elastic", elastic),
        _row("on the seabed, with and without friction", _grounded()),
    ]
    common = {
        "error_unit": "largest miss of end b, lengths",
        "reference": "Irvine 1981 and Jonkman 2007 in 50 digits",
    }
    return [{**row, **common} for row in table]
