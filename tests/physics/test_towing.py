"""Boats that tow: paths against their sampled points, loops against linear theory, and boats in water by themselves."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from pydantic import ValidationError

from components.controller.path import BEFORE, CURVATURE, HEADING, LENGTH, beside, goes_on, lay, nearest
from components.controller.towing.model import Towing

# The boat of scenarios/parameters/boom_boat*.yaml with the gains of boom_controller.yaml.
LINEAR = {
    "surge_mass": 50.4, "sway_mass": 62.0, "yaw_inertia": 18.3, "surge_damping": 2.0, "sway_damping": 40.0,
    "sway_yaw_damping": -25.5, "yaw_sway_damping": -25.5, "yaw_damping": 25.7,
}  # fmt: skip
VESSEL = {
    **LINEAR, "damping": {"surge_surge": 6.0}, "cross_flow": {"length": 2.1, "draught": 0.065, "coefficient": 0.8},
    "max_speed": 1.6, "water_density": 1000.0, "takes_thrust": True, "takes_current": True,
}  # fmt: skip
OUTDRIVE = {
    "kind": "fixed", "x": -0.9, "max_thrust": 45.0, "max_power": 100.0, "max_speed": 157.0, "reverse_thrust": 25.0,
    "diameter": 0.12, "speed_time": 0.2,
}  # fmt: skip
OUTDRIVES = {"thrusters": ({**OUTDRIVE, "y": -0.25}, {**OUTDRIVE, "y": 0.25}), "meets_water": True}
TOWING = {
    **LINEAR, "square_damping": 6.0, "arm": 0.25, "max_thrust": 45.0, "reverse_thrust": 25.0, "turn_frequency": 1.5,
    "max_turn_rate": 0.6, "speed_frequency": 0.8, "max_speed": 1.4, "max_acceleration": 0.3, "gathering": 0.2,
    "lookahead": 3.0, "integral": 0.2, "drift_time": 1.0, "turn_radius": 20.0, "speed": 0.8,
    "path": ((0.0, 0.0), (500.0, 0.0)),
}  # fmt: skip
SQUARE = ((15.0, -15.0), (15.0, 15.0), (-15.0, 15.0), (-15.0, -15.0))  # with turn_radius 15: a circle about the origin
CIRCLE = {"path": SQUARE, "turn_radius": 15.0, "is_closed": True}
H = 0.1


class Boat:
    """Hull, propellers and controller, wired as in the scenarios; `track`: rows of north, east, heading, u, v, r."""

    def __init__(self, unit, place=(0.0, 0.0), heading=0.0, current=(0.0, 0.0), partner=None, **parameters):
        self.current = (*current, 0.0)
        vessel = {**VESSEL, "position": place, "heading": heading}
        self.hull = unit("vessel.low_speed", [0.0, 0.0, 0.0, *self.current], H, **vessel)
        self.drives = unit("thrusters.propulsion", np.zeros(7), H, **OUTDRIVES)
        parameters = {**TOWING, "takes_partner": partner is not None, **parameters}
        self.controller = unit("controller.towing", self.inputs(partner), H, **parameters)
        self.track = []

    def inputs(self, partner):
        return [*self.low, *(() if partner is None else partner)]

    @property
    def low(self):
        return self.hull.y[12:18].copy()

    def move(self):
        y = self.hull.y
        self.drives.step([*self.controller.y[:4], y[18], y[19], y[17]])
        thrust = [*self.drives["total.force"], self.drives["total.moment"].item()]
        self.hull.step([*thrust, *self.current])
        self.track.append(self.low)

    def go(self, seconds, partner=None):
        for _ in range(round(seconds / H)):
            self.move()
            self.controller.step(self.inputs(partner))
        return np.array(self.track)


@pytest.fixture
def boat(unit):
    return lambda **parameters: Boat(unit, **parameters)


@pytest.fixture
def controller(unit):
    return lambda u, **parameters: unit("controller.towing", u, H, **{**TOWING, **parameters})


def pair(unit, separation, speed=0.8, **parameters):
    half = 0.5 * separation
    places = ((0.0, -half), (0.0, half))
    common = {"speed": speed, **parameters}
    return [
        Boat(unit, place=places[i], partner=places[1 - i], offset=places[i][1], **common) for i in (0, 1)
    ]  # fmt: skip


def go_together(boats, seconds, still=None):
    """Both a step, then both controllers; `still`: the one held where it is. Separation and gap of each step."""
    rows = []
    for _ in range(round(seconds / H)):
        for one in boats:
            if one is not still:
                one.move()
        places = [one.low[:2] for one in boats]
        for one, other in zip(boats, places[::-1], strict=True):
            one.controller.step(one.inputs(other))
        rows.append([np.hypot(*(places[0] - places[1])), boats[0].controller["error.along"].item()])
    return np.array(rows)


def points_of(pieces, step=1e-3):
    """Points along a path by adding up steps along its heading: (k, 2) and the way to each."""
    rows, ways = [], []
    for piece in pieces:
        s = np.arange(0.0, piece[LENGTH], step)
        chi = piece[HEADING] + piece[CURVATURE] * (s + 0.5 * step)
        steps = step * np.stack([np.cos(chi), np.sin(chi)], axis=1)
        rows.append(np.array(piece[:2]) + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)[:-1]]))
        ways.append(piece[BEFORE] + s)
    return np.concatenate(rows), np.concatenate(ways)


def test_path_is_smooth_and_a_point_is_where_its_nearest_point_is():
    """Each piece begins where and as the last one ends; along it and beside it against its points 1 mm apart."""
    pieces = lay(((0.0, 0.0), (10.0, 0.0), (14.0, 9.0), (2.0, 12.0), (2.0, 20.0)), 2.0, False)
    for one, then in pairwise(pieces):
        way, chi = one[LENGTH], one[HEADING] + one[CURVATURE] * one[LENGTH]
        end = points_of([one], way / 1e5)[0][-1] + way / 1e5 * np.array([np.cos(chi), np.sin(chi)])
        assert end == pytest.approx(then[:2], abs=1e-3)
        assert np.cos(chi - then[HEADING]) == pytest.approx(1.0, abs=1e-12)
        assert then[BEFORE] == pytest.approx(one[BEFORE] + one[LENGTH])
    q = np.array(pieces).ravel()
    places, ways = points_of(pieces)
    rng = np.random.default_rng(3)
    for i in rng.integers(0, len(places), 60):
        k = next(j for j, piece in enumerate(pieces) if ways[i] < piece[BEFORE] + piece[LENGTH])
        chi = pieces[k][HEADING] + pieces[k][CURVATURE] * (ways[i] - pieces[k][BEFORE])
        across = rng.uniform(-1.0, 1.0)
        place = places[i] + across * np.array([-np.sin(chi), np.cos(chi)])
        found = nearest(q, len(pieces), *place)
        along, beyond, heading = beside(np.array(pieces[found]), *place)
        assert pieces[found][BEFORE] + along == pytest.approx(ways[i], abs=3e-3)
        assert beyond == pytest.approx(across, abs=2e-3)
        assert np.cos(heading - chi) == pytest.approx(1.0, abs=1e-5)
        for before in range(max(found - 1, 0), min(found + 2, len(pieces))):
            assert goes_on(q, len(pieces), False, before, *place)[0] == found


def test_square_with_arcs_of_half_its_side_is_a_circle():
    """Four quarters, no straight between; once round is a round, backwards too; its centre is no trouble."""
    pieces = lay(SQUARE, 15.0, True)
    assert len(pieces) == 4
    assert pieces[-1][BEFORE] + pieces[-1][LENGTH] == pytest.approx(2 * pi * 15.0)
    q = np.array(pieces).ravel()
    angles = np.linspace(0.0, 4 * pi, 400)
    for sign, total in ((1.0, 2), (-1.0, -2)):
        piece, rounds = nearest(q, 4, 15.0, 0.0), 0
        for angle in angles[:-1] + 0.001:
            piece, more = goes_on(q, 4, True, piece, 15.0 * np.cos(angle), sign * 15.0 * np.sin(angle))
            rounds += more
        assert abs(rounds - total) <= 1
    assert all(np.isfinite(beside(np.array(one), 0.0, 0.0)).all() for one in pieces)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"path": ((0.0, 0.0), (0.0, 0.0))}, "corners 1 and 2 of path are the same point"),
        ({"path": ((0.0, 0.0), (90.0, 0.0), (10.0, 0.0))}, "corner 2 of path turns back"),
        ({"path": ((0.0, 0.0), (15.0, 0.0), (15.0, 90.0))}, "leg 1 of path is 15 m long, the arcs"),
        ({"path": ((0.0, 0.0), (90.0, 0.0)), "is_closed": True}, "expected 3 at least where closed"),
        ({"path": ((0.0, 0.0), (90.0, 0.0), (90.0, 90.0)), "offset": -20.0}, "offset is -20 m, turn_radius 20 m"),
        ({"speed": 2.0}, "speed is 2 m/s, above max_speed"),
    ],
)
def test_what_cannot_be_gone_is_refused(changes, told):
    with pytest.raises(ValidationError, match=told):
        Towing(**{**TOWING, **changes})


def test_heading_and_speed_have_the_poles_asked_for(controller):
    """A linear boat at a place of its path, in numpy: I (s^2 + 2 z w s + w^2) and m (s^2 + 2 z w s + w^2).

    Theory is continuous, the controller holds each 10 ms: 2 % of the first deviation.
    """
    h, n = 0.01, 600
    t = h * np.arange(1, n + 1)
    one = controller([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], speed=0.0)
    one.h = round(h * 1e9)
    psi, r, seen = 0.1, 0.0, []
    for _ in range(n):
        torque = 0.25 * (one.y[0] - one.y[1])
        r += h * (torque - LINEAR["yaw_damping"] * r) / LINEAR["yaw_inertia"]
        psi += h * r
        one.step([0.0, 0.0, psi, 0.0, 0.0, r])
        seen.append(psi)
    assert np.array(seen) == pytest.approx(0.1 * (1.0 + 1.5 * t) * np.exp(-1.5 * t), abs=0.002)
    push, u, seen = 5.0, 0.0, []
    one = controller([0.0] * 6, speed=0.0, square_damping=0.0, max_acceleration=1e3)
    one.h = round(h * 1e9)
    for _ in range(n):
        u += h * (one.y[0] + one.y[1] + push - LINEAR["surge_damping"] * u) / LINEAR["surge_mass"]
        one.step([0.0, 0.0, 0.0, u, 0.0, 0.0])
        seen.append(u)
    expected = push / LINEAR["surge_mass"] * t * np.exp(-0.8 * t)
    assert np.array(seen) == pytest.approx(expected, abs=0.02 * expected.max())


@pytest.mark.parametrize("current", [(0.0, 0.3), (-0.2, -0.2), (0.3, 0.0)])
def test_straight_line_in_a_current(boat, current):
    """From 3 m aside: onto the line to 1 cm after 100 m, at the speed over the ground, crabbing, and to stay."""
    track = boat(place=(0.0, 3.0), heading=0.5, current=current).go(200.0)
    late = track[track[:, 0] > 100.0]
    assert len(late) > 500
    assert np.abs(late[:, 1]).max() < 0.01
    assert np.diff(late[:, 0]) / H == pytest.approx(0.8, abs=0.005)
    if current[1]:
        assert np.sign(late[-1, 2]) == -np.sign(current[1])
    assert track[:, 1].min() > -1.0  # of 3 m: the turn onto the line goes little beyond it


def test_circle(boat):
    """Two rounds: onto the circle to 1 cm of its 15 m in still water, to 0.15 m where the current turns about it."""
    one = boat(place=(0.0, -15.0), **CIRCLE)
    track = one.go(240.0)
    assert np.abs(np.hypot(*track[1200:, :2].T) - 15.0).max() < 0.01
    assert np.hypot(track[1200:, 3], track[1200:, 4]) == pytest.approx(0.8, abs=0.01)
    assert one.controller["progress"] - 0.25 * 2 * pi * 15.0 > 0.7 * 240.0 - 0.75 * 2 * pi * 15.0
    track = boat(place=(0.0, -15.0), current=(0.1, 0.1), **CIRCLE).go(240.0)
    assert np.abs(np.hypot(*track[1200:, :2].T) - 15.0).max() < 0.15


def test_speed_step_does_not_overshoot(boat):
    """0.5 to 1.1 m/s: no more than 2 % of the step beyond, by 0.3 m/s^2.

    To within 2 % of it in 10 s: the propellers lose thrust by the speed, which the integral makes good at 0.8 rad/s.
    """
    one = boat(speed=0.5)
    one.go(30.0)
    assert one.track[-1][3] == pytest.approx(0.5, abs=1e-3)
    one.controller.set(speed=1.1)
    speed = one.go(40.0)[300:, 3]
    assert speed.max() < 1.1 + 0.02 * 0.6
    assert speed[-1] == pytest.approx(1.1, abs=1e-3)
    assert np.diff(speed).max() / H < 0.3 * 1.1
    assert np.argmax(speed > 1.1 - 0.02 * 0.6) * H < 10.0


def test_formation_is_kept_through_a_turn(unit):
    """8 m abeam, one boat on the outer side of a turn of 20 m: separation to 1.5 %, abeam to 0.25 m, to the end."""
    boats = pair(unit, 8.0, path=((0.0, 0.0), (40.0, 0.0), (40.0, 70.0)))
    seen = go_together(boats, 150.0)
    ends = [np.hypot(one.track[-1][3], one.track[-1][4]) for one in boats]
    assert np.abs(seen[:, 0] / 8.0 - 1.0).max() < 0.015
    assert np.abs(seen[:, 1]).max() < 0.25
    outer, inner = (np.array(one.track)[:, 3] for one in boats)
    assert outer.max() == pytest.approx(0.8 * 24.0 / 20.0, rel=0.03)
    assert inner[300:700].min() == pytest.approx(0.8 * 16.0 / 20.0, rel=0.03)
    assert max(ends) < 0.01
    for one, east in zip(boats, (44.0, 36.0), strict=True):
        assert one.controller["arrived"] == 1.0
        assert one.track[-1][:2] == pytest.approx([east, 70.0], abs=0.6)


def test_a_boat_waits_for_one_that_is_stopped(unit):
    """Held for 40 s: the other rests where speed / gathering lets it, 4 m ahead; then they close up."""
    boats = pair(unit, 6.0)
    go_together(boats, 20.0)
    held = go_together(boats, 40.0, still=boats[1])
    assert held[-1, 1] == pytest.approx(0.8 / 0.2, rel=0.05)
    assert np.hypot(*boats[0].track[-1][3:5]) < 0.02
    again = go_together(boats, 60.0)
    assert again[-1, 1] == pytest.approx(0.0, abs=0.02)
    assert again[-1, 0] == pytest.approx(6.0, abs=0.02)
    assert boats[0].track[-1][3] == pytest.approx(0.8, abs=0.01)


def test_boats_on_a_closed_path_are_abeam_across_its_seam(controller):
    """One just before the begin of the circle and one just after it are 0.2 m apart, not a whole round."""
    angle = 0.1 / 15.0
    for sign in (1.0, -1.0):
        place, partner = ((15.0 * np.cos(a), 15.0 * np.sin(a)) for a in (-sign * angle, sign * angle))
        one = controller([*place, pi / 2, 0.0, 0.0, 0.0, *partner], takes_partner=True, **CIRCLE)
        assert one["error.along"] == pytest.approx(-sign * 0.2, abs=1e-6)


def test_headings_of_whole_turns_more_are_the_same(controller):
    """Rounding of 20 turns: 1e-12 of the thrusts."""
    for heading in (0.3, 3.1, -3.1):
        u = [4.0, 1.0, heading, 0.6, 0.1, 0.05]
        expected = controller(u).step(u).y[:2].copy()
        for turns in (-20, -1, 1, 20):
            u[2] = heading + 2 * pi * turns
            assert controller(u).step(u).y[:2] == pytest.approx(expected, abs=1e-10)


def test_a_path_to_the_south_is_steered_across_the_wrap(boat):
    """Course 180 degrees: the heading crosses from 179 to -179 and the boat does not turn round."""
    track = boat(place=(0.0, 1.0), heading=3.0, path=((0.0, 0.0), (-500.0, 0.0)), current=(0.0, 0.2)).go(100.0)
    assert np.abs(track[600:, 1]).max() < 0.02
    assert np.ptp(track[:, 2]) < 1.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_bad_inputs_hold_the_thrust_and_a_lost_partner_the_gap(controller, bad):
    u = [3.0, 0.5, 0.1, 0.7, 0.0, 0.0, 1.0, 4.0, -8.0, 1.0, 0.0]
    one = controller(u, takes_partner=True, takes_line=True)
    for _ in range(20):
        one.step(u)
    before, gap = one.y[:2].copy(), one["error.along"].item()
    assert np.abs(before).min() > 0.0
    for k in (0, 1, 2, 3, 4, 5, 8, 9, 10):
        wrong = list(u)
        wrong[k] = bad
        one.step(wrong)
        assert (one.y[:2] == before).all()
        assert (one["held"], one["alone"]) == (1.0, 0.0)
    for k in (6, 7):
        wrong = list(u)
        wrong[k] = bad
        one.step(wrong)
        assert (one["held"], one["alone"]) == (0.0, 1.0)
        assert one["error.along"] == gap
    one.step(u)
    assert (one["held"], one["alone"]) == (0.0, 0.0)


@pytest.mark.parametrize("heading", [0.0, 1.0, -2.5])
def test_line_is_worked_against(controller, heading):
    """The thrusts differ by the line's force ahead and its moment about the reference point, as far as it is told."""
    line, hook, u = np.array([-9.0, 4.0, 2.0]), (-0.4, 0.1), [3.0, 0.5, heading, 0.7, 0.0, 0.0]
    strong = {"max_thrust": 1e3, "reverse_thrust": 1e3}
    bare = controller(u, **strong)
    told = controller([*u, *line], takes_line=True, hook=hook, line_share=0.5, **strong)
    c, s = np.cos(heading), np.sin(heading)
    ahead, across = c * line[0] + s * line[1], c * line[1] - s * line[0]
    assert told.y[:2].sum() - bare.y[:2].sum() == pytest.approx(-0.5 * ahead)
    turn = 0.25 * np.array([1.0, -1.0])
    moment = hook[0] * across - hook[1] * ahead
    assert turn @ told.y[:2] - turn @ bare.y[:2] == pytest.approx(-0.5 * moment)


def test_moment_goes_before_and_the_integral_rests_at_the_limit(controller):
    """Facing away both propellers are at a limit, turning, as they are for too fast a speed: nothing winds up."""
    u = [0.0, 0.0, 2.5, 0.0, 0.0, 0.0]
    one = controller(u, max_turn_rate=3.0)
    for _ in range(600):
        one.step(u)
    assert one.y[:2] == pytest.approx([-25.0, 45.0])
    assert one["limited"] == 1.0
    assert one["integral.force"] == 0.0
    u = [0.0] * 6
    one = controller(u, speed=1.4, square_damping=40.0)
    for _ in range(600):
        one.step(u)
    assert one.y[:2] == pytest.approx([45.0, 45.0])
    assert one["integral.force"] < 20.0
