"""A scenario of FMUs written as an SSP 1.0 archive: SystemStructure.ssd, parameter values in it, the FMUs beside it."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element as Xml
from xml.etree.ElementTree import SubElement, indent, register_namespace, tostring

from pipeline.errors import TowlineError
from pipeline.graph import Graph, Node, Term
from pipeline.hosts.fmu.component import FmuComponent
from pipeline.hosts.fmu.parameters import FmuParameters
from pipeline.hosts.fmu.units import Conversion
from pipeline.ssp import annotations
from pipeline.ssp.scenario_text import OF_PART, OF_SYSTEM
from pipeline.ssp.ssd import FMU, INTERFACES
from pipeline.ssp.ssv import SSC, SSD, SSV, definition, written
from pipeline.ssp.system import Affine, between, of_unit
from pipeline.ssp.variables import Element, elements, told, units_of
from pipeline.written import Instance, Scenario
from pipeline.yaml_source import plain

IMPLEMENTATIONS = {name: implementation for implementation, name in INTERFACES.items() if name}
TYPES = {"Boolean": "Boolean", "Enumeration": "Enumeration", "String": "String", "Binary": "Binary"}
EPOCH = (1980, 1, 1, 0, 0, 0)  # of the archive's members, so that the same scenario gives the same file


@dataclass
class _Member:
    """A component of the SSP: its FMU's variables by name, the names by port and position, and its XML."""

    node: Node
    instance: Instance
    path: Path
    known: dict[str, Element]
    titles: dict[tuple[str, int | None], str]
    changed: list[str]
    starts: dict[str, float] = field(default_factory=dict)  # constants that inputs are wired to, in the FMU's units


def ssp(scenario: Scenario, graph: Graph) -> tuple[bytes, list[str]]:
    """The archive, and what other tools will not read in it, a line each.

    Raises TowlineError with all that an SSP has no words for and that changes what is computed.
    """
    writing = _Writing(scenario, graph)
    root = writing.document()
    if writing.faults:
        raise TowlineError("\n".join(f"{scenario.source}: {text}; an SSP cannot say so" for text in writing.faults))
    indent(root)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        _add(archive, "SystemStructure.ssd", tostring(root, "utf-8", xml_declaration=True))
        for path, name in writing.fmus.items():
            _add(archive, name, path.read_bytes())
    return out.getvalue(), writing.notes


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    about = zipfile.ZipInfo(name, EPOCH)
    about.external_attr = 0o644 << 16
    kind = zipfile.ZIP_STORED if name.endswith(".fmu") else zipfile.ZIP_DEFLATED  # an FMU is packed already
    archive.writestr(about, content, kind)


