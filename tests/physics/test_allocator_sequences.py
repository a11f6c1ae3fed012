"""Sequences of demands to the allocator of least power: its limits hold in every step, for vessels drawn at random."""

from __future__ import annotations

import importlib.util
import sys
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from components.allocator.thrusters import Thruster, contains

PATH = Path(__file__).parents[1] / "benchmarks" / "allocation.py"
SPEC = importlib.util.spec_from_file_location("benchmark_allocation_sequences", PATH)
bench = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = bench
SPEC.loader.exec_module(bench)

STEP = 0.5
PROPELLER = Thruster(
    kind="rudder",
    x=-35.0,
    y=0.0,
    max_thrust=400e3,
    max_power=4e6,
    reverse_thrust=200e3,
    rudder_angle=radians(25.0),
    thrust_rate=40e3,
)
BOW = Thruster(kind="tunnel", x=30.0, y=0.0, max_thrust=100e3, max_power=1e6)


def any_thruster(random):
    """Of any kind, with rates; half of those that turn have a forbidden zone."""
    thrust = 10.0 ** random.uniform(4.5, 6.0)
    size = {"x": random.uniform(-60, 60), "y": random.uniform(-15, 15), "max_thrust": thrust, "max_power": 8 * thrust}
    size["thrust_rate"] = thrust * random.uniform(0.01, 0.3)
    kind = random.choice(["azimuth", "azimuth", "azimuth", "tunnel", "fixed", "rudder"])
    if kind == "fixed":
        return Thruster(kind=kind, direction=random.uniform(-3, 3), reverse_thrust=0.6 * thrust, **size)
    if kind == "rudder":
        return Thruster(kind=kind, rudder_angle=random.uniform(0.1, 0.7), reverse_thrust=0.5 * thrust, **size)
    if kind == "tunnel":
        return Thruster(kind=kind, **size)
    start, width = random.uniform(-3, 3), random.uniform(0.1, 2.5)
    zones = ((start, start + width),) if random.uniform() < 0.5 else ()
    return Thruster(kind=kind, azimuth_rate=random.uniform(0.02, 0.5), forbidden=zones, **size)


@pytest.mark.parametrize("seed", range(3))
def test_all_limits_hold_in_every_step_of_a_rough_sequence(seed):
    """Demands and spare powers that jump, noise on top; limits to 1e-9 of all thrusters, as the issue of the exact one
    asks. A thruster in a zone has no thrust; a board beyond its power has thrusters that fall as fast as they may."""
    random = np.random.default_rng(seed)
    for _ in range(8):
        layout = tuple(any_thruster(random) for _ in range(random.integers(2, 7)))
        boards, scale = bench.two_boards(layout, random.uniform(0.2, 1.2)), next(bench.cones(layout))
        allocator = bench.Allocator(STEP, thrusters=layout, switchboards=boards, hysteresis=random.choice([0.0, 0.05]))
        size, demand = scale.force * np.array([1.0, 1.0, scale.lever]), np.zeros(3)
        for _ in range(60):
            if random.uniform() < 0.08:
                demand = random.normal(size=3) * size * random.uniform(0.0, 1.0)
            if random.uniform() < 0.08:
                allocator.u[3:] = [board.spare_power * random.choice([0.0, 0.5, 2.0]) for board in boards]
            before = allocator["thrust"], allocator["azimuth"]
            allocator.step(demand + 0.01 * size * random.normal(size=3))
            _check(allocator, layout, boards, *before, 1e-9 * scale.force)


def _check(allocator, layout, boards, old_thrust, old_azimuth, rounding):
    thrust, azimuth = allocator["thrust"], allocator["azimuth"]
    assert np.isfinite(allocator.y).all()
    for i, t in enumerate(layout):
        change = t.thrust_rate * STEP + rounding
        assert -t.backwards - rounding <= thrust[i] <= t.max_thrust + rounding
        assert abs(thrust[i]) - abs(old_thrust[i]) <= change
        if t.kind != "azimuth" or t.azimuth_rate * STEP < 0.5 * pi:
            assert abs(thrust[i] - old_thrust[i]) <= change
        if t.kind == "azimuth":
            assert abs(azimuth[i] - old_azimuth[i]) <= t.azimuth_rate * STEP * (1.0 + 1e-9)
            inside = any(contains((a + 1e-6, b - 1e-6), azimuth[i]) for a, b in t.forbidden)
            assert not inside or thrust[i] <= rounding
    for b, board in enumerate(boards):
        if allocator["board.power"][b] > allocator.u[3 + b] * (1.0 + 1e-9):
            assert allocator["limit.board"][b] == 1.0
            for i in board.thrusters:
                falling = max(abs(old_thrust[i]) - layout[i].thrust_rate * STEP, 0.0)
                assert abs(thrust[i]) <= falling + rounding


