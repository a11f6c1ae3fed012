"""towline capability against Clarabel on every choice of sides, and its messages."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ive, kve

from pipeline.capability.limits import INTACT, capability
from pipeline.capability.ship import read_ship
from pipeline.cli import main

ROOT = Path(__file__).parents[2]
SUPPLY = ROOT / "scenarios" / "capability" / "supply_vessel.yaml"
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


# The supply vessel's coefficients as its parameter files cite them, and the constants of its hull in waves.
AIR, WATER, G = 1.247, 1026.9, 9.80665
LENGTH, BEAM, DRAUGHT, BOW = 76.2, 18.0, 6.25, 0.6


def wind_by_hand(wind, angle):
    """Fossen 2011, eqs. 8.30 to 8.34: wind from starboard pushes to port."""
    q, c, s = 0.5 * AIR * wind**2, np.cos(angle), np.sin(angle)
    along = 0.55 if c > 0 else 0.8
    shape = 1 - 0.5 * 0.55 * (1 - along * 310 / 570 / 0.9) * np.sin(2 * angle) ** 2
    x, y = -q * 310 * along * c / shape, -q * 570 * 0.9 * s / shape
    off = np.arccos(c)
    return np.array([x, y, (8.0 - 0.18 * 82.0 * (off - np.pi / 2)) * y])


def current_by_hand(speed, angle):
    """Linear damping, and Munk's moment of the two added masses."""
    u, v = speed * np.cos(angle), speed * np.sin(angle)
    return -np.array([7.7071e4 * u, 2.5468e5 * v, -6.7258e5 * v + (1.1341e7 - 6.7644e6) * u * v])


def drift_by_hand(height, period, angle):
    """Ursell's reflection with scipy's Bessel functions over the Pierson-Moskowitz spectrum."""
    omega = np.linspace(0.2, 20.0, 40_000) * 2 * np.pi / period
    peak, k = 2 * np.pi / period, omega**2 / G
    spectrum = 5 / 16 * height**2 * peak**4 / omega**5 * np.exp(-1.25 * (peak / omega) ** 4)
    wall = np.pi**2 * ive(1, k * DRAUGHT) ** 2
    kept = wall / (wall + (kve(1, k * DRAUGHT) * np.exp(-2 * k * DRAUGHT)) ** 2)
    push = WATER * G * np.trapezoid(spectrum * kept, omega)
    c, s = np.cos(angle), np.sin(angle)
    return -push * np.array([BEAM * BOW * c * abs(c), LENGTH * s * abs(s), 0.0])


def supply_by_hand(wind, angle, current, current_offset=0.0, sea_offset=0.0):
    height, period = 0.21 * wind**2 / G, 2 * np.pi * wind / (0.877 * G)
    waves = drift_by_hand(height, period, angle + sea_offset) if wind else np.zeros(3)
    return wind_by_hand(wind, angle) + current_by_hand(current, angle + current_offset) + waves


@pytest.fixture(scope="module")
def supply(tmp_path_factory):
    """`supply(weather)`: a file of the supply vessel in other weather."""
    folder = tmp_path_factory.mktemp("supply")

    def make(weather):
        path = folder / "ship.yaml"
        before, _, after = (
            SUPPLY.read_text()
            .replace("../parameters", str(ROOT / "scenarios/parameters"))
            .partition("{current: 0.5 m/s, max_wind: 40 m/s}")
        )
        assert after
        path.write_text(before + weather + after)
        return path

    return make


def test_loads_from_coefficients_are_those_by_hand(supply):
    """0.5 % of the largest: the drift is linear in frequency between the table's, and gamma of the sea is 1.01, not 1.

    Directions are those of the table, between which it is linear too, up to 1.7 % off.
    """
    weather = "{current: 0.5 m/s, max_wind: 30 m/s, current_offset: 40 deg, sea_offset: -30 deg, heading_step: 15 deg}"
    loads = read_ship(supply(weather)).loads
    assert loads.headings == pytest.approx(15.0 * np.arange(24))
    for k in (0, 10, 20, 40, 60):
        angles = np.radians(loads.headings)
        offsets = np.radians([40.0, -30.0])
        expected = np.array([supply_by_hand(loads.speeds[k], angle, 0.5, *offsets) for angle in angles])
        largest = np.abs(expected).max(axis=0)
        assert (np.abs(loads.table[:, k] - expected) / largest).max() < 5e-3


