"""The modelDescription.xml of the tests' FMUs, in each version of FMI, written from one list of variables."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from xml.sax.saxutils import quoteattr
from zlib import crc32

TIME = 599  # its value reference in FMI 3
UNITS = {  # powers of SI's base units, and the factor to them
    "m": ({"m": 1}, 1.0),
    "s": ({"s": 1}, 1.0),
    "m/s": ({"m": 1, "s": -1}, 1.0),
    "m/s2": ({"m": 1, "s": -2}, 1.0),
    "N": ({"kg": 1, "m": 1, "s": -2}, 1.0),
    "kN": ({"kg": 1, "m": 1, "s": -2}, 1000.0),
    "t": ({"kg": 1}, 1000.0),
    "deg": ({"rad": 1}, 0.017453292519943295),
}
CHOICES = {"low": 1, "middle": 2, "high": 3}
PLAIN = {"Float64": "Real", "Float32": "Real", "Boolean": "Boolean", "String": "String", "Enumeration": "Enumeration"}


@dataclass(frozen=True)
class Variable:
    """One variable, typed as FMI 3 does; shape: numbers, or names of structural parameters.

    start: one value, or as many as the shape holds. of: the state that it is the derivative of.
    """

    name: str
    reference: int
    causality: str
    type: str = "Float64"
    start: object = None
    unit: str = ""
    variability: str = ""
    shape: tuple[int | str, ...] = ()
    of: str = ""
    description: str = ""

    @property
    def is_float(self) -> bool:
        return self.type.startswith("Float")

    @property
    def varies(self) -> str:
        """Its variability, the usual one where none is given."""
        usual = "fixed" if "arameter" in self.causality else "continuous" if self.is_float else "discrete"
        return self.variability or usual

    @property
    def initial(self) -> str:
        if "arameter" in self.causality or self.causality in ("input", "independent"):
            return ""
        return "exact" if self.start is not None else "calculated"


@dataclass(frozen=True)
class Model:
    """A C source of this folder, and what its description says. flags: attributes of both interfaces."""

    name: str
    variables: tuple[Variable, ...]
    interfaces: tuple[str, ...] = ("CoSimulation", "ModelExchange")
    indicators: tuple[str, ...] = ()  # variables that are event indicators
    flags: dict[str, str] = field(default_factory=dict)
    step: str = "0.01"
    stop: str = "1"


def token(name: str) -> str:
    """What a model's description and binary know each other by; importers tell FMUs apart by it."""
    return f"{{8c4e810f-3da3-4a00-8276-{crc32(name.encode()):012x}}}"


def described(model: Model, fmi: int) -> str:
    """The document."""
    return {1: _fmi1, 2: _fmi2, 3: _fmi3}[fmi](model)


def _attributes(**values: object) -> str:
    return "".join(f" {key.rstrip('_')}={quoteattr(str(value))}" for key, value in values.items() if value is not None)


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return " ".join(map(_text, value)) if isinstance(value, list | tuple) else str(value)


def _start(one: Variable) -> str | None:
    return None if one.start is None else _text(one.start)


def _scalars(model: Model) -> list[Variable]:
    """The variables of FMI 1 and 2, which know neither arrays nor binaries nor structural parameters."""
    found: list[Variable] = []
    lengths = {one.name: one.start for one in model.variables if one.causality == "structuralParameter"}
    for one in model.variables:
        shape = [lengths[n] if isinstance(n, str) else n for n in one.shape]
        if one.causality == "structuralParameter" or one.type == "Binary":
            continue
        if not shape:
            found.append(one)
            continue
        starts = one.start if isinstance(one.start, tuple) else [one.start] * prod(shape)
        for k, index in enumerate(product(*(range(1, n + 1) for n in shape))):
            name = f"{one.name}[{','.join(map(str, index))}]"
            found.append(replace(one, name=name, reference=one.reference + k, start=starts[k], shape=()))
    return found


