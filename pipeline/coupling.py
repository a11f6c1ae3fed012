"""Refuses a body that takes a line's force one step late where that is unstable, and says how to tie them instead.

Such a coupling amplifies by about G/M a step, G the line's effective end mass -dF/da [kg] and M the body's own, and by
(h sqrt(K/M))^2 once the line is taut. G and M are found by trying: the line's first law, the body's answer to a force.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from components.contract import LineEnd, Port
from pipeline import native_loop as loop
from pipeline.conductor import Conductor
from pipeline.errors import Place, Problem, WiringError
from pipeline.graph import Graph, Node, alone
from pipeline.memory import lay_out

LIMIT = 0.1  # of G/M and of h sqrt(K/M); growth begins near 1, and what is below it must still be damped
PROBE_N = 1e-3  # small against any force, large against rounding


@dataclass(frozen=True)
class ForceLoop:
    """Line `line` has its end moved by node `body`, which takes the end's force, delayed, at u[target : target + 3]."""

    line: int
    end: str
    body: int
    target: int


def _place(ports: tuple[Port, ...], name: str) -> int:
    """Where a port begins in its vector."""
    return sum(port.size for port in ports[: [port.name for port in ports].index(name)])


def _feeds(consumer: Node, first: int, count: int, producer: Node, at: int, delayed: bool) -> int | None:
    """Where in the consumer's u the producer's outputs at..at+count arrive, if they do."""
    for term in consumer.terms:
        shift = producer.start + at - term.source
        inside = shift >= 0 and shift + count <= term.count
        if inside and term.gain == 1.0 and term.delayed == delayed and first in (-1, term.target + shift):
            return term.target + shift
    return None


def force_loops(graph: Graph) -> list[ForceLoop]:
    """All lines' ends whose force goes back, one step late, to the body that moves them."""
    found = []
    for i, line in enumerate(graph.nodes):
        for name, end in line.component.lines.items():
            if f"{end.motion}.position" not in [port.name for port in line.inputs]:
                continue
            taken, given = _place(line.inputs, f"{end.motion}.position"), _place(line.outputs, end.force)
            for j, body in enumerate(graph.nodes):
                target = _feeds(body, -1, 3, line, given, delayed=True)
                if target is not None and _moves(body, line, taken):
                    found.append(ForceLoop(i, name, j, target))
    return found


def _moves(body: Node, line: Node, taken: int) -> bool:
    """Whether the body gives the line the position that it takes at u[taken : taken + 3]."""
    places = [_place(body.outputs, port.name) for port in body.outputs if port.shape == (3,)]
    return any(_feeds(line, taken, 3, body, at, delayed=False) is not None for at in places)


def _end_mass(graph: Graph, node: int, end: LineEnd, u: np.ndarray) -> np.ndarray:
    """G (3, 3) [kg] of a line's end at t0, from the law it would give a bond."""
    line = graph.nodes[node]
    changed = type(line.parameters).model_validate({**line.parameters.model_dump(), end.switch: True})
    outputs = line.component.outputs(changed)
    memory = lay_out(alone(graph, replace(line, parameters=changed, outputs=outputs)))
    memory.tables.inputs[: len(u)] = u
    loop.initialise(memory.tables, memory.inits, 1, graph.start_ns)
    at = _place(outputs, f"{end.law}.mass")
    return memory.tables.board[at : at + 9].reshape(3, 3)


def _answer(graph: Graph, node: int, u: np.ndarray) -> np.ndarray:
    """A body's outputs after one step from t0 with the inputs u."""
    memory = lay_out(alone(graph, graph.nodes[node]))
    memory.tables.inputs[: len(u)] = u
    loop.initialise(memory.tables, memory.inits, 1, graph.start_ns)
    loop.advance(memory.tables, graph.nodes[node].period, graph.start_ns, graph.base_ns)
    return memory.tables.board.copy()


def _accelerance(graph: Graph, found: ForceLoop, motion: int, u: np.ndarray) -> np.ndarray:
    """da/dF (3, 3) [1/kg] of a body over one step, by trying a small force along each axis."""
    plain = _answer(graph, found.body, u)
    columns = []
    for axis in range(3):
        pushed = u.copy()
        pushed[found.target + axis] += PROBE_N
        columns.append((_answer(graph, found.body, pushed) - plain)[motion : motion + 3] / PROBE_N)
    return np.stack(columns, axis=1)


def _ratios(graph: Graph, conductor: Conductor, found: ForceLoop) -> tuple[float, float]:
    """G/M of a loop at t0, and h sqrt(K/M) with the taut line's stiffness K, which a slack start does not show."""
    line, body = graph.nodes[found.line], graph.nodes[found.body]
    end = line.component.lines[found.end]
    spans, tables = conductor.memory.spans["u"], conductor.memory.tables
    taken = _place(line.inputs, f"{end.motion}.acceleration")
    source = next(t.source + taken - t.target for t in line.terms if t.target <= taken < t.target + t.count)
    mass = _end_mass(graph, found.line, end, tables.inputs[spans[found.line]])
    accelerance = _accelerance(graph, found, source - body.start, tables.inputs[spans[found.body]])
    h = line.period * graph.base_ns * 1e-9
    greatest = float(np.abs(np.linalg.eigvals(accelerance)).max())
    stiff = h * np.sqrt(end.stiffness(line.parameters) * greatest)
    return float(np.abs(np.linalg.eigvals(accelerance @ mass)).max()), float(stiff)


def refuse_unstable(graph: Graph, source: str) -> None:
    """Raise WiringError if a plainly delayed force would be unstable or nearly so. source: the scenario's name."""
    loops = force_loops(graph)
    if not loops:
        return
    conductor = Conductor(graph)
    conductor.initialise()
    problems = []
    for found in loops:
        line, body = graph.nodes[found.line].name, graph.nodes[found.body].name
        mass, stiffness = _ratios(graph, conductor, found)
        if max(mass, stiffness) > LIMIT:
            text = (
                f"{body} takes the force of {line}.{found.end} one step late: unstable (G/M = {mass:.2g}, "
                f"h sqrt(K/M) = {stiffness:.2g}, limit {LIMIT}); tie them with a bond: bonds: {{tie: {{body: "
                f"{body}.<end>, line: {line}.{found.end}}}}}, or take a heavier body or a shorter step"
            )
            problems.append(Problem(Place(source), f"components.{body}.inputs", text))
    if problems:
        raise WiringError(problems)