@pytest.mark.parametrize("case", [INTACT, "bow azimuth", "port switchboard"])
def test_limits_from_coefficients_by_hand_and_clarabel(case, supply):
    """Within 0.1 m/s, which the loads' 0.5 % come to at the limits' 10 to 35 m/s."""
    ship = read_ship(supply("{current: 0.5 m/s, max_wind: 35 m/s, heading_step: 45 deg}"))
    found = capability(ship, lambda _: None)
    lost = ship.failures.get(case, frozenset())
    layout = [t for t, name in zip(ship.allocator.thrusters, ship.names, strict=True) if name not in lost]
    pieces = list(bench.cones(tuple(layout)))

    def is_held(wind, angle):
        demand = -supply_by_hand(wind, angle, 0.5)
        return any(piece.least_miss(demand, (1.0, 1.0, 1.0)) < MET for piece in pieces)

    for h, angle in enumerate(np.radians(found.headings)):
        if found.is_more[case][h]:
            assert is_held(35.0, angle)
        else:
            assert is_held(found.winds[case][h] - 0.1, angle)
            assert not is_held(found.winds[case][h] + 0.1, angle)
    assert found.worst[0] == ""  # from ahead no failure loses position in 35 m/s
    assert found.worst[2] == "starboard switchboard"


def test_cross_flow_and_a_table_of_seas(supply, tmp_path):
    """A current across by strips, 1/2 rho C_D T L v^2; seas linear between the winds of their table."""
    path = tmp_path / "ship.yaml"
    path.write_text(
        "vessel: {surge_mass: 6e6 kg, sway_mass: 1.1e7 kg, yaw_inertia: 4e9 kg m^2, max_speed: 3 m/s,\n"
        "  cross_flow: {length: 80 m, draught: 6 m, coefficient: 0.7}, windage: {frontal_area: 310 m^2,\n"
        "  lateral_area: 570 m^2, length: 82 m, cross: 0.9, ahead: 0.55, astern: 0.8, shape: 0.55}}\n"
        "weather: {current: 1.5 m/s, waves: false}\n"
        "thrusters: [{kind: azimuth, x: 0 m, y: 0 m, max_thrust: 900 kN, max_power: 6 MW}]\n"
    )
    loads = read_ship(path).loads
    assert loads.table[9, 0] == pytest.approx([0.0, -0.5 * WATER * 0.7 * 6 * 80 * 1.5**2, 0.0], abs=1e-6)
    weather = (
        "{seas: [{wind: 4 m/s, height: 1 m, period: 6 s}, {wind: 12 m/s, height: 3 m, period: 10 s}], max_wind: 12 m/s}"
    )
    table = read_ship(supply(weather)).loads
    sway = wind_by_hand(8.0, np.pi / 2)[1] + drift_by_hand(2.0, 8.0, np.pi / 2)[1]
    assert table.table[9, 16][1] == pytest.approx(sway, rel=5e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("weather: {current: 0.5 m/s, max_wind: 40 m/s}\n", ""), "weather: missing"),
        (("weather:", "loads: loads.csv\nweather:"), "loads: given beside vessel and weather"),
        (("max_wind: 40 m/s", "heading_step: 7 deg"), "heading_step does not go into 360 deg"),
        (("max_wind: 40 m/s", "seas: [{wind: 9 m/s, height: 2 m, period: 7 s}]"), "max_wind is above 9 m/s"),
        (("current: 0.5 m/s", "current: 4 m/s"), "vessel: a current of 4 m/s is above its max_speed, 3 m/s"),
        (("current: 0.5 m/s", "curent: 1 m/s"), "weather.curent: unknown parameter; did you mean 'current'?"),
        ((", ../parameters/supply_vessel.yaml]", "]\n  max_speed: 3 m/s"), "vessel: hull or responses is missing"),
        (("../parameters/supply_vessel_windage.yaml, ", ""), "vessel: windage is missing: what the wind meets"),
        (("aft tunnel, bow tunnel, bow azimuth]\nfail", "bow azimuth]\nfail"), "names: expected a list of 6 names"),
        (("{file: ../parameters/supply_allocator.yaml}", "{file: nowhere.yaml}"), "thrusters.file: nowhere.yaml"),
        (("supply_allocator.yaml", "supply_controller.yaml"), "thrusters: expected a list of thrusters"),
    ],
)
def test_mistakes_in_coefficients_are_told(change, message, tmp_path, capsys):
    text = SUPPLY.read_text()
    assert change[0] in text
    path = tmp_path / "ship.yaml"
    text = text.replace(*change, 1).replace("../parameters", str(ROOT / "scenarios/parameters"))
    path.write_text(text)
    assert main(["capability", str(path)]) == 1
    assert message in " ".join(capsys.readouterr().err.split())
