"""Lays a graph out in memory: five flat arrays, and the tables of indices that the compiled loop walks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from components import compiled
from components.contract import N_W, N_X, numbers_in
from pipeline.errors import TowlineError
from pipeline.graph import Graph, Node, OtherEnd, execution_order
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.python import PythonHost
from pipeline.kernels import refusal
from pipeline.loop_tables import BOND_ROW, BOND_STATE, LAW, Tables
from pipeline.rehearsal import beyond

if TYPE_CHECKING:
    from pipeline.hosts.fmu.base import FmuHost

CAPTURE_BYTES = 8 << 20  # captured rows held between two hand-overs to the recorder
CAPTURE_TICKS = 1 << 16


@dataclass
class Memory:
    """A graph's memory, whose addresses are in the tables: it must live as long as they are used.

    spans[name][i]: slice of node i's vector in the array of all (p, u, x, y, w).
    """

    tables: Tables
    inits: np.ndarray
    parameters: np.ndarray
    workspace: np.ndarray
    spans: dict[str, list[slice]]
    hosts: dict[int, PythonHost | FmuHost]
    entries: list[compiled.EntryPoints | PythonHost | FmuHost]
    row_starts: np.ndarray  # (channels,) where each channel's captured rows begin
    row_lengths: np.ndarray  # (channels,) numbers a row, time included
    capture_ticks: int

    @property
    def fmus(self) -> dict[int, FmuHost]:
        """The hosts whose state is not in x, by node."""
        return {i: host for i, host in self.hosts.items() if not isinstance(host, PythonHost)}

    def close(self) -> None:
        """Let FMUs go."""
        for host in self.fmus.values():
            host.close()


def _spans(sizes: list[int]) -> list[slice]:
    ends = np.cumsum([0, *sizes])
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def _array(length: int) -> np.ndarray:
    return np.zeros(max(length, 1))


def _rows(table: list[tuple[int, ...]], columns: int) -> np.ndarray:
    return np.array(table, np.int64).reshape(-1, columns)


def _capture_layout(graph: Graph) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Row lengths, row starts, total length and the ticks that fit, of the captured rows of nodes, then bonds."""
    lengths = [1 + node.width for node in graph.nodes]
    lengths += [1 + BOND_ROW] * len(graph.bonds)
    periods = [node.period for node in graph.nodes] + [graph.nodes[bond.body].period for bond in graph.bonds]
    per_tick = sum(8 * n / period for n, period in zip(lengths, periods, strict=True))
    ticks = int(min(CAPTURE_TICKS, max(1, CAPTURE_BYTES // max(per_tick, 1))))
    sizes = [n * (ticks // period + 2) for n, period in zip(lengths, periods, strict=True)]
    starts = np.cumsum([0, *sizes])
    return np.array(lengths, np.int64), starts[:-1].astype(np.int64), int(starts[-1]), ticks


def _terms(
    graph: Graph, u: list[slice]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, list[float], list[int]]:
    """Tables of terms and of delayed copies; the values which the copies hold at t0; each node's first term."""
    terms: list[tuple[int, ...]] = []
    gains: list[float] = []
    offsets: list[float] = []
    delayed: list[tuple[int, ...]] = []
    initial: list[float] = []
    first: list[int] = []
    for i, node in enumerate(graph.nodes):
        first.append(len(terms))
        for term in node.terms:
            source = term.source
            if term.delayed:
                source = graph.board + len(initial)
                delayed.append((source, term.source, term.count))
                initial += term.initial or (0.0,) * term.count
            offset = -1
            if term.offset:
                offset = len(offsets)
                offsets += term.offset
            terms.append((u[i].start + term.target, source, term.count, offset, int(term.assigns)))
            gains.append(term.gain)
    first.append(len(terms))
    tables = _rows(terms, 5), np.array(gains, np.float64), np.array(offsets, np.float64), _rows(delayed, 3)
    return *tables, initial, first


def _vectors(graph: Graph) -> tuple[list[np.ndarray], dict[str, list[slice]]]:
    """Each node's packed p, and the spans of all vectors in their arrays."""
    packed = [node.component.pack(node.parameters, node.seed) for node in graph.nodes]
    spans = {
        "p": _spans([len(p) for p in packed]),
        "u": _spans([sum(port.size for port in node.inputs) for node in graph.nodes]),
        "x": _spans([int(p[N_X]) for p in packed]),
        "y": [slice(node.start, node.start + node.width) for node in graph.nodes],
        "w": _spans([int(p[N_W]) for p in packed]),
    }
    return packed, spans


def _entry(
    node: Node, vectors: list[np.ndarray], start_ns: int, dt_ns: int
) -> compiled.EntryPoints | PythonHost | FmuHost:
    if isinstance(node.component, FmuComponent):
        from pipeline.hosts.fmu.host import (
            host_of,
        )  # and its compiled step, which a scenario without FMUs does not need

        return host_of(node, vectors, start_ns)
    if node.component.compiled:
        if node.model.endswith(".py") and (wrong := beyond(node.component, vectors, start_ns, dt_ns)):
            raise TowlineError(f"{node.name} ({node.model}): {wrong}")
        try:
            return compiled.bind(node.component)
        except Exception as error:  # numba's are of many kinds
            text = f"{node.name} ({node.model}) cannot be compiled: {refusal(error)} (--debug shows all)"
            raise TowlineError(text) from error
    return PythonHost(node.component.init, node.component.step, vectors, node.inputs, node.outputs)


def _bonds(graph: Graph, u: list[slice], starts: np.ndarray) -> np.ndarray:
    n = len(graph.nodes)
    rows = []
    for j, b in enumerate(graph.bonds):
        other = b.other or OtherEnd(bond=-1, cross=0, is_first=False, accelerance=0)
        own = (b.line, b.body, b.motion, b.accepted, u[b.body].start + b.target, b.rounds, n + j)
        rows.append((*own, other.bond, other.cross, int(other.is_first), other.accelerance))
    return _rows(rows, 11)


def _groups(graph: Graph) -> tuple[np.ndarray, np.ndarray]:
    """Order of nodes and table of groups; bonds are in the order of the groups that hold them."""
    order: list[int] = []
    groups: list[tuple[int, ...]] = []
    bond = 0
    for members in execution_order(graph):
        count = sum(b.line in members for b in graph.bonds)
        groups.append((len(order), len(order) + len(members), bond, bond + count))
        bond += count
        order += members
    return np.array(order, np.int64), _rows(groups, 4)


def lay_out(graph: Graph) -> Memory:
    """Allocate a graph's memory, compile or load its components and fill the loop's tables."""
    packed, spans = _vectors(graph)
    terms, gains, offsets, delayed, initial, first = _terms(graph, spans["u"])
    lengths, starts, total, ticks = _capture_layout(graph)
    parameters = np.concatenate([*packed, np.zeros(1)])
    arrays = {v: _array(max((span.stop for span in spans[v]), default=0)) for v in "uxw"}
    arrays |= {"p": parameters, "y": _array(graph.board + len(initial))}
    arrays["y"][graph.board :][: len(initial)] = initial
    rows, inits, hosts, entries = [], [], {}, []
    for i, node in enumerate(graph.nodes):
        vectors = [arrays[v][spans[v][i]] for v in "puxyw"]
        entry = _entry(node, vectors, graph.start_ns, node.period * graph.base_ns)
        entries.append(entry)
        addresses = [arrays[v].ctypes.data + 8 * spans[v][i].start for v in "puxyw"]
        if not isinstance(entry, compiled.EntryPoints):
            hosts[i] = entry
            addresses[-1] = entry.workspace or addresses[-1]
        x, y = spans["x"][i], spans["y"][i]
        places = (y.start, numbers_in(node.outputs), x.start, x.stop - x.start, first[i], first[i + 1])
        rows.append((entry.step, *addresses, node.period * graph.base_ns, node.period, *places, node.width, 0))
        inits.append(entry.init)
    capture = _array(total)
    order, groups = _groups(graph)
    tables = Tables(
        clock=np.zeros(3, np.int64),
        nodes=_rows(rows, 16),
        order=order,
        groups=groups,
        terms=terms,
        gains=gains,
        offsets=offsets,
        delayed=delayed,
        bonds=_bonds(graph, spans["u"], starts),
        tolerances=np.array([bond.tolerance for bond in graph.bonds], np.float64),
        bond_energy=np.zeros((len(graph.bonds), BOND_STATE)),
        laws=np.zeros((len(graph.bonds), LAW)),
        best_laws=np.zeros((len(graph.bonds), LAW)),
        system=np.zeros((3, 7)),
        inputs=arrays["u"],
        states=arrays["x"],
        saved=arrays["x"].copy(),
        board=arrays["y"],
        added=np.zeros(max(graph.board, 1)),
        capture=capture,
        capture_ns=capture.view(np.int64),
        filled=starts.copy(),
    )
    inits = np.array(inits, np.int64)
    return Memory(tables, inits, parameters, arrays["w"], spans, hosts, entries, starts, lengths, ticks)
