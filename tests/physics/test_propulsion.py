"""Propellers and thrusters against the exact solution of their dynamics, the propeller laws and each failure."""

from __future__ import annotations

import ctypes
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from components.compiled import bind
from components.thrusters.propulsion.component import COMPONENT
from components.thrusters.propulsion.following import follow

FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
SIZE = {"max_thrust": 100e3, "max_power": 800e3, "max_speed": 20.0}
AZIMUTH = {"kind": "azimuth", "x": 10.0, "y": 3.0, **SIZE, "speed_time": 2.0, "azimuth_rate": 0.2}
TUNNEL = {"kind": "tunnel", "x": 20.0, "y": 0.0, **SIZE}
RUDDER = {"kind": "rudder", "x": -30.0, "y": 4.0, **SIZE, "reverse_thrust": 60e3, "rudder_angle": 0.6}


class Propulsion:
    """Thrusters outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, *thrusters, h=0.5, **more):
        self.parameters = COMPONENT.parameters(thrusters=thrusters, **more)
        self.p, self.h, self.t = COMPONENT.pack(self.parameters), round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.zeros(int(n)) for n in self.p[1:5])
        entries = bind(COMPONENT)
        self._init, self._step = FUNCTION(entries.init), FUNCTION(entries.step)
        self._call(self._init)

    def _call(self, function):
        self.y[:] = self.w[:] = np.nan
        vectors = (self.p, self.u, self.x, self.y, self.w)
        assert function(self.t, self.h, *[vector.ctypes.data for vector in vectors]) == 0
        assert np.isfinite(self.y).all()

    def run(self, seconds, thrust, azimuth, water=()):
        self.u[:] = [*thrust, *azimuth, *water]
        for _ in range(round(seconds * 1e9 / self.h)):
            self.t += self.h
            self._call(self._step)
        return self

    def set(self, **more):
        self.parameters = self.parameters.model_copy(update=more)
        self.p = COMPONENT.pack(self.parameters)

    def __getitem__(self, name):
        k = 0
        for port in COMPONENT.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)


@pytest.mark.parametrize(("time_constant", "rate"), [(2.0, 0.3), (0.5, 10.0), (0.0, 0.7), (1.0, np.inf), (0.0, np.inf)])
def test_following_is_exact_for_any_step(time_constant, rate):
    """Against DOP853 of v' = clip((c - v) / T, -r, r), and in one step as in a hundred; roundings and its tolerance."""
    value, command, seconds = -1.0, 2.5, 3.0
    one, many = follow(value, command, time_constant, rate, seconds), value
    for _ in range(100):
        many = follow(many, command, time_constant, rate, seconds / 100)
    assert many == pytest.approx(one, abs=1e-12)
    if time_constant > 0.0:
        speed = lambda _, v: np.clip((command - v) / time_constant, -rate, rate)  # noqa: E731
        truth = solve_ivp(speed, (0, seconds), [value], "DOP853", rtol=1e-10, atol=1e-12, max_step=0.01).y[0, -1]
        assert one == pytest.approx(truth, abs=1e-6)
    elif rate < np.inf:
        assert one == pytest.approx(min(value + rate * seconds, command), abs=1e-12)
    else:
        assert one == command


def test_thrust_and_power_obey_the_propeller_laws():
    """Settled: the thrust asked for; n by its root, power by its 3/2 power; force and moment of each at its place."""
    plant = Propulsion(AZIMUTH, TUNNEL, RUDDER).run(200.0, (25e3, -64e3, 49e3), (2.0, 0.3, 0.4))
    assert plant["thrust"] == pytest.approx([25e3, -64e3, 49e3], rel=1e-9)
    assert plant["speed"] == pytest.approx([10.0, -16.0, 14.0], rel=1e-9)
    assert plant["power"] == pytest.approx(800e3 * np.array([0.25, 0.64, 0.49]) ** 1.5, rel=1e-9)
    assert plant["azimuth"] == pytest.approx([2.0, pi / 2, 0.4], rel=1e-9)
    x, y = np.array([10.0, 20.0, -30.0]), np.array([3.0, 0.0, 4.0])
    fx, fy = plant["thrust"] * np.cos(plant["azimuth"]), plant["thrust"] * np.sin(plant["azimuth"])
    assert plant["total.force"] == pytest.approx([fx.sum(), fy.sum()])
    assert plant["total.moment"] == pytest.approx((x * fy - y * fx).sum())
    assert plant["running"].all()


