"""The view of a rope from a boat: geometry by hand, a circle's points, the stated noise, the state alone."""

import numpy as np
import pytest
from scipy import stats

from components.markers.rope_view.component import COMPONENT
from components.markers.rope_view.model import RopeView

KIND = "markers.rope_view"
SEGMENTS = 40


def rope(nodes, north=0.0, east=0.0, heading=0.0):
    return np.array([*np.ravel(nodes), north, east, heading])


def straight():
    """A rope of 20 m to the south of the origin."""
    nodes = np.zeros((SEGMENTS + 1, 3))
    nodes[:, 0] = -np.linspace(0.0, 20.0, SEGMENTS + 1)
    return nodes


def test_points_stand_in_the_boats_frame(unit):
    # The boat lies 3 m east of the rope's middle and heads east: south is to starboard, the rope astern.
    view = unit(KIND, rope(straight(), -10.0, 3.0, 0.5 * np.pi), segments=SEGMENTS, points=4, farthest=50.0)
    assert view["points"] == pytest.approx(np.array([[-3.0, s] for s in (-7.5, -2.5, 2.5, 7.5)]), abs=1e-12)
    assert (view["valid"] == 1.0).all()


def test_only_what_is_in_range_and_sector_is_seen(unit):
    # From (0, 4 m east), heading north, camera 1 m astern: points at distance and bearing by hand.
    given = {"segments": SEGMENTS, "points": 200, "camera": (-1.0, 0.0), "nearest": 5.0, "farthest": 9.0}
    view = unit(KIND, rope(straight(), 0.0, 4.0, 0.0), field=np.deg2rad(100.0), **given)
    ahead = -(np.arange(200) + 0.5) / 200 * 20.0
    distance, bearing = np.hypot(ahead + 1.0, -4.0), np.degrees(np.arctan2(-4.0, ahead + 1.0)) % 360.0
    expected = (distance >= 5.0) & (distance <= 9.0) & (abs(bearing - 180.0) <= 50.0)
    assert expected.any()
    assert (view["valid"] == expected).all()
    assert (view["points"][~expected] == 0.0).all()
    # A middle of the sector to port sees the same as turning the boat, across the angle's wrap.
    turned = unit(KIND, rope(straight(), 0.0, 4.0, 0.0), bearing=np.deg2rad(-270.0), field=np.deg2rad(100.0), **given)
    bearing = np.degrees(np.arctan2(-4.0, ahead + 1.0))
    assert (turned["valid"] == ((distance >= 5.0) & (distance <= 9.0) & (abs(bearing - 90.0) <= 50.0))).all()


def test_points_lie_on_the_curve(unit):
    # On a half circle of 5 m, where the cubic is within h^4 / (24 R^3) of it in the outer cells.
    angle = np.linspace(0.0, np.pi, SEGMENTS + 1)
    nodes = np.stack([5.0 * np.cos(angle), 5.0 * np.sin(angle), 0.0 * angle], axis=1)
    view = unit(KIND, rope(nodes, 1.0, -2.0, 0.7), segments=SEGMENTS, points=77, farthest=50.0, field=2.0 * np.pi)
    co, si = np.cos(0.7), np.sin(0.7)
    world = view["points"] @ np.array([[co, si], [-si, co]]) + (1.0, -2.0)
    h = 5.0 * np.pi / SEGMENTS
    assert abs(np.hypot(*world.T) - 5.0).max() < h**4 / (24.0 * 5.0**3)


def test_noise_grows_with_the_distance_and_is_normal(unit):
    given = {"segments": SEGMENTS, "points": 20, "farthest": 50.0, "field": 2.0 * np.pi}
    u = rope(straight(), 0.0, 4.0, 0.3)
    exact = unit(KIND, u, **given)["points"]
    view = unit(KIND, u, noise=0.03, noise_per_range=0.01, **given)
    seen = np.array([view.step(u)["points"] for _ in range(400)])
    deviation = np.hypot(0.03, 0.01 * np.hypot(*exact.T))[:, None]
    z = (seen - exact) / deviation
    assert stats.kstest(z.ravel(), "norm").pvalue > 1e-3
    following = np.mean(z[1:] * z[:-1], axis=0)
    assert abs(following).max() < 4.0 / np.sqrt(400)
    assert abs(np.corrcoef(z.reshape(400, -1).T)[np.triu_indices(40, 1)]).max() < 4.5 / np.sqrt(400)


def test_goes_on_from_its_state_alone(unit):
    given = {"segments": SEGMENTS, "points": 20, "farthest": 50.0, "noise": 0.03}
    u = rope(straight(), 0.0, 4.0, 0.3)
    view, other = unit(KIND, u, **given), unit(KIND, u, **given)
    for _ in range(3):
        view.step(u)
    other.x[:], other.t = view.x, view.t
    assert view.step(u).y.tobytes() == other.step(u).y.tobytes()
    assert unit(KIND, u, seed=8, **given).y.tobytes() != unit(KIND, u, **given).y.tobytes()


def test_what_sees_nothing_is_refused():
    with pytest.raises(ValueError, match=r"nearest is 9 m, farthest 9 m: nothing would be seen"):
        RopeView(segments=SEGMENTS, nearest=9.0, farthest=9.0)
    assert [term.name for term in COMPONENT.terms(RopeView(segments=SEGMENTS, farthest=9.0)) if term.on] == []
