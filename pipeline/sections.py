"""Cuts a graph's schedule into sections: maximal runs of one host's components that it allows back to back.

Components with images are in sections with those of their own period only: their messages are large, and travel when a
section is due.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from components.contract import ImagePort
from pipeline.graph import Bond, Graph, Node, OtherEnd, Term, execution_order


@dataclass(frozen=True)
class Section:
    """Some of one host's components, stepped back to back in a tick, and what they read from elsewhere.

    stage: sections of one stage do not depend on each other within a tick. nodes, bonds: indices in the whole graph.
    outside: (k,) places on the whole graph's board (its delayed copies behind its signals) of what is read from other
    sections. graph: of the section alone; its board is that of its nodes, then the k numbers from outside.
    """

    number: int
    host: str
    stage: int
    nodes: tuple[int, ...]
    bonds: tuple[int, ...]
    outside: np.ndarray
    graph: Graph

    @property
    def signals(self) -> int:
        """Numbers that its nodes put on the board."""
        return sum(node.width for node in self.graph.nodes)

    @cached_property
    def periods(self) -> tuple[int, ...]:
        """The different periods of its components, in ticks."""
        return tuple(sorted({node.period for node in self.graph.nodes}))

    @cached_property
    def is_due_always(self) -> bool:
        """Whether one of its components steps in every tick."""
        return self.periods[0] == 1

    def is_due(self, tick: int) -> bool:
        """Whether one of its components steps in the tick."""
        return self.is_due_always or any(tick % period == 0 for period in self.periods)

    def next_due(self, tick: int) -> int:
        """The first tick after this one in which one of them steps."""
        return tick + 1 if self.is_due_always else min((tick // period + 1) * period for period in self.periods)


Where = tuple[str, int]


def cut(graph: Graph, hosts: Sequence[str]) -> tuple[Section, ...]:
    """Sections in the order of their stages, and within a stage of their first nodes. hosts: of each node."""
    groups = execution_order(graph)
    after = _successors(graph, groups)
    where = [_where(graph.nodes[members[0]], hosts[members[0]]) for members in groups]
    stage = _earliest(after, where)
    _put_off(stage, after, where)
    members: dict[tuple[int, Where], list[int]] = {}
    for group in range(len(groups)):
        members.setdefault((stage[group], where[group]), []).append(group)
    ordered = sorted(members.items(), key=lambda item: (item[0][0], min(groups[g][0] for g in item[1])))
    delayed = _delayed_places(graph)
    return tuple(
        _section(number, name, at, graph, [groups[g] for g in inside], delayed)
        for number, ((at, (name, _)), inside) in enumerate(ordered)
    )


def _where(node: Node, host: str) -> Where:
    """What a group shares with those that may be in its section: the host, and with images the period; else 0."""
    has_images = any(isinstance(port, ImagePort) for port in (*node.inputs, *node.outputs))
    return host, node.period if has_images else 0


def _producers(graph: Graph) -> np.ndarray:
    """The node that writes each signal of the board."""
    return np.repeat(np.arange(len(graph.nodes)), [node.width for node in graph.nodes])


def _successors(graph: Graph, groups: list[tuple[int, ...]]) -> list[set[int]]:
    """For each group those that read it directly; all of them come later in the list."""
    producer = _producers(graph)
    group_of = {node: number for number, members in enumerate(groups) for node in members}
    after: list[set[int]] = [set() for _ in groups]
    for i, node in enumerate(graph.nodes):
        for term in node.terms:
            if not term.delayed and term.gain != 0.0:
                for j in np.unique(producer[term.source : term.source + term.count]).tolist():
                    if group_of[j] != group_of[i]:
                        after[group_of[j]].add(group_of[i])
    return after


def _earliest(after: list[set[int]], where: list[Where]) -> list[int]:
    """Each group's first possible stage: one after its producers' elsewhere, no earlier than those at its own place."""
    stage = [0] * len(after)
    for group, later in enumerate(after):
        for other in later:
            stage[other] = max(stage[other], stage[group] + (where[other] != where[group]))
    return stage


def _put_off(stage: list[int], after: list[set[int]], where: list[Where]) -> None:
    """Join each section to its place's next one where no other place waits for it in between."""
    for at in range(max(stage, default=0) - 1, -1, -1):
        for name in sorted({where[group] for group in range(len(stage)) if stage[group] == at}):
            inside = [group for group in range(len(stage)) if stage[group] == at and where[group] == name]
            following = min((s for s, h in zip(stage, where, strict=True) if h == name and s > at), default=None)
            waiting = [stage[g] for group in inside for g in after[group] if where[g] != name]
            if following is not None and all(following < s for s in waiting):
                for group in inside:
                    stage[group] = following


