"""The ROV against closed forms, scipy's DOP853, a moving frame and the line's law."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from components.compiled import bind
from components.vessel.rov.component import COMPONENT
from pipeline.parameters import build, gather
from pipeline.yaml_source import parse, read_text

FOLDER = Path(__file__).parents[2] / "scenarios" / "parameters"
FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


def published():
    table, _ = parse(read_text(FOLDER / "bluerov2_heavy.yaml", "bluerov2_heavy.yaml"), "bluerov2_heavy.yaml")
    problems = []
    found = build(
        COMPONENT.parameters, gather(COMPONENT.parameters, table, FOLDER, "", problems), table.place, "", problems
    )
    assert not problems
    return found.model_dump()


BLUEROV = published()


class Rov:
    """An ROV outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, h, u=(), **parameters):
        self.parameters = COMPONENT.parameters(**parameters)
        self.p, self.h, self.t = COMPONENT.pack(self.parameters), round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        self.u[:] = u
        entries = bind(COMPONENT)
        self._init, self._step = FUNCTION(entries.init), FUNCTION(entries.step)
        self._call(self._init)

    def _call(self, function):
        self.y[:] = self.w[:] = np.nan
        vectors = (self.p, self.u, self.x, self.y, self.w)
        assert function(self.t, self.h, *[vector.ctypes.data for vector in vectors]) == 0
        assert np.isfinite(self.y).all()

    def step(self, u=None):
        self.t += self.h
        if u is not None:
            self.u[:] = u
        self._call(self._step)

    def run(self, seconds):
        for _ in range(round(seconds * 1e9 / self.h)):
            self.step()
        return self

    def __getitem__(self, name):
        k = 0
        for port in COMPONENT.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)


def test_it_rises_by_its_buoyancy():
    """Terminal speed in heave: (33 + 190 w) w = (rho V - m) g, by the quadratic's root."""
    rov = Rov(0.1, **BLUEROV | {"position": (0.0, 0.0, 50.0)}).run(60.0)
    up = (1025.97 * 0.0134 - 13.5) * 9.80665
    w = (-33.0 + np.sqrt(33.0**2 + 4 * 190.0 * up)) / (2 * 190.0)
    assert rov["velocity"][2] == pytest.approx(-w, rel=1e-9)


def rates(_, state, tau, current):
    """Fossen 2011, eq. 6.111 for the BlueROV2 Heavy's numbers, in plain numpy."""
    psi, nu = state[3], state[4:]
    c, s = np.cos(psi), np.sin(psi)
    turned = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    water = turned.T @ np.array([*current, 0.0])
    m = np.array([19.86, 20.62, 32.18, 0.592])
    u, v, w, r = rel = nu - water
    d = np.array([13.7 + 141 * abs(u), 217 * abs(v), 33 + 190 * abs(w), 1.5 * abs(r)]) * rel
    coriolis = np.array([-m[1] * v * r, m[0] * u * r, 0.0, (m[1] - m[0]) * u * v])
    sinks = np.array([0, 0, (13.5 - 1025.97 * 0.0134) * 9.80665, 0])
    carried = r * np.array([water[1], -water[0], 0.0, 0.0])
    return np.concatenate([turned @ nu, (tau - d - coriolis + sinks) / m + carried])


def test_manoeuvre_in_a_current_is_that_of_scipy():
    """DOP853 at 1e-11; second order: half the step, a quarter of the error."""
    tau, current, seconds = np.array([30.0, 10.0, 15.0, 1.0]), np.array([0.2, -0.1, 0.05]), 10.0
    start = [0, 0, 20.0, 0.4, 0, 0, 0, 0]
    truth = solve_ivp(rates, (0, seconds), start, "DOP853", rtol=1e-11, atol=1e-12, args=(tau, current)).y[:, -1]
    errors = []
    for h in (0.1, 0.05, 0.025):
        p = BLUEROV | {"position": (0.0, 0.0, 20.0), "heading": 0.4, "takes_thrust": True, "takes_current": True}
        rov = Rov(h, [*tau, *current], **p).run(seconds)
        errors.append(np.linalg.norm(rov["position"] - truth[:3]))
    assert errors[0] < 0.05
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


def test_line_law_is_in_the_balance():
    """A plain force of what the law gives at the accelerations found makes the same motion, heave included."""
    rng = np.random.default_rng(1)
    root = rng.normal(size=(3, 3))
    g, reference, pull = 60.0 * root @ root.T, 0.1 * rng.normal(size=3), 5.0 * rng.normal(size=3)
    p = BLUEROV | {"velocity": (0.4, 0.1, 0.2), "yaw_rate": 0.3, "heading": 1.1, "position": (0.0, 0.0, 30.0)}
    tied = Rov(0.05, np.concatenate([pull, reference, g.ravel()]), **p | {"takes_law": True})
    free = Rov(0.05, np.zeros(3), **p | {"takes_force": True})
    free.x[:] = tied.x
    for _ in range(5):
        tied.step()
        free.step(pull - g @ (tied["hook.acceleration"] - reference))
        assert free["hook.acceleration"] == pytest.approx(tied["hook.acceleration"], abs=1e-9)
        assert free["position"] == pytest.approx(tied["position"], abs=1e-12)
    assert np.array_equal(tied["accelerance"], tied["accelerance"].T)
    assert np.linalg.eigvalsh(tied["accelerance"]).min() > 0  # it yields in all three directions


def test_accelerance_is_the_slope_of_the_acceleration():
    """Central differences; the part that is not symmetric is of the order of the step."""
    p = BLUEROV | {"velocity": (0.4, 0.1, 0.2), "yaw_rate": 0.3, "heading": 1.1, "position": (0.0, 0.0, 30.0)}
    slopes = np.empty((3, 3))
    for j in range(3):
        found = []
        for sign in (1e-3, -1e-3):
            rov = Rov(0.01, np.zeros(18), **p | {"takes_law": True, "takes_force": True})
            u = np.zeros(18)
            u[j] = sign
            rov.step(u)
            found.append(rov["hook.acceleration"])
        slopes[:, j] = (found[0] - found[1]) / 2e-3
    assert np.abs(rov["accelerance"] - slopes).max() < 0.02 * np.abs(slopes).max()
