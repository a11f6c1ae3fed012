"""Laws of drag found again from points of a towed rope, and told as confounded where the points cannot separate them.

The ropes are those of coverage.steady, which integrates eq. 9 of Bhattacharya et al. 2011 by DOP853; the fit has
quadratures of its own. Which laws share a shape is of shared/PAPERS.md: linear with c_V = c_S, quadratic across only,
isotropic.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pipeline.analysis.coverage.drag import ACROSS, EQUAL, LAWS, QUADRATIC, QUADRATIC_ACROSS, Drag
from pipeline.analysis.coverage.steady import shape, tow_at
from pipeline.analysis.drag.curve import between, curve_of, misses
from pipeline.analysis.drag.fit import FAMILIES, fit, judge
from pipeline.analysis.drag.pictures import Errors, Pictures
from pipeline.cli import main

SCENE = Path(__file__).parents[2] / "scenarios" / "boom_views.yaml"
LENGTH, POINTS = 18.288, 20
SHARED = {"linear", "quadratic, part by part", "quadratic, isotropic"}  # of one shape
SOME = Drag("", 1, 0.4)
ROPE = Drag("", 2, 0.2)


def seen(law, separations=(6.0, 10.0), speeds=(0.6, 1.2), count=3, noise=0.03, views=(0, 1), pull=0.0, errors=None):
    """Pictures of a law's steady rope from boats abeam, going north; the nearer 9 m of it; c v^p with c = 5."""
    rng = np.random.default_rng(5)
    errors = errors or Errors()
    bias = rng.normal(size=6) * errors.bias()
    rows = []
    for D, v in zip(separations, speeds, strict=True):
        line = LENGTH * shape(law, D / LENGTH, 2 * POINTS + 1)
        force = 5.0 * v**law.power * LENGTH * tow_at(law, D / LENGTH).force
        for _ in range(count):
            pose = np.array([[line[0, 1], line[0, 0], 0.1], [line[-1, 1], line[-1, 0], -0.2]])
            points, deviation = np.zeros((2, POINTS, 2)), np.full((2, POINTS), np.inf)
            for boat, (north, east, heading) in enumerate(pose):
                dn, de = line[1::2, 1] - north, line[1::2, 0] - east
                co, si = np.cos(heading), np.sin(heading)
                points[boat] = np.stack([co * dn + si * de, co * de - si * dn], axis=1)
                points[boat] += noise * rng.normal(size=(POINTS, 2))
                if boat in views:
                    deviation[boat, np.hypot(dn, de) < 9.0] = noise
            measured = pose - (bias + rng.normal(size=6) * errors.each()).reshape(2, 3)
            pulls = force * (1.0 + pull * rng.normal(size=2)) if pull else [np.nan, np.nan]
            rows.append((measured, v, points, deviation, pulls))
    pose, speed, points, deviation, pulls = (np.array(part) for part in zip(*rows, strict=True))
    return Pictures(LENGTH, pose, (0.0, 0.0), np.zeros(len(pose)), speed, points, deviation, pulls, pull)


def of(found, name):
    return next(one for one in found.fits if one.family.name == name)


@pytest.mark.parametrize("law", [*LAWS, SOME, ROPE], ids=lambda law: f"{law.power} {law.ratio:g}")
def test_lines_between_ends_are_those_integrated(law):
    """Also with one boat ahead: cut off the integrated line, between its own points."""
    line = shape(law, 0.45, 161)
    cut = line[20:] - line[20]
    length = (1.0 - 20 / 160) * 1.0
    for part, known in ((line - line[0], 1.0), (cut, length)):
        lines = between(curve_of(law), known, part[-1:, 0], part[-1:, 1])
        distance, _ = misses(lines, part[None, :, 0], part[None, :, 1])
        assert abs(distance).max() < 3e-8  # the table's 2e-8
    assert lines.tension()[0, 1] == pytest.approx(tow_at(law, 0.45).force, rel=1e-7)


