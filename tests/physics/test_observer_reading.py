"""What observers do with each value of an instrument: lever arms, delays, faults, wrapping, wind."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

SHIP = {
    "surge_mass": 6.7644e6, "sway_mass": 1.1341e7, "sway_yaw_mass": -3.4016e7, "yaw_inertia": 4.4524e9,
    "surge_damping": 7.7071e4, "sway_damping": 2.5468e5, "sway_yaw_damping": -2.0342e6, "yaw_sway_damping": -6.7258e5,
    "yaw_damping": 3.8501e8, "wave_period": 8.0, "takes_thrust": False,
}  # fmt: skip
FILTER = {
    "heading_noise": 0.002, "disturbance_force": 3e4, "disturbance_moment": 6e5, "slow_force": 1.5e5,
    "slow_moment": 3e6, "wave_motion": 0.3, "wave_turn": 0.006,
}  # fmt: skip
GNSS = ({"kind": "gnss", "noise": 0.3},)
WINDAGE = {"frontal_area": 310.0, "lateral_area": 570.0, "length": 82.0, "centroid": 8.0, "cross": 0.9, "ahead": 0.55,
           "astern": 0.8, "shape": 0.55}  # fmt: skip
USED, SAME, LOST, FROZEN, WILD = range(5)
BOTH = pytest.mark.parametrize("kind", ["kalman", "passive"])


@pytest.fixture
def observer(unit):
    """`observer(kind, u, **parameters)`."""

    def make(kind, u, h=0.1, **parameters):
        own = {"references": GNSS, **SHIP, **(FILTER if kind == "kalman" else {}), **parameters}
        return unit(f"observer.{kind}", u, h, **own)

    return make


def fix(north, east, heading, t, t_fix=None, valid=1.0):
    return [north, east, 0.0, valid, t if t_fix is None else t_fix, heading, 1.0, t]


@BOTH
def test_lever_arms_and_tilt(observer, kind):
    """A receiver on the mast and a transponder on the bed, in a hull that rolls: scipy's rotation, exactly."""
    roll, pitch, heading = 0.1, -0.06, 2.0
    turn = Rotation.from_euler("ZYX", (heading, pitch, roll)).as_matrix()
    at, arm, below, bed = np.array([30.0, -20.0, 0]), np.array([5.0, 2, -22]), np.array([1.0, -3, 8]), [90.0, 10, 180]
    antenna, offset = at + turn @ arm, turn.T @ (bed - at) - below
    gnss = {"kind": "gnss", "place": tuple(arm), "noise": 0.3}
    usbl = {"kind": "hydroacoustic", "place": tuple(below), "transponder": tuple(bed), "noise": 0.5}
    for reference, value in ((gnss, antenna), (usbl, offset)):
        u = [*value, 1.0, 0.0, heading, 1.0, 0.0, roll, pitch, 1.0]
        seen = observer(kind, u, references=(reference,), takes_mru=True)
        assert seen["estimate.position"] == pytest.approx(at[:2], abs=1e-9)
        assert seen["estimate.heading"] == pytest.approx(heading)


@BOTH
def test_late_values_are_of_their_time(observer, kind):
    """A hull that rolls by 5 degrees, its antenna 22 m up, positions 2 s late: without its memory 1.9 m of error."""

    def motion(t):
        roll = radians(5.0) * sin(2 * pi * t / 9.0)
        return roll, 22.0 * sin(roll)

    rng, errors = np.random.default_rng(2), []
    reference = ({"kind": "gnss", "place": (0.0, 0.0, -22.0), "noise": 0.1},)
    seen = observer(kind, [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1], references=reference, takes_mru=True)
    for k in range(1, 1500):
        t = 0.1 * k
        late = np.floor(t) - 2.0
        east = motion(late)[1] if late >= 0 else 0.0
        value = [rng.normal(0, 0.1), east + rng.normal(0, 0.1), 0.0, float(late >= 0), late]
        seen.step([*value, rng.normal(0, 0.002), 1.0, t, motion(t)[0], 0.0, 1.0])
        errors.append(seen["estimate.position"])
    assert np.std(errors[300:], axis=0).max() < 0.15


