"""modelDescription.xml of an FMU of anyone, read by fmpy and checked: its variables, and what it can do."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from pipeline import archive
from pipeline.errors import TowlineError
from pipeline.fmu.archive import DOCUMENT, LARGEST, binary, model_description
from pipeline.hosts.fmu.kinds import kinds
from pipeline.hosts.fmu.units import Conversion, conversion
from pipeline.hosts.fmu.variables import MOST, Variable, grouped, unbundled

CO_SIMULATION, MODEL_EXCHANGE = "co-simulation", "model-exchange"
SETTABLE = ("parameter", "structuralParameter")
PORTS = ("input", "output")
EXACT_OR_GUESSED = ("exact", "approx")


class FmuError(TowlineError):
    """An FMU cannot be used, or failed; names the file or the variable, and the reason."""


@dataclass(frozen=True)
class Interface:
    """One of the two ways to run an FMU, and what it can do in it."""

    name: str
    identifier: str
    can_vary_step: bool = True
    fixed_step_s: float | None = None
    can_save: bool = False  # its state, as bytes
    is_single: bool = False  # one instance a process
    needs_tool: bool = False
    has_events: bool = False
    returns_early: bool = False
    needs_completed_steps: bool = True


@dataclass(frozen=True, eq=False)  # compared by identity: one is read for each content
class Description:
    """An FMU as it describes itself. digest: SHA-256 of the file. variables: all that can be seen or set.

    refused: variables that cannot be ports, by name, and why. states, indicators: of its model-exchange interface.
    validity: the output that tells it, see components.contract.Component; "" where Towline did not export the FMU.
    """

    path: Path
    digest: str
    fmi: int
    model: str
    token: str
    summary: str
    interfaces: tuple[Interface, ...]
    variables: tuple[Variable, ...]
    refused: Mapping[str, str]
    categories: tuple[str, ...]
    states: int
    indicators: int
    tolerance: float | None
    validity: str

    def of(self, *causalities: str) -> list[Variable]:
        """Its variables of these causalities, in order."""
        return [one for one in self.variables if one.causality in causalities]

    def interface(self, wanted: str) -> Interface:
        """The interface of this name, or the first there is. Raises FmuError."""
        found = [one for one in self.interfaces if wanted in ("", one.name)]
        if not found:
            names = " and ".join(one.name for one in self.interfaces) or "none that can be run"
            raise FmuError(f"{self.path.name} has no {wanted or 'interface'}; it has {names}")
        return found[0]


@lru_cache(64)
def _read(path: Path, _stamp: tuple[int, int]) -> Description:
    from pipeline.xml_source import parse_xml  # with lxml, which a scenario without FMUs does not need

    told, data = model_description(path), path.read_bytes()
    root = parse_xml(archive.read(path, "FMU", DOCUMENT, LARGEST), f"{path}: its {DOCUMENT}")
    if told.fmiVersion == "1.0" and told.coSimulation is None:
        raise FmuError(f"{path.name}: an FMI 1.0 model exchange FMU; of FMI 1.0 only co-simulation is taken")
    try:
        return _description(path, hashlib.sha256(data).hexdigest(), told, root)
    except FmuError as error:
        raise FmuError(f"{path.name}: {error}") from error
    except (ValueError, TypeError, AttributeError, KeyError, OverflowError) as error:  # values that are no numbers
        text = (str(error).splitlines() or [type(error).__name__])[0]
        raise FmuError(f"{path.name}: its {DOCUMENT} cannot be read: {text}") from error


def read(path: Path) -> Description:
    """The description of the FMU at `path`, read once for each content. Raises TowlineError."""
    try:
        about = path.stat()
        return _read(path.absolute(), (about.st_mtime_ns, about.st_size))
    except OSError as error:
        raise FmuError(f"{path} cannot be read: {error.strerror or error}") from error


def _description(path: Path, digest: str, told: Any, root: Any) -> Description:
    fmi = int(told.fmiVersion[0])
    interfaces = tuple(_interfaces(told, fmi, root))
    if not interfaces:
        raise FmuError(f"its {DOCUMENT} names neither co-simulation nor model exchange")
    for one in interfaces:
        binary(path, told.fmiVersion, one.identifier)
    shapes, frames, validity = _annotated(root)
    relative = {element.get("name") for element in root.iter() if element.get("relativeQuantity") in ("true", "1")}
    units = {unit.name: unit.baseUnit for unit in told.unitDefinitions} if fmi > 1 else {}
    variables, refused = _variables(told, fmi, units, relative)
    joined = _named_ports(grouped(variables, shapes))
    outputs = {one.title: one for one in joined if one.causality == "output"}
    return Description(
        path=path,
        digest=digest,
        fmi=fmi,
        model=told.modelName or path.stem,
        token=told.guid,
        summary=told.description or "",
        interfaces=interfaces,
        variables=tuple(replace(one, frame=frames.get(one.title, "")) for one in joined),
        refused=refused,
        categories=tuple(category.name for category in told.logCategories),
        states=told.numberOfContinuousStates,
        indicators=told.numberOfEventIndicators,
        tolerance=float(told.defaultExperiment.tolerance) if _has_tolerance(told) else None,
        validity=outputs[validity].name if validity in outputs and not outputs[validity].shape else "",
    )


def _has_tolerance(told: Any) -> bool:
    return told.defaultExperiment is not None and bool(told.defaultExperiment.tolerance)


def _interfaces(told: Any, fmi: int, root: Any) -> Iterable[Interface]:
    can = [element.get("canHandleVariableCommunicationStepSize") for element in root.iter("Capabilities")]
    can_vary = fmi == 1 and any(value in ("true", "1") for value in can)  # which fmpy does not read
    for name, one in ((CO_SIMULATION, told.coSimulation), (MODEL_EXCHANGE, told.modelExchange)):
        if one is None or (fmi == 1 and name == MODEL_EXCHANGE):
            continue
        if not one.modelIdentifier or not re.fullmatch(r"[A-Za-z_]\w*", one.modelIdentifier):
            raise FmuError(f"its modelIdentifier is '{one.modelIdentifier}', which names no library")
        fixed = getattr(one, "fixedInternalStepSize", None)
        skips = getattr(one, "completedIntegratorStepNotNeeded", False)
        yield Interface(
            name=name,
            identifier=one.modelIdentifier,
            can_vary_step=bool(getattr(one, "canHandleVariableCommunicationStepSize", True)) or can_vary,
            fixed_step_s=float(fixed) if fixed else None,
            can_save=fmi > 1 and bool(one.canGetAndSetFMUstate and one.canSerializeFMUstate),
            is_single=bool(one.canBeInstantiatedOnlyOncePerProcess),
            needs_tool=bool(one.needsExecutionTool),
            has_events=bool(getattr(one, "hasEventMode", False)),
            returns_early=bool(getattr(one, "mightReturnEarlyFromDoStep", False)),
            needs_completed_steps=not skips if fmi == 2 else bool(getattr(one, "needsCompletedIntegratorStep", False)),
        )


def _annotated(root: Any) -> tuple[dict[str, tuple[int, ...]], dict[str, str], str]:
    """Shapes and frames of ports, and the validity's name, where Towline exported the FMU."""
    shapes, frames, validity = {}, {}, ""
    for holder in (*root.iter("Tool"), *root.iter("Annotation")):
        if "towline" in (holder.get("name"), holder.get("type")):
            validity = next((ports.get("validity", "") for ports in holder.iter("Ports")), "")
            for port in holder.iter("Port"):
                name = port.get("name", "")
                shapes[name] = tuple(int(length) for length in port.get("shape", "").split())
                frames[name] = port.get("frame", "")
    return shapes, frames, validity


