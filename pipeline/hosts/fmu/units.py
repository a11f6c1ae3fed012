"""Units of an FMU's variables turned into those of ports: SI, with the factor and offset that lead there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pipeline.quantities import base_units, converts, is_unit, same_unit

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
# Powers of the bases above -> the name that a reader knows.
NAMED: dict[tuple[int, ...], str] = {
    (1, 1, -2, 0, 0, 0, 0, 0): "N",
    (1, 2, -2, 0, 0, 0, 0, 0): "J",
    (1, 2, -3, 0, 0, 0, 0, 0): "W",
    (1, -1, -2, 0, 0, 0, 0, 0): "Pa",
    (0, 0, -1, 0, 0, 0, 0, 0): "1/s",
    (1, 2, -3, -1, 0, 0, 0, 0): "V",
}
# pint's names of the same bases.
PINT = ("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela", "radian")


@dataclass(frozen=True)
class Conversion:
    """value in `unit` (SI) = factor * value of the FMU + offset."""

    unit: str = "1"
    factor: float = 1.0
    offset: float = 0.0

    @property
    def is_none(self) -> bool:
        """Whether the numbers stay as they are."""
        return self.factor == 1.0 and self.offset == 0.0

    def to_si(self, value: float) -> float:
        """One of the FMU's numbers in SI."""
        return value if self.is_none else self.factor * value + self.offset

    def to_fmu(self, value: float) -> float:
        """A number in SI as the FMU takes it."""
        return value if self.is_none else (value - self.offset) / self.factor


def conversion(name: str, base: Any, *, is_relative: bool) -> Conversion:
    """Of a unit by its name and FMI's definition of it (None: there is none), as fmpy reads it.

    is_relative: a difference, to which no offset is added. A unit that is defined nowhere counts as a plain number.
    """
    if base is not None:
        return _defined(name, base, is_relative)
    if not name or not is_unit(name):
        return Conversion()
    powers, factor, offset = base_units(name)
    if not set(powers) <= set(PINT) or any(power != int(power) for power in powers.values()):
        return Conversion()
    unit = _spelt(name, tuple(int(powers.get(one, 0)) for one in PINT))
    return Conversion(unit, float(factor), 0.0 if is_relative else float(offset))


def _defined(name: str, base: Any, is_relative: bool) -> Conversion:
    factor, offset = float(base.factor), 0.0 if is_relative else float(base.offset)
    if not (math.isfinite(factor) and math.isfinite(offset)) or factor == 0.0:
        raise ValueError(f"its unit '{name}' has the factor {base.factor} and the offset {base.offset}")
    powers = tuple(int(getattr(base, one) or 0) for one in BASES)
    unit = _spelt(name, powers) if (factor, offset) == (1.0, 0.0) else _named(powers)
    return Conversion(unit, factor, offset)


def _spelt(name: str, powers: tuple[int, ...]) -> str:
    """The FMU's own name where that is the SI unit itself, else ours."""
    ours = _named(powers)
    return name if is_unit(name) and converts(name, ours) and same_unit(name, ours) else ours


def _named(powers: tuple[int, ...]) -> str:
    if powers in NAMED:
        return NAMED[powers]
    over = [_power(one, power) for one, power in zip(BASES, powers, strict=True) if power > 0]
    under = [_power(one, -power) for one, power in zip(BASES, powers, strict=True) if power < 0]
    text = "*".join(over) or "1"
    return "/".join([text, *under])


def _power(base: str, power: int) -> str:
    return base if power == 1 else f"{base}^{power}"