@BOTH
def test_steady_speed_and_late_positions(observer, kind):
    """1 m/s north, positions 3 s late: the estimate is where the vessel is, not where it was.

    The slow load that stands for 77 kN of drag leaks by a thousandth each second, which the passive observer makes up
    by 2 % of the speed: 0.06 m in 3 s.
    """
    rng = np.random.default_rng(4)
    seen = observer(kind, fix(0, 0, 0, 0), slow_force=1e6) if kind == "kalman" else observer(kind, fix(0, 0, 0, 0))
    errors = []
    for k in range(1, 6000):
        t = 0.1 * k
        late = np.floor(t) - 3.0
        seen.step([late + rng.normal(0, 0.1), rng.normal(0, 0.1), 0, 1, late, rng.normal(0, 0.002), 1, t])
        errors.append(seen["estimate.position"] - [t, 0.0])
    assert np.mean(errors[3000:], axis=0) == pytest.approx([0.0, 0.0], abs=0.2)
    assert seen["estimate.velocity"] == pytest.approx([1.0, 0.0], abs=0.1)


@BOTH
def test_each_fault_is_told_and_none_is_used(observer, kind):
    """No value, a number that is none, an old one, the same one, a frozen one, a wild one."""
    rng = np.random.default_rng(6)
    seen = observer(kind, fix(0, 0, 0.5, 0))
    for k in range(1, 600):
        seen.step(fix(*rng.normal(0, 0.1, 2), 0.5 + rng.normal(0, 0.002), 0.1 * k, np.floor(0.1 * k)))
    place = seen["estimate.position"]
    t = seen.seconds
    faults = {
        "not valid": (fix(500, 0, 0.5, t + 0.1, valid=0.0), LOST),
        "no number": (fix(np.nan, 0, 0.5, t + 0.2), LOST),
        "infinite": (fix(0, np.inf, 0.5, t + 0.3), LOST),
        "no time": (fix(0, 0, 0.5, t + 0.4, np.nan), LOST),
        "old": (fix(500, 0, 0.5, t + 0.5, t - 20.0), LOST),
        "wild": (fix(500, 0, 0.5, t + 0.6), WILD),
        "same": (fix(500, 0, 0.5, t + 0.7, t + 0.6), SAME),
    }
    for name, (u, status) in faults.items():
        seen.step(u)
        assert seen["status.references"] == status, name
        assert seen["estimate.position"] == pytest.approx(place, abs=0.2), name
    assert seen["innovation.references"] == pytest.approx(np.zeros((1, 2)))


@BOTH
def test_frozen_receiver_is_not_followed(observer, kind):
    """A receiver repeats its value with new times while the vessel drifts 20 m: two are used, then none."""
    rng = np.random.default_rng(8)
    seen = observer(kind, fix(0, 0, 0, 0))
    for k in range(1, 300):
        seen.step(fix(*rng.normal(0, 0.1, 2), rng.normal(0, 0.002), 0.1 * k))
    states = []
    for k in range(300, 320):
        seen.step(fix(0.05, 0.05, rng.normal(0, 0.002), 0.1 * k))
        states.append(int(seen["status.references"][0]))
    assert states == [USED, USED] + [FROZEN] * 18
    seen.step(fix(0.06, 0.05, 0.0, 32.0))
    assert seen["status.references"] == USED


@BOTH
def test_heading_is_continuous_over_south(observer, kind):
    """A turn through 180 degrees, where the compass jumps by a whole turn."""
    rng, rate = np.random.default_rng(9), radians(0.5)
    seen = observer(kind, fix(0, 0, 3.0, 0))
    last = 3.0
    for k in range(1, 1000):
        heading = 3.0 + rate * 0.1 * k
        wrapped = (heading + pi) % (2 * pi) - pi
        seen.step(fix(*rng.normal(0, 0.1, 2), wrapped + rng.normal(0, 0.002), 0.1 * k))
        assert abs(seen["estimate.heading"] - last) < 0.05
        last = seen["estimate.heading"].item()
    assert last == pytest.approx(heading, abs=0.02)


