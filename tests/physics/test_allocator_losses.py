"""Losses of thrust in the allocator of least power, by the water and by wakes, against thrusters.propulsion."""

from __future__ import annotations

import importlib.util
import sys
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from components.allocator.exact.losses import behind
from components.allocator.thrusters import Thruster
from components.thrusters.propulsion.model import Actuator
from components.thrusters.propulsion.propeller import power_of, speed_for, thrust_of

PATH = Path(__file__).parents[1] / "benchmarks" / "allocation.py"
SPEC = importlib.util.spec_from_file_location("benchmark_allocation_losses", PATH)
bench = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = bench
SPEC.loader.exec_module(bench)

DIAMETER, SPEED, ADVANCE = 3.0, 12.0, 0.9  # of the propeller [m], its shaft [rad/s], J_0
ZERO = ADVANCE * SPEED / (2.0 * pi) * DIAMETER  # J_0 n D [m/s]
WATER = {"meets_water": True, "weights": (1.0, 1.0, 1.0)}


def azimuth(x, y, **more):
    return Thruster(kind="azimuth", x=x, y=y, max_thrust=100e3, max_power=1e6, **more)


def tunnel(x, y, **more):
    return Thruster(kind="tunnel", x=x, y=y, max_thrust=100e3, max_power=1e6, **more)


def settled(demand, water=(0.0, 0.0, 0.0), steps=1500, **parameters):
    """After 150 s of the same demand in the same water."""
    allocator = bench.Allocator(**parameters)
    if allocator.parameters.meets_water:
        allocator.u[-3:] = water
    for _ in range(steps):
        allocator.step(demand)
    return allocator


@pytest.mark.parametrize(
    ("distance", "kept"), [(0.5, 0.1657), (7.0 / 3.0, 0.3972), (4.0, 0.5156), (16.0, 0.8390), (1e3, 1.0)]
)
def test_thrust_in_line_is_that_of_the_published_curve(distance, kept):
    """1 - 0.75^((x / D)^(2/3)), worked out by hand to four digits; 7 m behind 3 m: 0.40, as others print it."""
    assert behind(distance, 0.0) == pytest.approx(kept, abs=6e-5)


def test_a_jet_turned_away_takes_less_and_less():
    kept = [behind(4.0, degrees) for degrees in range(0, 181, 5)]
    assert np.all(np.diff(kept) > 0.0)
    assert behind(4.0, 30.0) == pytest.approx(0.5156 + 0.4844 * 27e3 / (130.0 / 0.5156**3 + 27e3), abs=1e-4)
    assert kept[-1] > 0.999


@pytest.mark.parametrize("speed", [0.0, 0.8, 2.0, -1.5])
@pytest.mark.parametrize("thrust", [10e3, 60e3, -45e3])
def test_what_is_asked_for_in_still_water_gives_the_thrust_in_moving_water(speed, thrust):
    """Against thrusters.propulsion: its shaft, told `still.thrust`, gives the thrust that the allocator counts on."""
    layout = (tunnel(20.0, 0.0, zero_thrust_speed=ZERO), tunnel(-20.0, 0.0, zero_thrust_speed=ZERO))
    allocator = settled((0.0, 2.0 * thrust, 0.0), (0.0, speed, 0.0), 3, thrusters=layout, **WATER)
    assert allocator["met"] == 1.0
    numbers = {"zero_thrust_advance": ADVANCE, "diameter": DIAMETER, "max_speed": SPEED}
    k = np.array(Actuator(kind="tunnel", x=20.0, y=0.0, max_thrust=100e3, max_power=1e6, **numbers).numbers())
    n = speed_for(k, float(allocator["still.thrust"][0]))
    given = thrust_of(k, n, speed) if n > 0.0 else -thrust_of(k, -n, -speed)
    assert allocator["thrust"][0] == pytest.approx(thrust, rel=1e-9)
    assert given == pytest.approx(thrust, rel=1e-9)


