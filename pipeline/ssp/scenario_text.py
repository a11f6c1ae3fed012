"""A system of FMUs written as the YAML of a scenario, by the ports, parameters and units that the FMUs have here."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pipeline.document import name_from
from pipeline.errors import TowlineError
from pipeline.fmu.archive import model_description
from pipeline.hosts.fmu.variables import Variable
from pipeline.quantities import as_time, is_plain, ratio, same_unit
from pipeline.ssp.system import Affine, End, Feed, Link, Part, System, Value, between, of_unit, time_ns
from pipeline.ssp.variables import Element, elements
from pipeline.ssp.wires import Wire
from pipeline.ssp.wires import inputs as written_inputs
from pipeline.yaml_source import CoreDumper

DURATION_NS = 10_000_000_000  # of a system that does not tell how long it runs
OF_SYSTEM = ("seed", "scene", "bus", "hosts", "machines", "events")
OF_PART = ("isolate", "record", "overdue")


def scenario_text(
    system: System,
    fmus: Mapping[Path, str],
    step_ns: int | None = None,
    duration_ns: int | None = None,
    is_delayed: bool | None = None,
) -> str:
    """The scenario; notes of what is not kept are added to the system's. fmus: paths as the YAML is to have them.

    step_ns, duration_ns: instead of what the system says. is_delayed: all wires, or only those that close a cycle;
    None: as the system's own tools do. Raises TowlineError.
    """
    if not system.parts:
        raise TowlineError(f"{system.name}: there is no FMU in it")
    is_delayed = system.are_delayed if is_delayed is None else is_delayed
    try:
        return _Writing(system, fmus).text(step_ns, duration_ns, is_delayed)
    except (ValueError, OverflowError) as error:
        raise TowlineError(f"{system.name}: {error}") from error


class _Writing:
    def __init__(self, system: System, fmus: Mapping[Path, str]):
        self._system, self._fmus = system, fmus
        self._parts = {part.title: part for part in system.parts}
        self._names = _names(system)

    def text(self, step_ns: int | None, duration_ns: int | None, is_delayed: bool) -> str:
        links = self._directed(is_delayed)
        system = self._system
        step_ns = step_ns or system.step_ns or self._usual_step()
        start_ns = system.start_ns or 0
        document: dict[str, Any] = {"name": name_from(system.name)}
        if system.description:
            document["description"] = system.description
        document["duration"] = as_time(self._duration(duration_ns, start_ns, step_ns))
        document["step"] = as_time(step_ns)
        if start_ns:
            document["start"] = as_time(start_ns)
        document |= {key: system.settings[key] for key in OF_SYSTEM if key in system.settings}
        document["components"] = {self._names[part.title]: self._part(part, links) for part in system.parts}
        body = yaml.dump(document, Dumper=CoreDumper, sort_keys=False, allow_unicode=True, width=120)
        return "".join(f"# {' '.join(line.split())}\n" for line in self._heading()) + body

    def _heading(self) -> Iterable[str]:
        if self._system.notes:
            yield "Not kept, or changed:"
            yield from (f"- {text}" for text in self._system.notes)

    def _usual_step(self) -> int:
        """The shortest step that the FMUs' default experiments have."""
        steps = []
        for part in self._system.parts:
            experiment = model_description(part.fmu).defaultExperiment
            if experiment is not None and experiment.stepSize:
                steps.append(time_ns(str(experiment.stepSize), f"{part.title}: the step"))
        if not steps or min(steps) <= 0:
            raise TowlineError(f"{self._system.name}: no step is told, nor by its FMUs; give it by --step")
        self._system.note(f"no step is told; {as_time(min(steps))} is the shortest of the FMUs' own")
        return min(steps)

    def _duration(self, wanted_ns: int | None, start_ns: int, step_ns: int) -> int:
        told = None if self._system.stop_ns is None else self._system.stop_ns - start_ns
        duration_ns = wanted_ns or told or DURATION_NS
        if wanted_ns is None and told is None:
            self._system.note(f"no stop time is told; {as_time(duration_ns)} is written")
        if duration_ns <= 0:
            raise TowlineError(f"{self._system.name}: it would run for {as_time(duration_ns)}; give --duration")
        whole_ns = -(-duration_ns // step_ns) * step_ns
        if whole_ns != duration_ns:
            self._system.note(f"the stop time is no multiple of the step; {as_time(whole_ns)} are run")
        return whole_ns

    def _directed(self, is_delayed: bool) -> list[Link]:
        """The links with each wire direct or delayed: as told, or delayed where it would close a cycle."""
        onward: dict[str, set[str]] = {part.title: set() for part in self._system.parts}
        is_kept = is_delayed == self._system.are_delayed
        for link in self._system.links:
            for feed in link.feeds:
                if is_kept and feed.is_direct:
                    onward[feed.source.part].add(link.target.part)
        links = []
        for link in self._system.links:
            feeds = []
            for feed in link.feeds:
                is_direct = feed.is_direct if is_kept else None
                if is_direct is None:
                    closes = _reaches(onward, link.target.part, feed.source.part)
                    is_direct = not is_delayed and not closes
                    if closes and not is_delayed:
                        wire = f"{_label(feed.source)} -> {_label(link.target)}"
                        self._system.note(f"{wire} is delayed: it closes a cycle of direct wires")
                if is_direct:
                    onward[feed.source.part].add(link.target.part)
                feeds.append(replace(feed, is_direct=is_direct))
            links.append(Link(link.target, tuple(feeds)))
        return links

    def _part(self, part: Part, links: list[Link]) -> dict[str, Any]:
        entry: dict[str, Any] = {"fmu": self._fmus[part.fmu]}
        if part.interface:
            entry["interface"] = part.interface
        period = part.settings.get("period") or (as_time(part.period_ns) if part.period_ns else None)
        if period:
            entry["period"] = period
        entry |= {key: part.settings[key] for key in OF_PART if key in part.settings}
        if parameters := self._parameters(part):
            entry["parameters"] = parameters
        wires = [self._wire(link) for link in links if link.target.part == part.title]
        if inputs := written_inputs([wire for wire in wires if wire is not None]):
            entry["inputs"] = inputs
        return entry

    def _parameters(self, part: Part) -> dict[str, Any]:
        """Values by the names of parameters here; elements of an array together, the others as the FMU starts."""
        known, flat = elements(part.fmu), {}
        for name, value in part.values.items():
            element = known.get(name)
            if element is None or element.variable.causality == "output":
                what = "no variable" if element is None else "an output as"
                self._system.note(f"{part.title} has {what} '{name}', whose value is not set")
                continue
            number = self._number(value, element, f"{part.title}.{name}")
            one = element.variable
            if element.position is None:
                self._system.note(f"{part.title}.{name} is an array; its value is not set")
                continue
            values = flat.setdefault(one.name, (one, list(one.start or [0.0] * max(one.size, 1))))[1]
            values[element.position] = number
        return {
            name: _nested([_quantity(value, one) for value in values], one.shape)
            for name, (one, values) in flat.items()
        }

    def _number(self, value: Value, element: Element, label: str) -> Any:
        """A value as the FMU takes it."""
        kind, given = element.variable.kind, value.value
        if not kind.is_number or isinstance(given, str):
            return given
        if not kind.is_real and value.then == Affine():
            return bool(given) if kind.is_boolean else int(given)
        change = between(value.unit, element.unit)
        if change is None:
            self._system.note(f"{label}: its value's unit does not convert to the FMU's; the number is taken as it is")
        number = value.then.after(change or Affine())
        exact = number.factor * Fraction(given) + number.offset
        return float(exact) if kind.is_real else bool(exact) if kind.is_boolean else round(exact)

    def _wire(self, link: Link) -> Wire | None:
        target = self._end(link.target, "input")
        found = [(feed, self._end(feed.source, "output")) for feed in link.feeds]
        if target is None or any(source is None for _, source in found):
            return None
        sources = tuple(source for _, source in found if source is not None)
        if any((source.position is None) != (target.position is None) for source in sources):
            self._system.note(f"{_label(link.target)}: a whole array is wired to one of its elements; it is left out")
            return None
        addends = tuple(self._addend(feed, source, target) for feed, source in zip(link.feeds, sources, strict=True))
        return Wire(target, sources, addends)

    def _end(self, end: End, causality: str) -> Element | None:
        element = elements(self._parts[end.part].fmu).get(end.variable)
        if element is None or element.variable.causality != causality or not element.variable.kind.is_number:
            why = "is none of its numbers" if element is None else f"is no {causality} of numbers"
            self._system.note(f"{_label(end)} {why}; what it is wired to is left out")
            return None
        return element

    def _addend(self, feed: Feed, source: Element, target: Element) -> Any:
        """A wire's source with gain and offset between SI units, from a map between the FMUs' own numbers."""
        made = of_unit(target.variable.unit).after(feed.map).after(of_unit(source.variable.unit).inverse())
        given, wanted = source.variable.unit.unit, target.variable.unit.unit
        text = f"{self._names[feed.source.part]}.{source.variable.name}{{}}"
        entry: dict[str, Any] = {"from": text}
        if made.factor != 1 or not same_unit(given, wanted):
            entry["gain"] = _written(float(made.factor), "1" if same_unit(wanted, given) else ratio(wanted, given))
        if made.offset != 0:
            offset = _written(float(made.offset), wanted)
            shape = target.variable.shape if target.position is None else ()
            entry["offset"] = np.full(shape, offset, object).tolist() if shape else offset
        if not feed.is_direct:
            entry["delay"] = True
            initial = feed.initial if feed.initial is not None else _start(source)
            if initial:
                entry["initial"] = initial
        return text if len(entry) == 1 else entry


def _names(system: System) -> dict[str, str]:
    """Names of components from titles: small letters, digits and _."""
    found: dict[str, str] = {}
    for part in system.parts:
        name = re.sub(r"\W", "_", part.title, flags=re.ASCII).lower()
        name = name if re.match(r"[a-z]", name) else f"c{name}"
        while name in found.values():
            name += "_"
        if name != part.title:
            system.note(f"'{part.title}' is named '{name}'")
        found[part.title] = name
    return found


def _reaches(onward: Mapping[str, set[str]], start: str, goal: str) -> bool:
    """Whether there is a way from one part to the other along direct wires."""
    seen, ahead = set(), [start]
    while ahead:
        one = ahead.pop()
        if one == goal:
            return True
        if one not in seen:
            seen.add(one)
            ahead += onward[one]
    return False


def _quantity(number: Any, one: Variable) -> Any:
    """A number of the FMU as a scenario writes it."""
    return _written(float(one.unit.to_si(number)), one.unit.unit) if one.kind.is_real else number


def _written(number: float, unit: str) -> Any:
    return number if is_plain(unit) else f"{number!r} {unit}"


def _nested(values: list[Any], shape: tuple[int, ...]) -> Any:
    if not shape:
        return values[0]
    array = np.empty(len(values), object)
    array[:] = values
    return array.reshape(shape).tolist()


def _start(source: Element) -> float | list | None:
    """What an output is before the first step, where its FMU tells and it is not zero."""
    one = source.variable
    if one.start is None or one.initial != "exact" or not one.kind.is_number:
        return None
    numbers = [float(one.unit.to_si(value)) if one.kind.is_real else float(value) for value in one.start]
    if source.position is None:
        return _nested(numbers, one.shape) if any(numbers) else None
    return numbers[source.position] or None


def _label(end: End) -> str:
    return f"{end.part}.{end.variable}"


def relative(path: Path, folder: Path) -> str:
    """A path as a scenario in the folder names it."""
    return Path(os.path.relpath(path.absolute(), folder.absolute())).as_posix()
