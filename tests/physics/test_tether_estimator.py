"""The estimator of a tether: truth of its own model and chi-square, the quasi-static line, and what may go wrong."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from components.estimator.tether.layout import STATES, D
from components.kinematics import to_body, to_world

H, EVERY, LATE = 0.5, 4, 2  # step [s]; steps from one USBL value to the next, and by which it comes late
USED, SAME, LOST, WILD = range(4)
LENGTH, STORED = 250.0, 85.0
LINE = {
    "weight": 0.035, "axial_stiffness": 1e6, "drag_diameter": 0.015, "tangential_drag": 0.01,
    "current_depth": (0.0, 30.0, 100.0),
    "current": ((-0.33, 0.23, 0.0), (-0.1, 0.17, 0.0), (-0.02, 0.1, 0.0)),
}  # fmt: skip
PLACE, HOOK, TRANSCEIVER = np.array([50.0, 90.0, 120.0]), np.array([0.0, 9.0, 3.0]), np.array([0.0, 0.0, 8.0])
NOISE = {"range": 0.3, "angle": 0.004, "bias": 0.004, "cell": 2.0, "swing": 8.0, "along": 0.02, "across": 0.01,
         "place": 1.0, "speed": 0.05, "agitation": 0.02}  # fmt: skip
FILTER = {
    "whole_length": LENGTH,
    "hook": tuple(HOOK), "transceiver": tuple(TRANSCEIVER), "start": tuple(PLACE), "start_place": NOISE["place"],
    "start_speed": NOISE["speed"], "agitation": NOISE["agitation"], "range_noise": NOISE["range"],
    "angle_noise": NOISE["angle"], "angle_bias": NOISE["bias"], "cell_noise": NOISE["cell"], "swing": NOISE["swing"],
    "swing_time": 4.0, "offset_along": NOISE["along"], "offset_across": NOISE["across"],
    "following_time": 1e9,  # the line follows nothing
}  # fmt: skip


def inputs(t, sight=(0.0, 0.0, 0.0), seen=None, tension=None, stored=STORED, pose=(0.0, 0.0, 0.0, 0.0)):
    """Of a ship at the origin; seen: the USBL value's time [s], None without one; pose: roll, pitch, heading, heave."""
    roll, pitch, heading, heave = pose
    usbl = [*sight, 0.0 if seen is None else 1.0, 0.0 if seen is None else seen]
    cell = [0.0, 0.0, 0.0] if tension is None else [tension, 1.0, t]
    return [0.0, 0.0, heading, 0.0, 0.0, 0.0, roll, pitch, heave, 1.0, *usbl, *cell, stored]


def sight(place, pose=(0.0, 0.0, 0.0, 0.0)):
    """Range, across and along of a transponder, by the definition of both angles."""
    roll, pitch, heading, heave = pose
    north, east, down = place - to_world(roll, pitch, heading, *TRANSCEIVER) - np.array([0.0, 0.0, heave])
    ahead, across, _ = to_body(roll, pitch, heading, north, east, down)
    reach = np.sqrt(north**2 + east**2 + down**2)
    return np.array([reach, np.arcsin(across / reach), np.arcsin(ahead / reach)])


@pytest.fixture(scope="module")
def line(unit):
    """`line(end, along, across, hook)`: tether.quasistatic between the hook and an end, in the current so offset."""

    def solve(end, along=0.0, across=0.0, hook=HOOK):
        u, current = np.zeros(18), []
        u[:3], u[9:12] = hook, end
        for one in np.array(LINE["current"]):
            way = one / np.linalg.norm(one)
            current.append(tuple(one + along * way + across * np.array([-way[1], way[0], 0.0])))
        given = {**LINE, "length": LENGTH - STORED, "current": tuple(current), "segments": 20}
        return unit("tether.quasistatic", u, H, **given)

    return solve


