"""The allocator of least power against Clarabel's conic solver, exhaustive search and its own stated limits."""

from __future__ import annotations

import importlib.util
import sys
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from components.allocator.exact.convex_pieces import pieces
from components.allocator.thrusters import Thruster, allowed, contains

PATH = Path(__file__).parents[1] / "benchmarks" / "allocation.py"
SPEC = importlib.util.spec_from_file_location("benchmark_allocation", PATH)
bench = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = bench
SPEC.loader.exec_module(bench)

WEIGHTS = (1.0, 1.0, 10.0)


def scales(layout):
    return next(bench.cones(layout))


def achieved(allocator, layout):
    """(3,) of the commands themselves, and the sum of their parts' sizes per axis."""
    f = allocator.forces
    x, y = np.array([t.x for t in layout]), np.array([t.y for t in layout])
    total = np.array([f[:, 0].sum(), f[:, 1].sum(), (x * f[:, 1] - y * f[:, 0]).sum()])
    parts = np.array([abs(f[:, 0]).sum(), abs(f[:, 1]).sum(), (abs(x * f[:, 1]) + abs(y * f[:, 0])).sum()])
    return total, parts


def overload(allocator, layout):
    """By what part a thruster is above its largest thrust, 0 or less if none is."""
    most = np.array([t.max_thrust * t.loss_factor for t in layout])
    back = np.array([t.backwards * t.loss_factor for t in layout])
    thrust = allocator["thrust"]
    return max((thrust / most).max() - 1.0, (-thrust[thrust < 0] / back[thrust < 0]).max(initial=1.0) - 1.0)


def weighted(miss, scale):
    return np.linalg.norm(np.array(WEIGHTS) * miss / (scale.force * np.array([1.0, 1.0, scale.lever])))


@pytest.mark.parametrize("name", bench.LAYOUTS)
def test_power_and_miss_are_those_of_the_conic_optimum(name):
    """1000 demands. Clarabel's own gap is 1e-11 of all thrusters' power: what a small demand is compared to."""
    layout = bench.open_water(bench.LAYOUTS[name])
    allocator, scale = bench.Allocator(thrusters=layout), scales(layout)
    met = 0
    for demand in bench.demands(layout, 1000):
        allocator.step(demand)
        total, _ = achieved(allocator, layout)
        assert overload(allocator, layout) <= 1e-9
        least, _ = scale.least_power(demand)
        if allocator["met"] == 1.0:
            met += 1
            assert least is not None
            power = allocator["power"].sum()
            assert power <= least * (1.0 + 1e-6) + 1e-10 * scale.power
            assert np.all(abs(total - demand) <= 1e-12 * scale.force * np.array([1.0, 1.0, scale.lever]))
        else:
            assert weighted(total - demand, scale) <= scale.least_miss(demand, WEIGHTS) + 1e-6
    assert 300 < met < 1000  # both kinds of demand are there


@pytest.mark.parametrize("name", bench.LAYOUTS)
def test_zones_give_the_best_of_all_choices_of_sides(name):
    """100 demands, each against Clarabel on every choice of convex pieces; 3 where these are 4096."""
    layout = bench.LAYOUTS[name]
    allocator, problems = bench.Allocator(thrusters=layout), list(bench.cones(layout))
    scale = problems[0]
    for demand in bench.demands(layout, 100 if len(problems) < 20 else 3, seed=11):
        allocator.step(demand)
        total, _ = achieved(allocator, layout)
        assert overload(allocator, layout) <= 1e-9
        assert allocator["proven"] == 1.0
        for thruster, azimuth, thrust in zip(layout, allocator["azimuth"], allocator["thrust"], strict=True):
            inside = [contains((a + 1e-9, b - 1e-9), azimuth) for a, b in thruster.forbidden]
            assert thrust == 0.0 or not any(inside)
        found = [value for problem in problems if (value := problem.least_power(demand)[0]) is not None]
        if allocator["met"] == 1.0:
            assert allocator["power"].sum() <= min(found) * (1.0 + 1e-6) + 1e-10 * scale.power
        else:
            assert not found
            least = min(problem.least_miss(demand, WEIGHTS) for problem in problems)
            assert weighted(total - demand, scale) <= least + 1e-6


