"""Any line of a log against the catenary through its ends, and what loads it when that fails; by hand and on scenes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pipeline.analysis.line_loads import cause, loads
from pipeline.analysis.line_properties import Properties, Water, properties
from pipeline.analysis.line_record import LineRecord
from pipeline.analysis.line_validity import judge_line
from pipeline.analysis.scenario_entries import Entries
from pipeline.cli import main

WEIGHT, MASS, ADDED, K = 2.0, 0.5, 0.3, 8.0
SPEED, ACCELERATION = 0.4, 1.5
FRAMES, NODES = 5, 11


def line(**changes) -> Properties:
    values = {
        "length": 20.0,
        "load": np.array([0.0, 0.0, WEIGHT]),
        "dry_weight": 9.0,
        "mass": MASS,
        "added": ADDED,
        "square": (K, 0.0),
        "linear": (0.0, 0.0),
        "flexibility": 0.0,
        "seabed": np.inf,
        "rough": False,
        "held": (True, True),
        "water": Water(np.zeros(1), np.zeros((1, 3))),
        "beyond": (),
        "notes": (),
    }
    return Properties(**values | changes)


def upright(**changes) -> LineRecord:
    """A vertical line of 20 m at rest."""
    nodes = np.zeros((FRAMES, NODES, 3))
    nodes[:, :, 2] = np.linspace(0.0, 20.0, NODES)
    values = {
        "name": "line",
        "t_ns": np.arange(FRAMES) * 10**8,
        "nodes": nodes,
        "velocity": np.zeros_like(nodes),
        "acceleration": np.zeros_like(nodes),
        "force_a": None,
        "force_b": None,
        "length": None,
        "whole": np.ones(FRAMES, bool),
    }
    return LineRecord(**values | changes)


def everywhere(vector) -> np.ndarray:
    return np.broadcast_to(np.array(vector, float), (FRAMES, NODES, 3))


@pytest.mark.parametrize(
    ("record", "water", "expected"),
    [
        (upright(velocity=everywhere([SPEED, 0, 0])), None, (0.0, K * SPEED**2 / WEIGHT, 0.0)),
        (upright(velocity=everywhere([0, 0, SPEED])), None, (0.0, 0.0, 0.0)),
        (upright(acceleration=everywhere([0, ACCELERATION, 0])), None, ((MASS + ADDED) * ACCELERATION / WEIGHT, 0, 0)),
        (upright(acceleration=everywhere([0, 0, ACCELERATION])), None, (MASS * ACCELERATION / WEIGHT, 0.0, 0.0)),
        (upright(), [[0, SPEED, 0]], (0.0, 0.0, K * SPEED**2 / WEIGHT)),
        (upright(current=np.full((FRAMES, 1, 3), [0, SPEED, 0])), None, (0.0, 0.0, K * SPEED**2 / WEIGHT)),
    ],
)
def test_loads_over_the_weight(record, water, expected):
    """k v^2, (m + m_a) a across and m a along, over the weight: exact but for rounding."""
    still = Water(np.zeros(1), np.zeros((1, 3)) if water is None else np.array(water))
    found = loads(record, line(water=still))
    for values, value in zip(found.over_weight().values(), expected, strict=True):
        assert values == pytest.approx(value, rel=1e-12, abs=1e-15)


def test_sheared_current_loads_unevenly():
    """u = s z over 20 m: k u^2 has the mean k s^2 z^2 over nodes; its differences from that, over all mean load."""
    sheared = Water(np.array([0.0, 20.0]), np.array([[0, 0, 0], [SPEED, 0, 0]], float))
    found = loads(upright(), line(water=sheared))
    drag = K * (SPEED * np.linspace(0.0, 1.0, NODES)) ** 2
    mean = np.hypot(WEIGHT, drag.mean())
    assert found.current == pytest.approx(np.sqrt((drag**2).mean()) / WEIGHT, rel=1e-12)
    assert found.uneven["current"] == pytest.approx(drag.std() / mean, rel=1e-12)
    assert found.uneven["motion"] == pytest.approx(0.0, abs=1e-15)


def test_speeds_and_accelerations_that_equal_the_weight():
    assert line().speed == pytest.approx(np.sqrt(WEIGHT / K))
    assert line(square=(0.0, 0.0), linear=(4.0, 0.0)).speed == pytest.approx(WEIGHT / 4.0)
    mixed = line(linear=(4.0, 0.0)).speed
    assert K * mixed**2 + 4.0 * mixed == pytest.approx(WEIGHT, rel=1e-12)
    assert line().acceleration == pytest.approx(WEIGHT / (MASS + ADDED))


def test_cause_is_the_largest_that_matters():
    ratios = {"acceleration": np.array([0.3, 9.0]), "motion": np.array([0.2, np.nan]), "current": np.zeros(2)}
    assert cause(ratios, np.array([True, False]), 0.08)[0] == "acceleration"
    assert cause({"motion": np.array([0.05])}, np.array([True]), 0.08) == ("", {"motion": 0.05})


def test_what_cannot_be_judged_says_why():
    free = judge_line(upright(), line(held=(True, False)), None, 0.1)
    assert all(match.verdict == "not known" for match in free.matches.values())
    assert "an end is free" in free.matches["weight"].missing
    afloat = judge_line(upright(), line(load=np.zeros(3)), None, 0.1)
    assert "no weight in water" in afloat.matches["weight"].missing
    assert "forces at its ends are not recorded" in afloat.matches["mean_load"].missing


def test_sections_and_events_are_told():
    sections = [{"length": "5.0 m", "segments": 5}, {"length": "15.0 m", "segments": 5, "mass_per_length": "2.0 kg/m"}]
    given = {
        "length": "20.0 m",
        "mass_per_length": "1.0 kg/m",
        "volume_per_length": "0.0 m^2",
        "gravity": "10.0 m/s^2",
        "sections": sections,
        "current_input": True,
    }
    wired = {"tether": {"model": "tether.cable", "parameters": given, "inputs": {"current": {"sum": []}}}}
    found = properties(Entries("scene", wired, frozenset({"tether.cut", "drum.speed"})), "tether")
    assert found is not None
    assert found.load[2] == pytest.approx(17.5)
    assert found.beyond == ("parts of other properties",)
    assert found.notes == (
        "its current comes by a wire that is no plain one: not counted",
        "events set tether.cut: its parameters are taken as they were at the start",
    )


HUNG = """
hook: {model: motion.fixed, parameters: {position: [0 m, 0 m, 1 m]}}
far: {model: motion.fixed, parameters: {position: [12 m, 5 m, 4 m]}}
level: {model: motion.fixed, parameters: {position: [13 m, 5 m, 9 m]}}
leaning:
  model: tether.catenary
  parameters: {length: 16 m, load: [0.4 N/m, 0.3 N/m, 0.9 N/m], axial_stiffness: 2 kN}
  inputs: {end_a: hook.motion, end_b: far.motion}
