"""modelDescription.xml of an exported component: what FMI 2.0 and FMI 3.0 share, and the wording of each."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import version
from xml.etree import ElementTree as ET

from pipeline.fmu.units import base_unit
from pipeline.fmu.variables import Contents, Variable

TOOL = "towline"  # whose annotation it is
STATUS_CATEGORY = "logStatusError"
VARIABILITY = {"time": "continuous", "input": "continuous", "output": "continuous", "constant": "constant"}
CAUSALITY = {"time": "independent", "constant": "local"}
INITIAL = {"output": "calculated", "parameter": "exact", "constant": "exact"}
TYPES = {
    2: {"real": "Real", "integer": "Integer", "boolean": "Boolean", "text": "String"},
    3: {"real": "Float64", "integer": "Int64", "boolean": "Boolean", "text": "String"},
}


@dataclass(frozen=True)
class Experiment:
    """When and in which steps a component is meant to run [ns]; whether other steps are refused."""

    step_ns: int
    start_ns: int = 0
    step_is_fixed: bool = False


def description(
    fmi: int, contents: Contents, variables: tuple[Variable, ...], token: str, identifier: str, experiment: Experiment
) -> bytes:
    """The document; variables: in the order of their value references."""
    component = contents.component
    root = ET.Element("fmiModelDescription", fmiVersion={2: "2.0", 3: "3.0"}[fmi], modelName=component.name)
    root.set("guid" if fmi == 2 else "instantiationToken", token)
    if component.assumptions:
        root.set("description", component.assumptions)
    root.set("generationTool", f"{TOOL} {version(TOOL)}")
    root.set("variableNamingConvention", "structured")
    ET.SubElement(root, "CoSimulation", _capabilities(fmi, identifier, experiment))
    _units(root, variables)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name=STATUS_CATEGORY, description="why a call was refused or failed")
    seconds = {"startTime": experiment.start_ns, "stepSize": experiment.step_ns}
    ET.SubElement(root, "DefaultExperiment", {name: repr(ns / 1e9) for name, ns in seconds.items()})
    if fmi == 2:
        annotations = ET.SubElement(root, "VendorAnnotations")
        _ports(ET.SubElement(annotations, "Tool", name=TOOL), contents)
    _variables(fmi, root, variables)
    _structure(fmi, root, variables)
    if fmi == 3:
        annotations = ET.SubElement(root, "Annotations")
        _ports(ET.SubElement(annotations, "Annotation", type=TOOL), contents)
    ET.indent(root)
    return ET.tostring(root, "utf-8", xml_declaration=True)


def _capabilities(fmi: int, identifier: str, experiment: Experiment) -> dict[str, str]:
    """Attributes of the interface.

    Directional derivatives are not offered: outputs change in steps only, so that their derivative by the inputs of the
    same instant is zero, as the empty dependencies say, and FMI does not ask for that of a step.
    """
    state = "FMUstate" if fmi == 2 else "FMUState"
    found = {
        "modelIdentifier": identifier,
        "canHandleVariableCommunicationStepSize": str(not experiment.step_is_fixed).lower(),
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }
    if fmi == 2:
        found["canNotUseMemoryManagementFunctions"] = "true"
    if fmi == 3 and experiment.step_is_fixed:
        found["fixedInternalStepSize"] = repr(experiment.step_ns / 1e9)
    return found


def _units(root: ET.Element, variables: Iterable[Variable]) -> None:
    names = dict.fromkeys(one.unit for one in variables if one.unit != "1")
    definitions = ET.SubElement(root, "UnitDefinitions") if names else root
    for name in names:
        element = ET.SubElement(definitions, "Unit", name=name)
        base = base_unit(name)
        if base is not None:
            values = {symbol: str(power) for symbol, power in base.powers.items()}
            values |= {"factor": repr(base.factor)} if base.factor != 1.0 else {}
            values |= {"offset": repr(base.offset)} if base.offset != 0.0 else {}
            ET.SubElement(element, "BaseUnit", values)


def _ports(parent: ET.Element, contents: Contents) -> None:
    """What FMI has no words for: each port's frame, in FMI 2 its shape, and which output tells the validity."""
    component, parameters = contents.component, contents.parameters
    element = ET.SubElement(parent, "Ports", {"validity": component.validity} if component.validity else {})
    for direction, ports in (("input", component.inputs(parameters)), ("output", component.outputs(parameters))):
        for port in ports:
            shape = " ".join(map(str, port.shape))
            ET.SubElement(
                element, "Port", direction=direction, name=port.name, unit=port.unit, shape=shape, frame=port.frame
            )


def _start(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _variables(fmi: int, root: ET.Element, variables: Iterable[Variable]) -> None:
    parent = ET.SubElement(root, "ModelVariables")
    for reference, one in enumerate(variables):
        common = {"name": one.name, "valueReference": str(reference)}
        common |= {"description": _told(one)} if _told(one) else {}
        common |= {"causality": CAUSALITY.get(one.role, one.role), "variability": _variability(one)}
        common |= {"initial": INITIAL[one.role]} if one.role in INITIAL else {}
        own = {"unit": one.unit} if one.unit != "1" and one.type == "real" else {}
        own |= _bounds(one) if one.type == "real" else {}
        if fmi == 2:
            scalar = ET.SubElement(parent, "ScalarVariable", common)
            start = {"start": _start(one.start[0])} if one.start else {}
            ET.SubElement(scalar, TYPES[2][one.type], own | start)
            continue
        start = {"start": " ".join(map(_start, one.start))} if one.start and one.type != "text" else {}
        element = ET.SubElement(parent, TYPES[3][one.type], common | own | start)
        for length in one.shape:
            ET.SubElement(element, "Dimension", start=str(length))
        for text in one.start if one.type == "text" else ():
            ET.SubElement(element, "Start", value=text)


def _told(one: Variable) -> str:
    return ", ".join(filter(None, (one.description, f"in {one.frame}" if one.frame else "")))


def _variability(one: Variable) -> str:
    return VARIABILITY.get(one.role) or ("tunable" if one.tunable else "fixed")


def _bounds(one: Variable) -> dict[str, str]:
    """Closed bounds that all of its numbers share; an open one cannot be said, and the FMU checks it."""
    if len(set(one.bounds)) != 1:
        return {}
    bounds = one.bounds[0]
    low = {} if bounds.low_is_open or bounds.low == float("-inf") else {"min": repr(float(bounds.low))}
    high = {} if bounds.high_is_open or bounds.high == float("inf") else {"max": repr(float(bounds.high))}
    return low | high


def _structure(fmi: int, root: ET.Element, variables: Iterable[Variable]) -> None:
    """Outputs are those of the last step, whatever the inputs are since; at t0 all of them hang on all inputs."""
    structure = ET.SubElement(root, "ModelStructure")
    places = [reference for reference, one in enumerate(variables) if one.role == "output"]
    if fmi == 3:
        for reference in places:
            ET.SubElement(structure, "Output", valueReference=str(reference), dependencies="")
        for reference in places:
            ET.SubElement(structure, "InitialUnknown", valueReference=str(reference))
    elif places:
        outputs = ET.SubElement(structure, "Outputs")
        for reference in places:
            ET.SubElement(outputs, "Unknown", index=str(reference + 1), dependencies="")
        unknowns = ET.SubElement(structure, "InitialUnknowns")
        for reference in places:
            ET.SubElement(unknowns, "Unknown", index=str(reference + 1))
