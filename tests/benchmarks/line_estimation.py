"""Three estimators of a riser's tension: consistency on truth of their own models, error on a simulated riser, speed.

100 seeded runs each; `inside` is the share of times at which their average lies in its pointwise 95 % chi-square band.
The simulated risers are those of the scenario riser_tank, seen by its camera: a chain of 82 bars, and the elastic cable
of tether.cable.
"""

from __future__ import annotations

import ctypes
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from filterpy.kalman import KalmanFilter

from components.estimator.best.model import Best
from components.estimator.corrected.model import Corrected
from components.estimator.modal import corrected, joints
from pipeline.estimation.consistency import autocorrelation, inside
from pipeline.estimation.own_truth import Campaign, Twin, campaign
from pipeline.estimation.record import record_of
from pipeline.estimation.smoothing import smooth
from pipeline.estimation.stepping import BEST, CORRECTED, Stepper
from pipeline.log.reader import Log, open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
H, RUNS, STEPS, MANY, LAGS, REPEATS = 0.036, 100, 200, 1_000_000, 10, 200
LINE = {"length": 1.0, "bars": 5, "mass_per_length": 0.338, "weight": 0.98, "spacing": 0.2, "normal_friction": 1.0}
# Stiff enough that angles driven by random walks stay small, as the linear model has them.
LINEAR = LINE | {
    "flexural_rigidity": 0.05, "clamp": True, "gamma": 0.85, "marker_noise": 1e-3, "interval": H, "force_noise": 0.01,
    "start_angle": 0.05, "start_rate": 0.1, "start_force": 0.01, "angles": (-0.02, -0.05, -0.08, -0.1, -0.13),
}  # fmt: skip
CHAIN = LINE | {
    "flexural_rigidity": 1.3e-5, "drag_diameter": 0.0123, "fluid_density": 1000.0, "marker_noise": 2e-3,
    "end_force": (1.5, -0.9), "end_force_spread": 0.3, "end_force_time": 2.0, "moment_noise": 3e-3,
    "angles": tuple(np.linspace(-0.1, -0.6, 5)), "start_angle": 0.1, "start_rate": 0.3,
}  # fmt: skip
END, SETTLED_S, PIECES, LENGTH = 4.6, 3.0, 82, 8.19  # where the camera's metre ends; the fairlead's ramp is over
CABLE = """
    model: tether.cable
    parameters:
      length: 8.190 m
      segments: 82
      mass_per_length: 0.219 kg/m
      volume_per_length: 1.189e-4 m^2
      axial_stiffness: 5 kN
      damping_time: 10 ms
      drag_diameter: 12.3 mm
      tangential_drag: 0.01
      fluid_density: 998.2067 kg/m^3
      seabed: 4 m
      seabed_stiffness: 300 N/m^2
"""
LINKAGE = """
    model: tether.linkage
    parameters: {file: parameters/riser_line.yaml}
"""
Row = dict[str, str | float]


def _consistency(name: str, found: Campaign) -> Row:
    rho, deviation = autocorrelation(found.innovations, LAGS)
    error = (found.tension - found.true_tension).ravel()
    row: Row = {
        "case": f"{name}, {RUNS} runs of {STEPS} frames, a tenth of the markers missing",
        "method": name.split(" ")[0],
        "nis_inside": inside(found.nis, found.freedom),
        "nees_inside": inside(found.nees, found.states),
        "nis_mean": float(found.nis.sum() / found.freedom.sum()),
        "nees_mean": float(found.nees.mean() / found.states),
        "rho_largest": float(np.abs(rho).max()),
        "rho_deviation": deviation,
        "reference": "chi-square; white noise over 10 lags",
    }
    if np.isfinite(error).all():
        mean = float(found.true_tension.mean())
        row |= {"error_mean": float(error.mean()), "error": float(np.sqrt((error**2).mean())), "error_unit": "N, rms"}
        row["error_percent"] = 100.0 * float(row["error"]) / mean
    return row


def _simulated(text: str, name: str, folder: Path) -> list[Row]:
    """From images to tension."""
    assert LINKAGE in text
    path = folder / f"{name}.mcap"
    changed = text.replace(LINKAGE, CABLE) if name == "tether.cable" else text
    scenario = load_scenario_text(changed, "riser_tank.yaml", SCENARIOS)
    run_scenario(scenario, build_graph(scenario), path, Options(scene=False), lambda _: None)
    log = open_log(path)
    t, true = log.times("best") * 1e-9, _true_tension(log)
    late = t > SETTLED_S
    table = []
    for method in ("published", "corrected", "best"):
        nis = (log.port(method, "nis") / np.maximum(log.port(method, "freedom"), 1.0))[late].mean()
        estimate, spread = log.port(method, "end_tension"), log.port(method, "deviation.end_tension")
        table.append(_tension(name, method, estimate[late], true[late]) | {"nis_mean": float(nis)})
        table[-1]["deviation"] = float(np.median(spread[late]))
    smoothed = smooth(record_of(log, "best")).states
    force = np.hypot(smoothed[:, 10], smoothed[:, 11])
    return [*table, _tension(name, "best, smoothed", force[late], true[late])]


def _true_tension(log: Log) -> np.ndarray:
    """Where the camera's metre ends, at the estimators' frames."""
    middles = (np.arange(PIECES) + 0.5) * LENGTH / PIECES
    tension = np.array([np.interp(END, middles, row) for row in log.port("riser", "tension")])
    return np.interp(log.times("best") * 1e-9, log.times("riser") * 1e-9, tension)


