"""Coverage by a towed line: closed forms, global balances, and areas that are known, or counted point by point."""

from __future__ import annotations

import json
from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np
import pytest
import shapely
from scipy.integrate import simpson
from scipy.optimize import brentq

from pipeline.analysis.coverage import exact
from pipeline.analysis.coverage.boats import Boat, speed
from pipeline.analysis.coverage.drag import ACROSS, EQUAL, LAWS, QUADRATIC, QUADRATIC_ACROSS, Drag
from pipeline.analysis.coverage.optimum import optimum, rate
from pipeline.analysis.coverage.patch import capture, patch_of
from pipeline.analysis.coverage.steady import shape, tow, tow_at
from pipeline.analysis.coverage.swept import area, swept
from pipeline.cli import main
from pipeline.log.reader import open_log

ROOT = Path(__file__).parents[2]
SAMPLE = str(ROOT / "logs" / "sample.mcap")
# Of Bhattacharya et al. 2011, section V: a rope of 18.288 m, separations of the trials.
ROPE, SEPARATIONS = 18.288, (4.0, 6.0, 8.0, 10.0, 12.0)
# D/L and rate of each law's optimum, as the errata of that paper and issue 8 give them.
PUBLISHED = {EQUAL: (0.7951, 1.3255), QUADRATIC_ACROSS: (0.5768, 1.4864), QUADRATIC: (0.8621, None)}


@pytest.mark.parametrize("drag", LAWS, ids=lambda drag: drag.name)
def test_optimum_of_equation_26(drag):
    """By integration, against the closed form: to the root of its own 1e-11, for the rate is flat there."""
    found, expected = optimum(drag), exact.optimum(drag)
    if drag == ACROSS:
        assert found is None
        assert expected is None
        return
    assert found.separation == pytest.approx(expected.separation, abs=1e-5)
    assert found.rate == pytest.approx(expected.rate, rel=1e-9)
    separation, best = PUBLISHED[drag]
    assert found.separation == pytest.approx(separation, abs=1e-4)
    assert best is None or found.rate == pytest.approx(best, abs=1e-4)


def test_without_drag_along_less_separation_always_sweeps_more():
    """Linear, c_V = 0: the rate falls with D/L all the way, from pi f/c on."""
    tows = [tow(ACROSS, apex) for apex in np.geomspace(0.03, 4.0, 40)]
    rates = np.array([rate(ACROSS, one) for one in tows])
    assert (np.diff([one.separation for one in tows]) > 0.0).all()
    assert (np.diff(rates) < 0.0).all()
    assert rates[0] == pytest.approx(pi, abs=1e-6)


@pytest.mark.parametrize("separation", [0.05, 0.8, 0.9999])
@pytest.mark.parametrize("drag", LAWS, ids=lambda drag: drag.name)
def test_force_and_angle_are_the_closed_form(drag, separation):
    """Integrated to 1e-11; taut, 1 - D/L is known to 1e-10 of itself, and so is the force."""
    found, expected = tow_at(drag, separation), exact.tow(drag, exact.u_at(drag, separation))
    assert found.force == pytest.approx(expected.force, rel=1e-7)
    assert found.angle == pytest.approx(expected.angle, abs=1e-8)


def test_shapes_of_the_trials_are_catenaries():
    """Figure 7a at all five separations of the trials: y = a (cosh(x/a) - 1); speed and c do not matter."""
    for D in SEPARATIONS:
        line = ROPE * shape(EQUAL, D / ROPE, 41)
        a = brentq(lambda a, D=D: 2.0 * a * np.sinh(0.5 * D / a) - ROPE, 0.2, 100.0, xtol=1e-13)
        assert line[-1, 0] - line[0, 0] == pytest.approx(D, abs=1e-9)
        assert np.abs(line[:, 1] - a * (np.cosh(line[:, 0] / a) - 1.0)).max() < 1e-8
        assert line[20] == pytest.approx([0.0, 0.0], abs=0)


