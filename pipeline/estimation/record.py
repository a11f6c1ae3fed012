"""An estimator in a log: its parameters, its inputs at each step, and the run of it anew."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from components.contract import Component, Port
from components.estimator.line import Line
from pipeline.errors import LogError
from pipeline.estimation.stepping import KINDS, Stepper
from pipeline.graph import Graph
from pipeline.log.reader import Log
from pipeline.replay import inputs_of
from pipeline.rerun import graph_of

OPEN = 1e6  # deviations, which no reading is off by


@dataclass(frozen=True)
class Walk:
    """What a filter said of a log after t0. nis: per innovation; seen, refused: readings."""

    nis: float
    seen: int
    refused: int


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

    def between(self, first: float, last: float) -> Record:
        """The part of it from first to last [s of the log's time]. Raises ValueError if that is less than two steps."""
        inside = (self.t_ns >= first * 1e9 - 0.5) & (self.t_ns <= last * 1e9 + 0.5)
        if inside.sum() < 2:
            raise ValueError(f"{first:g} to {last:g} s holds {inside.sum()} of its steps; expected two at least")
        return replace(self, t_ns=self.t_ns[inside], inputs=self.inputs[inside])

    def walk(self) -> Walk:
        """Step the filter through it. Raises ValueError if the filter fails."""
        filter_, nis, freedom, seen, refused = self.begin(), 0.0, 0.0, 0, 0
        for u in self.inputs[1:]:
            filter_.step(u)
            nis += float(filter_["nis"])
            freedom += float(filter_["freedom"])
            used = filter_["used"]
            seen, refused = seen + int((used != 0.0).sum()), refused + int((used < 0.0).sum())
        return Walk(nis / max(freedom, 1.0), seen, refused)

    def without_refused(self) -> Record:
        """Without the readings that the filter refuses, and with its gate open: the same data whatever the noises are.

        Raises ValueError if the filter fails.
        """
        flags, at = [], 0
        for port in self.component.inputs(self.parameters):
            assert isinstance(port, Port)
            flags += range(at, at + port.size) if port.name.rpartition(".")[2] == "valid" else []
            at += port.size
        inputs, filter_ = self.inputs.copy(), self.begin()
        for k, u in enumerate(self.inputs):
            used = (filter_.step(u) if k else filter_)["used"]
            inputs[k, np.array(flags)[used < 0.0]] = 0.0
        return replace(self.with_parameters(gate=OPEN), inputs=inputs)

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
        raise LogError(f"{log.path}: no component {name} of {' or '.join(KINDS)}{_others(graph)}")
    node = graph.nodes[index]
    assert isinstance(node.parameters, Line)
    ticks, u = inputs_of(log, graph, index)
    h = node.period * graph.base_ns * 1e-9
    return Record(node.component, node.parameters, graph.start_ns + ticks * graph.base_ns, u, h)


def estimators_in(log: Log) -> list[str]:
    """Names of the estimators in a log that can be stepped alone."""
    _, graph = graph_of(log)
    return [node.name for node in graph.nodes if node.model in KINDS]


def _others(graph: Graph) -> str:
    names = [node.name for node in graph.nodes if node.model in KINDS]
    return f"; there is {', '.join(names)}" if names else ", nor any other"
