"""The ROV's tether of the main scene as estimator.tether tells it: shape, end tensions and ROV, beside the log's truth.

From 30 s on, by when the USBL has given ten positions, before and after the current grows by half at 420 s. Authority:
the dynamic line of tether.cable, which the estimator does not know, in a current that it is told wrongly.
"""

from __future__ import annotations

import ctypes
import tempfile
import time
from pathlib import Path

import numpy as np

from components.compiled import functions
from pipeline.log.reader import Log, open_log
from pipeline.replay import inputs_of
from pipeline.rerun import graph_of
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENE = Path(__file__).parents[2] / "scenarios" / "dp_rov_tether.yaml"
SPANS = ((30.0, 420.0), (420.0, 600.0), (30.0, 600.0))
Row = dict[str, str | float]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _errors(log: Log) -> list[Row]:
    t = log.times("estimator")
    chosen = {name: np.searchsorted(log.times(name), t) for name in ("estimator", "tether", "rov")}

    def seen(component: str, port: str) -> np.ndarray:
        return log.port(component, port)[chosen[component]]

    shape = np.linalg.norm(seen("estimator", "nodes") - seen("tether", "nodes")[:, ::2], axis=2)
    true = np.maximum(seen("tether", "tension")[:, [0, -1]], 0.0)
    place = np.linalg.norm(seen("estimator", "end_b.position") - seen("rov", "hook.position"), axis=1)
    table: list[Row] = []
    for first, last in SPANS:
        part = (t >= first * 1e9) & (t <= last * 1e9)
        case = f"{first:g} to {last:g} s"
        table.append({"case": case, "what": "shape", "error": _rms(shape[part]), "error_unit": "m, rms of the nodes"})
        table.append({"case": case, "what": "ROV", "error": _rms(place[part]), "error_unit": "m, rms"})
        for end, name in enumerate(("ship", "ROV")):
            mean = float(true[part, end].mean())
            for port, method in (("tension", "estimated"), ("mean_tension", "the line at rest alone")):
                error = _rms(seen("estimator", port)[part, end] - true[part, end])
                row: Row = {"case": case, "what": f"tension at the {name}, {method}", "error": error}
                table.append({**row, "error_unit": "N, rms", "error_percent": 100.0 * error / mean})
    return [{**row, "reference": "tether.cable"} for row in table]


def _microseconds(log: Log) -> float:
    """Of a compiled step, the median over the scene."""
    _, graph = graph_of(log)
    i = next(i for i, node in enumerate(graph.nodes) if node.name == "estimator")
    node = graph.nodes[i]
    sizes, (_, inputs) = node.component.sizes(node.parameters), inputs_of(log, graph, i)
    p = node.component.pack(node.parameters, node.seed)
    u, x, y, w = (np.zeros(size) for size in (inputs.shape[1], sizes.state, node.width, sizes.workspace))
    calls = [entry._bound[1] for entry in functions(node.component)]
    addresses = [ctypes.c_void_p(vector.ctypes.data) for vector in (p, u, x, y, w)]
    dt_ns, taken = node.period * graph.base_ns, []
    for k, values in enumerate(inputs):
        u[:] = values
        began = time.perf_counter()
        assert calls[k > 0](k * dt_ns, dt_ns, *addresses) == 0
        taken.append(time.perf_counter() - began)
    return 1e6 * float(np.median(taken))


def rows() -> list[Row]:
    """Errors by span, and what a step costs."""
    scenario = load_scenario(SCENE)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "scene.mcap"
        result = run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
        with open_log(out) as log:
            speed: Row = {"case": "whole scene", "what": "a step", "us": _microseconds(log)}
            return [*_errors(log), {**speed, "real_time_factor_of_the_scene": result.real_time_factor}]