def _variables(
    told: Any, fmi: int, units: Mapping[str, Any], relative: set[str | None]
) -> tuple[list[Variable], dict[str, str]]:
    """Those that can be seen or set; and those that a scene may ask for in vain."""
    found, refused, names = [], {}, set()
    by_name = kinds(fmi)
    structural = {one.valueReference for one in told.modelVariables if one.causality == "structuralParameter"}
    for one in told.modelVariables:
        if one.name in names:
            raise FmuError(f"two of its variables are named '{one.name}'")
        names.add(one.name)
        if not 0 <= one.valueReference < 2**32:
            raise FmuError(f"'{one.name}' has the value reference {one.valueReference}")
        is_port = one.causality in PORTS
        if one.type not in by_name or (is_port and not by_name[one.type].is_number):
            if is_port:
                what = f"'{one.name}' is a {one.type.lower()}, which changes during a run; only numbers can be wired"
                refused[one.name] = what
            if one.causality != "input" or one.type not in by_name:
                continue
        if is_port or one.causality in SETTABLE or _has_start_value(one):
            try:
                found.append(_variable(one, by_name[one.type], units, relative, structural))
            except FmuError:
                raise
            except (ValueError, OverflowError) as error:
                raise FmuError(f"'{one.name}': {error}") from error
    return found, refused


