"""An SSP 1.0 (or the SSD in it) read: its hierarchy flattened, connections followed from output to input."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.errors import TowlineError
from pipeline.hosts.fmu.units import Conversion
from pipeline.ssp import annotations
from pipeline.ssp.package import Package
from pipeline.ssp.ssv import SSC, SSD, SSM, SSV, mapped, parameter_set, transformation, unit_of, units
from pipeline.ssp.system import Affine, End, Feed, Link, Part, System, Value, between, time_ns
from pipeline.ssp.variables import elements

FMU = "application/x-fmu-sharedlibrary"
INTERFACES = {"CoSimulation": "co-simulation", "ModelExchange": "model-exchange", "any": ""}
NO_MEANING = ("ElementGeometry", "SystemGeometry", "ConnectorGeometry", "ConnectionGeometry", "GraphicalElements")

Place = tuple[str, ...]  # names of elements from the outermost system inwards
Node = tuple[Place, str]  # a connector of one


@dataclass
class _Reading:
    """What is gathered over the hierarchy. incoming: of each connector, the connections that end there."""

    package: Package
    system: System
    known: dict[str, Conversion]
    parts: dict[Place, Part] = field(default_factory=dict)
    kinds: dict[Node, str] = field(default_factory=dict)
    unit: dict[Node, Conversion | None] = field(default_factory=dict)
    incoming: dict[Node, list[tuple[Node, Any, str]]] = field(default_factory=dict)

    def elements(self, element: Any, place: Place) -> None:
        """Gather a system's connectors, components, sub-systems and connections."""
        self._connectors(element, place)
        for one in element.iterfind(f"{SSD}Elements/*"):
            inside = (*place, one.get("name", ""))
            if one.tag == f"{SSD}System":
                self.elements(one, inside)
            elif one.tag == f"{SSD}Component":
                self._component(one, inside)
            else:
                self.system.note(f"{_shown(inside)}: a signal dictionary's; what is wired by it is not kept")
        for connection in element.iterfind(f"{SSD}Connections/{SSD}Connection"):
            self._connection(connection, place)

    def _component(self, element: Any, place: Place) -> None:
        kind, source = element.get("type", FMU), element.get("source", "")
        if kind != FMU or source.lower().endswith((".ssp", ".ssd")):
            raise TowlineError(f"{self.package.shown}: {_shown(place)} is a {kind}; only FMUs are read")
        interface = element.get("implementation", "any")
        if interface not in INTERFACES:
            raise TowlineError(f"{self.package.shown}: {_shown(place)} asks for {interface}, which is not run")
        told = annotations.read(element)
        part = Part(_shown(place), self.package.path(source), INTERFACES[interface], settings=told)
        self.parts[place] = part
        self._connectors(element, place)

    def _connectors(self, element: Any, place: Place) -> None:
        for one in element.iterfind(f"{SSD}Connectors/{SSD}Connector"):
            node = (place, one.get("name", ""))
            self.kinds[node] = one.get("kind", "")
            real = one.find(f"{SSC}Real")
            self.unit[node] = None if real is None else unit_of(real.get("unit"), self.known)

    def _connection(self, element: Any, place: Place) -> None:
        start, end = (
            (
                (*place, inside) if (inside := element.get(f"{which}Element")) else place,
                element.get(f"{which}Connector", ""),
            )
            for which in ("start", "end")
        )
        if self._gives(end, place) and not self._gives(start, place):
            start, end = end, start
        label = f"connection {_label(start)} -> {_label(end)}"
        for node in (start, end):
            if node not in self.kinds and node[0] not in self.parts:
                self.system.note(f"{label}: there is no {_label(node)}; it is left out")
                return
        self.incoming.setdefault(end, []).append((start, element, label))

    def _gives(self, node: Node, place: Place) -> bool:
        """Whether a connector is where values come from, seen in the system `place`."""
        inward = self.kinds.get(node, "") in ("input", "parameter")
        return inward if node[0] == place else not inward

    def link(self, place: Place, name: str) -> Link | None:
        """What feeds an input of a component, followed up through the systems around it."""
        target = (place, name)
        chain: list[tuple[Node, Any, Node, str]] = []
        while target[0] not in self.parts or not chain:
            found = self.incoming.get(target, [])
            if len(found) > 1 or len(chain) > len(self.kinds):
                raise TowlineError(f"{self.package.shown}: {_label(target)} is fed by {len(found)} connections")
            if not found:
                where = f"{_label(target)}: an input of the whole system"
                self.system.note(f"{where}; {_label((place, name))} is not wired")
                return None
            start, element, label = found[0]
            chain.append((start, element, target, label))
            target = start
        change, unit, told = Affine(), self._unit(target), {}
        for _, element, end, label in reversed(chain):
            step, unit = self._step(element, unit, self._unit(end), label)
            if step is None:
                return None
            change, told = step.after(change), told | annotations.read(element)
        is_delayed = told.get("delay")
        is_direct = None if is_delayed is None else not is_delayed
        feed = Feed(End(_shown(target[0]), target[1]), change, is_direct, told.get("initial"))
        return Link(End(_shown(place), name), (feed,))

    def _unit(self, node: Node) -> Conversion | None:
        """What a connector's numbers are in: as the SSD says, or as the FMU does."""
        told = self.unit.get(node)
        if told is not None or node[0] not in self.parts:
            return told
        element = elements(self.parts[node[0]].fmu).get(node[1])
        return element.unit if element else None

    def _step(
        self, element: Any, unit: Conversion | None, wanted: Conversion | None, label: str
    ) -> tuple[Affine | None, Conversion | None]:
        """What one connection does with numbers in a unit, and the unit they have then."""
        change = transformation(element, label)
        if change is None:
            self.system.note(f"{label}: it maps values by no linear function; it is left out")
            return None, wanted
        if element.get("suppressUnitConversion") in ("true", "1"):
            return change, wanted or unit
        converted = between(unit, wanted)
        if converted is None:
            text = f"from {unit.unit if unit else '?'} to {wanted.unit if wanted else '?'}"
            self.system.note(f"{label}: {text}, which do not convert; the numbers are taken as they are")
        return change.after(converted or Affine()), wanted or unit

    def values(self, element: Any, place: Place, above: dict[str, Value]) -> None:
        """Give parts their values: those of outer levels count more, later ones more than earlier ones."""
        here = self._bindings(element, place) | above
        if place in self.parts:
            self.parts[place].values = here
            return
        for one in element.iterfind(f"{SSD}Elements/*"):
            name = one.get("name", "")
            inner = self._exposed((*place, name), here)
            inner |= {key.removeprefix(f"{name}."): value for key, value in here.items() if key.startswith(f"{name}.")}
            if one.tag in (f"{SSD}System", f"{SSD}Component"):
                self.values(one, (*place, name), inner)

    def _exposed(self, inside: Place, values: dict[str, Value]) -> dict[str, Value]:
        """Values of the system's own connectors that connections take to connectors of an element in it."""
        found = {}
        for (place, name), connections in self.incoming.items():
            for start, element, label in connections:
                if place != inside or start[0] != inside[:-1] or start[1] not in values:
                    continue
                value, wanted = values[start[1]], self._unit((place, name))
                own = self._unit(start)
                first = between(value.unit, own) or Affine()
                step, _ = self._step(element, own or value.unit, wanted, label)
                if step is not None and isinstance(value.value, int | float):
                    found[name] = Value(value.value, None, step.after(value.then.after(first)))
                elif step == Affine():
                    found[name] = value
        return found

    def _bindings(self, element: Any, place: Place) -> dict[str, Value]:
        found: dict[str, Value] = {}
        for binding in element.iterfind(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
            what, prefix = f"parameters of {_shown(place)}", binding.get("prefix", "")
            inline = binding.find(f"{SSD}ParameterValues/{SSV}ParameterSet")
            if inline is None and binding.get("source"):
                inline = self._document(binding, place)
            if inline is None or inline.tag != f"{SSV}ParameterSet":
                self.system.note(f"{what}: in another format than SSV; they are not set")
                continue
            values = parameter_set(inline, self.known)
            mapping = binding.find(f"{SSD}ParameterMapping")
            if mapping is not None:
                inner = mapping.find(f"{SSM}ParameterMapping")
                values, notes = mapped(self._document(mapping, place) if inner is None else inner, values, what)
                for text in notes:
                    self.system.note(text)
            found |= {prefix + name: value for name, value in values.items()}
        return found

    def _document(self, holder: Any, place: Place) -> Any:
        if holder.get("sourceBase", "SSD") == "component" and place in self.parts:
            return annotations.member(self.parts[place].fmu, holder.get("source", ""))
        return self.package.document(holder.get("source", ""))


def read(package: Package, root: Any) -> System:
    """The system of an SSD's root. Raises TowlineError."""
    outer = root.find(f"{SSD}System")
    if outer is None:
        raise TowlineError(f"{package.shown}: its SSD has no System")
    try:
        return _read(package, root, outer)
    except ValueError as error:
        raise TowlineError(f"{package.shown}: {error}") from error


def _read(package: Package, root: Any, outer: Any) -> System:
    system = System(
        root.get("name") or Path(package.shown).stem, root.get("description") or outer.get("description") or ""
    )
    _times(system, root, outer)
    reading = _Reading(package, system, units(root.find(f"{SSD}Units")))
    reading.elements(outer, ())
    reading.values(outer, (), {})
    system.parts = list(reading.parts.values())
    ends = [node for node in reading.incoming if node[0] in reading.parts]
    links = [reading.link(place, name) for place, name in ends if reading.kinds.get((place, name)) != "parameter"]
    system.links = [link for link in links if link is not None]
    found = {name for name in NO_MEANING for _ in zip(range(1), root.iter(f"{SSD}{name}"), strict=False)}
    if found:
        system.note(f"drawings ({', '.join(sorted(found))}) are not kept")
    for dictionary in root.iter(f"{SSD}SignalDictionary"):
        system.note(f"the signal dictionary {dictionary.get('name')} is not kept")
    return system


def _times(system: System, root: Any, outer: Any) -> None:
    system.settings = annotations.read(root)
    experiment = root.find(f"{SSD}DefaultExperiment")
    if experiment is not None:
        times = {key: experiment.get(f"{key}Time") for key in ("start", "stop")}
        system.start_ns, system.stop_ns = (time_ns(t, "the time") if t else None for t in times.values())
    step = system.settings.get("step_s")  # SSP 1.0 has no word for it; other tools have annotations
    for solver in (*outer.iter("{*}FixedStepMaster"), *root.iter("{*}FixedStepSolver")):
        step = step or solver.get("stepSize")
    if step:
        system.step_ns = time_ns(str(step), "the step")


def _shown(place: Place) -> str:
    return ".".join(place) or "the system"


def _label(node: Node) -> str:
    return ".".join((*node[0], node[1]))
