"""Runs one component again from the inputs that a log holds, and compares its outputs with the logged ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from components.contract import numbers_in, parted
from pipeline import native_loop as loop
from pipeline.conductor import Conductor
from pipeline.errors import LogError
from pipeline.film import Pictures
from pipeline.graph import Graph, Node, Term, alone
from pipeline.log.reader import Log
from pipeline.log.recorder import pack_rows
from pipeline.loop_tables import LAW

if TYPE_CHECKING:
    from pipeline.hosts.fmu.base import FmuHost

Take = Callable[[np.ndarray], None]


@dataclass(frozen=True)
class Replay:
    """times_ns: (k,) of the steps that the log holds, t0 first; outputs: (k, n_y) numbers at these.

    ports: largest absolute difference from the log, by port, of images in grey levels; None for one that the log does
    not hold in this shape.
    """

    component: str
    times_ns: np.ndarray
    outputs: np.ndarray
    identical: bool
    ports: dict[str, float | None]


class _Signals:
    """The board's history as far as the log holds it, by producer."""

    def __init__(self, log: Log, graph: Graph):
        self._log = log
        self._graph = graph
        self._values: dict[int, np.ndarray] = {}

    def steps(self, j: int) -> np.ndarray:
        """Outputs of node j at all its steps: (k, n_y). Raises LogError if they were not all recorded."""
        if j not in self._values:
            node = self._graph.nodes[j]
            if node.record_every != 1 or node.name not in self._log.channels:
                every = f"every {node.record_every} steps" if node.record_every else "never"
                raise LogError(
                    f"{self._log.path}: {node.name} was recorded {every}; replay needs every step of it: "
                    f"remove `record` of {node.name} in the scenario and run again"
                )
            self._values[j] = self._log.values(node.name)
        return self._values[j]

    def column(self, index: int, ticks: np.ndarray) -> np.ndarray:
        """Signal at a board index as it stood after each of the ticks."""
        j = next(j for j, node in enumerate(self._graph.nodes) if index < node.start + node.width)
        values = self.steps(j)[:, index - self._graph.nodes[j].start]
        return values[ticks // self._graph.nodes[j].period]

    def last_tick(self, j: int) -> int:
        """Last tick up to which node j's outputs are known."""
        period = self._graph.nodes[j].period
        return len(self.steps(j)) * period - 1


def _producers(graph: Graph, node: Node) -> list[int]:
    """Indices of the nodes whose outputs a node's terms read."""
    read = {term.source for term in node.terms if term.gain != 0.0}
    return [j for j, other in enumerate(graph.nodes) if any(other.start <= s < other.start + other.width for s in read)]


def _addend(term: Term, signals: _Signals, ticks: np.ndarray) -> np.ndarray:
    """Values of one term at a node's steps: (k, count); as gather() in the loop, operation by operation."""
    value = np.zeros((len(ticks), term.count))
    if term.gain != 0.0:
        seen = np.maximum(ticks - 1, 0) if term.delayed else ticks
        columns = [signals.column(term.source + c, seen) for c in range(term.count)]
        source = np.stack(columns, axis=1)
        if term.delayed:
            source[0] = term.initial or 0.0
        value = source if term.gain == 1.0 and not term.offset else term.gain * source
    return value + np.array(term.offset) if term.offset else value


def inputs_of(log: Log, graph: Graph, i: int) -> tuple[np.ndarray, np.ndarray]:
    """Ticks of node i's steps that can be replayed, from t0 on, and its numbers at each: (k,), (k, n_u)."""
    node = graph.nodes[i]
    signals = _Signals(log, graph)
    last = [signals.last_tick(j) for j in _producers(graph, node)]
    ticks = np.arange(0, min([graph.ticks, *last]) + 1, node.period)
    u = np.zeros((len(ticks), numbers_in(node.inputs)))
    for term in (term for term in node.terms if not term.is_image):
        span = slice(term.target, term.target + term.count)
        addend = _addend(term, signals, ticks)
        u[:, span] = addend if term.assigns else addend + u[:, span]
    for bond in graph.bonds:
        if bond.body == i:
            law = log.values(f"bond/{bond.name}")[:, :LAW]
            ticks, u = ticks[: len(law) + 1], u[: len(law) + 1]
            u[1:, bond.target : bond.target + LAW] = law[: len(u) - 1]
    return ticks, u


class _Alone(Conductor):
    """One component, fed with inputs from a log instead of a board."""

    def compute(self, u: np.ndarray, ticks: np.ndarray, pictures: Pictures, take: Take) -> np.ndarray:
        """Outputs (k, n_y) at its steps, t0 first, from inputs (k, n_u) and the steps' ticks (k,). Raises StepError.

        These are the numbers; images are shown and compared step by step. take: gets the rows.
        """
        y = np.empty((len(ticks), numbers_in(self.graph.nodes[0].outputs)))
        self._tables.inputs[: u.shape[1]] = u[0]
        pictures.show(self._tables.inputs, 0)
        self.initialise()
        y[0] = self._tables.board[: y.shape[1]]
        if not pictures.is_any:
            self._compute(u, y, ticks)
            take(pack_rows(self._times_ns(ticks), y))
            return y
        for s in range(len(ticks)):
            if s:
                pictures.show(self._tables.inputs, int(ticks[s]))
                self._compute(u[: s + 1], y[: s + 1], ticks[: s + 1], s)
            pictures.compare(self._tables.board, s)
            take(pack_rows(self._times_ns(ticks[s : s + 1]), self._tables.board[None, : self.graph.board]))
        return y

    def _times_ns(self, ticks: np.ndarray) -> np.ndarray:
        return self.graph.start_ns + ticks * self.graph.base_ns

    def _compute(self, u: np.ndarray, y: np.ndarray, ticks: np.ndarray, done: int = 1) -> None:
        """The steps from number `done` on."""
        while done < len(ticks):
            while (next_tick := self.events.next_tick()) is not None and next_tick < ticks[done]:
                self.events.fire(next_tick)
            end = len(ticks) if next_tick is None else int(np.searchsorted(ticks, next_tick, side="right"))
            self._step(u, y, done, end)
            done = end

    def _step(self, u: np.ndarray, y: np.ndarray, first: int, end: int) -> None:
        """Steps first..end-1. Raises StepError."""
        step_ns = self.graph.nodes[0].period * self.graph.base_ns
        failed = loop.step_through(self._tables, u, y, first, end, self.graph.start_ns, step_ns)
        self._raise_if_stopped(self.graph.start_ns + failed * step_ns)


def led_to(log: Log, graph: Graph, i: int, tick: int) -> FmuHost:
    """A host of node i, an FMU that cannot save its state, fed all its inputs from the log up to a tick.

    Raises LogError where they were not all recorded, StepError if a step fails.
    """
    node = graph.nodes[i]
    ticks, u = inputs_of(log, graph, i)
    k = int(np.searchsorted(ticks, tick, side="right"))
    last = tick // node.period * node.period
    if k == 0 or ticks[k - 1] < last:
        raise LogError(f"{log.path}: it does not hold all inputs of {node.name}, which cannot save its state")
    single = _Alone(alone(graph, node))
    single.compute(u[:k], ticks[:k], Pictures(log, graph, i, node), _ignore)
    return single.memory.fmus[0]


def _ignore(_: np.ndarray) -> None:
    """Rows that nobody wants."""


def _compare(node: Node, y: np.ndarray, logged_node: Node, logged: np.ndarray) -> dict[str, float | None]:
    before: dict[str, tuple[tuple[int, ...], np.ndarray]] = {}
    at = 0
    for port in parted(logged_node.outputs)[0]:
        before[port.name] = (port.shape, logged[:, at : at + port.size])
        at += port.size
    differences: dict[str, float | None] = {}
    at = 0
    for port in parted(node.outputs)[0]:
        shape, values = before.get(port.name, ((-1,), logged))
        difference = None
        if shape == port.shape:
            apart = y[:, at : at + port.size] - values
            difference = float(np.abs(apart, out=apart).max(initial=0.0))
        differences[port.name] = difference
        at += port.size
    return differences


def replay_component(log: Log, graph: Graph, node: Node, take: Take = _ignore) -> Replay:
    """Run a node of the log's graph again, maybe with other parameters than the graph's of that name.

    take: gets its new rows, (k, 1 + n) as the recorder takes them, images included; where there are some, step by step.
    A log that ends early is replayed as far as it holds the node's own steps. Raises LogError if an input was not
    recorded at every step, StepError if it fails.
    """
    i = [other.name for other in graph.nodes].index(node.name)
    ticks, u = inputs_of(log, graph, i)
    logged, pictures = _Signals(log, graph).steps(i), Pictures(log, graph, i, node)
    if len(logged) == 0:
        raise LogError(f"{log.path}: holds no step of {node.name}")
    k = pictures.steps(ticks[: len(logged)])
    ticks, u, logged = ticks[:k], u[:k], logged[:k]
    y = _Alone(alone(graph, node)).compute(u, ticks, pictures, take)
    identical = np.array_equal(y.view(np.uint64), logged.view(np.uint64)) and not any(pictures.differences.values())
    times = graph.start_ns + ticks * graph.base_ns
    differences = _compare(node, y, graph.nodes[i], logged) | pictures.differences
    return Replay(node.name, times, y, identical, differences)
