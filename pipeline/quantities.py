"""Numbers with units, as users write them, turned into SI floats and integer nanoseconds.

pint knows the units; its registry is made on first need (0.4 s), and not at all for numbers already in the unit
that is wanted. Conversion is decimal, so that 0.1 s is 100 000 000 ns and 30 deg is rounded once.
"""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction
from functools import cache, lru_cache
from math import isfinite
from typing import Any

_LONGEST = 80  # characters; no honest quantity is longer, and pint need not see more
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?")
_NOT_FINITE = re.compile(r"[+-]?\.?(?:inf|nan)(?:inity)?\b", re.IGNORECASE)
_POWER = r"(?:(?:\^|\*\*)-?[0-9](?:\.[0-9])?|[²³])?"
_UNIT = re.compile(rf"(?>1(?![0-9.])|[A-Za-zµμ°Ω%][A-Za-zµμ°Ω_]*+{_POWER}|\){_POWER}|\*(?!\*)|[(/· ])+")
_COHERENT = r"(?:m|s|kg|N|J|W|Pa|Hz|V|A|K|rad)(?:\^[1-4])?"  # the usual ones, known without waking pint
_SI = re.compile(rf"1|(?:1/)?{_COHERENT}(?:[ */]{_COHERENT})*")
LATEST = 2**63 - 1  # ns
_SECOND = 10**9  # ns
_TIMES = {
    "s": Fraction(1),
    "ms": Fraction(1, 10**3),
    "us": Fraction(1, 10**6),
    "ns": Fraction(1, 10**9),
}  # without pint


