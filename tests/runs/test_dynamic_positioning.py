"""The closed loops of dynamic positioning, run whole from their scenarios.

Authority: the simulated vessel's own motion, limits stated in the scenarios, the chi-square distribution.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from components.allocator.thrusters import contains
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
USED, SAME, LOST, FROZEN, WILD = range(5)


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """`logs(name)`: a log of the scenario, run once."""
    kept = {}

    def run(name):
        if name not in kept:
            scenario, out = load_scenario(SCENARIOS / f"{name}.yaml"), tmp_path_factory.mktemp("dp") / f"{name}.mcap"
            run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
            kept[name] = open_log(out), scenario
        return kept[name]

    return run


@pytest.fixture
def altered(tmp_path):
    """`altered(changes, settings, events, duration)`: a log of thruster_failure without its failures, so changed."""

    def run(changes, settings, events, duration):
        text = (SCENARIOS / "thruster_failure.yaml").read_text().partition("events:")[0]
        for old, new in changes.items():
            assert text.count(old) == 1
            text = text.replace(old, new)
        text += "events:" + "".join(f"\n  - {event}" for event in events) + "\n" if events else ""
        scenario = load_scenario_text(text, "altered.yaml", SCENARIOS, settings, duration)
        out = tmp_path / "altered.mcap"
        run_scenario(scenario, build_graph(scenario), out, Options(scene=False, overwrite=True), lambda _: None)
        return open_log(out)

    return run


class Loop:
    """Signals of a log by time [s]."""

    def __init__(self, log):
        self.log = log
        self.t = log.times("vessel") * 1e-9
        self.place, self.heading = log.port("vessel", "low.position"), log.port("vessel", "low.heading")

    def off(self, start=0.0, end=np.inf):
        """Distance of the true vessel from the controller's reference [m]."""
        t, track = self.log.times("controller") * 1e-9, self.log.port("controller", "reference.position")
        reference = np.column_stack([np.interp(self.t, t, column) for column in track.T])
        return np.linalg.norm(self.place - reference, axis=1)[(self.t >= start) & (self.t <= end)]

    def mistaken(self, start=0.0, end=np.inf):
        """Distance of the observer's estimate from the true vessel [m]."""
        estimate = self.log.port("observer", "estimate.position")
        return np.linalg.norm(estimate - self.place, axis=1)[(self.t >= start) & (self.t <= end)]


def test_box(logs):
    """All corners in turn; 2.5 m and 3 degrees from the reference at most, sensors' own slow errors included."""
    log, _ = logs("supply_vessel_box")
    loop = Loop(log)
    legs = log.port("controller", "waypoint")
    assert list(dict.fromkeys(legs)) == [0, 1, 2, 3, 4]
    assert loop.off(60.0).max() < 2.5
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 3.0
    assert log.port("allocator", "met")[600:].mean() > 0.9  # rates leave some of each second's new position unmet
    corner = loop.place[np.argmax(legs == 3) - 1]
    assert corner == pytest.approx([14.64, 54.64], abs=2.0)


def test_filter_fits_the_vessel_in_waves(logs):
    """Mean NIS of 850 positions in the 95 % band of chi-square, though vessel and sea are not the filter's model."""
    log, _ = logs("supply_vessel_box")
    nis = log.port("observer", "nis.references")[:, 0][log.port("observer", "status.references")[:, 0] == USED]
    low, high = chi2.ppf([0.025, 0.975], 2 * len(nis)) / len(nis)
    assert low < nis[50:].mean() < high
    assert 0.92 < (nis[50:] <= chi2.ppf(0.95, 2)).mean() < 0.98


def test_each_sensor_fault_is_outlived(logs):
    """What the observer does with each value, how far it errs meanwhile, and that it is back a minute later."""
    log, _ = logs("sensor_dropout")
    loop = Loop(log)
    gnss, usbl = log.port("observer", "status.references").T
    assert set(gnss[1510:2000]) == {LOST}
    assert loop.mistaken(150.0, 200.0).max() < 1.5  # the hydroacoustics alone
    assert log.port("observer", "dead_reckoning").max() == pytest.approx(62.0, abs=2.1)
    assert loop.mistaken(200.0, 262.0).max() < 6.0  # a minute without any position
    assert set(gnss[3530:4000]) == {SAME, FROZEN}
    assert loop.mistaken(350.0, 400.0).max() < 1.5
    assert set(gnss[4510:4800]) <= {WILD, SAME}
    assert loop.mistaken(450.0, 480.0).max() < 1.5
    assert (log.port("observer", "status.compass")[5501:6000] == LOST).all()
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 2.0
    for over in (320.0, 460.0, 540.0, 660.0, 760.0):
        assert loop.mistaken(over, over + 30.0).max() < 1.2
    assert loop.off(60.0).max() < 6.0
    # 1 % are wild by themselves; without roll and pitch from 650 to 700 s more seem so.
    assert (np.delete(usbl, np.s_[6500:7050]) == WILD).sum() < 10


