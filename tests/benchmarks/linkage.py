"""The chain of rigid segments: cost of a step over their number, and times real time in the loop, beside the error.

Two boats abreast on an about-turn with 18.288 m of rope. Beside it the method of Bhattacharya et al. 2011 in numpy: the
quasi-static matrices of (23) in full, theta' = -B^-1 A P' of (24), stepped by Heun's method.

Why ten segments do not reach 20 000 times real time, 500 ns a step: of a step's one Newton iteration the elimination
takes 378 ns, the way back 75, the closure 77; keeping the state 91, outputs 64, boats and loop 150 (each alone in a
compiled loop, beside a load of 4). The elimination is bound by how many operations it has, not by their order: two in
step, as from both ends, took 559 ns where the same work in sequence took 548; without the stores that it could do
without, 371. Half of it would need both halves of the line in one vector register, and another layout of the state.
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path

import numpy as np

from pipeline.conductor import Conductor
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
LENGTH, DRAG = 18.288, 0.05
LINEAR, QUADRATIC = "parameters/boom_rope.yaml", "parameters/boom_rope_quadratic.yaml"
DURATION_S, REPEATS = 40.0, 5
COUNTS = (10, 30, 100, 300, 1000)
FINEST = 320
Row = dict[str, str | float]


def _loop(file: str, segments: int, step_ms: float) -> tuple[float, np.ndarray, float]:
    """Least wall time of a step, boats included [s], nodes at the end (n+1, 3) [m], and the median wall time [s]."""
    text = (SCENARIOS / "boom_about_turn.yaml").read_text()
    text = text.replace("step: 10 ms", f"step: {step_ms} ms")
    text = text.replace(f"{{file: {QUADRATIC}, segments: 40}}", f"{{file: {file}, segments: {segments}}}")
    scenario = load_scenario_text(text, "linkage.yaml", SCENARIOS, (), f"{DURATION_S} s")
    walls = []
    for _ in range(REPEATS if step_ms == 10.0 else 1):
        graph = build_graph(scenario)
        conductor = Conductor(graph)
        conductor.initialise()
        began = time.perf_counter()
        for _ in conductor.run(graph.ticks):
            pass
        walls.append((time.perf_counter() - began) / graph.ticks)
    board = conductor.memory.tables.board
    nodes = board[18 : 18 + 3 * (segments + 1)].reshape(-1, 3).copy()
    return min(walls), nodes, statistics.median(walls)


def _boats() -> float:
    """Least wall time of a step of both boats without the line [s]."""
    text = (SCENARIOS / "boom_about_turn.yaml").read_text().partition("  boom:")[0]
    scenario = load_scenario_text(text, "boats.yaml", SCENARIOS, (), f"{DURATION_S} s")
    walls = []
    for _ in range(REPEATS):
        conductor = Conductor(build_graph(scenario))
        conductor.initialise()
        ticks, began = conductor.graph.ticks, time.perf_counter()
        for _ in conductor.run(ticks):
            pass
        walls.append((time.perf_counter() - began) / ticks)
    return min(walls)


def _ends(step_s: float) -> np.ndarray:
    """Positions of both boats, (steps + 1, 4) [m], as the scenario's courses give them."""
    scenario = load_scenario_text(
        (SCENARIOS / "boom_about_turn.yaml").read_text(), "linkage.yaml", SCENARIOS, (), "1 s"
    )
    graph = build_graph(scenario)
    t_ns = np.round(np.arange(round(DURATION_S / step_s) + 1) * step_s * 1e9).astype(np.int64)
    boats = []
    for node in graph.nodes[:2]:
        p, y = node.component.pack(node.parameters), np.empty(9)
        rows = []
        for t in t_ns:
            node.component.step(int(t), 1, p, np.empty(0), np.empty(0), y, np.empty(0))
            rows.append(y[:2].copy())
        boats.append(np.array(rows))
    return np.hstack(boats)


