"""Components outside a conductor, for tests of what they do by themselves."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from components.compiled import functions
from components.tether.cable import line
from components.tether.cable.component import COMPONENT

INIT, STEP = functions(COMPONENT)


class Lone:
    """A cable stepped by hand; y and w are filled with NaN before every call. `status`: of the last call."""

    def __init__(self, h, u, **parameters):
        self.parameters = COMPONENT.parameters(**parameters)
        self.p = COMPONENT.pack(self.parameters)
        self.h, self.t = round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        self._call(INIT, u)

    def _call(self, function, u):
        self.y[:] = self.w[:] = np.nan
        self.u[:] = u
        self.status = function(self.t, self.h, self.p, self.u, self.x, self.y, self.w)

    def step(self, u):
        self.t += self.h
        self._call(STEP, u)

    @property
    def state(self):
        """A view of the nodes' records."""
        return self.x[: line.STATE * (self.parameters.segments + 1)].reshape(-1, line.STATE)

    def __getitem__(self, name):
        k = 0
        for port in COMPONENT.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)


@pytest.fixture(scope="session")
def cable():
    """`cable(h, u, **parameters)`: h [s]; u: the inputs, or the two ends' positions as a pair."""

    def make(h, u, **parameters):
        return Lone(h, ends(*u) if isinstance(u, tuple) else u, **parameters)

    return make


def ends(a, b):
    """Inputs of two ends at rest."""
    u = np.zeros(18)
    u[0:3], u[9:12] = a, b
    return u


@pytest.fixture(scope="session")
def cable_of():
    """The same, each call of which must have gone well."""

    def make(h, u, **parameters):
        return Sound(h, u, **parameters)

    return make


class Sound(Lone):
    """A cable whose every call must give status 0."""

    def _call(self, function, u):
        super()._call(function, u)
        assert self.status == 0


class Unit:
    """Any component stepped by hand; y and w are filled with NaN before every call, which must go well."""

    def __init__(self, kind, u, h, seed, parameters):
        self.component = importlib.import_module(f"components.{kind}.component").COMPONENT
        self.parameters, self.seed = self.component.parameters(**parameters), seed
        self.p, self.h, self.t = self.component.pack(self.parameters, seed), round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        self._init, self._step = functions(self.component)
        self._call(self._init, u)

    def _call(self, function, u):
        self.y[:] = self.w[:] = np.nan
        self.u[:] = u
        assert function(self.t, self.h, self.p, self.u, self.x, self.y, self.w) == 0
        assert np.isfinite(self.y).all()
        assert np.isfinite(self.x).all()

    def step(self, u=None):
        self.t += self.h
        self._call(self._step, self.u.copy() if u is None else u)
        return self

    def set(self, **more):
        """Other tunable parameters, as an event gives them."""
        self.parameters = self.parameters.model_copy(update=more)
        self.p = self.component.pack(self.parameters, self.seed)

    @property
    def seconds(self):
        return self.t * 1e-9

    def __getitem__(self, name):
        k = 0
        for port in self.component.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)


@pytest.fixture(scope="session")
def unit():
    """`unit(kind, u, h=0.1, seed=7, **parameters)`: kind as `observer.kalman`; u: inputs at t0; h [s]."""

    def make(kind, u, h=0.1, seed=7, **parameters):
        return Unit(kind, u, h, seed, parameters)

    return make