def _has_start_value(one: Any) -> bool:
    is_set = one.start is not None and one.initial in EXACT_OR_GUESSED
    return is_set and one.variability != "constant" and one.causality == "local"


def _variable(
    one: Any, kind: Any, units: Mapping[str, Any], relative: set[str | None], structural: set[int]
) -> Variable:
    title, declared = str(one.name), one.declaredType
    unit_name: str = one.unit or getattr(declared, "unit", None) or ""
    is_relative = one.name in relative or bool(getattr(declared, "relativeQuantity", False))
    unit = conversion(unit_name, units.get(unit_name), is_relative=is_relative) if kind.is_real else Conversion()
    dimensions = tuple(_dimension(one, length, structural) for length in one.dimensions)
    shape = tuple(one.shape or ())
    if math.prod(shape) > MOST or any(length < 0 for length in shape):
        raise FmuError(f"'{one.name}' claims the shape {shape}")
    low, high = _bounds(one, unit)
    items = () if declared is None else tuple((item.name, int(item.value)) for item in declared.items)
    is_unknown = unit_name not in ("", "1") and unit.unit == "1" and unit.is_none
    about = one.description or getattr(declared, "description", None) or ""
    return Variable(
        name=title,
        title=title,
        kind=kind,
        references=(one.valueReference,),
        causality=one.causality,
        variability=one.variability,
        initial=one.initial or "",
        unit=unit,
        shape=shape,
        dimensions=dimensions,
        start=_start(one, kind),
        low=low,
        high=high,
        items=items,
        description=f"{about} [{unit_name}]".strip() if is_unknown else about,
    )


def _bounds(one: Any, unit: Conversion) -> tuple[float | None, float | None]:
    """Least and greatest value in SI; a negative factor exchanges them, infinite ones are none."""
    declared = one.declaredType
    texts = [getattr(one, name) or getattr(declared, name, None) for name in ("min", "max")]
    low, high = (unit.to_si(float(text)) if text else None for text in texts)
    low, high = (high, low) if unit.factor < 0 else (low, high)
    return (
        low if low is not None and math.isfinite(low) else None,
        high if high is not None and math.isfinite(high) else None,
    )


def _dimension(one: Any, length: Any, structural: set[int]) -> int:
    if length.start is not None:
        return int(length.start)
    if length.valueReference not in structural:
        raise FmuError(f"'{one.name}' has a dimension from variable {length.valueReference}, no structural parameter")
    return -1 - int(length.valueReference)


def _start(one: Any, kind: Any) -> tuple[Any, ...] | None:
    """Its start values as numbers, truths or texts; one for all elements is repeated."""
    if one.start is None:
        return None
    n = math.prod(one.shape or ())
    if not kind.is_number:
        return (bytes.fromhex(one.start).hex() if kind.name == "Binary" else one.start,)
    texts = str(one.start).split()
    values = tuple(_number(text, kind) for text in texts)
    if len(values) == 1 and n != 1:
        return values * n
    if len(values) != n:
        raise FmuError(f"'{one.name}' holds {n} values and starts with {len(values)}")
    return values


def _number(text: str, kind: Any) -> Any:
    if kind.is_boolean:
        if text not in ("true", "false", "0", "1"):
            raise FmuError(f"'{text}' is neither true nor false")
        return text in ("true", "1")
    return float(text) if kind.is_real else int(text)


def _named_ports(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """No port is a bundle of others, in either direction."""
    renamed = {}
    for causality in PORTS:
        ports = [one for one in variables if one.causality == causality and one.kind.is_number]
        renamed |= dict(zip((one.title for one in ports), unbundled([one.name for one in ports]), strict=True))
    return tuple(replace(one, name=renamed.get(one.title, one.name)) for one in variables)