def test_a_propeller_with_a_rudder_goes_astern_and_ahead_again_by_its_rate():
    """Astern is negative thrust, rudder midships, as thrusters.propulsion takes it; 20 kN a step through zero."""
    allocator = bench.Allocator(STEP, thrusters=(PROPELLER, BOW))
    allocator.call(allocator._init, (200e3, 20e3, 0.0))
    seen = []
    for demand in [(-150e3, 0.0, 0.0)] * 30 + [(200e3, 20e3, 0.0)] * 30:
        before = allocator["thrust"][0]
        allocator.step(demand)
        thrust = allocator["thrust"][0]
        assert abs(thrust - before) <= 20e3 * (1.0 + 1e-9)
        assert abs(allocator["azimuth"][0]) <= (radians(25.0) if thrust >= 0.0 else 0.0) + 1e-9
        assert allocator["power"][0] == pytest.approx(4e6 * (abs(thrust) / (400e3 if thrust > 0.0 else 200e3)) ** 1.5)
        seen.append((thrust, allocator["met"]))
    assert seen[29] == (pytest.approx(-150e3), 1.0)
    assert seen[59][1] == 1.0


def test_continuous_demands_give_continuous_commands_with_boards_at_their_limits():
    """One turn of a demand that two boards limit on its way, without zones: half the step, half the largest change."""
    layout = bench.open_water(bench.LAYOUTS["semi-submersible"])
    largest, limited = {}, 0
    for count in (400, 800):
        allocator = bench.Allocator(thrusters=layout, switchboards=bench.two_boards(layout, 0.3))
        forces, changes = [], []
        for k in range(count):
            angle = 2.0 * pi * k / count
            allocator.step((1.9e6 * np.cos(angle), 1.2e6 * np.sin(angle), 2e7 * np.sin(2.0 * angle)))
            forces.append(allocator.forces)
            limited += allocator["limit.board"].any()
        changes = abs(np.diff(forces, axis=0)).max(axis=(1, 2))
        largest[count] = changes.max()
    assert limited > 100
    assert largest[400] < 0.1 * 496e3
    assert largest[800] < 0.6 * largest[400]


@pytest.mark.parametrize("much", [1e20, 1e100, 1e300])
def test_any_demand_that_is_a_number_gets_the_best_in_its_direction(much):
    """Beyond 1e12 times all thrusters only the direction counts; 1e9 times is as good as that."""
    layout = bench.LAYOUTS["semi-submersible"]
    beyond, far = bench.Allocator(thrusters=layout), bench.Allocator(thrusters=layout)
    beyond.step((much, -much, much))
    far.step((1e16, -1e16, 1e16))
    assert beyond["thrust"] == pytest.approx(far["thrust"], abs=1.0)
    assert beyond["achieved.force"] == pytest.approx(far["achieved.force"], rel=1e-5)


def test_the_fewest_nodes_still_give_a_command_within_all_limits():
    """most_nodes of 1: the first choice of sides found, flagged as not proven."""
    layout = bench.LAYOUTS["semi-submersible"]
    allocator = bench.Allocator(thrusters=layout, most_nodes=1)
    unproven = 0
    for demand in bench.demands(layout, 100, seed=9):
        allocator.step(demand)
        unproven += allocator["proven"] == 0.0
        assert np.isfinite(allocator.y).all()
        assert allocator["nodes"] <= len(layout) + 2
        assert np.all(allocator["thrust"] <= 496e3 * (1.0 + 1e-9))
        for thruster, azimuth, thrust in zip(layout, allocator["azimuth"], allocator["thrust"], strict=True):
            inside = any(contains((a + 1e-9, b - 1e-9), azimuth) for a, b in thruster.forbidden)
            assert not inside or thrust == 0.0
    assert unproven > 10