def test_lost_thruster_and_runaway_are_outlived(logs):
    """The vessel stays within 3 m and 2.5 degrees, and the allocator asks nothing of what it knows to have failed."""
    log, _ = logs("thruster_failure")
    loop = Loop(log)
    assert loop.off(60.0).max() < 3.0
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 2.5
    thrust = log.port("allocator", "thrust")
    assert (thrust[2060:, 5] == 0.0).all()
    assert (thrust[4060:, 0] == 0.0).all()
    assert log.port("thrusters", "thrust")[4040, 0] > 0.6 * 340e3  # on its way to full speed


def test_growing_wind_saturates_without_windup(logs):
    """Held within 3 m up to 45 m/s; beyond saturation the heading is held first, and the integral stays as it is."""
    log, _ = logs("semisub_dp")
    loop = Loop(log)
    met = log.port("allocator", "met")
    assert met[60:1000].all()
    assert not met[1700:].any()
    assert loop.off(300.0, 1170.0).max() < 3.0
    assert loop.off(1700.0).max() > 10.0
    assert np.degrees(np.abs(loop.heading)).max() < 1.5
    integral = log.port("controller", "integral.force")
    assert np.ptp(integral[1700:], axis=0).max() == 0.0
    assert np.abs(integral[-1] - integral[1500]).max() < 0.15 * np.linalg.norm(integral[1500])


def test_recorded_demand_by_four_methods(logs):
    """Figures 4 to 8: without limits all is met and thrusters are asked for too much; exact keeps all limits."""
    log, scenario = logs("semisub_allocation")
    demand = np.column_stack([log.port("demand", "demand.force"), log.port("demand", "demand.moment")])
    given = {name: np.column_stack([log.port(name, "achieved.force"), log.port(name, "achieved.moment")])
             for name in ("quadratic", "newton", "published", "exact")}  # fmt: skip
    size = np.abs(demand).max(axis=0)
    for name in ("quadratic", "newton"):
        assert (np.abs(given[name] - demand) / size).max() < 1e-14
        assert log.port(name, "overload").max() > 1.2
    assert log.port("published", "overload").max() > 1.1
    thrust, azimuth, met = (log.port("exact", name) for name in ("thrust", "azimuth", "met"))
    assert thrust.max() <= 496e3 * (1 + 1e-9)
    thrusters = next(one for one in scenario.instances if one.name == "exact").parameters.thrusters
    for i, thruster in enumerate(thrusters):
        for first, last in thruster.forbidden:
            inside = (first + 1e-9, last - 1e-9)
            assert not any(contains(inside, a) for a in azimuth[thrust[:, i] > 0.0, i])
    assert (np.abs(given["exact"] - demand)[met == 1] / size).max() < 1e-12
    missed = np.abs(given["exact"] - demand)[met == 0] / size
    assert 20 < (met == 0).sum() < 60
    assert missed[:, 2].max() < 0.01 < missed[:, :2].max() < 0.1


ASTERN = {"{depth: 0 m, speed: 0.5 m/s, direction: 150 deg}": "{depth: 0 m, speed: 1 m/s, direction: 30 deg}"}
NO_STREAM = {"{depth: 0 m, speed: 0.5 m/s, direction: 150 deg}], variation: 0.05 m/s": "{depth: 0 m, speed: 0 m/s}]"}


def test_current_from_astern(altered):
    """1 m/s along a heading that the hull does not keep by itself: Munk's moment turns it across."""
    log = altered(ASTERN, ["wind.speed=5"], [], "600 s")
    loop = Loop(log)
    assert log.port("vessel", "water_velocity")[-1, 0] == pytest.approx(-1.0, abs=0.2)
    assert loop.off(60.0).max() < 3.0
    assert loop.off(300.0).max() < 1.5
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 2.0


def test_wind_that_turns_by_90_degrees_at_once(altered):
    """From 10 deg off the bow to 100 deg at 12 m/s, where the limit is 22: fed forward, it hardly moves the vessel."""
    log = altered({}, ["wind.speed=12"], ["{at: 300 s, set: {wind.direction: 130 deg}}"], "600 s")
    loop = Loop(log)
    wind = log.port("vessel", "wind_load.force")[:, 1]
    before, after = wind[2000:3000].mean(), wind[3200:].mean()
    assert abs(after) > 3.0 * abs(before)
    assert loop.off(300.0).max() < 2.5
    assert loop.off(450.0).max() < 1.5
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 2.0