@pytest.mark.parametrize(
    ("law", "allowed", "name", "ratio"),
    [
        (EQUAL, SHARED, "linear", 1.0),
        (QUADRATIC_ACROSS, SHARED, "quadratic, part by part", 0.0),
        (QUADRATIC, SHARED, "quadratic, isotropic", 1.0),
        (ACROSS, {"linear"}, "linear", 0.0),
        (SOME, {"linear"}, "linear", 0.4),
        (ROPE, {"quadratic, part by part"}, "quadratic, part by part", 0.2),
    ],
    ids=("equal", "quadratic across", "isotropic", "across", "0.4", "rope"),
)
def test_laws_of_one_shape_are_confounded_and_others_found(law, allowed, name, ratio):
    found = judge(seen(law), Errors())
    assert set(found.equal) == allowed
    assert found.fits_at_all
    assert of(found, name).low - 1e-6 <= ratio <= of(found, name).high + 1e-6
    assert of(found, name).high - of(found, name).low < 0.1


@pytest.mark.parametrize("law", [EQUAL, QUADRATIC_ACROSS, QUADRATIC], ids=("equal", "across", "isotropic"))
def test_pulls_at_two_speeds_and_separations_separate_them(law):
    """Load cells of 2 %: the true law alone is left, with its coefficient of 5."""
    found = judge(seen(law, pull=0.02), Errors())
    names = {EQUAL: "linear", QUADRATIC_ACROSS: "quadratic, part by part", QUADRATIC: "quadratic, isotropic"}
    assert found.equal == [names[law]]
    # The ratio is fitted beside: up to 0.05 in it is 2 % of the tension at the ends.
    assert found.fits[0].coefficient == pytest.approx(5.0, rel=0.03)


def test_pulls_at_one_speed_and_separation_do_not():
    found = judge(seen(EQUAL, separations=(8.0,), speeds=(0.8,), pull=0.02), Errors())
    assert set(found.equal) == SHARED


def test_a_nearly_straight_rope_tells_nothing():
    """D / L = 0.995: the sag of 0.04 L has the same shape for every law, to 3 cm."""
    found = judge(seen(SOME, separations=(0.995 * LENGTH,), speeds=(0.5,)), Errors())
    assert set(found.equal) == SHARED
    assert (of(found, "linear").low, of(found, "linear").high) == (0.0, 1.0)


def test_intervals_hold_the_truth_with_few_points_noise_one_boat_and_wrong_boats():
    """Each with wider intervals than the full data, the truth within; of one draw each, which is fixed."""
    full = of(judge(seen(SOME), Errors()), "linear")
    errors = Errors(0.05, 0.02, 0.1, 0.02)
    cases = [seen(SOME, count=1, views=(1,), separations=(8.0,), speeds=(0.8,)), seen(SOME, noise=0.5)]
    for pictures, wrong in [*((one, Errors()) for one in cases), (seen(SOME, errors=errors), errors)]:
        found = of(judge(pictures, wrong), "linear")
        assert found.low <= 0.4 <= found.high
        assert found.high - found.low > 1.1 * (full.high - full.low)


def test_boats_errors_that_are_not_told_are_a_misfit():
    """0.1 m and 1 degree of slow error against 3 cm points: nothing fits, and the intervals are widened."""
    found = judge(seen(SOME, errors=Errors(0.0, 0.0, 0.2, 0.04)), Errors())
    assert not found.fits_at_all
    assert found.scale > 2.0