def test_largest_thrust_and_power_in_moving_water_are_those_of_the_propeller():
    """Full ahead against water of 1.5 m/s: what thrusters.propulsion gives and draws at its largest speed."""
    layout = tuple(azimuth(x, 0.0, zero_thrust_speed=ZERO) for x in (-20.0, 0.0, 20.0))
    allocator = settled((1e9, 0.0, 0.0), (1.5, 0.0, 0.0), 3, thrusters=layout, **WATER)
    numbers = {"zero_thrust_advance": ADVANCE, "diameter": DIAMETER, "max_speed": SPEED}
    k = np.array(Actuator(kind="fixed", x=0.0, y=0.0, max_thrust=100e3, max_power=1e6, **numbers).numbers())
    assert allocator["thrust"] == pytest.approx([thrust_of(k, SPEED, 1.5)] * 3, rel=1e-9)
    assert allocator["power"] == pytest.approx([power_of(k, SPEED, 1.5)] * 3, rel=1e-9)
    assert allocator["still.thrust"] == pytest.approx([100e3] * 3, rel=1e-9)
    assert np.all(allocator["limit.thrust"] == 1.0)


def test_a_turning_hull_meets_the_water_at_each_thruster():
    """Yaw of 0.05 rad/s: at x = 40 m the water comes at 2 m/s across, which takes from a thrust to starboard there."""
    layout = (tunnel(40.0, 0.0, zero_thrust_speed=ZERO), tunnel(-40.0, 0.0, zero_thrust_speed=ZERO))
    allocator = settled((0.0, 1e9, 0.0), (0.0, 0.0, 0.05), 3, thrusters=layout, **WATER)
    assert allocator["thrust"] == pytest.approx([100e3 * (1.0 - 2.0 / ZERO), 100e3], rel=1e-9)


def test_each_step_is_the_optimum_with_the_factors_of_the_last_azimuths():
    """Against the allocator without losses, whose thrusters are told the factors worked out here from the last step."""
    layout = tuple(
        azimuth(x, y, zero_thrust_speed=7.0, wake_diameter=2.5) for x, y in ((-30.0, -6.0), (-20.0, 6.0), (25.0, 0.0))
    )
    boards = ({"thrusters": (0, 1), "spare_power": 0.9e6}, {"thrusters": (2,), "spare_power": 0.8e6})
    given = {**WATER, "switchboards": boards, "wake_time": 1e-6}
    allocator, water = bench.Allocator(thrusters=layout, **given), np.array([1.0, 0.6, 0.01])
    allocator.u[-3:] = water
    for demand in bench.demands(layout, 40, seed=6):
        azimuths, running = allocator["azimuth"], allocator["thrust"] > 1e-3
        told = tuple(_told(layout, i, azimuths, running, water) for i in range(3))
        plain = bench.Allocator(thrusters=told, weights=(1.0, 1.0, 1.0), switchboards=boards)
        plain.step(demand)
        allocator.step(demand)
        assert allocator["met"] == plain["met"]
        assert allocator["power"].sum() == pytest.approx(plain["power"].sum(), rel=1e-6)
        assert allocator["achieved.force"] == pytest.approx(plain["achieved.force"], rel=1e-6, abs=1.0)


def _told(layout, i, azimuths, running, water):
    """Thruster i with the losses in its figures: thrust and power in moving water, thrust in the wakes."""
    here, factor = layout[i], 1.0
    for j, other in enumerate(layout):
        if j != i and running[j]:
            way = np.array([here.x - other.x, here.y - other.y])
            jet = -np.array([np.cos(azimuths[j]), np.sin(azimuths[j])])
            degrees = np.degrees(np.arccos(np.clip(jet @ way / np.linalg.norm(way), -1.0, 1.0)))
            factor *= behind(np.linalg.norm(way) / 2.5, degrees)
    past = (water[0] - here.y * water[2]) * np.cos(azimuths[i]) + (water[1] + here.x * water[2]) * np.sin(azimuths[i])
    part = max(past, 0.0) / 7.0
    figures = {
        "loss_factor": factor * (1.0 - part),
        "max_power": 1e6 * (1.0 - part / 1.15),
        "zero_thrust_speed": None,
        "wake_diameter": None,
    }
    return here.model_copy(update=figures)