def test_heading_change_through_south(altered):
    """From 30 deg through 180 to -160 by the shorter way, weather from all sides; the compass jumps at 180."""
    log = altered({}, [], ["{at: 150 s, set: {controller.heading: -160 deg}}"], "750 s")
    loop = Loop(log)
    headings = np.degrees(loop.heading)
    assert np.ptp(np.degrees(log.port("gyro", "heading"))) > 300.0
    assert (headings[1500:] > 28.0).all()
    assert headings[-500:] == pytest.approx(np.full(500, 200.0), abs=1.5)
    assert headings.max() < 202.0
    assert loop.off(60.0).max() < 4.0
    assert np.degrees(np.abs(log.port("controller", "error.heading"))).max() < 4.0
    assert np.degrees(np.abs(log.port("observer", "estimate.heading") - loop.heading)).max() < 1.0


def test_nothing_to_do(altered):
    """No wind, sea or current: every number is one, and thrusters idle at less than 1 % of their 9 MW."""
    log = altered(NO_STREAM, ["wind.speed=0", "sea.height=0"], [], "300 s")
    loop = Loop(log)
    assert loop.off(60.0).max() < 0.8
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 0.5
    assert log.port("thrusters", "power")[600:].sum(axis=1).mean() < 90e3
    assert (log.port("controller", "held") == 0.0).all()


def test_compass_lost_in_a_turn(altered):
    """For two minutes from the middle of a turn by 120 deg on: heading by the model alone, then all is as before.

    Nothing else tells the heading; after 270 s the loop is lost, until the compass comes back.
    """
    turn, lost, back = "controller.heading: 150 deg", "gyro.dropped: 1", "gyro.dropped: 0"
    events = [f"{{at: {at} s, set: {{{what}}}}}" for at, what in ((200, turn), (230, lost), (350, back))]
    log = altered({}, [], events, "750 s")
    loop = Loop(log)
    wrong = np.degrees(np.abs(log.port("observer", "estimate.heading") - loop.heading))
    assert (log.port("observer", "status.compass")[2302:3499] == LOST).all()
    assert wrong[2300:3500].max() < 8.0
    assert wrong[3550:].max() < 1.0
    assert loop.off(60.0).max() < 4.0
    assert np.degrees(loop.heading[-1]) == pytest.approx(150.0, abs=1.5)


def test_all_thrusters_lost_and_back(altered):
    """Two minutes adrift, 45 m off: the integral held; a hundred seconds later it is on station."""
    out, well = [0] * 6, [1] * 6
    events = [
        f"{{at: 200 s, set: {{thrusters.failure: {well}, allocator.available: {out}}}}}",
        f"{{at: 320 s, set: {{thrusters.failure: {out}, allocator.available: {well}}}}}",
    ]
    log = altered({}, [], events, "600 s")
    loop = Loop(log)
    integral = log.port("controller", "integral.force")
    assert (log.port("allocator", "thrust")[2001:3200] == 0.0).all()
    assert np.ptp(integral[2005:3195], axis=0).max() == 0.0
    assert 30.0 < loop.off().max() < 60.0
    assert loop.off(420.0).max() < 3.0
    assert loop.off(540.0).max() < 1.5
    assert np.degrees(np.abs(loop.heading - np.radians(30.0))).max() < 7.0


def test_line_that_pulls_is_worked_against(altered):
    """150 kN at the stern from the start: told of it, the controller lets the vessel go half as far or less."""
    pull = "[-120 kN, 90 kN, 0 N]"
    hooked = {
        "      waves: 60\n": "      waves: 60\n      takes_force_a: true\n",
        "sea: sea.waves}": f"sea: sea.waves, force_a: {pull}}}",
    }
    told = {
        "      takes_wind: true\n      heading: 30 deg\n": "      takes_wind: true\n      heading: 30 deg\n"
        "      takes_line: true\n      hook: [-38 m, 0 m]\n",
        "      wind_load: observer.wind_load\n": f"      wind_load: observer.wind_load\n      line_force: {pull}\n",
    }
    found = []
    for changes in (hooked, {**hooked, **told}):
        loop = Loop(altered(changes, (), (), "200 s"))
        found.append((loop.off().max(), np.ptp(loop.heading)))
    (off, turned), (off_known, turned_known) = found
    assert off > 3.0
    assert off_known < 0.5 * off
    assert turned_known < 0.5 * turned