def shown(value: object) -> str:
    """The value as a message shows it: YAML's words, text quoted, long text cut."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    text = f"'{value}'" if isinstance(value, str) else str(value)
    return text if len(text) <= _LONGEST // 2 else f"{text[: _LONGEST // 2]}..."


def si_value(value: object, unit: str, *, bare: bool = False) -> float:
    """`3.5 m`, `30 deg`, or a number, in `unit` (SI, "1": dimensionless).

    bare: a number without a unit is taken to be in `unit` already; else only dimensionless ones may do without.
    Raises ValueError with what is wrong and what would be right.
    """
    if isinstance(value, str):
        return _from_text(value, unit, bare=bare)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{_kind(value)} is not a number; expected {_example(unit)}")
    number = _finite(value, str(value))
    if not bare and not is_plain(unit):
        raise ValueError(f"{shown(value)} has no unit; expected {_example(unit, value)}")
    return number


def nanoseconds(value: object, *, bare: bool = False, rate: bool = False) -> int:
    """`20 ms` as 20 000 000, exactly.

    bare: a number without a unit is in seconds. rate: `25 Hz` is taken as well, as its period.
    Raises ValueError, also where it is no whole number of nanoseconds or does not fit 64 bits.
    """
    if not isinstance(value, str):
        return _whole(Fraction(str(si_value(value, "s", bare=bare))), str(value))
    number, unit = _split(value, "s")
    if not unit:
        si_value(value, "s", bare=bare)  # raises unless a bare number will do
        return _whole(Fraction(number), value)
    if unit in _TIMES:
        return _whole(Fraction(number) * _TIMES[unit], value)
    if rate and converts(unit, "Hz"):
        hertz = Fraction(number) * Fraction(_conversion(unit, "Hz")[0])
        if hertz == 0:
            raise ValueError(f"{shown(value)} has no period; expected a rate above zero")
        return _whole(1 / hertz, value)
    factor, _ = _factors(value, unit, "s")
    return _whole(Fraction(number) * Fraction(factor), value)


def as_time(ns: int) -> str:
    """166980000000 as `166.98 s`, exactly."""
    for unit, size in (("s", 10**9), ("ms", 10**6), ("us", 10**3)):
        if abs(ns) >= size and ns * 1000 % size == 0:
            return f"{(Decimal(ns) / size).normalize():f} {unit}"
    return f"{ns} ns" if ns else "0 s"


def same_unit(given: str, wanted: str) -> bool:
    """Whether a number in one unit is the same number in the other (N m and J; not rad/s and Hz)."""
    return given == wanted or (converts(given, wanted) and _conversion(given, wanted) == (1, 0))


def ratio(unit: str, per: str) -> str:
    """The unit of `unit` divided by `per`, as text."""
    if per == "1":
        return unit
    return f"{unit}/{per}" if re.fullmatch(r"[A-Za-z]+", per) else f"{unit}/({per})"


def is_unit(unit: str) -> bool:
    """Whether the text is a unit, "1" among them."""
    return bool(_SI.fullmatch(unit)) or converts(unit, unit)


@lru_cache(1024)
def is_plain(unit: str) -> bool:
    """Whether a number in this unit needs no unit written: dimensionless, and no angle."""
    return unit == "1" or converts(unit, "1")


@lru_cache(1024)
def converts(given: str, wanted: str) -> bool:
    """Whether `given` can be expressed in `wanted`; false too where either is no unit."""
    try:
        _conversion(given, wanted)
    except ValueError:
        return False
    return True


def base_units(unit: str) -> tuple[dict[str, float], Decimal, Decimal]:
    """Powers of pint's base units (in SI) by name, and factor and offset: value in them = factor * value + offset.

    Raises ValueError if it is no unit.
    """
    _dimension(unit)
    registry = _registry()
    zero, one = (registry.Quantity(Decimal(n), registry.parse_units(unit)).to_base_units() for n in (0, 1))
    powers = {str(name): float(power) for name, power in one.unit_items()}
    return powers, one.magnitude - zero.magnitude, zero.magnitude


def _from_text(text: str, unit: str, *, bare: bool) -> float:
    number, given = _split(text, unit)
    if not given:
        if not bare and not is_plain(unit):
            raise ValueError(f"{shown(text)} has no unit; expected {_example(unit, number)}")
        return _finite(number, text)
    factor, offset = _factors(text, given, unit)
    if (factor, offset) == (1, 0):
        return _finite(number, text)
    return _finite(Decimal(number) * factor + offset, text)


def _split(text: str, wanted: str) -> tuple[str, str]:
    """Number and unit of a written quantity."""
    text = text.strip()
    match = _NUMBER.match(text)
    if match is None and _NOT_FINITE.match(text):
        raise ValueError(f"{shown(text)} is not finite; expected {_example(wanted)}")
    if match is None or len(text) > _LONGEST:
        raise ValueError(f"{shown(text)} is not a number; expected {_example(wanted)}")
    return match.group(), text[match.end() :].strip()


def _factors(text: str, given: str, wanted: str) -> tuple[Decimal, Decimal]:
    if given == wanted:
        return Decimal(1), Decimal(0)
    try:
        return _conversion(given, wanted)
    except ValueError as error:
        raise ValueError(f"{shown(text)}: {error}; expected {_example(wanted)}") from None


@lru_cache(4096)
def _conversion(given: str, wanted: str) -> tuple[Decimal, Decimal]:
    """Factor and offset from one unit to the other; ValueError where there is none."""
    if _dimension(given) != _dimension(wanted):
        raise ValueError(f"'{given}' does not convert to '{wanted}'")
    registry = _registry()
    source, target = registry.parse_units(given), registry.parse_units(wanted)
    zero, one = (Decimal(str(registry.Quantity(Decimal(n), source).to(target).magnitude)) for n in (0, 1))
    return one - zero, zero


@lru_cache(4096)
def _dimension(unit: str) -> tuple[frozenset[tuple[str, float]], float]:
    """Dimensions, and the power of the angle, which is told apart in numbers and rates only: rad/s is not Hz."""
    if len(unit) > _LONGEST or not _UNIT.fullmatch(unit):
        raise ValueError(f"{shown(unit)} is not a unit")
    try:
        one = _registry().Quantity(Decimal(1), _registry().parse_units(unit)).to_root_units()
    except Exception:  # pint's parser raises many kinds, AssertionError among them
        raise ValueError(f"{shown(unit)} is not a known unit") from None
    dimensions = frozenset((name, float(power)) for name, power in one.dimensionality.items())
    is_rate = all(name == "[time]" for name, _ in dimensions)
    return dimensions, float(dict(one.unit_items()).get("radian", 0)) if is_rate else 0.0


@cache
def _registry() -> Any:  # pint's annotations know no Decimal
    import pint

    registry: Any = pint.UnitRegistry
    return registry(non_int_type=Decimal)


def _finite(number: float | str | Decimal, text: str) -> float:
    try:
        value = float(number)
    except OverflowError:
        value = float("inf")
    if not isfinite(value):
        raise ValueError(f"{shown(text)} is not finite; expected a finite number")
    return value


def _whole(seconds: Fraction, text: str) -> int:
    time = seconds * _SECOND
    if abs(time) > LATEST:
        raise ValueError(f"{shown(text)} is too long; times reach to 292 years")
    if time.denominator != 1:
        raise ValueError(f"{shown(text)} is not a whole number of nanoseconds; expected e.g. {round(time)} ns")
    return int(time)


def _kind(value: object) -> str:
    if isinstance(value, list | tuple):
        return "a list"
    return "a mapping" if isinstance(value, dict) else shown(value)


def _example(unit: str, number: object = 1) -> str:
    return "a number" if unit == "1" else f"a quantity in {unit}, such as '{number} {unit}'"
