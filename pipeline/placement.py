"""Where components of a distributed run live: `hosts:` and `machines:` of a scenario, and how long they may take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pipeline.catalogue import closest
from pipeline.document import IDENTIFIER, NOT_A_NAME, MachineEntry, below, validated
from pipeline.errors import Place, Problem
from pipeline.graph import Graph, execution_order
from pipeline.quantities import shown
from pipeline.yaml_source import Scalar, Table, plain

OVERDUE_S = 1.0  # wall time after which a component that has not answered is taken to hang, unless the scenario says


@dataclass(frozen=True)
class Hosts:
    """hosts: component -> host, as far as written. places: of these entries in the file.

    machines: hosts that are not processes of this machine -> ns of wall time that the run waits for them.
    """

    hosts: Mapping[str, str] = field(default_factory=dict)
    machines: Mapping[str, int] = field(default_factory=dict)
    places: Mapping[str, Place] = field(default_factory=dict)

    def written(self) -> dict[str, object]:
        """As the scenario's keys."""
        machines = {name: {"limit": f"{limit_ns} ns"} for name, limit_ns in self.machines.items()}
        return {**({"hosts": dict(self.hosts)} if self.hosts else {}), **({"machines": machines} if machines else {})}


@dataclass(frozen=True)
class Placement:
    """hosts, overdue_s: of each node. limits_s: of the hosts that are other machines."""

    hosts: tuple[str, ...]
    overdue_s: tuple[float, ...]
    limits_s: Mapping[str, float] = field(default_factory=dict)


def read_hosts(tree: Table, components: Sequence[str], problems: list[Problem]) -> Hosts:
    """The two keys of a scenario's top level."""
    hosts, places = {}, {}
    for name, entry in _entries(tree, "hosts").items():
        path = below("hosts", name)
        if name not in components:
            text = f"unknown component '{name}'{closest(name, list(components))}"
            problems.append(Problem(_keys(tree, "hosts")[name], path, text))
        elif not isinstance(entry, Scalar) or not IDENTIFIER.fullmatch(str(entry.value)):
            problems.append(Problem(entry.place, path, f"{shown(plain(entry))} is {NOT_A_NAME}"))
        else:
            hosts[name], places[name] = str(entry.value), entry.place
    return Hosts(hosts, _machines(tree, hosts, problems), places)


def _machines(tree: Table, hosts: Mapping[str, str], problems: list[Problem]) -> dict[str, int]:
    machines = {}
    for name, entry in _entries(tree, "machines").items():
        path = below("machines", name)
        if name not in hosts.values():
            text = f"no component is on it{closest(name, sorted(set(hosts.values())))}; place one with hosts:"
            problems.append(Problem(_keys(tree, "machines")[name], path, text))
        machine = validated(MachineEntry, entry, path, problems)
        if machine is not None:
            machines[name] = machine.limit
    return machines


def _entries(tree: Table, key: str) -> dict:
    inside = tree.entries.get(key)
    return inside.entries if isinstance(inside, Table) else {}


def _keys(tree: Table, key: str) -> dict[str, Place]:
    inside = tree.entries.get(key)
    return inside.keys if isinstance(inside, Table) else {}


def parted(names: Sequence[str], group: Sequence[int], hosts: Mapping[str, str]) -> str | None:
    """The first component of a bonded group that is not on the host of those before it; None where all are on one."""
    written = [names[i] for i in group if names[i] in hosts]
    return next((name for name in written if hosts[name] != hosts[written[0]]), None)


def placement_of(graph: Graph, hosts: Hosts, overdue_s: Mapping[str, float]) -> Placement:
    """Each node's host: the written one, else that of what it is bonded to, else a process with its own name."""
    names = [node.name for node in graph.nodes]
    places = [""] * len(names)
    for group in execution_order(graph):
        known = [hosts.hosts[names[i]] for i in group if names[i] in hosts.hosts]
        for i in group:
            places[i] = known[0] if known else names[min(group)]
    limits_s = {name: limit_ns / 1e9 for name, limit_ns in hosts.machines.items()}
    return Placement(tuple(places), tuple(overdue_s.get(name, OVERDUE_S) for name in names), limits_s)