def _fmi1(model: Model) -> str:
    lines = []
    for one in _scalars(model):
        kind = PLAIN.get(one.type, "Integer")
        is_parameter = "arameter" in one.causality
        role = one.causality if one.causality in ("input", "output") else "internal"
        fixed = "true" if one.causality == "output" and one.start is not None else None
        declared = "Choice" if kind == "Enumeration" else None
        about = _attributes(
            name=one.name, valueReference=one.reference, description=one.description or None, causality=role
        )
        varies = _attributes(variability="parameter" if is_parameter else one.varies)
        inner = _attributes(declaredType=declared, unit=one.unit or None, start=_start(one), fixed=fixed)
        lines.append(f"<ScalarVariable{about}{varies}><{kind}{inner}/></ScalarVariable>")
    items = "".join(f"<Item name={quoteattr(name)}/>" for name in CHOICES)
    units = "".join(f"<BaseUnit unit={quoteattr(unit)}/>" for unit in _units(model))
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="1.0" modelName="{model.name}" '
        f'modelIdentifier="{model.name}" guid="{token(model.name)}" '
        'numberOfContinuousStates="0" numberOfEventIndicators="0">\n'
        + f"<UnitDefinitions>{units}</UnitDefinitions>"
        + f'<TypeDefinitions><Type name="Choice"><EnumerationType>{items}</EnumerationType></Type></TypeDefinitions>\n'
        + f'<DefaultExperiment startTime="0" stopTime="{model.stop}"/>\n'
        + "<ModelVariables>\n"
        + "\n".join(lines)
        + "\n</ModelVariables>\n<Implementation><CoSimulation_StandAlone><Capabilities"
        + ' canHandleVariableCommunicationStepSize="true" canHandleEvents="true"/>'
        + "</CoSimulation_StandAlone></Implementation>\n</fmiModelDescription>\n"
    )


def _fmi2(model: Model) -> str:
    variables = _scalars(model)
    index = {one.name: k + 1 for k, one in enumerate(variables)}
    lines = []
    for one in variables:
        kind = PLAIN.get(one.type, "Integer")
        declared = "Choice" if kind == "Enumeration" else None
        of = index[one.of] if one.of else None
        about = _attributes(name=one.name, valueReference=one.reference, description=one.description or None)
        roles = _attributes(causality=one.causality, variability=one.varies, initial=one.initial or None)
        inner = _attributes(declaredType=declared, unit=one.unit or None, start=_start(one), derivative=of)
        lines.append(f"<ScalarVariable{about}{roles}><{kind}{inner}/></ScalarVariable>")
    outputs = [index[one.name] for one in variables if one.causality == "output"]
    rates = [index[one.name] for one in variables if one.of]
    unknown = [
        index[one.name] for one in variables if one.initial == "calculated" and (one.causality == "output" or one.of)
    ]
    structure = "".join(
        f"<{name}>{''.join(f'<Unknown index={quoteattr(str(k))}/>' for k in found)}</{name}>"
        for name, found in (("Outputs", outputs), ("Derivatives", rates), ("InitialUnknowns", sorted(unknown)))
        if found
    )
    flags = {"canGetAndSetFMUState": "canGetAndSetFMUstate", "canSerializeFMUState": "canSerializeFMUstate"}
    mine = {flags.get(key, key): value for key, value in model.flags.items() if key not in EVENTS}
    of_steps = {"canHandleVariableCommunicationStepSize": "true"}
    items = "".join(f'<Item name="{name}" value="{value}"/>' for name, value in CHOICES.items())
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="2.0" modelName="{model.name}" '
        f'guid="{token(model.name)}" numberOfEventIndicators="{len(model.indicators)}">\n'
        + "".join(
            f"<{kind}{_attributes(modelIdentifier=model.name)}"
            + _attributes(**({} if kind == "ModelExchange" else of_steps) | _common(mine, kind))
            + "/>\n"
            for kind in ("ModelExchange", "CoSimulation")
            if kind in model.interfaces
        )
        + _unit_definitions(model, 2)
        + f'<TypeDefinitions><SimpleType name="Choice"><Enumeration>{items}</Enumeration></SimpleType>'
        + "</TypeDefinitions>\n"
        + f'<DefaultExperiment startTime="0" stopTime="{model.stop}" stepSize="{model.step}"/>\n<ModelVariables>\n'
        + "\n".join(lines)
        + f"\n</ModelVariables>\n<ModelStructure>{structure}</ModelStructure>\n</fmiModelDescription>\n"
    )


