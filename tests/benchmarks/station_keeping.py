"""Dynamic positioning against wind: how far from station, with what wear and power, and whether the filter fits.

A supply vessel in the fully grown sea of each wind with two observers, and the semi-submersible in wind alone. After
300 s to settle in, 1500 s are judged; true motion without the waves' part, so that errors of the observer count.
"""

from __future__ import annotations

import tempfile
from math import pi
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from components.constants import GRAVITY
from pipeline.log.reader import Log, open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
# Of each wind [m/s] the vessel's own motion in that sea, which a filter is to be told: metres and radians per metre of
# significant height, from logs of the vessel; and its damping ratio, less where long waves move the vessel in a
# narrower band (fitted by NIS: with 0.07 it is 0.77 of what it should be at 14 m/s, 0.61 at 17).
SUPPLY_WINDS = {5.0: (0.0043, 7e-4, 0.07), 8.0: (0.028, 1.7e-3, 0.07), 11.0: (0.059, 2.2e-3, 0.07),
                14.0: (0.096, 2.4e-3, 0.045), 17.0: (0.123, 2.2e-3, 0.033)}  # fmt: skip
SEMI_WINDS = (10.0, 20.0, 30.0, 40.0, 50.0)
SETTLED_S, DURATION = 300.0, "1800 s"
Row = dict[str, str | float]


def fully_grown(wind: float) -> tuple[float, float]:
    """Significant height [m] and peak period [s] of a fully grown sea, wind in m/s (Pierson and Moskowitz 1964)."""
    return 0.21 * wind**2 / GRAVITY, 2.0 * pi * wind / (0.877 * GRAVITY)


def supply_vessel(wind: float, observer: str) -> Log:
    """The vessel of sensor_dropout.yaml without its faults."""
    height, period = fully_grown(wind)
    text = (SCENARIOS / "sensor_dropout.yaml").read_text().partition("events:")[0]
    settings = [f"wind.speed={wind}", f"sea.height={height}", f"sea.period={period}", f"observer.wave_period={period}"]
    if observer == "passive":
        text = text.replace("observer.kalman", "observer.passive").replace(", parameters/supply_observer.yaml]", "]")
    else:
        shift, turn, damping = SUPPLY_WINDS[wind]
        settings += [f"observer.wave_motion={shift * height}", f"observer.wave_turn={turn * height}",
                     f"observer.wave_damping={damping}"]  # fmt: skip
    return _run(text, "sensor_dropout.yaml", settings)


def semi_submersible(wind: float) -> Log:
    """The unit of semisub_dp.yaml in wind that does not grow; its filter's gusts are as the wind's pressure."""
    gusts = 1e5 * (wind / 30.0) ** 2
    settings = [f"wind.speed={wind}", "wind.rise=0"]
    settings += [f"observer.disturbance_force={gusts}", f"observer.disturbance_moment={30.0 * gusts}"]
    return _run((SCENARIOS / "semisub_dp.yaml").read_text(), "semisub_dp.yaml", settings)


def _run(text: str, name: str, settings: list[str]) -> Log:
    scenario = load_scenario_text(text, name, SCENARIOS, settings, DURATION)
    out = Path(tempfile.mkdtemp()) / "run.mcap"
    run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
    return open_log(out)


def judged(case: str, method: str, log: Log) -> Row:
    """Root mean squares about the station, wear, power, and the filter's NIS."""
    late = log.times("vessel") >= SETTLED_S * 1e9
    place, heading = log.port("vessel", "low.position")[late], log.port("vessel", "low.heading")[late]
    target = log.port("controller", "reference.heading")[-1]
    allocated = log.times("allocator") >= SETTLED_S * 1e9
    thrust, azimuth = log.port("allocator", "thrust")[allocated], log.port("allocator", "azimuth")[allocated]
    minutes = (log.times("allocator")[-1] * 1e-9 - SETTLED_S) / 60.0
    row: Row = {
        "case": case,
        "method": method,
        "error": float(np.sqrt((place**2).sum(axis=1).mean())),
        "error_unit": "m, rms off station",
        "heading_deg": float(np.degrees(np.sqrt(((heading - target) ** 2).mean()))),
        "power_kW": float(log.port("thrusters", "power")[late].sum(axis=1).mean() * 1e-3),
        "turns_deg_min": float(np.degrees(np.abs(np.diff(azimuth, axis=0)).sum(axis=0).mean() / minutes)),
        "changes_kN_min": float(np.abs(np.diff(thrust, axis=0)).sum(axis=0).mean() * 1e-3 / minutes),
        "unmet": float(1.0 - log.port("allocator", "met")[allocated].mean()),
    }
    if method == "kalman":
        row |= _consistency(log)
    log.path.unlink()
    log.path.parent.rmdir()
    return row


def _consistency(log: Log) -> Row:
    """NIS of the first reference over its degrees of freedom, and what part of it is within the 95 % bound."""
    late = log.times("observer") >= SETTLED_S * 1e9
    is_used = log.port("observer", "status.references")[late, 0] == 0.0
    nis = log.port("observer", "nis.references")[late, 0][is_used]
    return {"nis": float(nis.mean() / 2.0), "nis_within": float((nis <= chi2.ppf(0.95, 2)).mean())}


def rows() -> list[Row]:
    """Each wind, vessel and observer."""
    table = []
    for wind in SUPPLY_WINDS:
        for observer in ("kalman", "passive"):
            table.append(judged(f"supply vessel, {wind:g} m/s", observer, supply_vessel(wind, observer)))
    table += [judged(f"semi-submersible, {wind:g} m/s", "kalman", semi_submersible(wind)) for wind in SEMI_WINDS]
    return [{**row, "reference": "the simulated vessel's own motion, without the waves' part"} for row in table]
