"""towline capability against Clarabel on every choice of sides, and its messages."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from pipeline.capability.limits import INTACT, capability
from pipeline.capability.ship import read_ship
from pipeline.cli import main

ROOT = Path(__file__).parents[2]
SHIP = ROOT / "scenarios" / "capability" / "dp_tool_ship.yaml"
SPEC = importlib.util.spec_from_file_location("benchmark_allocation", ROOT / "tests" / "benchmarks" / "allocation.py")
bench = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = bench
SPEC.loader.exec_module(bench)

MARGIN = 1e-5  # m/s of wind about a limit, where the load changes by 1e-3 of all thrust per m/s or more
MET = 1e-9  # of all thrust: a miss that Clarabel, whose tolerance is 1e-11, may have where there is none


@pytest.fixture(scope="module")
def ship():
    return read_ship(SHIP)


@pytest.fixture(scope="module")
def found(ship):
    return capability(ship, lambda _: None)


def load(ship, heading, wind):
    table = ship.loads.table[heading]
    return np.array([np.interp(wind, ship.loads.speeds, table[:, axis]) for axis in range(3)])


def holds(ship, lost, heading, wind):
    """By Clarabel, whether any choice of sides meets the load."""
    layout = [t for t, name in zip(ship.allocator.thrusters, ship.names, strict=True) if name not in lost]
    demand = -load(ship, heading, wind)
    return any(problem.least_miss(demand, (1.0, 1.0, 1.0)) < MET for problem in bench.cones(tuple(layout)))


@pytest.mark.parametrize("case", [INTACT, "Th1", "Th3"])
def test_limits_are_where_the_conic_problem_becomes_infeasible(case, ship, found):
    lost = set() if case == INTACT else {case}
    for heading in range(0, 36, 3):
        wind = found.winds[case][heading]
        if wind == 0.0:
            assert not holds(ship, lost, heading, ship.loads.speeds[0])
            continue
        assert not found.is_more[case][heading]
        assert holds(ship, lost, heading, wind - MARGIN)
        assert not holds(ship, lost, heading, wind + MARGIN)
        assert all(holds(ship, lost, heading, speed) for speed in ship.loads.speeds[ship.loads.speeds < wind])


def test_symmetry_of_ship_and_loads_is_in_the_rose(found):
    """The loads mirror about the bow to their three decimals, and so do thrusters and zones: Th1 for Th2."""
    mirror = -np.arange(36) % 36
    assert found.winds[INTACT] == pytest.approx(found.winds[INTACT][mirror], abs=5e-3)
    assert found.winds["Th1"][:5] == pytest.approx(found.winds["Th2"][mirror][:5], abs=5e-3)


def test_json_and_picture(tmp_path, capsys):
    out = tmp_path / "rose.svg"
    assert main(["capability", str(SHIP), "--json", "-o", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["heading_deg"] == [10.0 * i for i in range(36)]
    assert set(told["limiting_wind_m_s"]) == {"intact", "Th1", "Th2", "Th3", "Th4", "Th5"}
    assert all(
        np.less_equal(winds, told["limiting_wind_m_s"]["intact"]).all() for winds in told["limiting_wind_m_s"].values()
    )
    assert "intact" in out.read_text()
    assert main(["capability", str(SHIP), "-o", str(out)]) == 1
    assert "exists; give another name" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("thrust: 694.428", "thrusts: 694.428"), "thrusters[0].thrusts: unknown parameter"),
        (("power: 4500.0", "power: -4500.0"), "thrusters[0].max_power: -4500000 W is out of range"),
        (("name: Th2", "name: Th1"), "'Th1' is another thruster's name"),
        (("loads: dp_tool_loads.csv", "loads: nowhere.csv"), "nowhere.csv: cannot be read"),
        (("loads: dp_tool_loads.csv", "load: dp_tool_loads.csv"), "load: unknown key; did you mean 'loads'?"),
        (("thrusters:", "failures: {bus: [Th9]}\nthrusters:"), "'Th9' is no thruster"),
        (("thrusters:", "switchboards: {A: 5 MW}\nthrusters:"), "switchboards: expected a list of {thrusters: [Th1]"),
        (
            ("thrusters:", "switchboards: [{thrusters: [Th1, Th9], spare_power: 5 MW}]\nthrusters:"),
            "switchboards[0].thrusters: 'Th9' is no thruster; did you mean",
        ),
    ],
)
def test_mistakes_are_told_with_place_and_remedy(change, message, tmp_path, capsys):
    text = SHIP.read_text()
    assert change[0] in text
    (tmp_path / "dp_tool_loads.csv").write_bytes((SHIP.parent / "dp_tool_loads.csv").read_bytes())
    path = tmp_path / "ship.yaml"
    path.write_text(text.replace(*change, 1))
    assert main(["capability", str(path)]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("1.5,10.0,-4.877", "1.5,10.0,lots"), ":3: surge_kN is 'lots'; expected a number"),
        (("1.5,10.0,", "1.5,11.0,"), "no load at"),
        (("sway_kN", "sideways"), "no column sway_N or sway_kN or sway_MN"),
    ],
)
def test_a_table_that_is_not_whole_is_refused(change, message, tmp_path, capsys):
    text = (SHIP.parent / "dp_tool_loads.csv").read_text()
    assert change[0] in text
    (tmp_path / "dp_tool_loads.csv").write_text(text.replace(*change, 1))
    path = tmp_path / "ship.yaml"
    path.write_bytes(SHIP.read_bytes())
    assert main(["capability", str(path)]) == 1
    assert message in capsys.readouterr().err


def test_failures_of_groups_and_units_of_our_own(tmp_path):
    (tmp_path / "loads.csv").write_text("wind_speed_m_s,heading_deg,surge_N,sway_N,yaw_Nm\n0,0,0,0,0\n10,0,-3e5,0,0\n")
    path = tmp_path / "ship.yaml"
    path.write_text(
        "loads: loads.csv\nfailures: {board A: [a, b], board B: [c]}\nthrusters:\n"
        + "".join(
            f"  - {{name: {name}, kind: azimuth, x: {x} m, y: 0 m, max_thrust: 100 kN, max_power: 1 MW}}\n"
            for name, x in (("a", -20), ("b", 0), ("c", 20))
        )
    )
    found = capability(read_ship(path), lambda _: None)
    assert found.winds[INTACT][0] == pytest.approx(10.0)
    assert found.winds["board A"][0] == pytest.approx(10.0 / 3.0)
    assert found.winds["board B"][0] == pytest.approx(20.0 / 3.0)
    assert found.worst == ["board A"]


def test_a_switchboard_limits_the_wind_that_is_held(tmp_path):
    """3 MW for three thrusters of 100 kN ahead hold 300 kN; 1.5 MW hold (1 / 2)^(2/3) of it, spread evenly."""
    (tmp_path / "loads.csv").write_text("wind_speed_m_s,heading_deg,surge_N,sway_N,yaw_Nm\n0,0,0,0,0\n10,0,-3e5,0,0\n")
    path = tmp_path / "ship.yaml"
    path.write_text(
        "loads: loads.csv\nswitchboards: [{thrusters: [c, a, b], spare_power: 1.5 MW}]\nthrusters:\n"
        + "".join(
            f"  - {{name: {name}, kind: azimuth, x: {x} m, y: 0 m, max_thrust: 100 kN, max_power: 1 MW}}\n"
            for name, x in (("a", -20), ("b", 0), ("c", 20))
        )
    )
    found = capability(read_ship(path), lambda _: None)
    assert found.winds[INTACT][0] == pytest.approx(10.0 * 0.5 ** (2.0 / 3.0), rel=1e-6)
    assert found.winds["a"][0] == pytest.approx(10.0 * 2.0 / 3.0 * 0.75 ** (2.0 / 3.0), rel=1e-6)