@pytest.mark.parametrize("drag", [Drag("", 1, 0.4), Drag("", 2, 0.03), Drag("", 2, 0.5)], ids=["1", "2", "2b"])
def test_boats_pull_what_the_water_resists(drag):
    """A balance of the whole line, for laws without a closed form: both boats' pull ahead is the drag along the tow.

    The drag by Simpson's rule over 2001 points of the shape, whose angles are differences: 1e-6.
    """
    one, line = tow_at(drag, 0.6), shape(drag, 0.6, 2001)
    phi = np.arctan2(*np.gradient(line, 1.0 / 2000, axis=0, edge_order=2).T[::-1])
    v_n, v_t = np.cos(phi), np.sin(phi)
    across, along = (np.abs(v) ** (drag.power - 1) * v for v in (v_n, v_t))
    resisted = simpson(across * v_n + drag.ratio * along * v_t, dx=1.0 / 2000)
    assert 2.0 * one.force * np.sin(one.angle) == pytest.approx(resisted, rel=1e-5)


def test_laws_and_separations_that_are_none():
    for wrong in ({"power": 3, "ratio": 1.0}, {"power": 1, "ratio": -0.1}, {"power": 1, "ratio": 1.1}):
        with pytest.raises(ValueError, match="expected"):
            Drag("", **wrong)
    with pytest.raises(ValueError, match="isotropic"):
        Drag("", 2, 0.5, is_isotropic=True)
    for separation in (0.0, -0.5, 1.0, 1.5):
        with pytest.raises(ValueError, match="separation"):
            tow_at(EQUAL, separation)


def test_boats_are_as_fast_as_their_thrust_allows():
    """Constant thrust, no hull: (26); with a hull and falling thrust a balance of forces; never above `fastest`."""
    best = exact.optimum(EQUAL)
    one = tow_at(EQUAL, best.separation)
    bare = Boat(lambda v: 7.0, lambda v: 0.0, 1e6)
    assert 12.0 * best.separation * speed(bare, EQUAL, 3.0, 12.0, one) == pytest.approx(best.rate * 7.0 / 3.0, rel=1e-9)
    boat = Boat(lambda v: 60.0 - 20.0 * v, lambda v: 6.0 * v * v, 1.5)
    v = speed(boat, QUADRATIC_ACROSS, 11.0, 18.0, one)
    pull = 11.0 * v * v * 18.0 * one.force * np.array([np.cos(one.angle), np.sin(one.angle)])
    assert np.hypot(pull[0], pull[1] + 6.0 * v * v) == pytest.approx(60.0 - 20.0 * v, rel=1e-9)
    assert speed(boat, EQUAL, 1e-6, 18.0, one) == 1.5


def straight(way, width=2.0, parts=4):
    """A straight line across, moved by way (k,) to the north."""
    across = np.linspace(0.0, width, parts + 1)
    return np.stack([np.repeat(way[:, None], parts + 1, 1), np.repeat(across[None], len(way), 0)], axis=2)


def test_areas_that_are_known():
    """A way ahead, to and fro, at rest, and a turn in 720 steps about an end and half a one about the middle."""
    assert area(straight(np.linspace(0.0, 5.0, 11))) == pytest.approx(10.0, rel=1e-14)
    assert area(straight(np.array([0.0, 5.0, 1.0, 4.0, -1.0]))) == pytest.approx(12.0, rel=1e-14)
    assert area(straight(np.zeros(5))) == 0.0
    angle = np.linspace(0.0, 2.0 * pi, 721)
    spoke = np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, None]
    polygon = 360.0 * np.sin(2.0 * pi / 720)  # of 720 corners, inscribed
    assert area(spoke * np.array([0.0, 0.5, 1.0])[:, None]) == pytest.approx(polygon, rel=1e-12)
    assert area(spoke[:361] * np.array([-1.0, -0.3, 0.3, 1.0])[:, None]) == pytest.approx(polygon, rel=1e-12)


