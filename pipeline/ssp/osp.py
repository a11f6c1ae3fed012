"""An OspSystemStructure.xml read, whose simulators libcosim steps all at once, on the values before."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.errors import TowlineError
from pipeline.fmu.archive import model_description
from pipeline.ssp.package import Package
from pipeline.ssp.ssv import READ
from pipeline.ssp.system import Affine, End, Feed, Link, Part, System, Value, number, time_ns
from pipeline.xml_source import parse_xml

ROOT = "OspSystemStructure"
_SIGNAL = re.compile(r"in(?:\[([0-9]{1,6})\])?")
# A variable of a group: the types of what it is in, and which of each type; its name.
Member = tuple[tuple[tuple[str, int], ...], str]
KINDS = ("Real", "Integer", "Boolean", "String")


@dataclass
class _Function:
    """A function between outputs and inputs; sources: of each input, by its number, the ends that feed it in turn."""

    kind: str
    change: Affine = field(default_factory=Affine)
    sources: dict[int, list[End]] = field(default_factory=dict)


@dataclass
class _Reading:
    package: Package
    system: System
    parts: dict[str, Part] = field(default_factory=dict)
    functions: dict[str, _Function] = field(default_factory=dict)
    feeds: dict[End, list[Feed]] = field(default_factory=dict)

    def simulator(self, element: Any) -> None:
        """Add a simulator."""
        name = element.get("name", "")
        if name in self.parts:
            raise ValueError(f"two simulators are named '{name}'")
        part = Part(name, self.package.path(element.get("source", "")))
        for initial in element.iterfind("{*}InitialValues/{*}InitialValue"):
            variable = initial.get("variable", "")
            for one in initial.iterchildren():
                kind = _tag(one)
                if kind in KINDS:
                    part.values[variable] = Value(READ[kind](one.get("value", ""), f"{name}.{variable}"))
        if element.get("stepSize"):
            part.period_ns = self._period(time_ns(element.get("stepSize"), f"{name}: the step"), name)
        self.parts[name] = part

    def _period(self, step_ns: int, name: str) -> int:
        """A multiple of the base step, the nearest as libcosim takes it."""
        base_ns = self.system.step_ns
        if not base_ns:
            return step_ns
        period_ns = max(1, round(step_ns / base_ns)) * base_ns
        if period_ns != step_ns:
            text = f"its step of {step_ns / 1e9:g} s is no multiple of the base step; {period_ns / 1e9:g} s is taken"
            self.system.note(f"{name}: {text}, as libcosim does")
        if period_ns > base_ns:
            text = "reads its inputs as its last base step begins, and libcosim as its own step does"
            self.system.note(f"{name}: steps by {period_ns / 1e9:g} s; it {text}")
        return period_ns

    def function(self, element: Any) -> None:
        """Add a function."""
        name, kind = element.get("name", ""), _tag(element)
        if kind == "LinearTransformation":
            factor = number(element.get("factor"), 1, f"{name}: factor")
            self.functions[name] = _Function(kind, Affine(factor, number(element.get("offset"), 0, f"{name}: offset")))
        elif kind in ("Sum", "VectorSum"):
            self.functions[name] = _Function(kind)
        else:
            raise ValueError(f"the function '{name}' is a {kind}; LinearTransformation, Sum and VectorSum are read")

    def connections(self, holder: Any) -> None:
        """Add all: what goes into functions first."""
        found = list(holder.iterchildren()) if holder is not None else []
        signals = [one for one in found if _tag(one) in ("SignalConnection", "SignalGroupConnection")]
        for one in found:
            if one in signals:
                continue
            if _tag(one) not in ("VariableConnection", "VariableGroupConnection"):
                self.system.note(f"{_tag(one)}: not known; it is left out")
                continue
            ends = [self._ends(end) for end in one.iterchildren()]
            if len(ends) != 2 or len(ends[0]) != len(ends[1]):
                raise ValueError(f"a {_tag(one)} joins {' and '.join(str(len(end)) for end in ends)} variables")
            pairs = list(zip(*ends, strict=True))
            if set(pairs) != set(zip(*(self._ends(end, is_written=True) for end in one.iterchildren()), strict=True)):
                names = " and ".join(f"{end.get('simulator')}.{end.get('name')}" for end in one.iterchildren())
                text = "they are joined by type here, and by libcosim in the order written"
                self.system.note(f"the groups {names} list their parts in different orders; {text}")
            for first, second in pairs:
                self._join(first, second)
        for is_output in (False, True):
            for one in signals:
                self._signal(one, is_output)

    def _signal(self, element: Any, is_output: bool) -> None:
        ends = list(element.iterchildren())
        if len(ends) != 2:
            raise ValueError(f"a {_tag(element)} has {len(ends)} ends")
        signal, other = sorted(ends, key=lambda end: not _tag(end).startswith("Signal"))
        name, port = signal.get("function", ""), signal.get("name", "")
        function = self.functions.get(name)
        if function is None or not _tag(signal).startswith("Signal"):
            raise ValueError(f"a {_tag(element)} names the function '{name}', which there is not")
        if (port == "out") != is_output:
            return
        variables = self._ends(other)
        if is_output:
            self._give(function, name, variables)
            return
        match = _SIGNAL.fullmatch(port)
        if match is None:
            raise ValueError(f"the function '{name}' has no signal '{port}'")
        function.sources[int(match[1] or 0)] = variables

    def _give(self, function: _Function, name: str, targets: list[End]) -> None:
        inputs = [function.sources[k] for k in sorted(function.sources)]
        if any(len(one) != len(targets) for one in inputs):
            raise ValueError(f"the signals of the function '{name}' have different lengths")
        for k, target in enumerate(targets):
            self.feeds.setdefault(target, []).extend(Feed(one[k], function.change, is_direct=False) for one in inputs)
        if not inputs:
            self.system.note(f"the function '{name}' has no inputs; what it feeds is not wired")

    def _join(self, first: End, second: End) -> None:
        """Connect two variables, the output first whichever way they are written."""
        for end in (first, second):
            if end.part not in self.parts:
                raise ValueError(f"a connection names the simulator '{end.part}', which there is not")
        if self._causality(second) == "output" and self._causality(first) != "output":
            first, second = second, first
        self.feeds.setdefault(second, []).append(Feed(first, is_direct=False))

    def _causality(self, end: End) -> str:
        told = {one.name: one.causality for one in model_description(self.parts[end.part].fmu).modelVariables}
        return told.get(end.variable, "")

    def _ends(self, element: Any, *, is_written: bool = False) -> list[End]:
        """The variables that an end of a connection names: one, or those of a group, by type or as written."""
        part, name = element.get("simulator", ""), element.get("name", "")
        if _tag(element) == "Variable":
            return [End(part, name)]
        if part not in self.parts:
            raise ValueError(f"a connection names the simulator '{part}', which there is not")
        groups = self._groups(self.parts[part])
        if name not in groups:
            raise ValueError(f"'{part}' has no variable group '{name}' in its OspModelDescription")
        members = groups[name] if is_written else sorted(groups[name], key=lambda member: member[0])
        return [End(part, variable) for _, variable in members]

    def _groups(self, part: Part) -> dict[str, list[Member]]:
        """Members of each group, as written."""
        found: dict[str, list[Member]] = {}
        for stem in dict.fromkeys((model_description(part.fmu).modelName, part.fmu.stem)):
            for folder in (part.fmu.parent, self.package.folder):
                path = folder / f"{Path(stem).name}_OspModelDescription.xml"
                if path.is_file():
                    root = parse_xml(path.read_bytes(), str(path))
                    for group in root.iterfind("{*}VariableGroups//*[@name]"):
                        found.setdefault(group.get("name"), _members(group))
        return found


def read(package: Package, root: Any) -> System:
    """The system of an OspSystemStructure's root. Raises TowlineError."""
    try:
        return _read(package, root)
    except ValueError as error:
        raise TowlineError(f"{package.shown}: {error}") from error


