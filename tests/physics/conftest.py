"""A cable outside a conductor, for the tests of its motion."""

import numpy as np
import pytest

from components.compiled import as_compiled
from components.tether.cable import line
from components.tether.cable.component import COMPONENT

init, step = as_compiled(COMPONENT.init), as_compiled(COMPONENT.step)


class Cable:
    """A cable outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, h, u, **parameters):
        self.parameters = COMPONENT.parameters(**parameters)
        self.p = COMPONENT.pack(self.parameters)
        self.h, self.t = round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        self.call(init, u)

    def call(self, function, u):
        self.y[:] = self.w[:] = np.nan
        self.u[:] = u
        assert function(self.t, self.h, self.p, self.u, self.x, self.y, self.w) == 0

    def step(self, u):
        self.t += self.h
        self.call(step, u)

    def __getitem__(self, name):
        k = 0
        for port in COMPONENT.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape)
            k += port.size
        raise KeyError(name)

    @property
    def state(self):
        """A view of the nodes' records."""
        return self.x[: line.STATE * (self.parameters.segments + 1)].reshape(-1, line.STATE)


@pytest.fixture(scope="session")
def cable_of():
    """The class: cable_of(h, u, **parameters)."""
    return Cable
