"""Sensors against the truth they measure, the statistics they state, and each fault of theirs."""

from __future__ import annotations

import ctypes
import importlib
from math import exp, pi, sqrt

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from components.compiled import bind

FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
KINDS = ("gnss", "gyro", "mru", "hydroacoustic", "wind", "thruster_feedback", "load_cell")
ATTITUDE = (0.05, -0.03, 2.0)


class Instrument:
    """A sensor outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, kind, u, h=1.0, seed=7, **parameters):
        self.component = importlib.import_module(f"components.sensors.{kind}.component").COMPONENT
        self.parameters, self.seed = self.component.parameters(**parameters), seed
        self.p, self.h, self.t = self.component.pack(self.parameters, seed), round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.zeros(int(n)) for n in self.p[1:5])
        entries = bind(self.component)
        self._init, self._step = FUNCTION(entries.init), FUNCTION(entries.step)
        self._call(self._init, u)

    def _call(self, function, u):
        self.y[:] = self.w[:] = np.nan
        self.u[:] = u
        vectors = (self.p, self.u, self.x, self.y, self.w)
        assert function(self.t, self.h, *[vector.ctypes.data for vector in vectors]) == 0
        assert np.isfinite(self.y).all()
        assert np.isfinite(self.x).all()

    def step(self, u=None):
        self.t += self.h
        self._call(self._step, self.u.copy() if u is None else u)
        return self

    def set(self, **more):
        self.parameters = self.parameters.model_copy(update=more)
        self.p = self.component.pack(self.parameters, self.seed)

    def record(self, name, steps):
        return np.array([self.step()[name] for _ in range(steps)])

    def __getitem__(self, name):
        k = 0
        for port in self.component.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)


def gnss(**parameters):
    return Instrument("gnss", (100.0, -50.0, 2.0, 0.0, 0.0, 0.0), **parameters)


def turn():
    return Rotation.from_euler("ZYX", ATTITUDE[::-1]).as_matrix()


def test_antenna_moves_with_the_vessel():
    """scipy's rotation by yaw, pitch and roll."""
    arm = np.array([3.0, -2.0, -15.0])
    seen = Instrument("gnss", (10.0, 20.0, 1.0, *ATTITUDE), antenna=tuple(arm))
    assert seen["position"] == pytest.approx(np.array([10.0, 20.0, 1.0]) + turn() @ arm)
    assert seen["valid"] == 1.0


def test_transponder_is_where_it_is_seen():
    """The vector from transceiver to transponder in the hull's frame, by scipy's rotation; the range is its length."""
    at, arm, target = np.array([10.0, 20.0, 1.0]), np.array([5.0, 1.0, 6.0]), np.array([40.0, -10.0, 120.0])
    seen = Instrument("hydroacoustic", (*at, *ATTITUDE, *target), transceiver=tuple(arm))
    true = turn().T @ (target - at) - arm
    assert seen["offset"] == pytest.approx(true)
    assert seen["range"] == pytest.approx(np.linalg.norm(true))
    assert (seen["along"], seen["across"]) == pytest.approx(tuple(np.arcsin(true[:2] / np.linalg.norm(true))))
    seen.set(max_range=50.0)
    assert seen.step()["valid"] == 0.0
    assert not seen["offset"].any()


def test_wind_is_felt_from_where_it_comes():
    """A north wind of 10 m/s on a vessel that steams east at 5 m/s: from port of the bow, by hand."""
    seen = Instrument("wind", (-10.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0, pi / 2))
    assert seen["speed"] == pytest.approx(sqrt(125.0))
    assert seen["direction"] == pytest.approx(-np.arctan2(10.0, 5.0))


