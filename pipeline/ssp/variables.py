"""Variables of an FMU by their own names, as system structures call them, and what ports they are part of."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.fmu.archive import model_description
from pipeline.hosts.fmu.description import Description, read
from pipeline.hosts.fmu.units import Conversion
from pipeline.hosts.fmu.variables import Variable

_INDEX = re.compile(r"\[[^\[\]]*\]")


@dataclass(frozen=True)
class Element:
    """A number of a port or parameter; position: which, row by row; None: the whole array, one variable of FMI 3."""

    variable: Variable
    position: int | None

    @property
    def slice(self) -> str:
        """As a scenario writes it behind the port's name."""
        if self.position is None or not self.variable.shape:
            return ""
        return f"[{', '.join(map(str, np.unravel_index(self.position, self.variable.shape)))}]"

    @property
    def unit(self) -> Conversion | None:
        """What its numbers are in; None where the FMU does not tell."""
        unit = self.variable.unit
        return None if unit == Conversion() else unit


def elements(fmu: Path) -> dict[str, Element]:
    """By name in the FMU, in its order. Raises TowlineError."""
    return _elements(read(fmu))


@lru_cache(64)
def _elements(description: Description) -> dict[str, Element]:
    homes: dict[tuple[str, int], list[tuple[Variable, int | None]]] = {}
    for one in description.variables:
        is_whole = len(one.references) == 1 and bool(one.shape or one.dimensions)
        for position, reference in enumerate(one.references):
            homes.setdefault((one.causality, reference), []).append((one, None if is_whole else position))
    found = {}
    for told in model_description(description.path).modelVariables:
        for variable, position in homes.get((told.causality, told.valueReference), ()):
            if variable.title in (told.name, _INDEX.sub("", told.name)):
                found.setdefault(told.name, Element(variable, position))
    return found


@lru_cache(64)
def told(path: Path) -> dict[str, Any]:
    """The FMU's variables by name, as fmpy reads them."""
    return {one.name: one for one in model_description(path).modelVariables}


@lru_cache(64)
def units_of(path: Path) -> dict[str, Any]:
    """Definitions of the FMU's units by name."""
    return {unit.name: unit.baseUnit for unit in model_description(path).unitDefinitions}