@BOTH
def test_first_position_may_come_late_and_far_away(observer, kind):
    """The first fix comes after 20 s, 5 km from where the parameters say, and is taken."""
    rng = np.random.default_rng(10)
    seen = observer(kind, [0, 0, 0, 0, 0, 0, 0, 0])
    for _ in range(200):
        seen.step([0, 0, 0, 0, 0, 0, 0, 0])
        assert seen["status.references"] == LOST
    for k in range(201, 900):
        seen.step(fix(5000 + rng.normal(0, 0.1), -3000 + rng.normal(0, 0.1), 1.0 + rng.normal(0, 0.002), 0.1 * k))
        assert seen["status.references"] == USED
    assert seen["estimate.position"] == pytest.approx([5000, -3000], abs=0.3)


@BOTH
def test_wind_load(observer, kind):
    """A steady wind of 15 m/s from 50 degrees off the bow: Blendermann's formulas; then the anemometer is lost."""
    u = [*fix(0, 0, 0, 0), 15.0, radians(50.0), 1.0]
    seen = observer(kind, u, windage=WINDAGE, wind_time=5.0, air_density=1.25)
    c, s = cos(radians(50.0)), sin(radians(50.0))
    q, double = 0.5 * 1.25 * 15.0**2, 2 * s * c
    shape = 1 - 0.5 * 0.55 * (1 - 0.55 * 310 / 570 / 0.9) * double**2
    surge, sway = -q * 310 * 0.55 * c / shape, q * 570 * 0.9 * s / shape
    # Wind from starboard pushes to port.
    assert seen["wind_load.force"] == pytest.approx([surge, -sway])
    assert seen["wind_load.moment"] == pytest.approx(-(8.0 - 0.18 * 82.0 * (radians(50.0) - pi / 2)) * sway)
    before = seen["wind_load.force"]
    seen.step([*fix(0, 0, 0, 0.1), 0.0, 0.0, 0.0])
    assert seen["wind_load.force"] == pytest.approx(before)
    seen.step([*fix(0, 0, 0, 0.2), 0.0, 0.0, 1.0])
    assert seen["wind_load.force"] == pytest.approx(before * np.exp(-0.1 / 5.0))


