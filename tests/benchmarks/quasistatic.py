"""Microseconds of a line in a sheared current beside its error, over meshes, and beside scipy's collocation."""

from __future__ import annotations

import statistics
import time

import numpy as np
from scipy.integrate import solve_bvp

from components.compiled import as_compiled
from components.tether.quasistatic.component import COMPONENT
from components.tether.quasistatic.model import Quasistatic

REPEATS = 9
DEPTHS, CURRENT = (0.0, 400.0), ((1.0, 0.2, 0.0), (0.1, 0.0, 0.0))
END_B = (120.0, 0.0, 200.0)
FINEST = 1600
_step = as_compiled(COMPONENT.step)


def _solve(segments: int) -> tuple[np.ndarray, float, float]:
    """Nodes (n+1, 3) [m], estimated error [m] and wall time [s]."""
    parameters = Quasistatic(
        length=300.0,
        weight=0.5,
        axial_stiffness=1e6,
        drag_diameter=0.015,
        tangential_drag=0.02,
        segments=segments,
        current_depth=DEPTHS,
        current=CURRENT,
    )
    ports = COMPONENT.outputs(parameters)
    y, w = np.empty(sum(port.size for port in ports)), np.empty(COMPONENT.sizes(parameters).workspace)
    p, u = COMPONENT.pack(parameters), np.array([*[0.0] * 9, *END_B, *[0.0] * 6])
    walls = []
    for _ in range(REPEATS + 1):
        began = time.perf_counter()
        _step(0, 1, p, u, np.empty(0), y, w)
        walls.append(time.perf_counter() - began)
    place = 4 * (segments + 1) + 9  # behind nodes, tensions, both forces and three of the account
    return y[: 3 * (segments + 1)].reshape(-1, 3), float(y[place]), statistics.median(walls[1:])


def _by_collocation(guess: np.ndarray, tolerance: float) -> tuple[np.ndarray, float]:
    """scipy's solve_bvp from the straight line: nodes at the guess's places, and wall time [s]."""
    c_n, c_t = 0.5 * 1025.97 * 0.015 * 1.2, 0.5 * 1025.97 * 0.015 * np.pi * 0.02

    def rate(_: np.ndarray, state: np.ndarray) -> np.ndarray:
        r, N = state[:3], state[3:]
        T = np.linalg.norm(N, axis=0)
        t = N / T
        v = np.array([np.interp(r[2], DEPTHS, [row[k] for row in CURRENT]) for k in range(3)])
        s = (v * t).sum(axis=0)
        n = v - s * t
        load = c_n * np.linalg.norm(n, axis=0) * n + c_t * np.abs(s) * s * t + np.array([[0.0], [0.0], [0.5]])
        return np.concatenate([t * (1.0 + T / 1e6), -load])

    s = np.linspace(0.0, 300.0, len(guess))
    tangent = np.gradient(guess, s, axis=0).T
    start = np.concatenate([guess.T, 200.0 * tangent])
    began = time.perf_counter()
    found = solve_bvp(
        rate, lambda a, b: np.concatenate([a[:3], b[:3] - END_B]), s, start, tol=tolerance, max_nodes=50000
    )
    return found.sol(s)[:3].T, time.perf_counter() - began


def rows() -> list[dict]:
    """A 300 m ROV tether between two points in shear."""
    exact, _, _ = _solve(FINEST)
    table = []
    for segments in (20, 50, 100, 200):
        nodes, estimate, wall = _solve(segments)
        error = float(np.linalg.norm(nodes - exact[:: FINEST // segments], axis=1).max())
        table.append(
            {"method": f"towline, {segments} segments", "us": 1e6 * wall, "error": error, "estimate": estimate}
        )
    guess = _solve(50)[0]
    for tolerance in (1e-4, 1e-8):
        nodes, wall = _by_collocation(guess, tolerance)
        error = float(np.linalg.norm(nodes - exact[:: FINEST // 50], axis=1).max())
        table.append({"method": f"scipy solve_bvp {tolerance:g}, given the shape", "us": 1e6 * wall, "error": error})
    common = {"case": "300 m tether in sheared current", "error_unit": "m", "reference": f"{FINEST} segments"}
    return [{**common, **row} for row in table]
