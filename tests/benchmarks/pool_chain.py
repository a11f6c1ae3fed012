"""The pool chain with recording: times real time, beside the error of end force and shape against a converged run."""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import numpy as np

from pipeline.log.reader import open_log
from pipeline.run import Options, Result, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIO = Path(__file__).parents[2] / "scenarios" / "pool_chain.yaml"
REPEATS = 5
COMPARED = "166.98 s"
# (segments, step): the scenario's own and its neighbours; the last is the reference.
CASES = ((20, "20 ms"), (50, "20 ms"), (50, "10 ms"), (100, "5 ms"))
REFERENCE = (200, "1 ms")
COARSEST_S = 0.02


def _run(folder: Path, segments: int, step: str, duration: str | None = None) -> tuple[Result, Path]:
    text = SCENARIO.read_text().replace("step: 20 ms", f"step: {step}").replace("segments: 50", f"segments: {segments}")
    scenario = load_scenario_text(text, SCENARIO.name, SCENARIO.parent, (), duration)
    out = folder / "run.mcap"
    return run_scenario(scenario, build_graph(scenario), out, Options(overwrite=True), lambda _: None), out


def _compared(folder: Path, segments: int, step: str) -> tuple[np.ndarray, np.ndarray]:
    """Force on the hand (k, 3) [N] and eleven points along the line (k, 11, 3) [m], each 20 ms."""
    result, out = _run(folder, segments, step, COMPARED)
    log = open_log(out)
    every = round(COARSEST_S / (result.simulated_s / (log.channels["tether"].count - 1)))
    nodes = log.port("tether", "nodes")[::every]
    return log.port("tether", "force_b")[::every], nodes[:, :: segments // 10]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum(values**2, axis=-1))))


def rows() -> list[dict]:
    """One row a resolution."""
    table = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        force, points = _compared(folder, *REFERENCE)
        for segments, step in CASES:
            f, q = _compared(folder, segments, step)
            factors = []
            for _ in range(REPEATS):
                began = time.perf_counter()
                result, _ = _run(folder, segments, step)
                factors.append(result.simulated_s / (time.perf_counter() - began))
            table.append(
                {
                    "case": f"{segments} segments, {step}",
                    "method": "generalised-alpha, recorded",
                    "error": 1e3 * _rms(q - points),
                    "error_unit": "mm rms of the shape",
                    "force_error_N_median": float(np.median(np.linalg.norm(f - force, axis=1))),
                    "force_error_N_rms": _rms(f - force),
                    "real_time_factor": statistics.median(factors),
                    "reference": "own run, {} segments, {}".format(*REFERENCE),
                }
            )
    return table