def test_mru_gyro_and_feedback_give_the_truth():
    mru = Instrument("mru", (1.0, 2.0, 3.0, 0.1, -0.2, 4.0, 0.01, 0.02, 0.03))
    assert [*mru["roll_pitch"], mru["heave"], *mru["rates"]] == pytest.approx([0.1, -0.2, 3.0, 0.01, 0.02, 0.03])
    gyro = Instrument("gyro", (0.0, 0.0, 7.0, 0.0, 0.0, 0.03))
    assert (gyro["heading"], gyro["yaw_rate"]) == pytest.approx((7.0 - 2 * pi, 0.03))
    feedback = Instrument("thruster_feedback", (5.0, -6.0, 1.0, 4.0, 2e5, 3e5), thrusters=2)
    assert feedback["speed"].tolist() == [5.0, -6.0]
    assert feedback["azimuth"] == pytest.approx([1.0, 4.0 - 2 * pi])
    assert feedback["power"].tolist() == [2e5, 3e5]
    assert feedback["valid"].all()


def test_noise_is_white_and_normal():
    """3000 samples an axis: standard deviation within 4 standard errors (5.2 %), Kolmogorov-Smirnov, no correlation."""
    noise = np.array([0.3, 0.5, 0.8])
    error = gnss(noise=tuple(noise)).record("position", 3000) - [100.0, -50.0, 2.0]
    assert error.std(axis=0) == pytest.approx(noise, rel=0.052)
    for axis in range(3):
        assert stats.kstest(error[:, axis] / noise[axis], "norm").pvalue > 1e-3
        assert abs(np.corrcoef(error[1:, axis], error[:-1, axis])[0, 1]) < 4 / sqrt(3000)
    assert abs(np.corrcoef(error.T) - np.eye(3)).max() < 4 / sqrt(3000)


@pytest.mark.parametrize("h", [0.5, 20.0])
def test_bias_is_gauss_markov_whatever_the_rate(h):
    """200 instruments that start anew: spread at the start and 20 s later, correlation exp(-20 s / 50 s) between."""
    first, last = [], []
    for seed in range(200):
        seen = gnss(h=h, seed=seed, bias=(2.0, 2.0, 2.0), bias_time=50.0)
        first.append(seen["position"] - [100.0, -50.0, 2.0])
        last.append(seen.record("position", round(20.0 / h))[-1] - [100.0, -50.0, 2.0])
    first, last = np.ravel(first), np.ravel(last)  # 600 values: 4 standard errors are 11.5 %
    assert first.std() == pytest.approx(2.0, rel=0.115)
    assert last.std() == pytest.approx(2.0, rel=0.115)
    assert np.corrcoef(first, last)[0, 1] == pytest.approx(exp(-0.4), abs=4 * (1 - exp(-0.8)) / sqrt(600))


def test_delay_is_whole_samples_and_nothing_comes_before():
    seen = gnss(delay=3, h=0.1)
    assert seen["time"] == pytest.approx(-0.3)
    found = [(seen["valid"].item(), seen["position"][0])]
    for k in range(1, 8):
        seen.step((100.0 + k, 0, 0, 0, 0, 0))
        found.append((seen["valid"].item(), seen["position"][0]))
    assert seen["time"] == pytest.approx(0.4)
    assert found[:3] == [(0.0, 0.0)] * 3
    assert found[3:] == [(1.0, 100.0 + k) for k in range(5)]


def test_drop_outs_have_their_share_and_length():
    """10 s available, 2 s lost: lost for 1/6 of the time; 20 000 samples of 1 s hold 1700 cycles, 4 errors: 12 %."""
    valid = gnss(available_time=10.0, lost_time=2.0).record("valid", 20_000)
    assert 1 - valid.mean() == pytest.approx(1 / 6, rel=0.12)
    # the chain watched once a second: mean run of losses 1 / (1 - P(lost | lost)), by Kolmogorov's equation
    share, kept = 1 / 6, exp(-1 / 10 - 1 / 2)
    runs = np.diff(np.flatnonzero(np.diff(np.concatenate([[1.0], valid, [1.0]]))))[::2]
    assert runs.mean() == pytest.approx(1 / ((1 - share) * (1 - kept)), rel=0.12)


def test_freezes_repeat_the_last_value():
    seen = gnss(noise=(1.0, 1.0, 1.0), live_time=10.0, freeze_time=5.0)
    record = seen.record("position", 10_000)
    still = (record[1:] == record[:-1]).all(axis=1)
    assert still.mean() == pytest.approx(1 / 3, rel=0.12)
    calm = gnss(noise=(1.0, 1.0, 1.0)).record("position", 1000)
    assert not (calm[1:] == calm[:-1]).any()