class Truth:
    """End b, current, slow errors of the angles and swing as the filter's model has them; the tension is linear."""

    def __init__(self, rng, base, slope):
        self.rng, self.base, self.slope = rng, base, slope
        spread = [NOISE["place"]] * 3 + [NOISE["speed"]] * 3
        spread += [NOISE["along"], NOISE["across"], NOISE["bias"], NOISE["bias"], NOISE["swing"]]
        self.x = rng.normal(0.0, spread)
        self.x[:3] += PLACE
        self.spread, self.times = np.array(spread[6:]), np.array([600.0, 600.0, 1800.0, 1800.0, 4.0])
        self.root = NOISE["agitation"] * np.linalg.cholesky([[H**3 / 3.0, H**2 / 2.0], [H**2 / 2.0, H]])
        self.places = [self.x[:3].copy()]

    def step(self):
        push = self.root @ self.rng.standard_normal((2, 3))
        self.x[:3] += H * self.x[3:6] + push[0]
        self.x[3:6] += push[1]
        kept = np.exp(-H / self.times)
        self.x[6:] = kept * self.x[6:] + self.spread * np.sqrt(1.0 - kept**2) * self.rng.standard_normal(5)
        self.places.append(self.x[:3].copy())

    def tension(self):
        off = np.concatenate([self.x[:3] - PLACE, self.x[6:8]])
        return self.base + self.slope @ off + self.x[D] + self.rng.normal(0.0, NOISE["cell"])

    def sight(self):
        """Taken LATE steps ago; the slow errors have hardly changed since."""
        noise = self.rng.normal(0.0, [NOISE["range"], NOISE["angle"], NOISE["angle"]])
        return sight(self.places[-1 - LATE]) + noise + [0.0, *self.x[8:10]]


@pytest.fixture(scope="module")
def runs(unit, line):
    """Of 25 runs of 40 s: NIS of USBL (runs, 9) and load cell (runs, 80), NEES of all states at the end (runs, 1)."""
    steps = [*(0.5 * np.eye(5)[:3]), *(0.01 * np.eye(5)[3:])]
    tensions = [[line(PLACE + s * d[:3], *(s * d[3:]))["tension"][0] for s in (1.0, -1.0)] for d in steps]
    slope = np.array([(a - b) / (2.0 * d.max()) for (a, b), d in zip(tensions, steps, strict=True)])
    found = {"usbl": [], "cell": [], "nees": []}
    for seed in range(25):
        truth = Truth(np.random.default_rng(seed), line(PLACE)["tension"][0], slope)
        filter_, rows = unit("estimator.tether", inputs(0.0), H, **LINE, **FILTER), {"usbl": [], "cell": []}
        for k in range(1, 81):
            truth.step()
            new = k % EVERY == LATE and k > LATE
            value, seen = (truth.sight(), (k - LATE) * H) if new else (np.zeros(3), None)
            filter_.step(inputs(k * H, value, seen, truth.tension()))
            for i, name in enumerate(rows):
                if filter_["freedom"][i] > 0.0:
                    rows[name].append(filter_["nis"][i])
        error = filter_.x[:STATES] - truth.x
        cov = filter_.x[STATES : STATES + STATES**2].reshape(STATES, STATES)
        found["nees"].append([error @ np.linalg.solve(cov, error)])
        for name, values in rows.items():
            found[name].append(values)
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize(("name", "freedom"), [("usbl", 3), ("cell", 1), ("nees", STATES)])
def test_consistent(runs, name, freedom):
    """The average lies in its 99 % band: innovations are independent, and so are runs (Bar-Shalom et al. 2001, 5.4)."""
    values = runs[name]
    low, high = chi2.ppf([0.005, 0.995], freedom * values.size) / values.size
    assert low <= values.mean() <= high


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0, 0.0), (0.05, -0.03, 2.0, 0.6)])
def test_it_finds_the_line_at_rest(unit, line, pose):
    """tether.quasistatic's, improved from two meshes; one of as many segments is off by four times its error.

    Exact values of the USBL put end b right to 1 cm and more, which moves nodes by little more.
    """
    hook = np.array(to_world(*pose[:3], *HOOK)) + np.array([0.0, 0.0, pose[3]])
    fine = {**FILTER, "range_noise": 1e-3, "angle_noise": 1e-5, "angle_bias": 1e-6, "agitation": 1e-4}
    end = PLACE + np.array([0.4, -0.3, 0.2])
    filter_ = unit("estimator.tether", inputs(0.0, sight(end, pose), 0.0, pose=pose), H, **LINE, **fine)
    for k in range(1, 30):
        filter_.step(inputs(k * H, sight(end, pose), k * H, pose=pose))
    truth = line(end, hook=hook)
    assert filter_["end_b.position"] == pytest.approx(end, abs=0.01)
    assert np.abs(filter_["nodes"] - truth["nodes"]).max() <= 5.0 * truth["error"] + 0.03
    assert filter_["mean_tension"] == pytest.approx(truth["tension"][[0, -1]], rel=0.01)
    assert filter_["held"] == 0.0


