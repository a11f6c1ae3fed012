"""Units of ports and parameters as FMI writes them: powers of the SI base units, a factor and an offset."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.quantities import base_units

# pint's names of the base units, and FMI's.
SYMBOLS = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}


@dataclass(frozen=True)
class BaseUnit:
    """value in SI = factor * value + offset; powers: of FMI's base units, zeros left out."""

    powers: dict[str, int]
    factor: float
    offset: float


def base_unit(unit: str) -> BaseUnit | None:
    """A unit in SI base units; None where it has other ones or broken powers, which FMI cannot say."""
    powers, factor, offset = base_units(unit)
    if not all(name in SYMBOLS and power == int(power) for name, power in powers.items()):
        return None
    return BaseUnit({SYMBOLS[name]: int(power) for name, power in powers.items()}, float(factor), float(offset))