@pytest.mark.parametrize("name", bench.LAYOUTS)
def test_balance_of_demands_well_within_the_thrusters(name):
    """|B f - tau| <= 1e-14 |B| |f| per row, of the forces before they are turned into thrusts and azimuths."""
    layout = tuple(
        t.model_copy(update={"max_thrust": 1e3 * t.max_thrust}) for t in bench.open_water(bench.LAYOUTS[name])
    )
    allocator = bench.Allocator(thrusters=layout)
    for demand in bench.demands(bench.LAYOUTS[name], 1000, seed=3):
        allocator.step(demand)
        assert allocator["met"] == 1.0
        _, parts = achieved(allocator, layout)
        given = np.array([*allocator["achieved.force"], allocator["achieved.moment"]])
        assert np.all(abs(given - demand) <= 1e-14 * parts)


def azimuth(x, y, **more):
    return Thruster(kind="azimuth", x=x, y=y, max_thrust=100e3, max_power=1e6, **more)


SQUARE = tuple((x, y) for x in (-20.0, 20.0) for y in (-8.0, 8.0))


def square(**more):
    return tuple(azimuth(x, y, **more) for x, y in SQUARE)


def test_no_demand_gives_no_thrust_and_no_nan():
    allocator = bench.Allocator(thrusters=square())
    allocator.step((1e5, 0.0, 0.0))
    before = allocator["azimuth"]
    allocator.step((0.0, 0.0, 0.0))
    assert np.all(allocator["thrust"] == 0.0)
    assert np.all(allocator["azimuth"] == before)
    assert allocator["met"] == 1.0


def test_a_thousand_times_too_much_is_what_the_thrusters_can_in_that_direction():
    """All thrusters ahead, by symmetry."""
    allocator = bench.Allocator(thrusters=square())
    allocator.step((4e8, 0.0, 0.0))
    assert allocator["thrust"] == pytest.approx([100e3] * 4)
    assert allocator["azimuth"] == pytest.approx([0.0] * 4, abs=1e-6)
    assert allocator["met"] == 0.0
    assert np.all(allocator["limit.thrust"] == 1.0)


@pytest.mark.parametrize(
    "layout",
    [
        square(forbidden=((0.0, 2 * pi),)),
        tuple(azimuth(5.0, 3.0) for _ in range(3)),
        tuple(Thruster(kind="tunnel", x=x, y=0.0, max_thrust=1e5, max_power=1e6) for x in (10.0, 20.0)),
        (Thruster(kind="fixed", x=-30.0, y=0.0, max_thrust=1e5, max_power=1e6),),
        (azimuth(0.0, 0.0),),
    ],
    ids=["all zones closed", "one place", "across only", "ahead only", "one at the origin"],
)
def test_layouts_that_cannot_give_all_give_the_least_miss(layout):
    allocator, problem = bench.Allocator(thrusters=layout), scales(layout)
    for demand in [(0.0, 0.0, 0.0), *bench.demands(layout, 40, seed=5), (-1e5, 0.0, 0.0), (0.0, 0.0, 1e7)]:
        demand = np.array(demand)
        allocator.step(demand)
        total, _ = achieved(allocator, layout)
        assert np.isfinite(allocator.y).all()
        assert weighted(total - demand, problem) <= problem.least_miss(demand, WEIGHTS) + 1e-6


def test_failed_thrusters_give_nothing_and_others_take_over():
    allocator = bench.Allocator(thrusters=square(), available=(1, 0, 1, 1))
    allocator.step((1.5e5, 5e4, 2e5))
    assert allocator["thrust"][1] == 0.0
    assert allocator["met"] == 1.0
    everything = bench.Allocator(thrusters=square(), available=(0, 0, 0, 0))
    everything.step((1.5e5, 5e4, 2e5))
    assert np.all(everything["thrust"] == 0.0)
    assert everything["met"] == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("axis", range(3))
