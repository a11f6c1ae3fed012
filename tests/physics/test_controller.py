"""Controllers against linear theory, the limits of their reference, and what saturation and bad input may not do."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from scipy.integrate import solve_ivp

MASS = {"surge_mass": 7e6, "sway_mass": 11e6, "yaw_inertia": 4.5e9}
DAMPING = {"surge_damping": 8e4, "sway_damping": 2.5e5, "yaw_damping": 3.8e8}
TUNING = {
    "frequency": (0.07, 0.08, 0.09), "damping_ratio": (0.9, 0.8, 0.7), "radius": 1.0, "angle": 0.03,
    "reference_frequency": 0.12, "max_speed": 0.5, "max_acceleration": 0.01, "turn_frequency": 0.12,
    "max_turn_rate": radians(0.5), "max_turn_acceleration": radians(0.01),
}  # fmt: skip
STATION = {**MASS, **DAMPING, **TUNING, "takes_achieved": False}
H = 0.1


@pytest.fixture
def station(unit):
    """`station(u, **parameters)`."""

    def make(u, **parameters):
        return unit("controller.station", u, H, **{**STATION, **parameters})

    return make


def load(controller):
    return np.array([*controller["demand.force"], controller["demand.moment"]])


def at(north=0.0, east=0.0, heading=0.0, surge=0.0, sway=0.0, yaw=0.0):
    return [north, east, heading, surge, sway, yaw]


def test_gains_place_the_poles(station):
    """Surge, sway and yaw under control and a steady load: the poles m s^3 + (d + K_d) s^2 + K_p s + K_i of theory.

    A linear vessel in numpy, steps of 0.1 s, against solve_ivp of the closed loop: 2 % of the largest excursion. It
    hardly turns, since the integral is held in the world's frame.
    """
    masses, damping = np.array(list(MASS.values())), np.array(list(DAMPING.values()))
    omega, zeta = np.array(TUNING["frequency"]), np.array(TUNING["damping_ratio"])
    kp, kd = masses * omega**2, 2 * zeta * omega * masses - damping
    ki = 0.1 * omega * kp
    ki[:2] = ki[:2].mean()
    push = np.array([5e4, -4e4, 2e4])

    def rates(_, s):
        eta, nu, z = s[:3], s[3:6], s[6:]
        return np.concatenate([nu, (push - damping * nu - kp * eta - kd * nu - z) / masses, ki * eta])

    exact = solve_ivp(rates, (0, 300), np.zeros(9), rtol=1e-9, atol=1e-9, dense_output=True)
    controller = station(at())
    eta, nu, seen = np.zeros(3), np.zeros(3), []
    for _ in range(3000):
        nu += H * (push + load(controller) - damping * nu) / masses
        eta += H * nu
        controller.step(at(*eta, *nu))
        seen.append(eta.copy())
    expected = exact.sol(H * np.arange(1, 3001))[:3].T
    size = np.abs(expected).max(axis=0)
    assert (np.abs(np.array(seen) - expected).max(axis=0) / size).max() < 0.02


def test_reference_keeps_its_limits_and_does_not_overshoot(station):
    """60 m away and 90 degrees round: a straight line, speeds and accelerations within theirs, no overshoot.

    Behind the limited acceleration the speed is of second order with a damping ratio of 0.866: 0.43 % above its limit.
    """
    controller = station(at())
    controller.set(position=(48.0, -36.0), heading=pi / 2)
    places, headings = [], []
    for _ in range(6000):
        controller.step(at())
        places.append(controller["reference.position"])
        headings.append(controller["reference.heading"].item())
    places, headings = np.array(places), np.array(headings)
    speed, turn = np.diff(places, axis=0) / H, np.diff(headings) / H
    assert np.abs(places @ [0.6, 0.8]).max() < 1e-9
    assert np.linalg.norm(speed, axis=1).max() <= 0.5 * 1.0043
    assert np.linalg.norm(np.diff(speed, axis=0) / H, axis=1).max() <= 0.01 + 1e-9
    assert turn.max() <= radians(0.5) * 1.0043
    assert np.abs(np.diff(turn) / H).max() <= radians(0.01) + 1e-9
    assert (places @ [0.8, -0.6]).max() < 60.0 + 0.05
    assert headings.max() < pi / 2 + radians(0.1)
    assert places[-1] == pytest.approx([48.0, -36.0], abs=0.02)


def test_heading_goes_the_short_way(station):
    """From 179 to -179 degrees is two degrees, and the demand turns to starboard."""
    controller = station(at(heading=radians(179.0)), heading=radians(-179.0))
    for _ in range(1200):
        controller.step(at(heading=radians(179.0)))
    assert controller["reference.heading"] == pytest.approx(radians(181.0), abs=0.002)
    assert controller["error.heading"] == pytest.approx(radians(2.0), abs=0.002)
    assert controller["demand.moment"] > 0.0


@pytest.mark.parametrize("heading", [0.0, 1.0, 3.0])
def test_known_loads_are_opposed(station, heading):
    """Where nothing else is, the demand is minus the wind's load and the line's pull, moment of the hook included."""
    wind, line, hook = np.array([3e4, -5e4, 7e5]), np.array([2e4, 1e4, 5e3]), (-38.0, 2.0)
    u = [*at(heading=heading), *wind, *line]
    controller = station(u, heading=heading, takes_wind=True, takes_line=True, hook=hook)
    controller.step(u)
    c, s = np.cos(heading), np.sin(heading)
    body = np.array([c * line[0] + s * line[1], c * line[1] - s * line[0]])
    pull = np.array([*body, hook[0] * body[1] - hook[1] * body[0]])
    assert load(controller) == pytest.approx(-wind - pull)


def test_integral_holds_while_thrusters_fall_short(station):
    """A gust beyond the thrusters for 300 s; afterwards the vessel comes back as if the integral had never known.

    Without the hold the integral would have grown by 0.1 * 0.07 * 7e6 * 0.07^2 N/(m s) times the excursion, some MN.
    """
    most, mass, slow = 2e5, 7e6, -6e4

    def run(takes):
        controller = station([*at(), *([0.0] * 3 if takes else [])], takes_achieved=takes)
        x = v = 0.0
        places, integrals, given = [], [], 0.0
        for k in range(20_000):
            gust = -2.2e5 if 8000 <= k < 11_000 else 0.0
            given = float(np.clip(controller["demand.force"][0], -most, most))
            v += H * (given + slow + gust - 8e4 * v) / mass
            x += H * v
            controller.step([*at(north=x, surge=v), *([given, 0.0, 0.0] if takes else [])])
            places.append(x)
            integrals.append(controller["integral.force"][0])
        return np.array(places), np.array(integrals)

    places, integrals = run(takes=True)
    wound, _ = run(takes=False)
    assert integrals[7999] == pytest.approx(6e4, rel=0.02)
    assert integrals[10_999] == pytest.approx(6e4, rel=0.1)
    assert places[11_000:].max() < 0.1 * -places.min()
    assert wound[11_000:].max() > 3 * places[11_000:].max()


def test_waypoints_in_turn(station):
    """Each is reached by vessel and reference, stayed at, and left; then round again."""
    waypoints = (
        {"position": (5.0, 0.0), "stay": 10.0},
        {"position": (5.0, 5.0), "heading": 0.2, "stay": 20.0},
        {"position": (0.0, 0.0), "speed": 0.1},
    )
    controller = station(at(), waypoints=waypoints, repeats=True)
    legs, arrivals = [], {}
    for _ in range(8000):
        place, heading = controller["reference.position"], controller["reference.heading"].item()
        controller.step(at(*place, heading))
        leg = int(controller["waypoint"])
        if controller["arrived"] and leg not in arrivals:
            arrivals[leg] = controller.seconds
        if not legs or legs[-1][0] != leg:
            legs.append((leg, controller.seconds))
    assert [leg for leg, _ in legs][:4] == [0, 1, 2, 0]
    assert legs[1][1] - arrivals[0] == pytest.approx(10.0, abs=0.11)
    assert legs[2][1] - arrivals[1] == pytest.approx(20.0, abs=0.11)


def test_arrival_is_within_a_circle(station):
    """0.9 m north and 0.9 m east are 1.27 m away, and not within a radius of 1 m."""
    waypoints = ({"position": (0.0, 0.0)}, {"position": (5.0, 0.0)})
    for north, east, leg in ((0.9, 0.9, 0), (0.7, 0.7, 1)):
        controller = station(at(north, east), waypoints=waypoints, radius=1.0)
        controller.step(at(north, east))
        assert controller["waypoint"] == leg, (north, east)


@pytest.mark.parametrize("h", [0.1, 5.0, 20.0])
def test_reference_at_any_step(unit, h):
    """A reference of 0.5 rad/s in steps of up to ten of its time constants: within its speed, and no overshoot."""
    fast = {**STATION, "reference_frequency": 0.5, "turn_frequency": 0.5, "max_acceleration": 10.0}
    controller = unit("controller.station", at(), h, **fast)
    controller.set(position=(60.0, 0.0), heading=pi - 0.01)
    places, headings = [], []
    for _ in range(round(1200 / h)):
        controller.step(at())
        places.append(controller["reference.position"][0])
        headings.append(controller["reference.heading"].item())
    assert np.diff(places).max() <= 0.5 * 1.006 * h
    assert max(places) == pytest.approx(60.0, abs=1e-6)
    assert places[-1] == pytest.approx(60.0, abs=1e-6)
    assert max(headings) == pytest.approx(pi - 0.01, abs=1e-6)


def test_half_a_turn(station):
    """To the opposite heading: one way round, without hesitation, and to the end."""
    controller = station(at())
    controller.set(heading=pi)
    headings = [0.0]
    for _ in range(6000):
        controller.step(at(heading=headings[-1]))
        headings.append(controller["reference.heading"].item())
    turns = np.diff(headings)
    assert (turns <= 1e-9).all() or (turns >= -1e-9).all()
    assert np.cos(headings[-1]) == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_bad_input_holds_the_last_demand(station, bad):
    controller = station(at(), position=(3.0, 1.0))
    for _ in range(50):
        controller.step(at())
    before = load(controller)
    assert np.abs(before).max() > 0.0
    for k in range(6):
        u = at()
        u[k] = bad
        controller.step(u)
        assert load(controller) == pytest.approx(before, abs=0)
        assert controller["held"] == 1.0
    controller.step(at())
    assert controller["held"] == 0.0


def test_rov_goes_to_its_waypoints_against_current_and_tether(unit):
    """A BlueROV2 as four linear axes with its thrusters' limits: both waypoints within 0.3 m, never beyond a limit."""
    mass, damping = np.array([19.2, 24.2, 26.1, 0.4]), np.array([13.7, 0.0, 33.0, 0.8])
    limit = (85.0, 85.0, 120.0, 14.0)
    parameters = {
        "mass": (19.2, 24.2, 26.1), "yaw_inertia": 0.4, "linear_damping": (13.7, 0.0, 33.0), "yaw_damping": 0.8,
        "frequency": (0.8, 0.8, 0.8), "yaw_frequency": 1.5, "max_force": limit[:3], "max_moment": limit[3],
        "radius": 0.4, "reference_frequency": 1.0, "max_speed": 0.5, "max_acceleration": 0.2, "turn_frequency": 1.5,
        "max_turn_rate": 0.5, "max_turn_acceleration": 0.5, "takes_line": True, "hook": (-0.2, 0.0),
        "waypoints": ({"position": (10.0, 5.0), "depth": 20.0, "heading": 1.0, "stay": 5.0},
                      {"position": (0.0, 5.0), "depth": 22.0, "heading": -2.0}),
    }  # fmt: skip
    eta, nu, line, seen = np.array([0.0, 0.0, 15.0, 3.0]), np.zeros(4), np.array([-20.0, 5.0, -10.0]), []

    def inputs():
        return [*eta[:3], 0.0, 0.0, eta[3], *nu[:3], 0.0, 0.0, nu[3], *line]

    rov = unit("controller.rov", inputs(), 0.05, **parameters)
    for _ in range(3000):
        c, s = np.cos(eta[3]), np.sin(eta[3])
        turn = np.array([[c, s], [-s, c]])
        pull = np.array([*(turn @ line[:2]), line[2], 0.0])
        pull[3] = -0.2 * pull[1]
        water = np.array([*(turn @ [-0.3, 0.1]), 0.0, 0.0])
        thrust = np.array([*rov["thrust.force"], rov["thrust.moment"]])
        assert (np.abs(thrust) <= limit).all()
        nu += 0.05 * (thrust + pull - (damping + 30.0 * np.abs(nu - water)) * (nu - water)) / mass
        eta += 0.05 * np.array([*(turn.T @ nu[:2]), nu[2], nu[3]])
        rov.step(inputs())
        seen.append([*eta, rov["waypoint"].item()])
    seen = np.array(seen)
    first = seen[seen[:, 4] == 0]
    assert np.abs(first[-1, :3] - [10.0, 5.0, 20.0]).max() < 0.3
    assert seen[-1, :3] == pytest.approx([0.0, 5.0, 22.0], abs=0.3)
    assert np.cos(seen[-1, 3] + 2.0) > 0.999


def test_record_is_played_by_a_spline(unit):
    """scipy's natural cubic spline, and the first and last row beyond the ends."""
    from scipy.interpolate import CubicSpline

    rows = ((1.0, 1e5, 0.0, 3e6), (2.0, 2e5, -1e5, 2e6), (4.0, 1e5, 3e5, -1e6), (4.5, 0.0, 2e5, 0.0))
    record = unit("controller.record", [], H, table=rows)
    table = np.array(rows)
    spline = CubicSpline(table[:, 0], table[:, 1:], bc_type="natural")
    assert load(record) == pytest.approx(table[0, 1:])
    for _ in range(60):
        record.step()
        assert load(record) == pytest.approx(spline(np.clip(record.seconds, 1.0, 4.5)), rel=1e-12, abs=1e-6)