def _dense_rates(theta: np.ndarray, ends_velocity: np.ndarray) -> np.ndarray:
    """(24) for c_S = c_V = c: theta' (n,) by full matrices, Q_theta = 0 (22) with the closure (20)."""
    n = len(theta)
    l0 = LENGTH / n
    normal = l0 * np.column_stack([-np.sin(theta), np.cos(theta)])
    # Velocities of the rods' middles by theta': (n, n, 2); F and tau of (14) for equal coefficients.
    middle = np.tril(np.ones((n, n)), -1)[:, :, None] * normal[None] + 0.5 * np.eye(n)[:, :, None] * normal[None]
    force = -DRAG * l0 * middle
    Q = np.einsum("kic,kjc->ij", middle, force) - np.eye(n) * DRAG * l0**3 / 12.0
    A = np.block([[Q, normal], [normal.T, np.zeros((2, 2))]])
    left = -DRAG * l0 * middle.sum(axis=0) @ ends_velocity[:2]
    return np.linalg.solve(A, np.concatenate([-left, ends_velocity[2:] - ends_velocity[:2]]))[:n]


def _dense(segments: int, theta: np.ndarray, step_s: float) -> tuple[float, np.ndarray]:
    """Wall time of a step [s] and nodes at the end (n+1, 2) [m]."""
    ends = _ends(step_s)
    velocities = np.diff(ends, axis=0) / step_s
    began = time.perf_counter()
    for v in velocities:
        first = _dense_rates(theta, v)
        second = _dense_rates(theta + step_s * first, v)
        theta = theta + 0.5 * step_s * (first + second)
    wall = (time.perf_counter() - began) / len(velocities)
    rods = LENGTH / segments * np.column_stack([np.cos(theta), np.sin(theta)])
    return wall, ends[-1, :2] + np.vstack([np.zeros(2), np.cumsum(rods, axis=0)])


def _first_angles(segments: int) -> np.ndarray:
    """Angles (n,) of the steady tow at the beginning."""
    text = (SCENARIOS / "boom_about_turn.yaml").read_text()
    text = text.replace(f"{{file: {QUADRATIC}, segments: 40}}", f"{{file: {LINEAR}, segments: {segments}}}")
    graph = build_graph(load_scenario_text(text, "linkage.yaml", SCENARIOS, (), "1 s"))
    conductor = Conductor(graph)
    conductor.initialise()
    at = 18 + 4 * segments + 9
    return conductor.memory.tables.board[at : at + segments].copy()


def _error(nodes: np.ndarray, exact: np.ndarray) -> float:
    """Largest distance of a node from the reference's, over the length."""
    every = (len(exact) - 1) // (len(nodes) - 1)
    return float(np.linalg.norm(nodes[:, :2] - exact[::every, :2], axis=1).max() / LENGTH)


def rows() -> list[Row]:
    """Quasi-static with linear drag, dynamic with quadratic, over the number of segments; the dense method at 10."""
    alone = _boats()
    table: list[Row] = [{"case": "no line", "method": "both boats alone", "us": 1e6 * alone,
                         "real_time_factor": 0.01 / alone}]  # fmt: skip
    for case, file in (("quasi-static, linear drag", LINEAR), ("dynamic, quadratic drag", QUADRATIC)):
        _, exact, _ = _loop(file, FINEST, 2.5)
        for segments in COUNTS:
            wall, nodes, median = _loop(file, segments, 10.0)
            row: Row = {
                "case": f"{case}, {segments} segments, 10 ms",
                "method": "towline, native loop with both boats",
                "us": 1e6 * wall,
                "us_median": 1e6 * median,
                "ns_per_segment": 1e9 * wall / segments,
                "real_time_factor": 0.01 / wall,
            }
            if FINEST % segments == 0:
                row |= {"error": _error(nodes, exact), "error_unit": "largest distance over the length"}
                row["reference"] = f"{FINEST} segments, 2.5 ms"
            table.append(row)
        if file == LINEAR:
            _, same, _ = _loop(file, 10, 2.5)
            wall, nodes = _dense(10, _first_angles(10), 0.01)
            table.append(
                {
                    "case": f"{case}, 10 segments, 10 ms",
                    "method": "(24) with full matrices, numpy, Heun",
                    "us": 1e6 * wall,
                    "real_time_factor": 0.01 / wall,
                    "error": _error(nodes, exact),
                    "error_unit": "largest distance over the length",
                    "reference": f"{FINEST} segments, 2.5 ms",
                    "difference": _error(nodes, same),
                }
            )
    return table
