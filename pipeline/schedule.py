"""The order of execution: stages by depth over direct wires, groups by power bonds, and cycles found by name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Edge = tuple[int, int]  # (producer, consumer)
Stages = tuple[tuple[tuple[int, ...], ...], ...]  # groups of nodes, see Graph


def stages(nodes: int, direct: Iterable[Edge], bonds: Iterable[Edge] = ()) -> tuple[tuple[tuple[int, ...], ...], ...]:
    """Stages of groups of nodes 0 .. nodes-1; the direct edges must be free of cycles.

    bonds: (body, line). A group holds both and everything on a direct path between them: it is a strongly connected
    component of the direct edges and the bonds backwards. A stage holds the groups of one depth (longest path of
    direct edges). Groups in a stage stand in the order of their first node, nodes in a group in order of execution.
    """
    direct = set(direct)
    order = _topological(nodes, direct)
    groups = components(nodes, direct | {(line, body) for body, line in bonds})
    group_of = {node: number for number, group in enumerate(groups) for node in group}
    between = {(group_of[a], group_of[b]) for a, b in direct if group_of[a] != group_of[b]}
    depth = [0] * len(groups)
    after = _successors(len(groups), between)
    for number in _topological(len(groups), between):
        for later in after[number]:
            depth[later] = max(depth[later], depth[number] + 1)
    rank = {node: position for position, node in enumerate(order)}
    result: list[list[tuple[int, ...]]] = [[] for _ in range(max(depth, default=-1) + 1)]
    for number in sorted(range(len(groups)), key=lambda number: min(groups[number])):
        result[depth[number]].append(tuple(sorted(groups[number], key=rank.__getitem__)))
    return tuple(tuple(stage) for stage in result)


def cycles(nodes: int, direct: Iterable[Edge]) -> list[list[int]]:
    """One shortest cycle for each knot of direct edges: its nodes in the direction of the wires."""
    direct = set(direct)
    after = _successors(nodes, direct)
    found = []
    for knot in components(nodes, direct):
        first = min(knot)
        if len(knot) > 1 or first in after[first]:
            found.append(_shortest_cycle(knot, after))
    return found


def components(nodes: int, edges: Iterable[Edge]) -> list[list[int]]:
    """Strongly connected components (Tarjan 1972, without recursion), each sorted, in order of their first node."""
    after = _successors(nodes, edges)
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    waiting: list[int] = []
    is_waiting = [False] * nodes
    result: list[list[int]] = []
    for root in range(nodes):
        path = [(root, iter(after[root]))] if root not in index else []
        while path:
            node, rest = path[-1]
            if node not in index:
                index[node] = low[node] = len(index)
                waiting.append(node)
                is_waiting[node] = True
            for later in rest:
                if later not in index:
                    path.append((later, iter(after[later])))
                    break
                if is_waiting[later]:
                    low[node] = min(low[node], index[later])
            else:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    result.append(_popped(waiting, node, is_waiting))
    return sorted(result)


def _popped(waiting: list[int], last: int, is_waiting: list[bool]) -> list[int]:
    """The top of the stack down to the node `last`, sorted."""
    group = []
    while not group or group[-1] != last:
        group.append(waiting.pop())
        is_waiting[group[-1]] = False
    return sorted(group)


def _successors(nodes: int, edges: Iterable[Edge]) -> list[list[int]]:
    after: list[list[int]] = [[] for _ in range(nodes)]
    for producer, consumer in sorted(edges):
        after[producer].append(consumer)
    return after


def _topological(nodes: int, edges: Iterable[Edge]) -> list[int]:
    """Nodes by depth, ties by number (Kahn 1962)."""
    edges = list(edges)
    after, missing = _successors(nodes, edges), [0] * nodes
    for _, consumer in edges:
        missing[consumer] += 1
    level = [node for node in range(nodes) if missing[node] == 0]
    order: list[int] = []
    while level:
        order.extend(level)
        following = []
        for node in level:
            for later in after[node]:
                missing[later] -= 1
                if missing[later] == 0:
                    following.append(later)
        level = sorted(following)
    return order


def _shortest_cycle(knot: Sequence[int], after: list[list[int]]) -> list[int]:
    """Breadth first from the knot's first node back to itself."""
    first, inside = knot[0], set(knot)
    came_from: dict[int, int] = {}
    queue = [first]
    for node in queue:
        for later in after[node]:
            if later == first:
                cycle = [node]
                while cycle[-1] != first:
                    cycle.append(came_from[cycle[-1]])
                return cycle[::-1]
            if later in inside and later not in came_from:
                came_from[later] = node
                queue.append(later)
    raise AssertionError("a knot without a cycle")