def test_swing_at_the_ship_is_that_at_the_rov(unit, line):
    """The cell's tension is far above the line's at rest: the excess is taken for its swing, alike at both ends."""
    rest = line(PLACE)["tension"]
    sure = {**FILTER, "start_place": 1e-3, "cell_noise": 0.1}
    filter_ = unit("estimator.tether", inputs(0.0, tension=rest[0]), H, **LINE, **sure)
    filter_.step(inputs(H, tension=rest[0] + 15.0))
    assert filter_["tension"][0] == pytest.approx(rest[0] + 15.0, abs=0.1)
    assert np.diff(filter_["tension"]) == pytest.approx(np.diff(filter_["mean_tension"]))


@pytest.mark.parametrize("stored", [LENGTH - 100.0, LENGTH, LENGTH + 5.0], ids=["too short", "none out", "less"])
def test_shape_is_held_where_no_line_fits(unit, stored):
    """And found again when one does. The paid out line is shorter than the distance, or there is none."""
    filter_ = unit("estimator.tether", inputs(0.0, sight(PLACE), 0.0, 30.0), H, **LINE, **FILTER)
    nodes, tension = filter_["nodes"], filter_["mean_tension"]
    filter_.step(inputs(H, tension=30.0, stored=stored))
    assert filter_["held"] == 1.0
    assert (filter_["nodes"] == nodes).all()
    assert (filter_["mean_tension"] == tension).all()
    assert filter_["status"][1] == LOST
    filter_.step(inputs(2 * H, tension=30.0))
    assert filter_["held"] == 0.0


def test_no_line_at_all_is_a_straight_way(unit):
    filter_ = unit("estimator.tether", inputs(0.0, stored=LENGTH), H, **LINE, **FILTER)
    assert filter_["held"] == 1.0
    assert filter_["nodes"] == pytest.approx(np.linspace(HOOK, PLACE, 21))


@pytest.mark.parametrize(
    ("value", "seen", "status"),
    [
        (sight(PLACE), H, USED),
        (sight(PLACE), None, LOST),
        (sight(PLACE), -20.0, LOST),
        (sight(PLACE), 5.0, LOST),
        (np.array([np.nan, 0.0, 0.0]), H, LOST),
        (sight(PLACE), 0.0, SAME),
        (sight(PLACE) + np.array([20.0, 0.0, 0.0]), H, WILD),
    ],
    ids=["used", "none", "too old", "of the future", "not a number", "again", "wild"],
)
def test_usbl_values(unit, value, seen, status):
    filter_ = unit("estimator.tether", inputs(0.0, sight(PLACE), 0.0), H, **LINE, **FILTER)
    before = filter_["deviation.end_b"]
    filter_.step(inputs(H, value, seen))
    assert filter_["status"][0] == status
    assert (filter_["deviation.end_b"] < before).all() == (status == USED)


def test_snap_is_refused(unit):
    filter_ = unit("estimator.tether", inputs(0.0, sight(PLACE), 0.0, 30.0), H, **LINE, **FILTER)
    filter_.step(inputs(H, tension=3000.0))
    assert filter_["status"][1] == WILD
    assert filter_["tension"][0] < 100.0


def test_a_lost_end_is_found_again(unit):
    """After five refusals, from 60 m away."""
    filter_ = unit("estimator.tether", inputs(0.0), H, **LINE, **{**FILTER, "start_place": 8.0})
    true = PLACE - [40.0, 40.0, 20.0]
    statuses = []
    for k in range(1, 40):
        filter_.step(inputs(k * H, sight(true), k * H))
        statuses.append(filter_["status"][0])
    assert WILD in statuses
    assert statuses[-1] == USED
    assert filter_["end_b.position"] == pytest.approx(true, abs=2.0)
