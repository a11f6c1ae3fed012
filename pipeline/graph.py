"""The validated wiring plus schedule: what the conductor steps, with every name resolved to an index."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from components.contract import Component, Parameters, Port


@dataclass(frozen=True)
class Term:
    """One addend of an input: u[target : target+count] takes gain * board[source : source+count] + offset.

    The first term of a target assigns, later ones add, in the order of the YAML. A constant has gain 0 and source 0.
    delayed: the source is read as the tick began; initial is then what init reads at t0 (count values, input's unit
    before gain and offset are applied: the signal's own value). is_image: the numbers are an image's bytes.
    """

    target: int
    source: int
    count: int
    gain: float = 1.0
    offset: tuple[float, ...] = ()  # count values, or none for zero
    delayed: bool = False
    initial: tuple[float, ...] = ()  # count values, or none for zero
    assigns: bool = True
    is_image: bool = False


@dataclass(frozen=True)
class Node:
    """One component instance. Its outputs are board[start : start + n_y]."""

    name: str
    model: str  # as written in the scenario
    component: Component
    parameters: Parameters
    seed: int
    period: int  # ticks
    record_every: int  # own steps between recorded messages; 0 records nothing
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    start: int
    terms: tuple[Term, ...]

    @property
    def width(self) -> int:
        """How many float64 it puts on the board, images included."""
        return sum(port.size for port in self.outputs)


@dataclass(frozen=True)
class OtherEnd:
    """The other end of a bond's line, where that is bonded too: what is needed to let it yield with the body there."""

    bond: int  # index in Graph.bonds
    cross: int  # board: -dF_a / d acceleration_b between the line's two ends (9)
    is_first: bool  # whether the other end is a
    accelerance: int  # board: of the body there (9)


@dataclass(frozen=True)
class Bond:
    """A line's end tied to a body: board indices of the bundles, and where the body's law enters its u.

    other: None where the other end is no bond's, or is not known to yield alone (see wiring.py).
    """

    name: str
    line: int  # node index
    body: int
    motion: int  # board: position, velocity, acceleration (9)
    law: int  # board: the line's law for the next step (15)
    accepted: int  # board: the line's law about the accepted motion (15)
    target: int  # in the body's u (15)
    tolerance: float  # N
    rounds: int
    other: OtherEnd | None = None


@dataclass(frozen=True)
class Event:
    """Fires as the tick that starts at `tick` begins: sets tunable parameters, or offsets signals from then on."""

    tick: int
    set: tuple[tuple[int, dict[str, Any]], ...] = ()  # (node, {parameter: SI value})
    add: tuple[tuple[int, tuple[float, ...]], ...] = ()  # (first board index, values)
    until: int = -1  # tick at which `add` ends; -1: never
    text: str = ""  # as written


@dataclass(frozen=True)
class Graph:
    """Nodes in the order of the YAML; `stages` is the order of execution.

    A stage is a tuple of groups that do not depend on each other within a tick; a group is a tuple of node indices
    that run back to back (more than one where power bonds tie them). Bonds stand in the order of their groups.
    """

    base_ns: int
    ticks: int
    nodes: tuple[Node, ...]
    stages: tuple[tuple[tuple[int, ...], ...], ...]
    board: int
    bonds: tuple[Bond, ...] = ()
    events: tuple[Event, ...] = ()
    start_ns: int = 0  # t0


def execution_order(graph: Graph) -> list[tuple[int, ...]]:
    """Groups of node indices, in the order in which a tick runs them."""
    return [group for stage in graph.stages for group in stage]


def alone(graph: Graph, node: Node) -> Graph:
    """A graph of one node and the events that touch it; its inputs are left to the caller.

    node: one of the graph's, or the same with other parameters.
    """
    i = [other.name for other in graph.nodes].index(node.name)
    start, end = graph.nodes[i].start, graph.nodes[i].start + graph.nodes[i].width
    events = []
    for event in graph.events:
        sets = tuple((0, changes) for target, changes in event.set if target == i)
        adds = tuple((first - start, values) for first, values in event.add if start <= first < end)
        if sets or adds:
            events.append(Event(event.tick, sets, adds, event.until, event.text))
    single = replace(node, start=0, terms=())
    return replace(graph, nodes=(single,), stages=(((0,),),), board=single.width, bonds=(), events=tuple(events))