def test_intervals_cover_as_often_as_they_say():
    """Twenty draws: 95 % of one freedom; 15 or fewer of 20 happen with a chance of 3e-3."""
    hits = 0
    rng = np.random.default_rng(11)
    clean = seen(SOME, count=2, separations=(8.0,), speeds=(0.8,))
    for _ in range(20):
        moved = clean.points + 0.1 * rng.normal(size=clean.points.shape)
        deviation = np.where(np.isfinite(clean.deviation), np.hypot(0.1, 0.03), np.inf)
        pictures = Pictures(LENGTH, clean.pose, (0.0, 0.0), clean.heading, clean.speed, moved, deviation, clean.pull)
        found = fit(pictures, Errors(), FAMILIES[0])
        hits += found.low <= 0.4 <= found.high
    assert hits > 15


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """The scene's log, run as a user does."""
    path = tmp_path_factory.mktemp("views") / "views.mcap"
    assert main(["run", str(SCENE), "--out", str(path), "--json"]) == 0
    return path


def found_in(log, capsys, *options):
    capsys.readouterr()
    assert main(["drag", str(log), "--json", *options]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_scene_is_confounded_until_pulls_are_known(log, capsys):
    """Quadratic across only, as the rope of 160 segments has it; k = rho d C_D / 2 = 11.43 N s^2/m^3."""
    found = found_in(log, capsys)
    assert found["confounded"]
    assert found["fits"]
    assert {one["law"] for one in found["laws"] if one["allowed"]} == SHARED
    # After one length of way, 18.3 m at 0.6 m/s and at 1.2 m/s.
    assert 40 < found["frames_used"] < 50
    found = found_in(log, capsys, "--pulls", "boom.force_a", "boom.force_b")
    allowed = [one for one in found["laws"] if one["allowed"]]
    assert [one["law"] for one in allowed] == ["quadratic, part by part"]
    assert allowed[0]["coefficient"] == pytest.approx(0.5 * 1000.0 * 1.2 * 0.01905, rel=5e-3)
    assert allowed[0]["ratio_high"] < 0.01


def test_one_view_is_enough_to_be_told_less(log, capsys):
    boats = ["--boat", "port.motion.position", "0 deg", "port_view"]
    boats += ["--boat", "starboard.motion.position", "0 deg", "-"]
    found = found_in(log, capsys, *boats, "--window", "0", "70")
    assert {one["law"] for one in found["laws"] if one["allowed"]} == SHARED
    assert found["points"] < 1500


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--window", "0", "20"], "none of 11 pictures is of a steady tow"),
        (["--window", "200", "300"], "no picture was taken from 200 to 300 s"),
        (["--length", "5"], "and the line is 5 m long"),
        (["--noise", "0"], "--noise: 0 is not above 0"),
        (["--noise", "2 kg"], "--noise: '2 kg'"),
        (["--pulls", "boom.force_c", "-"], "boom has no output 'force_c'; did you mean 'force_b'?"),
        (["--pulls", "boom.nodes", "-"], "boom.nodes is no signal of 1 or more numbers in N"),
        (["--boat", "a.b", "0", "port_view"], "--boat is given 1 times; expected twice"),
        (["--boat", "a.b", "0", "-", "--boat", "a.b", "0", "-"], "neither has a view"),
        (["--boat", "a.b", "0", "boom", "--boat", "a.b", "0", "-"], "boom is no view of a rope"),
        (["--boat", "a.b", "0", "port_view", "--boat", "a.b", "0", "-"], "has no channel a"),
        (["--drift", "1"], "--drift: '1' is no pair of numbers"),
        (["--hook", "a,b"], "--hook: 'a,b' is no pair of numbers"),
        (["--pose-error", "a", "1"], "--pose-error: a 1 are no two numbers"),
        (["--pose-bias", "-1", "1"], "expected two numbers that are not negative"),
        (["--pull-error", "0"], "--pull-error: 0 is not above 0"),
    ],
)
def test_what_does_not_fit_is_one_line(log, capsys, options, words):
    capsys.readouterr()
    assert main(["drag", str(log), *options]) == 1
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_a_log_without_views_is_refused(capsys):
    sample = Path(__file__).parents[2] / "logs" / "sample.mcap"
    assert main(["drag", str(sample)]) == 1
    assert "has 0 views of a rope" in capsys.readouterr().err
