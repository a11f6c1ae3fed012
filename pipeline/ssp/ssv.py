"""Parameter sets (SSV) and their mappings (SSM) of SSP 1.0."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

from pipeline.hosts.fmu.units import BASES, Conversion, conversion
from pipeline.hosts.fmu.variables import Variable
from pipeline.ssp.system import Affine, Value, number

SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
SSM = "{http://ssp-standard.org/SSP1/SystemStructureParameterMapping}"
TRUTHS = {"true": True, "1": True, "false": False, "0": False}


def units(holder: Any) -> dict[str, Conversion]:
    """The units that an element defines, by name; holder: Units, or None. Raises ValueError."""
    found = {}
    for unit in () if holder is None else holder.iter(f"{SSC}Unit"):
        base = unit.find(f"{SSC}BaseUnit")
        told = {} if base is None else base.attrib
        powers = {name: int(told.get(name, 0)) for name in BASES}
        about = SimpleNamespace(**powers, factor=float(told.get("factor", 1)), offset=float(told.get("offset", 0)))
        found[unit.get("name", "")] = conversion(unit.get("name", ""), about, is_relative=False)
    return found


def unit_of(name: str | None, known: dict[str, Conversion]) -> Conversion | None:
    """A unit by its name; None where none is told."""
    return (known.get(name) or conversion(name, None, is_relative=False)) if name else None


def parameter_set(root: Any, known: dict[str, Conversion]) -> dict[str, Value]:
    """The values of a ssv:ParameterSet by name. known: units defined around it. Raises ValueError."""
    known = known | units(root.find(f"{SSV}Units"))
    found = {}
    for parameter in root.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
        name = parameter.get("name", "")
        for one in parameter:
            kind = str(one.tag).removeprefix(SSV)
            if kind in READ:
                found[name] = Value(READ[kind](one.get("value", ""), name), unit_of(one.get("unit"), known))
    return found


def transformation(holder: Any, what: str) -> Affine | None:
    """What an element transforms numbers by; None where no linear function does the same. Raises ValueError."""
    linear = holder.find(f"{SSC}LinearTransformation")
    if linear is not None:
        factor, offset = (
            number(linear.get(key), usual, f"{what}: {key}") for key, usual in (("factor", 1), ("offset", 0))
        )
        return Affine(factor, offset)
    for name in ("BooleanMappingTransformation", "IntegerMappingTransformation"):
        mapping = holder.find(f"{SSC}{name}")
        if mapping is not None:
            return _line([(_whole(one.get("source")), _whole(one.get("target"))) for one in mapping])
    return None if holder.find(f"{SSC}EnumerationMappingTransformation") is not None else Affine()


def _whole(text: str | None) -> Fraction:
    return Fraction(TRUTHS[text]) if text in TRUTHS else Fraction(int(text or ""))


def _line(pairs: list[tuple[Fraction, Fraction]]) -> Affine | None:
    """The line through all the pairs, if there is one."""
    (x, y), *rest = dict(pairs).items() or [(Fraction(0), Fraction(0))]
    factor = (rest[0][1] - y) / (rest[0][0] - x) if rest else Fraction(0)
    line = Affine(factor, y - factor * x)
    return line if all(line.factor * a + line.offset == b for a, b in pairs) else None


def mapped(root: Any, values: dict[str, Value], what: str) -> tuple[dict[str, Value], list[str]]:
    """The values under the names of a ssm:ParameterMapping's targets, and what could not be. Raises ValueError."""
    found, notes = {}, []
    for entry in root.iterfind(f"{SSM}MappingEntry"):
        source, target = entry.get("source", ""), entry.get("target", "")
        value = values.get(source)
        change = transformation(entry, f"{what}: {source}")
        if value is None:
            continue
        if change is None or (change != Affine() and not isinstance(value.value, int | float)):
            notes.append(f"{what}: the mapping of {source} to {target} is no linear function; {target} is not set")
            continue
        unit = None if entry.get("suppressUnitConversion") in ("true", "1") else value.unit
        found[target] = Value(value.value, unit, change)
    return found, notes


def _real(text: str, name: str) -> float:
    return float(number(text, 0, f"the parameter {name}"))


def _integer(text: str, name: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"the parameter {name} '{text[:40]}' is no whole number") from None


def _boolean(text: str, name: str) -> bool:
    if text not in TRUTHS:
        raise ValueError(f"the parameter {name} '{text[:40]}' is neither true nor false")
    return TRUTHS[text]


def _text(text: str, _: str) -> str:
    return text


READ = {
    "Real": _real,
    "Integer": _integer,
    "Boolean": _boolean,
    "String": _text,
    "Enumeration": _text,
    "Binary": _text,
}


def definition(base: Any) -> tuple[tuple[str, str], ...]:
    """A unit's definition as attributes; FMI and SSP write it alike."""
    if base is None:
        return ()
    powers = [(key, str(int(getattr(base, key)))) for key in BASES if int(getattr(base, key) or 0)]
    usual = (("factor", 1.0), ("offset", 0.0))
    return (
        *powers,
        *((key, repr(float(getattr(base, key)))) for key, one in usual if float(getattr(base, key)) != one),
    )


def written(number: Any, one: Variable) -> str:
    """A number, truth or text of an FMU's variable as an SSV has it."""
    names = {value: name for name, value in one.items}
    if one.kind.name == "Enumeration":
        return names.get(int(number), str(int(number)))
    if isinstance(number, bool):
        return str(number).lower()
    if isinstance(number, float) and not one.kind.is_real:
        return str(bool(number)).lower() if one.kind.is_boolean else str(int(number))
    return repr(number) if isinstance(number, float) else str(number)