lying:
  model: tether.catenary
  parameters: {length: 20 m, weight: 3 N/m, seabed: 9 m}
  inputs: {end_a: hook.motion, end_b: level.motion}
slack:
  model: tether.catenary
  parameters: {length: 16 m, weight: 2 N/m}
  inputs: {end_a: hook.motion, end_b: far.motion}
"""


def test_static_lines_of_a_log_hold(run, capsys):
    """tether.catenary is a catenary: shape within what polylines of 20 parts leave of the arc's shares, 0.2 % of it;
    tensions to rounding, in a leaning load, on a bed and hanging."""
    log = run(HUNG, until="0.1 s")
    capsys.readouterr()
    assert main(["validity", str(log.path), "--json"]) == 0
    cables = json.loads(capsys.readouterr().out)["cables"]
    assert set(cables) == {"leaning", "lying", "slack"}
    for name, cable in cables.items():
        judged = cable["line"]["through_ends"]
        matches = [judged["weight"], *([] if name == "lying" else [judged["mean_load"]])]
        for match in matches:
            assert match["verdict"] == "holds"
            assert match["e_tension_percent"]["max"] < 1e-8
            assert match["e_shape_mm"]["max"] < 0.002 * 1e3 * cable["length_m"]
    assert "seabed" in cables["lying"]["line"]["through_ends"]["mean_load"]["missing"]
