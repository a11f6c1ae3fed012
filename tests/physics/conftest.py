"""A cable outside a conductor, for the tests of its terms."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from components.compiled import bind
from components.tether.cable import line
from components.tether.cable.component import COMPONENT

_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


class Lone:
    """A cable stepped by hand; y and w are filled with NaN before every call. `status`: of the last call."""

    def __init__(self, h, u, **parameters):
        self.parameters = COMPONENT.parameters(**parameters)
        self.p = COMPONENT.pack(self.parameters)
        self.h, self.t = round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        entries = bind(COMPONENT)
        self.init, self.advance = _FUNCTION(entries.init), _FUNCTION(entries.step)
        self._call(self.init, u)

    def _call(self, function, u):
        self.y[:] = self.w[:] = np.nan
        self.u[:] = u
        vectors = (self.p, self.u, self.x, self.y, self.w)
        self.status = function(self.t, self.h, *[vector.ctypes.data for vector in vectors])

    def step(self, u):
        self.t += self.h
        self._call(self.advance, u)

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