def test_thrust_moves_from_a_wake_to_the_thruster_that_makes_it():
    """Ahead, one 10 m behind the other: of equal thrusters the one in the jet is the dearer. Across, they share."""
    layout = (azimuth(5.0, 0.0, wake_diameter=3.0), azimuth(-5.0, 0.0, wake_diameter=3.0))
    in_line = settled((80e3, 0.0, 0.0), thrusters=layout)
    across = settled((0.0, 80e3, 0.0), thrusters=layout)
    assert in_line["met"] == across["met"] == 1.0
    kept = behind(10.0 / 3.0, 0.0) / behind(10.0 / 3.0, 180.0)
    ratio = in_line["thrust"][1] / in_line["thrust"][0]
    assert ratio == pytest.approx(kept**3, rel=1e-5)  # least of sum a T^(3/2) with a ~ t^(-3/2); wakes grown for 150 s
    assert across["thrust"] == pytest.approx([40e3, 40e3], rel=1e-3)


def test_thrusters_do_not_chase_each_others_wakes():
    """The same demand for 60 s: commands come to rest, where without the time of a wake 3 of 60 went to and fro."""
    layout = tuple(t.model_copy(update={"wake_diameter": 3.5}) for t in bench.LAYOUTS["semi-submersible"])
    for demand in 0.6 * bench.demands(layout, 12, seed=3):
        allocator = settled(demand, steps=600, thrusters=layout)
        before = allocator.forces
        allocator.step(demand)
        assert abs(allocator.forces - before).max() <= 1e-4 * 496e3


def test_rates_of_thrust_are_the_shafts_not_the_waters():
    """A current that comes and goes within a step changes the thrust at once, that of the shaft by its rate at most."""
    rates = {"azimuth_rate": radians(10.0), "thrust_rate": 20e3}
    layout = tuple(azimuth(x, y, zero_thrust_speed=7.0, **rates) for x in (-20.0, 20.0) for y in (-8.0, 8.0))
    allocator = bench.Allocator(thrusters=layout, **WATER)
    random, kept = np.random.default_rng(1), np.ones(4)
    for k in range(200):
        allocator.u[-3:] = (random.choice([0.0, 2.0]), 0.0, 0.0) if k % 10 == 0 else allocator.u[-3:]
        shaft, azimuths = allocator["thrust"] / kept, allocator["azimuth"]
        allocator.step((250e3 * np.sin(0.05 * k), 60e3, 2e5))
        kept = 1.0 - np.maximum(allocator.u[-3] * np.cos(azimuths), 0.0) / 7.0
        assert np.all(abs(allocator["thrust"] / kept - shaft) <= 2e3 * (1.0 + 1e-6) + 1e-3)
        assert np.all(allocator["thrust"] <= 100e3 * kept * (1.0 + 1e-9))


def test_water_that_is_no_number_holds_the_last_command():
    layout = (azimuth(0.0, 0.0, zero_thrust_speed=7.0),)
    allocator = settled((80e3, 0.0, 0.0), (1.0, 0.0, 0.0), 3, thrusters=layout, **WATER)
    before = allocator.y[:-4].copy()
    allocator.u[-2] = np.nan
    allocator.step((50e3, 0.0, 0.0))
    assert allocator["held"] == 1.0
    assert np.array_equal(allocator.y[:-4], before)


def test_without_losses_there_is_nothing_of_them():
    """No input, no output, the same numbers."""
    layout = bench.LAYOUTS["mixed sizes"]
    plain, idle = bench.Allocator(thrusters=layout), bench.Allocator(thrusters=layout, meets_water=True)
    idle.u[-3:] = 1.0, 1.0, 0.1
    with pytest.raises(KeyError):
        plain["still.thrust"]
    for demand in bench.demands(layout, 20, seed=1):
        plain.step(demand)
        idle.step(demand)
        assert np.array_equal(plain.y, idle.y)