def test_wild_points_have_their_share_and_size():
    """Binomial of 20 000: 2 % within 4 standard errors, 20 %."""
    error = gnss(wild_share=0.02, wild=(30.0, 20.0, 10.0)).record("position", 20_000) - [100.0, -50.0, 2.0]
    wild = abs(error[:, 0]) > 1.0
    assert wild.mean() == pytest.approx(0.02, rel=0.2)
    assert np.allclose(abs(error[wild]), [30.0, 20.0, 10.0])
    assert 0.3 < (error[wild, 0] > 0).mean() < 0.7


@pytest.mark.parametrize("kind", ["gnss", "gyro", "mru", "hydroacoustic", "wind", "load_cell"])
def test_events_drop_freeze_and_shift(kind):
    """Each by its tunable parameter, and back again."""
    n = {"gnss": 6, "gyro": 6, "load_cell": 1}.get(kind, 9)
    u = np.linspace(0.2, 0.9, n) * 3.0
    name = {"gnss": "position", "gyro": "heading", "mru": "heave", "hydroacoustic": "range", "wind": "direction",
            "load_cell": "tension"}[kind]  # fmt: skip
    seen = Instrument(kind, u)
    before = seen[name]
    seen.set(dropped=1.0)
    assert seen.step()["valid"] == 0.0
    assert not seen.y[:-1].any()
    seen.set(dropped=0.0, frozen=1.0)
    assert np.array_equal(seen.step(u * 1.1)[name], before)
    assert seen["valid"] == 1.0
    seen.set(frozen=0.0)
    assert not np.array_equal(seen.step()[name], before)
    shift = {"gnss": {"offset": (3.0, 0.0, 0.0)}, "gyro": {"offset": 0.3}, "mru": {"offset_heave": 0.3},
             "hydroacoustic": {"offset_range": 0.3}, "wind": {"offset_direction": 0.3},
             "load_cell": {"offset": 0.3}}[kind]  # fmt: skip
    seen.set(**shift)
    amount = 3.0 if kind == "gnss" else 0.3
    assert np.ravel(seen.step(u)[name])[0] - np.ravel(before)[0] == pytest.approx(amount)


def test_feedback_of_each_thruster_fails_by_itself():
    u = np.array([5.0, 6.0, 1.0, 2.0, 1e5, 2e5])
    seen = Instrument("thruster_feedback", u, thrusters=2, speed_noise=0.1)
    seen.set(dropped=(1.0, 0.0), frozen=(0.0, 1.0))
    before = seen["speed"][1]
    seen.step(2 * u)
    assert seen["valid"].tolist() == [0.0, 1.0]
    assert seen["speed"].tolist() == [0.0, before]
    noise = Instrument("thruster_feedback", u, thrusters=2, speed_noise=0.1).record("speed", 500) - u[:2]
    assert abs(np.corrcoef(noise.T)[0, 1]) < 4 / sqrt(500)
    with pytest.raises(ValueError, match="3 values for 2 thrusters"):
        Instrument("thruster_feedback", u, thrusters=2, dropped=(0.0, 0.0, 0.0))


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_number_is_not_valid_and_goes_no_further(kind):
    """NaN and infinity in, zeros and no validity out; the next true value is measured as if nothing had been."""
    more = {"thrusters": 1} if kind == "thruster_feedback" else {}
    u = np.linspace(0.3, 0.7, {"gnss": 6, "gyro": 6, "thruster_feedback": 3, "load_cell": 1}.get(kind, 9))
    seen, other = Instrument(kind, u, **more), Instrument(kind, u, **more)
    seen.step(np.full(len(u), np.nan))
    assert not seen.y[:-1].any()
    seen.step(np.full(len(u), np.inf))
    assert not seen.y[:-1].any()
    other.step()
    other.step()
    assert seen.step(u).y.tobytes() == other.step(u).y.tobytes()
