"""Two boats abeam, without their rope and with it: formation, force and swept area from the logs of the scenes."""

from __future__ import annotations

import json
from math import pi
from pathlib import Path

import numpy as np
import pytest

from pipeline.analysis.coverage.drag import Drag
from pipeline.analysis.coverage.steady import tow_at
from pipeline.cli import main
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
BOATS = ("port", "starboard")


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """The scenes' logs, run as a user does."""
    folder = tmp_path_factory.mktemp("boom")
    for name in ("boom_formation", "boom_sensors", "boom_sweep"):
        assert main(["run", str(SCENARIOS / f"{name}.yaml"), "--out", str(folder / f"{name}.mcap"), "--json"]) == 0
    return folder


def seen(path):
    """Times, separation by the true positions, and port's progress: (k,) each; the boats are able to do it."""
    with open_log(path) as log:
        port, starboard = (log.port(f"{side}_boat", "low.position") for side in BOATS)
        limited = sum(log.port(f"{side}_controller", "limited").mean() for side in BOATS)
        held = sum(log.port(f"{side}_controller", "held").sum() for side in BOATS)
        validity = max(log.port(f"{side}_boat", "validity.range").max() for side in BOATS)
        progress = log.port("port_controller", "progress")
        t = log.times("port_boat") * 1e-9
    assert limited < 0.04  # of both boats' steps, in changes of speed
    assert held == 0.0
    assert validity < 1.0
    return t, np.hypot(*(port - starboard).T), progress


@pytest.mark.parametrize(("name", "most"), [("boom_formation", 0.03), ("boom_sensors", 0.05)])
def test_separation_is_kept_through_turns_current_and_pull(logs, name, most):
    """8 m from 30 to 140 s, in which lie the pull's end, a turn to each side and a faster pace; then 6 m.

    By true positions; by sensors their slow error of 0.1 m each adds 0.14 m, 2 % of the separation.
    """
    t, separation, progress = seen(logs / f"{name}.mcap")
    assert np.abs(separation[(t > 30) & (t < 140)] / 8.0 - 1.0).max() < most
    assert np.abs(separation[(t > 165) & (t < 200)] / 6.0 - 1.0).max() < most
    assert (progress[t == 70.0] - progress[t == 40.0]) / 30.0 == pytest.approx(0.8, abs=0.03)
    assert (progress[t == 200.0] - progress[t == 170.0]) / 30.0 == pytest.approx(1.0, abs=0.03)


def test_swept_area_is_separation_times_way(logs, capsys):
    """The straight line between the boats, also in turns, as the one outside goes further (Pappus): 1 %."""
    path = logs / "boom_formation.mcap"
    _, separation, progress = seen(path)
    expected = np.trapezoid(separation, np.maximum.accumulate(progress))
    capsys.readouterr()
    ends = [f"{side}_boat.low.position" for side in BOATS]
    assert main(["coverage", str(path), "--between", *ends, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["swept_m2"] == pytest.approx(expected, rel=0.01)
    assert found["separation_m"] == pytest.approx(separation.mean(), rel=1e-9)


def test_one_boat_whose_propellers_stop_is_waited_for(tmp_path):
    """Port's stop at 40 s, in pull and current: starboard, soon 4 m ahead, is asked for no more speed."""
    text = (SCENARIOS / "boom_formation.yaml").read_text().partition("events:")[0]
    text += "events:\n  - {at: 40 s, set: {port_thrusters.failure: [1, 1]}}\n"
    scenario = load_scenario_text(text, "stop.yaml", SCENARIOS, duration="80 s")
    run_scenario(scenario, build_graph(scenario), tmp_path / "stop.mcap", Options(), lambda _: None)
    with open_log(tmp_path / "stop.mcap") as log:
        asked, gap = (log.port("starboard_controller", name) for name in ("reference.speed", "error.along"))
        t = log.times("starboard_controller") * 1e-9
    assert np.abs(gap[t < 40.0]).max() < 0.1
    assert asked[t == 40.0] > 0.7
    assert asked[t > 60.0].max() < 0.1
    assert gap[t > 60.0].min() > 4.0


def test_rope_pulls_as_the_steady_line_of_theory(logs):
    """Segments and boats that found their own balance, before and after the turn, against the integrated steady tow.

    At the rope's own separation and the boats' speed: 40 segments are within 1e-3 of the shape, 3e-3 of force.
    """
    with open_log(logs / "boom_sweep.mcap") as log:
        nodes, force = log.port("boom", "nodes"), log.port("boom", "force_a")
        speed = log.port("port_boat", "low.velocity")
        assert log.port("boom", "converged").min() == 1.0
        t = log.times("boom") * 1e-9
    drag = Drag("", 2, pi * 0.0115 / 1.2)
    for at in (50.0, 195.0):
        k = int(np.argmax(t == at))
        expected = tow_at(drag, float(np.linalg.norm(nodes[k, -1] - nodes[k, 0])) / 18.288)
        pressure = 0.5 * 1000.0 * 1.2 * 0.01905 * (speed[k] ** 2).sum() * 18.288
        assert np.linalg.norm(force[k]) == pytest.approx(pressure * expected.force, rel=0.003)
        assert abs(np.arctan2(abs(force[k, 0]), abs(force[k, 1])) - expected.angle) < 0.005


def test_sweep_keeps_its_width_and_takes_its_half_of_a_patch(logs, capsys):
    """12 m within 1.5 % out, about and back; the rope sweeps what its mouth does, and of the patch the inner half."""
    path = logs / "boom_sweep.mcap"
    with open_log(path) as log:
        port, starboard = (log.port(f"{side}_boat", "low.position") for side in BOATS)
        t = log.times("port_boat") * 1e-9
    separation = np.hypot(*(port - starboard).T)[(t > 20.0) & (t < 210.0)]
    assert np.abs(separation / 12.0 - 1.0).max() < 0.015
    capsys.readouterr()
    corners = ["20,2", "40,2", "40,10", "20,10"]
    assert main(["coverage", str(path), "--patch", *corners, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["swept_m2"] == pytest.approx(found["swept_by_mouth_m2"], rel=0.01)
    assert found["captured"] == pytest.approx((6.0 - 2.0) / 8.0, abs=0.01)
    assert 20.0 < found["first_s"] < found["last_s"] < 80.0