def _read(package: Package, root: Any) -> System:
    system = System(Path(package.shown).stem, are_delayed=True)
    times = {key: root.findtext(f"{{*}}{key}") for key in ("StartTime", "EndTime", "BaseStepSize")}
    start, stop, step = (None if text is None else time_ns(text, key) for key, text in times.items())
    system.start_ns, system.stop_ns, system.step_ns = start, stop, step
    reading = _Reading(package, system)
    for element in root.iterfind("{*}Simulators/{*}Simulator"):
        reading.simulator(element)
    for element in root.iterfind("{*}Functions/*"):
        reading.function(element)
    reading.connections(root.find("{*}Connections"))
    for target, feeds in reading.feeds.items():
        joined = [feed for feed in feeds if target.part in reading.parts and feed.source.part in reading.parts]
        if len(joined) < len(feeds):
            raise ValueError("a connection names a simulator which there is not")
        system.links.append(Link(target, tuple(feeds)))
    system.parts = list(reading.parts.values())
    if (root.findtext("{*}Algorithm") or "fixedStep") != "fixedStep":
        system.note(f"the algorithm {root.findtext('{*}Algorithm')} is not kept; wires are delayed, as in fixedStep")
    return system


def _tag(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]


def _members(group: Any, above: tuple[tuple[str, int], ...] = ()) -> list[Member]:
    """The variables of a group."""
    found: list[Member] = []
    counts: dict[str, int] = {}
    for one in group.iterchildren():
        kind = _tag(one)
        counts[kind] = counts.get(kind, -1) + 1
        place = (*above, (kind, counts[kind]))
        found += [(place, one.get("ref", ""))] if kind == "Variable" else _members(one, place)
    return found