def test_a_demand_that_is_no_number_holds_the_last_command(bad, axis):
    allocator = bench.Allocator(thrusters=square())
    allocator.step((1e5, 3e4, 1e5))
    before = {name: allocator[name] for name in ("thrust", "azimuth", "achieved.force", "achieved.moment")}
    demand = [1e5, 3e4, 1e5]
    demand[axis] = bad
    allocator.step(demand)
    assert allocator["held"] == 1.0
    for name, value in before.items():
        assert np.array_equal(allocator[name], value)
    allocator.step((1e5, 3e4, 1e5))
    assert allocator["held"] == 0.0


def test_azimuths_follow_a_turning_demand_through_astern_without_a_jump():
    """Two turns: each azimuth goes on through 180 degrees to 720, a hundredth of a turn or so at a time."""
    allocator = bench.Allocator(thrusters=square())
    allocator.call(allocator._init, (2e5, 0.0, 1e5))
    before, start = allocator["azimuth"], allocator["azimuth"]
    for k in range(1, 401):
        angle = 4.0 * pi * k / 400
        allocator.step((2e5 * np.cos(angle), 2e5 * np.sin(angle), 1e5))
        assert np.all(abs(allocator["azimuth"] - before) < 0.1)
        before = allocator["azimuth"]
    assert before - start == pytest.approx(4.0 * pi, abs=1e-9)


def test_azimuths_jump_only_across_a_forbidden_zone():
    """Where azimuths jump, at least one thruster goes from one edge of its zone to the other; the others make room."""
    layout = bench.LAYOUTS["semi-submersible"]
    allocator = bench.Allocator(thrusters=layout, hysteresis=0.01)
    before, jumps = None, 0
    for k in range(2000):
        angle = 2.0 * pi * k / 2000
        allocator.step((9e5 * np.cos(angle), 9e5 * np.sin(angle), 4e6))
        now = allocator["azimuth"]
        jumping = () if before is None else np.flatnonzero(abs(now - before) > 0.1)
        if len(jumping):
            jumps += 1
            assert any(crosses(layout[i], before[i], now[i]) for i in jumping)
        before = now
    assert 0 < jumps < 40


def crosses(thruster, before, now):
    """Whether both azimuths are within 0.02 rad of edges of one forbidden zone, and not of the same edge."""
    for zone in thruster.forbidden:
        near = [[abs((a - edge + pi) % (2 * pi) - pi) < 0.02 for edge in zone] for a in (before, now)]
        if (near[0][0] and near[1][1]) or (near[0][1] and near[1][0]):
            return True
    return False


def test_rates_are_kept_and_the_optimum_is_reached():
    """A demand that swings by 90 degrees: each step within the rates; after the time of the turn the free optimum."""
    rates = {"azimuth_rate": radians(10.0), "thrust_rate": 20e3}
    slow, free = bench.Allocator(thrusters=square(**rates)), bench.Allocator(thrusters=square())
    slow.call(slow._init, (2e5, 0.0, 3e5))
    for _ in range(300):
        thrust, angle = slow["thrust"], slow["azimuth"]
        slow.step((0.0, 2e5, 3e5))
        assert np.all(abs(slow["thrust"] - thrust) <= 2e3 * (1 + 1e-9) + 1e-3)
        assert np.all(abs(slow["azimuth"] - angle) <= radians(1.0) * (1 + 1e-9))
    free.step((0.0, 2e5, 3e5))
    assert slow["met"] == 1.0
    assert slow["power"].sum() == pytest.approx(free["power"].sum(), rel=1e-6)
    assert np.all(slow["limit.rate"] == 0.0)


def test_a_thruster_turns_through_its_zone_without_thrust():
    zone = (radians(60.0), radians(100.0))
    layout = square(forbidden=(zone,), azimuth_rate=radians(10.0), thrust_rate=20e3)
    allocator, free = bench.Allocator(thrusters=layout), bench.Allocator(thrusters=square(forbidden=(zone,)))
    allocator.call(allocator._init, (2e5, 0.0, 0.0))
    for _ in range(600):
        allocator.step((-1.5e5, 1.2e5, 0.0))
        inside = [contains((zone[0] + 1e-6, zone[1] - 1e-6), a) for a in allocator["azimuth"]]
        assert np.all(allocator["thrust"][inside] == 0.0)
    free.step((-1.5e5, 1.2e5, 0.0))
    assert allocator["met"] == 1.0
    assert allocator["power"].sum() == pytest.approx(free["power"].sum(), rel=1e-6)