def _delayed_places(graph: Graph) -> dict[tuple[int, int], int]:
    """Where memory.lay_out puts the copy of each delayed term, by node and place in its terms."""
    places, at = {}, graph.board
    for i, node in enumerate(graph.nodes):
        for j, term in enumerate(node.terms):
            if term.delayed:
                places[i, j] = at
                at += term.count
    return places


def _section(
    number: int,
    host: str,
    stage: int,
    graph: Graph,
    groups: list[tuple[int, ...]],
    delayed: dict[tuple[int, int], int],
) -> Section:
    nodes = sorted(node for group in groups for node in group)
    signals = np.concatenate([np.arange(n.start, n.start + n.width) for n in (graph.nodes[i] for i in nodes)])
    place = np.full(graph.board, -1)  # on the section's board, of its own signals
    place[signals] = np.arange(len(signals))
    copies = sum(term.count for node in graph.nodes for term in node.terms if term.delayed)
    foreign = np.full(graph.board + copies, -1)  # on the section's board, of what it reads from elsewhere
    outside: list[np.ndarray] = []

    def seen(i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        """Where the section reads the numbers of node i's term j, and whether these are its own signals."""
        term = graph.nodes[i].terms[j]
        source = np.arange(term.source, term.source + term.count)
        own = place[source] >= 0
        whole = delayed[i, j] + np.arange(term.count) if term.delayed else source
        new = whole[~own & (foreign[whole] < 0)]
        foreign[new] = len(signals) + sum(map(len, outside)) + np.arange(len(new))
        outside.append(new)
        return np.where(own, place[source], foreign[whole]), own

    renumbered = {node: index for index, node in enumerate(nodes)}
    inside = [_moved(graph.nodes[i], i, place, seen) for i in nodes]
    bonds = [j for j, bond in enumerate(graph.bonds) if bond.line in renumbered]
    alone = replace(
        graph,
        nodes=tuple(inside),
        stages=(tuple(tuple(renumbered[i] for i in group) for group in groups),),
        board=len(signals) + sum(map(len, outside)),
        bonds=tuple(_moved_bond(graph.bonds[j], renumbered, bonds, place) for j in bonds),
        events=(),
    )
    return Section(
        number, host, stage, tuple(nodes), tuple(bonds), np.concatenate([[], *outside]).astype(np.int64), alone
    )


Seen = Callable[[int, int], tuple[np.ndarray, np.ndarray]]


def _moved(node: Node, i: int, place: np.ndarray, seen: Seen) -> Node:
    """The node on the section's board; what comes from other sections is read there directly."""
    terms = [
        part
        for j, term in enumerate(node.terms)
        for part in ([term] if term.gain == 0.0 else _parts(term, *seen(i, j)))
    ]
    return replace(node, start=int(place[node.start]) if node.width else 0, terms=tuple(terms))


def _parts(term: Term, places: np.ndarray, own: np.ndarray) -> Iterable[Term]:
    """A term made into ones whose sources follow each other on the section's board; each number stays the same."""
    cuts = (np.flatnonzero((np.diff(places) != 1) | (own[1:] != own[:-1])) + 1).tolist()
    parts = []
    for first, end in zip([0, *cuts], [*cuts, term.count], strict=True):
        is_delayed = term.delayed and bool(own[first])
        part = replace(
            term,
            target=term.target + first,
            source=int(places[first]),
            count=end - first,
            offset=term.offset[first:end],
            delayed=is_delayed,
            initial=term.initial[first:end] if is_delayed else (),
        )
        parts.append(part)
    return parts


def _moved_bond(bond: Bond, nodes: dict[int, int], bonds: list[int], place: np.ndarray) -> Bond:
    other = bond.other
    if other is not None:
        at = int(place[other.cross]), int(place[other.accelerance])
        other = OtherEnd(bonds.index(other.bond), at[0], other.is_first, at[1])
    return replace(
        bond,
        line=nodes[bond.line],
        body=nodes[bond.body],
        motion=int(place[bond.motion]),
        law=int(place[bond.law]),
        accepted=int(place[bond.accepted]),
        other=other,
    )