def test_thrusters_give_no_more_than_they_can():
    plant = Propulsion(AZIMUTH, TUNNEL, RUDDER).run(200.0, (1e9, -1e9, -1e9), (0.0, 0.0, 2.0))
    assert plant["thrust"] == pytest.approx([100e3, -100e3, -60e3], rel=1e-9)
    assert plant["azimuth"][2] == pytest.approx(0.6)  # the rudder's stop


def test_azimuth_goes_the_short_way_across_astern_at_its_rate():
    plant = Propulsion({**AZIMUTH, "azimuth_time": 0.1}).run(60.0, (1e4,), (3.0,))
    before = plant["azimuth"][0]
    plant.run(1.0, (1e4,), (-3.0,))
    assert plant["azimuth"][0] - before == pytest.approx(0.2 * 1.0, abs=1e-9)  # 0.28 rad to go, at 0.2 rad/s
    plant.run(60.0, (1e4,), (-3.0,))
    assert plant["azimuth"][0] == pytest.approx(2 * pi - 3.0, abs=1e-9)


def test_thrust_falls_with_the_water_that_comes():
    """K_T = K_T0 (1 - J / J_0): none at V = J_0 n D, in place (turning counted); power is that of the torque left."""
    screw = {**AZIMUTH, "diameter": 2.0, "zero_thrust_advance": 0.8}
    plant = Propulsion(screw, meets_water=True).run(100.0, (100e3,), (0.0,), (0.0, 0.0, 0.0))
    full = 0.8 * 20.0 / (2 * pi) * 2.0
    plant.run(0.5, (100e3,), (0.0,), (0.5 * full, 0.0, 0.0))
    assert plant["thrust"][0] == pytest.approx(50e3, rel=1e-9)
    assert plant["power"][0] == pytest.approx(800e3 * (1 - 0.5 / 1.15), rel=1e-9)
    plant.run(0.5, (100e3,), (0.0,), (0.0, 0.0, -0.5 * full / 3.0))
    assert plant["thrust"][0] == pytest.approx(50e3, rel=1e-9)
    plant.run(0.5, (100e3,), (0.0,), (full, 7.0, 0.0))
    assert plant["thrust"][0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("code", "thrust", "azimuth"), [(1, 0.0, 1.0), (2, 25e3, 2.0), (3, 100e3, 2.0), (4, 64e3, 1.0)]
)
def test_failures(code, thrust, azimuth):
    """1 stops and cannot turn, 2 keeps its speed, 3 runs away, 4 cannot turn; all are told."""
    plant = Propulsion(AZIMUTH, TUNNEL).run(100.0, (25e3, 0.0), (1.0, 0.0))
    plant.set(failure=(code, 0))
    plant.run(100.0, (64e3, 0.0), (2.0, 0.0))
    assert plant["thrust"][0] == pytest.approx(thrust, abs=1.0)
    assert plant["azimuth"][0] == pytest.approx(azimuth, abs=1e-9)
    assert plant["running"].tolist() == [0.0, 1.0]


def test_a_command_that_is_no_number_leaves_things_as_they_are():
    plant = Propulsion(AZIMUTH).run(100.0, (25e3,), (1.0,)).run(5.0, (np.nan,), (np.nan,))
    assert plant["thrust"][0] == pytest.approx(25e3)
    assert plant["azimuth"][0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("thruster", "more", "text"),
    [
        ({**TUNNEL, "rudder_angle": 0.3}, {}, "belongs to kind rudder"),
        ({**AZIMUTH, "direction": 0.3}, {}, "it turns instead"),
        (TUNNEL, {"failure": (0, 1)}, "2 values for 1 thrusters"),
        (TUNNEL, {"failure": (7,)}, "expected 0, 1, 2, 3 or 4"),
    ],
)
def test_what_does_not_fit_is_refused(thruster, more, text):
    with pytest.raises(ValueError, match=text):
        COMPONENT.parameters(thrusters=(thruster,), **more)
