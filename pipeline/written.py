"""What a scenario says once it is read: components, wires, bonds and events, each with its place in the YAML."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from components.contract import Component, Parameters
from pipeline import parameters
from pipeline.document import Record
from pipeline.errors import Place
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.placement import Hosts
from pipeline.signals import Reference
from pipeline.yaml_source import CoreDumper, Items, Table, Tree, plain


@dataclass(frozen=True)
class Addend:
    """One addend of a wire: gain * source + offset, or a constant.

    source None: `offset` is the constant. gain, offset, initial: as written, None where not.
    """

    place: Place
    path: str
    source: Reference | None = None
    gain: Tree | None = None
    offset: Tree | None = None
    initial: Tree | None = None
    delayed: bool = False


@dataclass(frozen=True)
class Wire:
    """What feeds an input port, a part of one, or a bundle."""

    place: Place
    path: str
    port: str
    slice: str | None
    addends: tuple[Addend, ...]


@dataclass(frozen=True)
class Instance:
    """One component of the scenario; period_ns 0: the base step; overdue_ns 0: as any. given: where its parameters were
    given last."""

    name: str
    place: Place
    path: str
    model: str
    component: Component
    parameters: Parameters
    period_ns: int
    record: Record
    wires: tuple[Wire, ...]
    tree: Table
    given: Place
    overdue_ns: int = 0


@dataclass(frozen=True)
class Tie:
    """A power bond as written."""

    name: str
    place: Place
    path: str
    body: Reference
    line: Reference
    tolerance: float
    rounds: int
    places: dict[str, Place]  # of body and line

    def wire(self, port: str, producer: str, bundle: str, *, delayed: bool) -> Wire:
        """One of the two wires that the bond stands for."""
        source = Addend(self.place, self.path, Reference(producer, bundle), delayed=delayed)
        return Wire(self.place, self.path, port, None, (source,))


@dataclass(frozen=True)
class Change:
    """What an event sets (a parameter) or adds to (a signal); key: the place of its name."""

    key: Place
    path: str
    what: Reference
    value: Tree


@dataclass(frozen=True)
class Happening:
    """An event as written; until_ns None: `adds` stay."""

    place: Place
    path: str
    at_ns: int
    until_ns: int | None
    sets: tuple[Change, ...]
    adds: tuple[Change, ...]
    places: dict[str, Place]  # of its keys' values


@dataclass(frozen=True)
class Scenario:
    """A scenario, its parameters in SI and its wires as written; times in ns, scene_ns None: no 3D scene.

    folder: what relative paths are relative to. limit: where the duration stands, in the file or on the command line.
    broken, unread: components and bonds that could not be read (none in a Scenario that load_scenario returns).
    """

    name: str
    description: str
    source: str
    folder: Path
    duration_ns: int
    step_ns: int
    start_ns: int
    seed: int
    bus: str
    hosts: Hosts
    scene_ns: int | None
    instances: tuple[Instance, ...]
    ties: tuple[Tie, ...]
    happenings: tuple[Happening, ...]
    tree: Table
    limit: Place
    broken: frozenset[str] = frozenset()
    unread: frozenset[str] = frozenset()

    @property
    def scene_hz(self) -> float:
        """Rate of the 3D scene; 0 for none."""
        return 1e9 / self.scene_ns if self.scene_ns else 0.0

    def resolved_text(self) -> str:
        """The scenario as one YAML text without other files; it gives the same graph, bit for bit."""
        document: dict[str, Any] = {
            "name": self.name,
            "description": self.description,
            "duration": f"{self.duration_ns} ns",
            "step": f"{self.step_ns} ns",
            "start": f"{self.start_ns} ns",
            "seed": self.seed,
            "bus": self.bus,
            **self.hosts.written(),
            "scene": False if self.scene_ns is None else f"{self.scene_ns} ns",
            "components": {instance.name: _resolved(instance) for instance in self.instances},
        }
        if "bonds" in self.tree.entries:
            document["bonds"] = plain(self.tree.entries["bonds"])
        if self.happenings:
            events = self.tree.entries["events"]
            assert isinstance(events, Items)
            kept = {happening.place for happening in self.happenings}
            document["events"] = [plain(event) for event in events.items if event.place in kept]
        return yaml.dump(
            document, Dumper=CoreDumper, sort_keys=False, allow_unicode=True, default_flow_style=None, width=120
        )


def _resolved(instance: Instance) -> dict[str, Any]:
    is_fmu = isinstance(instance.component, FmuComponent)
    entry: dict[str, Any] = {"fmu" if is_fmu else "model": instance.model}
    entry |= {
        key: plain(instance.tree.entries[key]) for key in ("interface", "isolate") if key in instance.tree.entries
    }
    if instance.period_ns:
        entry["period"] = f"{instance.period_ns} ns"
    if instance.overdue_ns:
        entry["overdue"] = f"{instance.overdue_ns} ns"
    entry["parameters"] = parameters.written(instance.parameters)
    for key in ("inputs", "record"):
        if key in instance.tree.entries:
            entry[key] = plain(instance.tree.entries[key])
    return entry
