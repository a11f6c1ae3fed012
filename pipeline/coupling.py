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
from pipeline.hosts.fmu.component import FmuComponent
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
    try:
        memory.tables.inputs[: len(u)] = u
        loop.initialise(memory.tables, memory.inits, 1, graph.start_ns)
        loop.advance(memory.tables, graph.nodes[node].period, graph.start_ns, graph.base_ns)
        return memory.tables.board.copy()
    finally:
        memory.close()  # of an FMU there may be one instance only


def _response(graph: Graph, found: ForceLoop, motion: int, u: np.ndarray) -> np.ndarray:
    """Change (3, 3) of an output of a body over one step, by trying a small force along each axis [1/N]."""
    plain = _answer(graph, found.body, u)
    columns = []
    for axis in range(3):
        pushed = u.copy()
        pushed[found.target + axis] += PROBE_N
        columns.append((_answer(graph, found.body, pushed) - plain)[motion : motion + 3] / PROBE_N)
    return np.stack(columns, axis=1)


def _given(line: Node, body: Node, taken: int) -> int | None:
    """Where in the body's outputs u[taken] of the line comes from, if it does."""
    for term in line.terms:
        at = term.source + taken - term.target - body.start
        if term.target <= taken < term.target + term.count and term.gain == 1.0 and 0 <= at < body.width:
            return at
    return None


def _accelerance(graph: Graph, found: ForceLoop, motion: str, u: np.ndarray) -> np.ndarray:
    """da/dF (3, 3) [1/kg] of a body over one step, from the best that the line is given of its motion."""
    line, body = graph.nodes[found.line], graph.nodes[found.body]
    h = body.period * graph.base_ns * 1e-9
    for name, scale in (("acceleration", 1.0), ("velocity", 1.0 / h), ("position", 2.0 / h**2)):
        at = _given(line, body, _place(line.inputs, f"{motion}.{name}"))
        if at is not None:
            return scale * _response(graph, found, at, u)
    raise AssertionError("force_loops() finds bodies that give the position")


def _ratios(graph: Graph, inputs: list[np.ndarray], found: ForceLoop) -> tuple[float, float]:
    """G/M of a loop at t0, and h sqrt(K/M) with the taut line's stiffness K, which a slack start does not show.

    inputs: of every node at t0.
    """
    line = graph.nodes[found.line]
    end = line.component.lines[found.end]
    mass = _end_mass(graph, found.line, end, inputs[found.line])
    accelerance = _accelerance(graph, found, end.motion, inputs[found.body])
    h = line.period * graph.base_ns * 1e-9
    greatest = float(np.abs(np.linalg.eigvals(accelerance)).max())
    stiff = h * np.sqrt(end.stiffness(line.parameters) * greatest)
    return float(np.abs(np.linalg.eigvals(accelerance @ mass)).max()), float(stiff)


def _inputs(graph: Graph) -> list[np.ndarray]:
    """u of every node as its init takes it."""
    conductor = Conductor(graph)
    try:
        conductor.initialise()
        return [conductor.memory.tables.inputs[span].copy() for span in conductor.memory.spans["u"]]
    finally:
        conductor.close()


def refuse_unstable(graph: Graph, source: str) -> None:
    """Raise WiringError if a plainly delayed force would be unstable or nearly so. source: the scenario's name."""
    loops = force_loops(graph)
    if not loops:
        return
    inputs = _inputs(graph)
    problems = []
    for found in loops:
        line, body = graph.nodes[found.line].name, graph.nodes[found.body].name
        mass, stiffness = _ratios(graph, inputs, found)
        if max(mass, stiffness) > LIMIT:
            tie = f"tie them with a bond: bonds: {{tie: {{body: {body}.<end>, line: {line}.{found.end}}}}}"
            if isinstance(graph.nodes[found.body].component, FmuComponent):
                tie = "give the body by `model:` and tie them with a bond, which no FMU can be in"
            text = (
                f"{body} takes the force of {line}.{found.end} one step late: unstable (G/M = {mass:.2g}, "
                f"h sqrt(K/M) = {stiffness:.2g}, limit {LIMIT}); {tie}, or take a heavier body or a shorter step"
            )
            problems.append(Problem(Place(source), f"components.{body}.inputs", text))
    if problems:
        raise WiringError(problems)