def test_union_is_every_point_that_a_part_went_over():
    """Lines that fold, cross themselves and come back, against points counted by crossings of each quadrilateral."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        shapes = np.cumsum(rng.normal(size=(7, 5, 2)), axis=1) + np.cumsum(rng.normal(size=(7, 1, 2)), axis=0)
        found = swept(shapes)
        points = rng.uniform(shapes.min(axis=(0, 1)), shapes.max(axis=(0, 1)), size=(400, 2))
        inside = np.zeros(400, bool)
        for a, b in pairwise(shapes):
            for j in range(4):
                ring = np.array([a[j], a[j + 1], b[j + 1], b[j]])
                inside |= _inside(ring, points)
        assert np.array_equal(shapely.contains_xy(found, *points.T), inside)


def _inside(ring, points):
    """By an odd count of edges that a ray to +x crosses."""
    odd = np.zeros(len(points), bool)
    for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        above = (y0 > points[:, 1]) != (y1 > points[:, 1])
        odd ^= above & (points[:, 0] < x0 + (points[:, 1] - y0) * (x1 - x0) / (y1 - y0))
    return odd


def test_patch_is_taken_as_far_as_the_line_goes_over_it():
    t = np.linspace(0.0, 10.0, 101)
    shapes = straight(0.5 * t)
    half = capture(patch_of([(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)]), t, shapes)
    assert half.area == 4.0
    assert half.captured == pytest.approx(2.0, rel=1e-12)
    assert half.first == pytest.approx(2.1)
    assert half.last == pytest.approx(6.0)
    # Over time: 0.5 m/s by a metre's width, from 2 s on, at the end of each step.
    assert half.at(np.array([0.0, 2.0, 3.0, 5.5, 6.0, 9.0])) == pytest.approx([0.0, 0.0, 0.5, 1.75, 2.0, 2.0])
    missed = capture(patch_of([(6.0, 0.0), (7.0, 0.0), (7.0, 1.0)]), t, shapes)
    assert (missed.captured, missed.first, missed.last) == (0.0, None, None)
    assert missed.at(t).max() == 0.0


def told(arguments, capsys):
    code = main(["coverage", SAMPLE, *arguments, "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_command_measures_a_log(capsys):
    """The sample's chain: as its union; in water that goes with the hand's mean velocity it sweeps otherwise."""
    with open_log(SAMPLE) as log:
        nodes = log.port("tether", "nodes")[:, :, :2]
        ends = [log.port(name, "motion.position")[:, :2] for name in ("wall", "hand")]
    code, found = told(["--patch", "0,-1", "3,-1", "3,1", "0,1"], capsys)
    assert code == 0
    assert found["swept_m2"] == pytest.approx(area(nodes), rel=1e-12)
    assert found["captured_m2"] == pytest.approx(found["swept_m2"], rel=1e-6)
    assert found["captured"] == pytest.approx(found["swept_m2"] / 6.0, rel=1e-6)
    assert found["swept_by_mouth_m2"] == pytest.approx(area(nodes[:, [0, -1]]), rel=1e-12)
    code, between = told(["--between", "wall.motion.position", "hand.motion.position"], capsys)
    assert between["swept_m2"] == pytest.approx(area(np.stack(ends, axis=1)), rel=1e-12)
    code, drifting = told(["--drift", "0,-1"], capsys)
    assert drifting["swept_m2"] == pytest.approx(3.0 * found["separation_m"], rel=0.05)
    assert main(["coverage", SAMPLE, "--patch", "0,-1", "3,-1", "3,1"]) == 0
    assert "of the patch's 3 m²" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--line", "hand"], "has no port nodes"),
        (["--line", "boom"], "no channel boom"),
        (["--between", "hand", "wall"], "has no port position"),
        (["--between", "tether.tension", "wall.motion.position"], "is no position"),
        (["--drift", "1"], "expected such as 12.5,-3"),
        (["--drift", "nan,0"], "is not finite"),
        (["--patch", "0,0", "1,0"], "three at least"),
        (["--patch", "0,0", "1,0", "0,1", "1,1"], "give corners in turn"),
    ],
)
def test_command_says_what_is_wrong(arguments, told, capsys):
    assert main(["coverage", SAMPLE, *arguments]) == 1
    assert told in capsys.readouterr().err