def _tension(name: str, method: str, estimate: np.ndarray, true: np.ndarray) -> Row:
    error, mean = estimate - true, float(true.mean())
    rms = float(np.sqrt((error**2).mean()))
    return {
        "case": f"riser_tank, truth by {name}, tension {mean:.2f} N in the mean",
        "method": method,
        "error_mean": float(error.mean()),
        "error": rms,
        "error_unit": "N, rms",
        "error_percent": 100.0 * rms / mean,
        "reference": name,
    }


def _call_of(filter_: Stepper) -> tuple[Callable[..., int], list[ctypes.c_void_p]]:
    """The compiled step, and its vectors."""
    vectors = (filter_.p, filter_.u, filter_.x, filter_.y, filter_.w)
    return filter_._step._bound[1], [ctypes.c_void_p(v.ctypes.data) for v in vectors]


def _microseconds(filter_: Stepper, u: np.ndarray) -> float:
    """The least of many means over 50 steps of the compiled function: what other load leaves."""
    filter_.step(u)
    call, vectors = _call_of(filter_)
    least = np.inf
    for _ in range(REPEATS):
        began = time.perf_counter()
        for _ in range(50):
            call(0, filter_.h_ns, *vectors)
        least = min(least, (time.perf_counter() - began) / 50)
    return 1e6 * least


def _filterpy(line: Corrected) -> float:
    """The same 15 states and five angles in filterpy: microseconds a step."""
    model = corrected(line, line.force_noise**2, H)
    oracle = KalmanFilter(dim_x=15, dim_z=5)
    oracle.H = np.zeros((5, 15))
    oracle.H[:, :10:2] = joints(5) @ model.modes
    oracle.F, oracle.Q, oracle.R = model.transition, model.noise @ model.noise.T, 5e-5 * np.eye(5)
    least, z = np.inf, np.zeros(5)
    for _ in range(REPEATS):
        began = time.perf_counter()
        for _ in range(20):
            oracle.predict()
            oracle.update(z)
        least = min(least, (time.perf_counter() - began) / 20)
    return 1e6 * least


def _speeds() -> list[Row]:
    load = f"load {os.getloadavg()[0]:.1f}"
    table: list[Row] = []
    for name, kind, given in (
        ("corrected, 15 states", CORRECTED, Corrected(**LINEAR)),
        ("best, 12 states", BEST, Best(**CHAIN)),
        ("best, 18 states", BEST, Best(**CHAIN, pivot="moving")),
    ):
        twin = Twin(kind, given, H, 0)
        table.append({"case": f"a step, {load}", "method": name, "us": _microseconds(twin.filter, twin.inputs())})
    table.append({"case": f"a step, {load}", "method": "filterpy, 15 states", "us": _filterpy(Corrected(**LINEAR))})
    return table


def _endurance(name: str, twin: Twin) -> Row:
    """The least eigenvalue of the correlation matrix after a million frames."""
    filter_ = twin.filter
    u = []
    for _ in range(50):
        twin.step()
        u.append(filter_.u.copy())
    call, vectors = _call_of(filter_)
    for k in range(MANY):
        filter_.u[:] = u[k % len(u)]
        assert call(0, filter_.h_ns, *vectors) == 0
    P = filter_.root @ filter_.root.T
    scale = np.sqrt(np.diag(P))
    least = float(np.linalg.eigvalsh(P / np.outer(scale, scale))[0])
    asymmetry = float(np.abs(P - P.T).max())
    return {
        "case": f"{MANY} frames, marker noise {twin.line.marker_noise:g} m",
        "method": name,
        "error": asymmetry,
        "error_unit": "asymmetry of P",
        "least_eigenvalue": least,
        "reference": "correlation matrix",
    }


def _published() -> list[Row]:
    """What is printed: 23.9 N, beside the tension at which the printed first shape balances."""
    first = np.array([-0.0183, 0.0276, 0.0085, 0.0262, 0.0633])
    lever = 0.2 * np.array([sum((j - i) * first[j] for j in range(i + 1, 5)) for i in range(4)])
    weight = 0.1001 * 9.80665 * 0.04 * np.array([12.125, 7.7, 4.275, 1.85])
    balanced = float((weight / lever).mean())
    case = "printed: 23.9 N, on a line of 8.04 N in all"
    return [
        {"case": case, "method": "first shape in (13)-(16) at rest", "tension_N": balanced},
        {"case": case, "method": "the same, p_s without g", "tension_N": balanced / 9.80665},
        {"case": case, "method": "static estimate printed", "tension_N": 0.5},
    ]


def rows() -> list[Row]:
    """Consistency, tension, the printed figures, speed, endurance."""
    table: list[Row] = []
    for name, component, given in (
        ("corrected on linear truth", CORRECTED, Corrected(**LINEAR)),
        ("best on nonlinear truth", BEST, Best(**CHAIN)),
        ("best with a moving pivot, on its truth", BEST, Best(**CHAIN, pivot="moving")),
    ):
        table.append(_consistency(name, campaign(component, given, H, RUNS, STEPS, 0.1)))
    text = (SCENARIOS / "riser_tank.yaml").read_text()
    with tempfile.TemporaryDirectory() as folder:
        for truth in ("tether.linkage", "tether.cable"):
            table += _simulated(text, truth, Path(folder))
    table += _published() + _speeds()
    tiny = {"marker_noise": 1e-6}
    table.append(_endurance("corrected", Twin(CORRECTED, Corrected(**{**LINEAR, **tiny}), H, 1)))
    table.append(_endurance("best", Twin(BEST, Best(**{**CHAIN, **tiny}), H, 1)))
    return table
