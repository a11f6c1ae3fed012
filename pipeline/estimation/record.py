"""An estimator in a log: its parameters, its inputs at each step, and the run of it anew."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from components.contract import Component
from components.estimator.line import Line
from pipeline.errors import LogError
from pipeline.estimation.stepping import KINDS, Stepper
from pipeline.log.reader import Log
from pipeline.replay import inputs_of
from pipeline.rerun import graph_of


@dataclass(frozen=True)
class Record:
    """t_ns: (k,) of its steps, t0 first; inputs: (k, n_u); h: its period [s]."""

    component: Component
    parameters: Line
    t_ns: np.ndarray
    inputs: np.ndarray
    h: float

    def with_parameters(self, **changed: Any) -> Record:
        """The same with other parameters. Raises ValueError if they do not fit."""
        given = {name: getattr(self.parameters, name) for name in type(self.parameters).model_fields}
        return replace(self, parameters=type(self.parameters)(**{**given, **changed}))

    def begin(self) -> Stepper:
        """The filter at t0."""
        return Stepper(self.component, self.parameters, self.h).begin(self.inputs[0])

    def log_likelihood(self) -> float:
        """Of all that was measured after t0, by the innovations; -inf where the filter fails."""
        try:
            filter_ = self.begin()
            return float(sum(filter_.step(u)["log_density"] for u in self.inputs[1:]))
        except ValueError:
            return -np.inf


def record_of(log: Log, name: str) -> Record:
    """The estimator of this name in a log.

    Raises LogError if there is none of a kind that can be stepped alone, or its inputs were not recorded.
    """
    _, graph = graph_of(log)
    index = next((i for i, node in enumerate(graph.nodes) if node.name == name and node.model in KINDS), None)
    if index is None:
        raise LogError(f"{log.path}: no component {name} of {' or '.join(KINDS)}")
    node = graph.nodes[index]
    assert isinstance(node.parameters, Line)
    ticks, u = inputs_of(log, graph, index)
    h = node.period * graph.base_ns * 1e-9
    return Record(node.component, node.parameters, graph.start_ns + ticks * graph.base_ns, u, h)
