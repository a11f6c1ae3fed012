"""Component steps a second of five van der Pol oscillators, beside the error of the trajectory at 10 s."""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from pipeline.conductor import Conductor
from pipeline.graph import Graph
from pipeline.run import Options, run_scenario
from pipeline.scenario import Scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIO = Path(__file__).parents[2] / "scenarios" / "van_der_pol.yaml"
REPEATS = 5
COMPARED_S = 10.0
LOOP_TICKS = 2_000_000
RECORDED_TICKS = 200_000


def _load(step_ms: int, ticks: int) -> tuple[Scenario, Graph]:
    text = SCENARIO.read_text().replace("step: 1 ms", f"step: {step_ms} ms")
    scenario = load_scenario_text(text, SCENARIO.name, SCENARIO.parent, (), f"{ticks * step_ms} ms")
    return scenario, build_graph(scenario)


def _advance(graph: Graph) -> tuple[float, np.ndarray]:
    """Wall time [s] of the loop over the whole graph, and the five positions at its end."""
    conductor = Conductor(graph)
    conductor.initialise()
    began = time.perf_counter()
    for _ in conductor.run(graph.ticks):
        pass
    return time.perf_counter() - began, conductor.memory.tables.board[: graph.board : 2].copy()


def _recorded(scenario: Scenario, graph: Graph, folder: str) -> float:
    """Wall time [s] with digest and recording of every step."""
    return run_scenario(scenario, graph, Path(folder) / "v.mcap", Options(overwrite=True), lambda _: None).wall_s


def _exact(graph: Graph) -> np.ndarray:
    """The coupled equations without any splitting, by DOP853 at 1e-12."""
    start = [node.parameters for node in graph.nodes]

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        x, v = state[:5], state[5:]
        mu = np.array([p.mu for p in start])
        kappa = np.array([p.coupling for p in start])
        return np.concatenate([v, mu * (1 - x**2) * v - x + kappa * (np.roll(x, 1) - x)])

    state = np.array([p.position for p in start] + [p.velocity for p in start])
    return solve_ivp(rate, (0.0, COMPARED_S), state, "DOP853", rtol=1e-12, atol=1e-12).y[:5, -1]


def rows() -> list[dict]:
    """Loop alone and with recording."""
    table = []
    for step_ms in (10, 1):
        graph = _load(step_ms, round(COMPARED_S * 1000 / step_ms))[1]
        error = float(np.abs(_advance(graph)[1] - _exact(graph)).max())
        common = {"case": f"five in a ring, {step_ms} ms", "error": error, "error_unit": "largest |x| error at 10 s"}
        common["reference"] = "DOP853 of the coupled equations, 1e-12"
        loop_s = statistics.median(_advance(_load(step_ms, LOOP_TICKS)[1])[0] for _ in range(REPEATS))
        table.append({**common, "method": "native loop", "component_steps_per_s": 5 * LOOP_TICKS / loop_s})
        with tempfile.TemporaryDirectory() as folder:
            walls = [_recorded(*_load(step_ms, RECORDED_TICKS), folder) for _ in range(REPEATS)]
        recorded_s = statistics.median(walls)
        table.append({**common, "method": "with recording", "component_steps_per_s": 5 * RECORDED_TICKS / recorded_s})
    return table