class _Writing:
    def __init__(self, scenario: Scenario, graph: Graph):
        self._scenario, self._graph = scenario, graph
        self.faults: list[str] = [f"bond '{tie.name}' exchanges laws of force" for tie in scenario.ties]
        self.notes: list[str] = []
        self.fmus: dict[Path, str] = {}
        self._members: dict[str, _Member] = {}
        for node, instance in zip(graph.nodes, scenario.instances, strict=True):
            if isinstance(node.component, FmuComponent):
                self._members[node.name] = _member(node, instance)
            else:
                how = f"build one by towline fmu build {scenario.source}#{node.name}"
                self.faults.append(f"'{node.name}' is the model {node.model} and no FMU ({how})")

    def document(self) -> Xml:
        """The SSD's root."""
        for name, space in (("ssd", SSD), ("ssc", SSC), ("ssv", SSV)):
            register_namespace(name, space.strip("{}"))
        scenario = self._scenario
        about = {"description": scenario.description} if scenario.description else {}
        root = Xml(f"{SSD}SystemStructureDescription", {"version": "1.0", "name": scenario.name} | about)
        system = SubElement(root, f"{SSD}System", name="system")
        connections = [one for member in self._members.values() for one in self._connections(member)]
        holder = SubElement(system, f"{SSD}Elements")
        for member in self._members.values():
            self._component(holder, member)
        if connections:
            SubElement(system, f"{SSD}Connections").extend(connections)
        self._definitions(root)
        times = {"startTime": scenario.start_ns, "stopTime": scenario.start_ns + scenario.duration_ns}
        SubElement(root, f"{SSD}DefaultExperiment", {key: _seconds(time) for key, time in times.items()})
        document = plain(scenario.tree)
        assert isinstance(document, dict)
        settings = {key: document[key] for key in OF_SYSTEM if key in document}
        self._annotate(root, {"step_s": _seconds(scenario.step_ns)} | settings, "")
        return root

    def _component(self, holder: Xml, member: _Member) -> None:
        node, component = member.node, member.node.component
        assert isinstance(component, FmuComponent)
        path = component.description.path
        if path not in self.fmus:
            taken = set(self.fmus.values())
            names = [f"resources/{path.stem}{end}.fmu" for end in ("", *(f"_{k}" for k in range(2, len(taken) + 3)))]
            self.fmus[path] = next(name for name in names if name not in taken)
        about = {"name": node.name, "type": FMU, "source": self.fmus[path]}
        about["implementation"] = IMPLEMENTATIONS[component.interface.name]
        element = SubElement(holder, f"{SSD}Component", about)
        connectors = SubElement(element, f"{SSD}Connectors")
        for name, one in member.known.items():
            if (
                one.variable.causality in ("input", "output")
                and one.variable.kind.is_number
                and one.position is not None
            ):
                connector = SubElement(connectors, f"{SSD}Connector", name=name, kind=one.variable.causality)
                self._type(connector, SSC, member, name, one)
        if not len(connectors):
            element.remove(connectors)
        self._parameters(element, member)
        written = member.instance.tree.entries
        settings = {key: plain(written[key]) for key in ("period", *OF_PART) if key in written}
        self._annotate(element, settings, f"{node.name}: ")

    def _type(self, holder: Xml, space: str, member: _Member, name: str, one: Element, **value: str) -> None:
        """The type of a connector or of a parameter's value."""
        kind = one.variable.kind
        tag = "Real" if kind.is_real else TYPES.get(kind.name, "Integer")
        about = dict(value)
        if tag == "Enumeration" and space == SSC:
            tag = "Integer"  # connectors name an enumeration of the SSD's, and none is needed here
        if tag == "Real" and (unit := self._unit_name(member, name)):
            about["unit"] = unit
        SubElement(holder, f"{space}{tag}", about)

    def _unit_name(self, member: _Member, name: str) -> str:
        """The FMU's own name of a variable's unit, where the FMU defines it."""
        one = told(member.path)[name]
        unit = one.unit or (one.declaredType.unit if one.declaredType is not None else None) or ""
        return unit if unit in units_of(member.path) else ""

    def _parameters(self, element: Xml, member: _Member) -> None:
        """Values that are not as the FMU starts, and constants that inputs are wired to."""
        values = member.node.parameters
        assert isinstance(values, FmuParameters)
        given: dict[str, Any] = {}
        for name in values.changed():
            one, numbers = values.VARIABLES[name], values.values(name)
            whole = member.titles.get((name, None))
            if whole is not None:
                self.faults.append(f"'{member.node.name}.{name}' is an array of FMI 3")
                continue
            for position, number in enumerate(numbers):
                title = member.titles[one.name, position]
                if position >= len(one.start or ()) or one.start is None or number != one.start[position]:
                    given[title] = number
        given |= member.starts
        if not given:
            return
        binding = SubElement(SubElement(element, f"{SSD}ParameterBindings"), f"{SSD}ParameterBinding")
        holder = SubElement(binding, f"{SSD}ParameterValues")
        inner = SubElement(holder, f"{SSV}ParameterSet", version="1.0", name=member.node.name)
        listed = SubElement(inner, f"{SSV}Parameters")
        used = set()
        for title, number in given.items():
            one = member.known[title]
            is_whole = one.variable.kind.is_number and not one.variable.kind.is_real
            if is_whole and not -(2**31) <= number < 2**31:
                self.faults.append(f"'{member.node.name}.{title}' is {number}, beyond the Integer of SSP 1.0")
            parameter = SubElement(listed, f"{SSV}Parameter", name=title)
            self._type(parameter, SSV, member, title, one, value=written(number, one.variable))
            used.add(self._unit_name(member, title))
        self._units(inner, SSV, used - {""})

    def _connections(self, member: _Member) -> Iterator[Xml]:
        """A connection for each number of each term; constants become start values."""
        inputs = _numbers(member.node.inputs)
        for term in member.node.terms:
            for k in range(term.count):
                port, position = inputs[term.target + k]
                if not term.assigns:
                    self.faults.append(f"'{member.node.name}.{port}' is fed by a sum")
                    return
                is_constant = term.gain == 0.0 and term.source == 0
                constant = term.offset[k] if term.offset else 0.0
                if is_constant and self._is_start(member, port, position, constant):
                    continue
                target = self._end(member, port, position)
                if target is None:
                    return
                if is_constant:
                    unit = member.known[target].variable.unit
                    member.starts[target] = unit.to_fmu(constant)
                    continue
                connection = self._connection(member, target, term, k)
                if connection is not None:
                    yield connection

    def _is_start(self, member: _Member, port: str, position: int, number: float) -> bool:
        """Whether an input that nothing feeds holds what its FMU starts it with."""
        one = next(
            v.variable for v in member.known.values() if v.variable.name == port and v.variable.causality == "input"
        )
        return one.start is not None and one.unit.to_si(one.start[position]) == number and port not in member.changed

    def _connection(self, member: _Member, target: str, term: Term, k: int) -> Xml | None:
        node = next(n for n in self._graph.nodes if n.start <= term.source + k < n.start + n.width)
        producer = self._members.get(node.name)
        if producer is None:
            return None
        port, position = _numbers(node.outputs)[term.source + k - node.start]
        source = self._end(producer, port, position)
        if source is None:
            return None
        ends = {"startElement": node.name, "startConnector": source, "endElement": member.node.name}
        connection = Xml(f"{SSD}Connection", ends | {"endConnector": target})
        given, wanted = producer.known[source], member.known[target]
        offset = term.offset[k] if term.offset else 0.0
        made = of_unit(wanted.variable.unit).inverse().after(Affine(Fraction(term.gain), Fraction(offset)))
        made = made.after(of_unit(given.variable.unit))
        change = self._change(connection, made, given.unit, wanted.unit)
        if change != Affine():
            about = {"factor": repr(float(change.factor)), "offset": repr(float(change.offset))}
            SubElement(connection, f"{SSC}LinearTransformation", about)
        more: dict[str, Any] = {"delay": term.delayed}
        if term.delayed:
            more["initial"] = term.initial[k] if term.initial else 0.0
            self._note("which wires are delayed, and what they carry before the first step")
        annotations.write(connection, more)
        return connection

    def _change(self, connection: Xml, made: Affine, given: Conversion | None, wanted: Conversion | None) -> Affine:
        """What is left to a linear transformation once units are converted, which is suppressed where they differ."""
        converted = between(given, wanted)
        if converted == made:
            return Affine()
        if converted is None or converted != Affine():
            connection.set("suppressUnitConversion", "true")
        return made

    def _end(self, member: _Member, port: str, position: int) -> str | None:
        title = member.titles.get((port, position))
        if title is None:
            text = f"'{member.node.name}.{port}' is an array of FMI 3, which is wired"
            if text not in self.faults:
                self.faults.append(text)
        return title

    def _definitions(self, root: Xml) -> None:
        names = {one.get("unit", "") for one in root.iter(f"{SSC}Real") if one.get("unit")}
        self._units(root, SSD, names)

    def _units(self, holder: Xml, space: str, names: set[str]) -> None:
        """Definitions of units, as the first FMU that has them says."""
        if not names:
            return
        units = SubElement(holder, f"{space}Units")
        for name in sorted(names):
            found = [known[name] for known in map(units_of, self.fmus) if name in known]
            if len({definition(one) for one in found}) > 1:
                self.notes.append(f"the unit {name} is not the same in all FMUs; the first one's definition is written")
            SubElement(SubElement(units, f"{SSC}Unit", name=name), f"{SSC}BaseUnit", dict(definition(found[0])))

    def _annotate(self, element: Xml, settings: dict[str, Any], label: str) -> None:
        if settings:
            annotations.write(element, settings)
            self._note(f"{label}{', '.join(settings)}")

    def _note(self, what: str) -> None:
        text = f"{what}: kept as annotations, which only Towline reads"
        if text not in self.notes:
            self.notes.append(text)


def _member(node: Node, instance: Instance) -> _Member:
    assert isinstance(node.component, FmuComponent)
    path = node.component.description.path
    known = elements(path)
    titles = {(one.variable.name, one.position): name for name, one in known.items()}
    assert isinstance(node.parameters, FmuParameters)
    return _Member(node, instance, path, known, titles, node.parameters.changed())


def _numbers(ports: Any) -> list[tuple[str, int]]:
    """Each number of the ports in turn: the port's name and which of its numbers."""
    return [(port.name, position) for port in ports for position in range(port.size)]


def _seconds(ns: int) -> str:
    """Nanoseconds as seconds, exactly."""
    return f"{ns // 10**9}.{ns % 10**9:09d}".rstrip("0").rstrip(".")
