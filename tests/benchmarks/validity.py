"""Frames a second of the catenary fit, fast and as published, beside the error of C and of the residual."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

from pipeline.analysis.indicators import Fits, fit_frames
from pipeline.analysis.markers import MarkerFrames, from_log, marker_frames
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
REPEATS = 5
SYNTHETIC = 20_000
SEARCHED = 500  # synthetic frames for the published method, which takes milliseconds each; of the scenes it has all
WORSE = 1.001  # residual over the other method's
SIGMA = 5e-4  # m, of a marker's coordinates

Row = dict[str, str | float]


def _synthetic(sigma: float) -> tuple[MarkerFrames, np.ndarray]:
    """Chains of 12 markers, 245 mm apart, at random inclination, tension and heading; and C (k,) of each."""
    random = np.random.default_rng(0)
    C, slope = random.uniform(0.3, 2.0, SYNTHETIC), random.uniform(-1.0, 1.0, SYNTHETIC)
    alpha, psi = random.uniform(0.0, 1.0, SYNTHETIC), random.uniform(-np.pi, np.pi, SYNTHETIC)
    arc = 0.245 * np.arange(12)
    X = np.arcsinh(C[:, None] * (arc - arc.mean()) + slope[:, None])
    x, z = X / C[:, None], np.cosh(X) / C[:, None]
    aside, up = np.sin(alpha)[:, None] * z, np.cos(alpha)[:, None] * z
    cosine, sine = np.cos(psi)[:, None], np.sin(psi)[:, None]
    position = np.stack([cosine * x - sine * aside, sine * x + cosine * aside, -up], axis=2)
    position += sigma * random.standard_normal(position.shape)
    return marker_frames(np.arange(SYNTHETIC), position, arc=arc), C


def _simulated(name: str) -> MarkerFrames:
    """The markers of a scenario's run."""
    scenario = load_scenario(SCENARIOS / f"{name}.yaml")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        run_scenario(scenario, build_graph(scenario), path, Options(scene=False), lambda _: None)
        with open_log(path) as log:
            return from_log(log, "markers")


def _some(frames: MarkerFrames) -> MarkerFrames:
    """SEARCHED frames spread over the record."""
    rows = np.linspace(0, len(frames.t_ns) - 1, SEARCHED).astype(int)
    return replace(frames, t_ns=frames.t_ns[rows], position=frames.position[rows], valid=frames.valid[rows])


def _timed(frames: MarkerFrames, method: str, repeats: int) -> tuple[Fits, float]:
    """The fits and frames a second of processor time (one core), best of several."""
    fits, best = fit_frames(_few(frames), method), np.inf
    for _ in range(repeats):
        began = process_time()
        fits = fit_frames(frames, method)
        best = min(best, process_time() - began)
    return fits, len(frames.t_ns) / best


def _few(frames: MarkerFrames) -> MarkerFrames:
    """Enough frames to compile for."""
    return replace(frames, t_ns=frames.t_ns[:5], position=frames.position[:5], valid=frames.valid[:5])


def _row(case: str, method: str, error: float, unit: str, frames_per_s: float, reference: str) -> Row:
    return {
        "case": case,
        "method": method,
        "error": error,
        "error_unit": unit,
        "frames_per_s": frames_per_s,
        "us": 1e6 / frames_per_s,
        "reference": reference,
    }


def rows() -> list[Row]:
    """Synthetic chains against their C; the pool scenes' markers, where the two methods check each other."""
    table = []
    for case, sigma in (("12 markers, no noise", 0.0), ("12 markers, noise 0.5 mm", SIGMA)):
        frames, C = _synthetic(sigma)
        some = _some(frames)
        for method, timed, repeats in (("fast", frames, REPEATS), ("nelder-mead", some, 1)):
            _, speed = _timed(timed, method, repeats)
            error = np.abs(fit_frames(some, method).C / C[some.t_ns] - 1.0)
            unit = f"largest of {SEARCHED} errors of C / C"
            table.append(_row(case, method, float(error.max()), unit, speed, "the true C"))
    return table + [row for name in ("pool_chain", "pool_rope") for row in _scene(name)]


def _scene(name: str) -> list[Row]:
    """Both methods on all frames of a scene; the published one takes a minute or two."""
    frames = _simulated(name)
    fast, speed = _timed(frames, "fast", REPEATS)
    published, searched = _timed(frames, "nelder-mead", 1)
    table = []
    both = fast.fitted & published.fitted
    ratio = fast.e_catenary[both] / published.e_catenary[both]
    for method, worse, rate in (("fast", ratio, speed), ("nelder-mead", 1.0 / ratio, searched)):
        unit = f"frames of {both.sum()} with e_C over {100 * (WORSE - 1):g} % worse than the other method's"
        table.append(_row(f"{name}, all frames", method, float((worse > WORSE).sum()), unit, rate, "the other method"))
    return table