EVENTS = (
    "hasEventMode",
    "mightReturnEarlyFromDoStep",
    "canReturnEarlyAfterIntermediateUpdate",
    "fixedInternalStepSize",
)
OF_STEPS = (*EVENTS, "canHandleVariableCommunicationStepSize")


def _common(flags: dict[str, str], kind: str) -> dict[str, str]:
    """Those that an interface knows."""
    return {key: value for key, value in flags.items() if kind == "CoSimulation" or key not in OF_STEPS}


def _fmi3(model: Model) -> str:
    references = {one.name: one.reference for one in model.variables}
    time = Variable("time", TIME, "independent", unit="s")
    lines = []
    for one in (time, *model.variables):
        about = _attributes(name=one.name, valueReference=one.reference, description=one.description or None)
        about += _attributes(causality=one.causality, variability=one.varies, initial=one.initial or None)
        if one.type == "Enumeration":
            about += _attributes(declaredType="Choice")
        is_inside = one.type in ("String", "Binary")
        about += _attributes(unit=one.unit or None, start=None if is_inside else _start(one))
        about += _attributes(derivative=references[one.of] if one.of else None)
        inside = "".join(
            f"<Dimension{_attributes(valueReference=references[n]) if isinstance(n, str) else _attributes(start=n)}/>"
            for n in one.shape
        )
        if is_inside and one.start is not None:
            inside += f"<Start value={quoteattr(_text(one.start))}/>"
        lines.append(f"<{one.type}{about}>{inside}</{one.type}>" if inside else f"<{one.type}{about}/>")
    outputs = [one.reference for one in model.variables if one.causality == "output"]
    rates = [one.reference for one in model.variables if one.of]
    unknown = [
        one.reference
        for one in model.variables
        if one.initial == "calculated" and (one.causality == "output" or one.of)
    ]
    structure = "".join(
        f'<{name} valueReference="{reference}"/>'
        for name, found in (
            ("Output", outputs),
            ("ContinuousStateDerivative", rates),
            ("InitialUnknown", unknown),
            ("EventIndicator", [references[name] for name in model.indicators]),
        )
        for reference in found
    )
    of_steps = {"canHandleVariableCommunicationStepSize": "true"}
    items = "".join(f'<Item name="{name}" value="{value}"/>' for name, value in CHOICES.items())
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="3.0" modelName="{model.name}" '
        f'instantiationToken="{token(model.name)}">\n'
        + "".join(
            f"<{kind}{_attributes(modelIdentifier=model.name)}"
            + _attributes(**({} if kind == "ModelExchange" else of_steps) | _common(model.flags, kind))
            + "/>\n"
            for kind in ("ModelExchange", "CoSimulation")
            if kind in model.interfaces
        )
        + _unit_definitions(model, 3)
        + f'<TypeDefinitions><EnumerationType name="Choice">{items}</EnumerationType></TypeDefinitions>\n'
        + f'<DefaultExperiment startTime="0" stopTime="{model.stop}" stepSize="{model.step}"/>\n<ModelVariables>\n'
        + "\n".join(lines)
        + f"\n</ModelVariables>\n<ModelStructure>{structure}</ModelStructure>\n</fmiModelDescription>\n"
    )


def _units(model: Model) -> list[str]:
    return sorted({one.unit for one in model.variables if one.unit in UNITS} | {"s"})


def _unit_definitions(model: Model, fmi: int) -> str:
    lines = []
    for unit in _units(model):
        powers, factor = UNITS[unit]
        base = _attributes(**powers, factor=None if factor == 1.0 else factor)
        lines.append(f'<Unit name="{unit}"><BaseUnit{base}/></Unit>')
    return f"<UnitDefinitions>{''.join(lines)}</UnitDefinitions>\n"