def test_passive_observer_is_a_notch(unit):
    """Position to estimate as Fossen and Strand's transfer function says, at frequencies about that of the waves.

    Velocity and slow load hardly follow: their gains are set to nearly nothing. 20 samples a second: 2 %.
    """
    omega0, zeta, wide, cut = 2 * pi / 8.0, 0.1, 1.0, 1.22 * 2 * pi / 8.0
    for ratio in (0.3, 1.0, 2.0):
        omega = ratio * omega0
        parameters = {**SHIP, "velocity_gain": (1e-6,) * 3, "wave_damping": zeta, "gate": 1e3}
        seen = unit("observer.passive", fix(0, 0, 0, 0), 0.05, references=GNSS, **parameters)
        found = []
        steps = round(30 * 2 * pi / omega / 0.05)
        for k in range(1, steps):
            t = 0.05 * k
            seen.step(fix(sin(omega * t), 0.0, 1e-9 * (k % 2), t))
            found.append(seen["estimate.position"][0])
        late = np.arange(1, steps)[steps // 2 :] * 0.05
        basis = np.column_stack([np.sin(omega * late), np.cos(omega * late)])
        amplitude = np.hypot(*np.linalg.lstsq(basis, np.array(found)[steps // 2 :], rcond=None)[0])
        s = 1j * omega
        notch = (
            cut * (s**2 + 2 * zeta * omega0 * s + omega0**2) / ((s**2 + 2 * wide * omega0 * s + omega0**2) * (s + cut))
        )
        assert amplitude == pytest.approx(abs(notch), abs=0.02), ratio


@pytest.mark.parametrize("gap", [1, 10, 20, 100])
def test_passive_observer_is_stable_at_any_rate(observer, gap):
    """Positions 0.1 to 10 s apart, first 5 m off: the estimate settles."""
    seen = observer("passive", fix(0, 0, 0.7, 0))
    for k in range(1, 8000):
        t = 0.1 * k
        seen.step(fix(5.0 + 1e-6 * k, -3.0, 0.7 + 1e-9 * k, t, k // gap * gap * 0.1))
    assert seen["estimate.position"] == pytest.approx([5.008, -3.0], abs=0.02)
    assert seen["estimate.velocity"] == pytest.approx([0.0, 0.0], abs=1e-3)


@BOTH
def test_garbage_is_not_reckoned_with(observer, kind):
    """A time to come, which would be used for ever after, and numbers whose squares are none, as first and later."""
    rng = np.random.default_rng(11)
    seen = observer(kind, fix(1e200, 0, 1e200, 0))
    assert seen["status.references"] == LOST
    assert seen["status.compass"] == LOST
    for k in range(1, 300):
        seen.step(fix(*rng.normal(0, 0.1, 2), rng.normal(0, 0.002), 0.1 * k))
    for k in range(300, 310):
        seen.step(fix(3.0, 0.0, 0.1, 0.1 * k, 0.1 * k + 3.0))
        assert seen["status.references"] == LOST
    seen.step(fix(-1e200, 1e200, 1e200, 31.0))
    assert seen["status.references"] == LOST
    assert seen["status.compass"] == LOST


@BOTH
def test_wrong_first_position_is_given_up(observer, kind):
    """The very first position is wild by 500 m: after 30 s of others the estimate begins anew, one wild one apart."""
    rng = np.random.default_rng(12)
    seen = observer(kind, fix(500, 0, 0, 0), believed_after=30.0)
    for k in range(1, 600):
        place = [-900.0, 400.0] if k == 150 else rng.normal(0, 0.1, 2)
        seen.step(fix(*place, rng.normal(0, 0.002), 0.1 * k))
        assert seen["status.references"] == (WILD if k <= 300 else USED)
    assert seen["estimate.position"] == pytest.approx([0.0, 0.0], abs=0.3)


@BOTH
def test_another_reference_keeps_a_jump_out(observer, kind):
    """One of two references jumps by 40 m for two minutes: it stays wild, however long, while the other is used."""
    rng = np.random.default_rng(13)
    seen = observer(kind, [0, 0, 0, 1, 0, *fix(0, 0, 0, 0)], references=GNSS * 2, believed_after=30.0)
    for k in range(1, 1800):
        t, jump = 0.1 * k, 40.0 if k > 600 else 0.0
        first = [jump + rng.normal(0, 0.1), rng.normal(0, 0.1), 0, 1, np.floor(t)]
        seen.step([*first, *fix(*rng.normal(0, 0.1, 2), rng.normal(0, 0.002), t, np.floor(t))])
        if k > 601:
            assert seen["status.references"][0] in (WILD, SAME)
    assert seen["estimate.position"] == pytest.approx([0.0, 0.0], abs=0.3)


@BOTH
@pytest.mark.parametrize("jump", [1.0, pi])
def test_compass_that_was_set_anew_is_believed(observer, kind, jump):
    """It jumps and stays there: after 30 s the heading is as it says, whichever way round."""
    rng = np.random.default_rng(14)
    seen = observer(kind, fix(0, 0, 0, 0), believed_after=30.0)
    for k in range(1, 1200):
        heading = rng.normal(0, 0.002) + (jump if k > 300 else 0.0)
        seen.step(fix(*rng.normal(0, 0.1, 2), heading, 0.1 * k))
        assert k == 601 or seen["status.compass"] == (WILD if 300 < k <= 600 else USED)  # 601: 30 s, rounded
    assert cos(seen["estimate.heading"] - jump) > 0.9999
    assert seen["estimate.position"] == pytest.approx([0.0, 0.0], abs=0.3)


@BOTH
def test_compass_that_comes_late(observer, kind):
    """An antenna 60 m ahead, the compass 5 s late at 2.5 rad: positions until then were turned wrongly, by 114 m."""
    rng = np.random.default_rng(15)
    reference = ({"kind": "gnss", "place": (60.0, 0.0, 0.0), "noise": 0.1},)
    antenna = 60.0 * np.array([cos(2.5), sin(2.5)])
    seen = observer(kind, [*antenna, 0, 1, 0, 0, 0, 0], references=reference)
    for k in range(1, 400):
        compass = [2.5 + rng.normal(0, 0.002), 1.0, 0.1 * k] if k > 50 else [0.0, 0.0, 0.0]
        seen.step([*(antenna + rng.normal(0, 0.1, 2)), 0, 1, 0.1 * k, *compass])
        assert seen["status.references"] == USED
    assert seen["estimate.position"] == pytest.approx([0.0, 0.0], abs=0.3)


@BOTH
@pytest.mark.parametrize("h", [0.05, 1.0, 5.0])
def test_small_vessel_at_any_step(observer, kind, h):
    """CyberShip II, 24 kg, whose yaw decays in 1.4 s: a push of 1 N ends at 1 N / X_u, whatever the step.

    In steps of 5 s the undivided midpoint rule grew without bound.
    """
    small = {
        "surge_mass": 25.8, "sway_mass": 33.8, "sway_yaw_mass": 1.0948, "yaw_inertia": 2.76, "surge_damping": 0.72253,
        "sway_damping": 0.88965, "sway_yaw_damping": 7.25, "yaw_sway_damping": -0.0313, "yaw_damping": 1.9,
        "takes_thrust": True, "wave_period": 0.8,
    }  # fmt: skip
    drives = {"disturbance_force": 0.1, "disturbance_moment": 0.02, "slow_force": 0.5, "slow_moment": 0.1}
    lost = [*[0.0] * 8, 1.0, 0.0, 0.0]
    seen = observer(kind, lost, h, **small, **(drives if kind == "kalman" else {}))
    for _ in range(round(400 / h)):
        seen.step(lost)
    assert seen["estimate.velocity"] == pytest.approx([1.0 / 0.72253, 0.0], rel=1e-3, abs=1e-9)
    assert seen["estimate.position"][0] == pytest.approx((400.0 - 25.8 / 0.72253) / 0.72253, rel=0.01)


def test_late_positions_in_short_waves(observer):
    """5 s are six periods of 0.8 s: the wave then is nearly as it is, unknown, and does not count more than its size.

    Taken back by the inverse of its transition it grew twentyfold, and NIS was 0.09 instead of 2.
    """
    rng = np.random.default_rng(16)
    small = {"surge_mass": 25.8, "sway_mass": 33.8, "yaw_inertia": 2.76, "sway_yaw_mass": 0.0, "surge_damping": 0.72,
             "sway_damping": 0.89, "sway_yaw_damping": 0.0, "yaw_sway_damping": 0.0, "yaw_damping": 1.9,
             "wave_period": 0.8, "disturbance_force": 0.1, "disturbance_moment": 0.02, "slow_force": 0.5,
             "slow_moment": 0.1, "wave_motion": 0.01}  # fmt: skip
    seen = observer("kalman", fix(0, 0, 0, 0), references=({"kind": "gnss", "noise": 0.02},), **small)
    errors, nis = [], []
    for k in range(1, 2000):
        t, late = 0.1 * k, 0.1 * k - 5.0
        place = 0.5 * sin(2 * pi * late / 60.0) + rng.normal(0, 0.02)
        seen.step([place, rng.normal(0, 0.02), 0, float(late > 0), late, rng.normal(0, 0.002), 1, t])
        errors.append(seen["estimate.position"][0] - 0.5 * sin(2 * pi * t / 60.0))
        nis.append(seen["nis.references"].item())
    assert 1.0 < np.mean(nis[800:]) < 2.5
    assert np.std(errors[800:]) < 0.12
