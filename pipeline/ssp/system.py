"""A system of FMUs as a system structure says it, flat: parts, what their inputs are fed by, values, and times."""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path
from typing import Any

from pipeline.hosts.fmu.units import Conversion


@dataclass(frozen=True)
class Affine:
    """y = factor x + offset, exactly, so that nothing is rounded before the end of a chain of them."""

    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)

    def after(self, first: Affine) -> Affine:
        """This one of what the first one gives."""
        return Affine(self.factor * first.factor, self.factor * first.offset + self.offset)

    def inverse(self) -> Affine:
        """x of y; the factor must not be zero."""
        return Affine(1 / self.factor, -self.offset / self.factor)


@dataclass(frozen=True)
class Value:
    """A parameter's or start value as written. unit: None where none is told, which means the variable's own.

    then: what is done with the number, once it is in the variable's unit.
    """

    value: Any
    unit: Conversion | None = None
    then: Affine = Affine()


@dataclass(frozen=True)
class End:
    """A variable of a part by its name in the FMU."""

    part: str
    variable: str


@dataclass(frozen=True)
class Feed:
    """One addend of what feeds an input: the FMU's numbers are made those of the input's FMU by `map`.

    is_direct, initial: whether the wire is direct, and what it carries before the first step, in SI; None: not told.
    """

    source: End
    map: Affine = Affine()
    is_direct: bool | None = None
    initial: Any = None


@dataclass(frozen=True)
class Link:
    """All that feeds one input."""

    target: End
    feeds: tuple[Feed, ...]


@dataclass
class Part:
    """One FMU of the system. title: its name there. settings: more keys of a scenario's component."""

    title: str
    fmu: Path
    interface: str = ""
    period_ns: int = 0
    values: dict[str, Value] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass
class System:
    """The whole. Times in ns, None where not told. notes: what could not be kept, a line each.

    settings: more keys of a scenario's top level. are_delayed: whether the structure steps all parts at once, on the
    values before.
    """

    name: str
    description: str = ""
    parts: list[Part] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    start_ns: int | None = None
    stop_ns: int | None = None
    step_ns: int | None = None
    are_delayed: bool = False
    settings: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def note(self, text: str) -> None:
        """Add a line, once."""
        text = " ".join(text.split())
        if text not in self.notes:
            self.notes.append(text)


def of_unit(unit: Conversion) -> Affine:
    """Numbers in the unit made SI."""
    return Affine(Fraction(unit.factor), Fraction(unit.offset))


def between(source: Conversion | None, target: Conversion | None) -> Affine | None:
    """Numbers in one unit made numbers in the other: as they are where one is not told; None where that cannot be."""
    if source is None or target is None or source == target:
        return Affine()
    if source.unit != target.unit:
        return None
    return of_unit(target).inverse().after(of_unit(source))


def time_ns(text: str, what: str) -> int:
    """Seconds as written, to the nearest nanosecond. Raises ValueError."""
    seconds = _exact(text)
    if seconds is None:
        raise ValueError(f"{what} '{text[:40]}' is no number of seconds")
    if abs(seconds) >= 2**63 // 10**9:
        raise ValueError(f"{what} of {text[:40]} s is beyond 292 years")
    return round(seconds * 10**9)


def number(text: str | None, default: int, what: str) -> Fraction:
    """A decimal number as written, exactly. Raises ValueError."""
    if text is None:
        return Fraction(default)
    value = _exact(text)
    if value is None:
        raise ValueError(f"{what} '{text[:40]}' is no finite number")
    return value


def _exact(text: str) -> Fraction | None:
    """A decimal number that float64 can hold; None where it is none. A few characters may claim a billion digits."""
    try:
        value = Decimal(text.strip()) if len(text) <= 100 else None
    except InvalidOperation:
        return None
    if value is None or not value.is_finite() or (value and abs(value.adjusted()) > 300):
        return None
    return Fraction(value)
