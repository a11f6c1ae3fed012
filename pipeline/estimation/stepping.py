"""An estimator of a line stepped by itself, its state and root of covariance laid open."""

from __future__ import annotations

import numpy as np

from components.compiled import functions
from components.contract import Component, Parameters
from components.estimator.best.component import COMPONENT as BEST
from components.estimator.best.layout import layout_of
from components.estimator.contradiction import KEPT
from components.estimator.corrected.component import COMPONENT as CORRECTED
from components.estimator.corrected.model import Corrected
from components.estimator.modal import corrected

KINDS = {BEST.name: BEST, CORRECTED.name: CORRECTED}
_FUNCTIONS = {name: functions(kind) for name, kind in KINDS.items()}


class Stepper:
    """A filter of a kind in KINDS, with a period h [s]."""

    def __init__(self, component: Component, parameters: Parameters, h: float):
        """Nothing is begun yet, see begin."""
        self.component, self.parameters, self.h_ns = component, parameters, round(h * 1e9)
        self.h = self.h_ns * 1e-9
        self.p = component.pack(parameters)
        self.u, self.x, self.y, self.w = (np.zeros(int(n)) for n in self.p[1:5])
        self._init, self._step = _FUNCTIONS[component.name]
        self._t = 0
        if component is BEST:
            self.layout = layout_of.py_func(self.p)
            self.states, self.noises = self.layout.N, self.layout.K
        else:
            assert isinstance(parameters, Corrected)
            self.model = corrected(parameters, parameters.force_noise**2, parameters.interval)
            self.states = self.noises = 3 * parameters.bars
        self._places, at = {}, 0
        for port in component.outputs(parameters):
            self._places[port.name] = (at, at + port.size, port.shape)
            at += port.size

    def __getitem__(self, name: str) -> np.ndarray:
        """An output of the last step."""
        first, last, shape = self._places[name]
        return self.y[first:last].reshape(shape).copy()

    @property
    def state(self) -> np.ndarray:
        """(N,) the estimate."""
        return self.x[: self.states].copy()

    @property
    def root(self) -> np.ndarray:
        """(N, N) S, the covariance being S S'."""
        return self.x[self.states :][: self.states**2].reshape(self.states, self.states).copy()

    def _call(self, function: object, u: np.ndarray) -> None:
        self.u[:] = u
        status = function(self._t, self.h_ns, self.p, self.u, self.x, self.y, self.w)  # type: ignore[operator]
        if status:
            raise ValueError(f"{self.component.name}: {self.component.status_text[status]}")

    def begin(self, u: np.ndarray) -> Stepper:
        """Begin with the first inputs. Raises ValueError with the status's text."""
        self._t = 0
        self._call(self._init, u)
        return self

    def step(self, u: np.ndarray) -> Stepper:
        """One step. Raises ValueError with the status's text."""
        self._t += self.h_ns
        self._call(self._step, u)
        return self

    def moved(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A state after a step without noise; the slope Phi (N, N) of that; the noise's columns G (N, K)."""
        if self.component is CORRECTED:
            return self.model.transition @ state, self.model.transition, self.model.noise
        # A step without any reading moves the state only, and leaves its slopes in the scratch.
        N, columns = self.states, self.states + self.noises
        x = np.concatenate([state, np.eye(N).ravel(), np.zeros(self.layout.R + KEPT)])
        if self._step(0, self.h_ns, self.p, np.zeros_like(self.u), x, np.empty_like(self.y), self.w):
            raise ValueError(f"{self.component.name}: the state moved to something non-finite")
        slopes = self.w[self.layout.moves :][: N * columns].reshape(N, columns).copy()
        return x[:N], slopes[:, :N], slopes[:, N:]
