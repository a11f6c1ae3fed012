"""Seconds of `towline validity` and `towline report` from the process' start, beside how far their numbers are off."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from pipeline.analysis.markers import from_log
from pipeline.analysis.plane import LEAST_POINTS
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
DURATION = "600s"
REPEATS = 5
LIMIT_S = 120.0
LEAST_MARKERS = 7  # N > 6, Drupt et al. 2022

Row = dict[str, str | float]


def _recorded(path: Path) -> None:
    """The chain for ten minutes, as `towline run` records it."""
    scenario = load_scenario(ROOT / "scenarios" / "pool_chain.yaml", [], DURATION)
    run_scenario(scenario, build_graph(scenario), path, Options(), lambda _: None)


def _timed(words: list[str]) -> tuple[dict[str, Any], float]:
    """What the command says of the markers, and its median time [s]; a first run, that may compile, does not count."""
    command = [sys.executable, "-m", "pipeline.cli", *words, "--json"]
    said, times = "", []
    for _ in range(REPEATS + 1):
        began = perf_counter()
        said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=LIMIT_S, cwd=ROOT).stdout
        times.append(perf_counter() - began)
    return json.loads(said)["cables"]["markers"], median(times[1:])


def _by_numpy(path: Path) -> Iterator[tuple[float, float]]:
    """alpha [deg] and e_P [mm] of each reliable frame by numpy's SVD, frame by frame: none of the analysis' code."""
    with open_log(path) as log:
        frames = from_log(log, "markers")
    for position, valid in zip(frames.position, frames.valid, strict=True):
        points = position[valid]
        if len(points) >= max(LEAST_MARKERS, LEAST_POINTS):
            _, singular, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
            yield np.degrees(np.arcsin(abs(axes[2, 2]))), 1e3 * singular[2] / np.sqrt(len(points))


def _error(said: dict[str, Any], reference: np.ndarray) -> float:
    """Largest relative difference of mean, maximum, median and deviation; the reference is (frames, 2)."""
    found = []
    for column, name in zip(reference.T, ("alpha_deg", "e_plane_mm"), strict=True):
        rows = {"mean": column.mean(), "max": column.max(), "median": np.median(column), "std": column.std()}
        found += [abs(said[name][row] / value - 1.0) for row, value in rows.items()]
    return max(found)


def rows() -> list[Row]:
    """Both commands on ten minutes of the chain's markers at 50 Hz."""
    with tempfile.TemporaryDirectory() as folder:
        path, page = Path(folder) / "chain.mcap", Path(folder) / "page.html"
        _recorded(path)
        reference = np.array(list(_by_numpy(path)))
        table: list[Row] = []
        for words in (["validity", str(path)], ["report", str(path), "--out", str(page), "--overwrite"]):
            said, seconds = _timed(words)
            table.append(
                {
                    "case": f"10 minutes, {said['frames']} frames",
                    "method": f"towline {words[0]}",
                    "error": _error(said, reference),
                    "error_unit": "largest of the statistics of alpha and e_P, relative",
                    "seconds": seconds,
                    "real_time_factor": 600.0 / seconds,
                    "reference": "numpy's SVD, frame by frame",
                }
            )
    return table