def test_hysteresis_keeps_a_side_until_the_other_saves_more():
    """Zones ahead and a demand ahead: power is alike on both sides of them, and noise would make thrusters hop."""
    zone = (radians(-30.0), radians(30.0))
    layout = (*square(forbidden=(zone,)),)
    random = np.random.default_rng(2)
    hops = {}
    for hysteresis in (0.0, 0.05):
        allocator = bench.Allocator(thrusters=layout, hysteresis=hysteresis)
        sides = []
        for _ in range(300):
            allocator.step((1e5, 2e3 * random.normal(), 1e4 * random.normal()))
            sides.append(np.sign(np.sin(allocator["azimuth"])))
        hops[hysteresis] = int((np.diff(sides, axis=0) != 0).any(axis=1).sum())
    assert hops[0.0] > 50
    assert hops[0.05] < 5


def test_thrust_factors_by_sector_are_the_optimum_of_that_problem():
    """Against every choice of pieces: half thrust in a sector towards the neighbour, a zone beside it."""
    more = {
        "forbidden": ((radians(80.0), radians(110.0)),),
        "factors": (
            {"sector": (radians(-30.0), radians(30.0)), "factor": 0.5},
            {"sector": (radians(110.0), radians(170.0)), "factor": 0.8},
        ),
    }
    layout = (azimuth(-20.0, -8.0, **more), azimuth(-20.0, 8.0, **more), azimuth(20.0, 0.0))
    allocator, problems = bench.Allocator(thrusters=layout), list(bench.cones(layout))
    for demand in bench.demands(layout, 60, seed=8):
        allocator.step(demand)
        found = [value for problem in problems if (value := problem.least_power(demand)[0]) is not None]
        if allocator["met"] == 1.0:
            assert allocator["power"].sum() <= min(found) * (1 + 1e-6) + 1e-10 * problems[0].power
        else:
            assert not found


def test_a_rudder_deflects_the_force_ahead_only():
    propeller = Thruster(
        kind="rudder", x=-35.0, y=0.0, max_thrust=400e3, max_power=4e6, reverse_thrust=200e3, rudder_angle=radians(25.0)
    )
    bow = Thruster(kind="tunnel", x=30.0, y=0.0, max_thrust=100e3, max_power=1e6)
    allocator = bench.Allocator(thrusters=(propeller, bow))
    allocator.step((2e5, 1e5, -5e5))
    assert allocator["met"] == 1.0
    assert 0.0 < abs(allocator["azimuth"][0]) <= radians(25.0) + 1e-9
    allocator.step((-1e5, 0.0, 0.0))
    assert allocator["met"] == 1.0
    assert allocator["achieved.force"] == pytest.approx([-1e5, 0.0], abs=1e-6)


def test_allowed_arcs_join_across_north():
    thruster = azimuth(0.0, 0.0, forbidden=((radians(80.0), radians(100.0)),))
    ((start, end), factor), *others = allowed(thruster)
    assert not others
    assert factor == 1.0
    assert np.degrees(end - start) == pytest.approx(340.0)
    assert len(pieces(thruster)) == 2


def test_what_does_not_fit_is_refused_by_name():
    with pytest.raises(ValueError, match="forbidden, factors and azimuth_rate are an azimuth thruster's"):
        Thruster(kind="tunnel", x=0, y=0, max_thrust=1, max_power=1, forbidden=((0, 1),))
    with pytest.raises(ValueError, match="sectors of `factors` overlap"):
        azimuth(0, 0, factors=({"sector": (0, 1), "factor": 0.5}, {"sector": (0.5, 2), "factor": 0.5}))
    with pytest.raises(ValueError, match="available has 1 values for 4 thrusters"):
        bench.Allocator(thrusters=square(), available=(1,))
