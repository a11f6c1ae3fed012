"""Names of an FMU's variables made into ports and parameters: elements that belong together become one array."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from typing import Any

from components.contract import Parameters
from pipeline.hosts.fmu.kinds import Kind
from pipeline.hosts.fmu.units import Conversion

_INDEX = re.compile(r"\[\s*([0-9]+(?:\s*,\s*[0-9]+)*)\s*\]")
TAKEN = ("VARIABLES", "changed", "numbers", "shape", "tunable", "values")  # by the class that parameters are fields of
MOST = 1 << 20  # elements of one array; more is no description of a model


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU, or several that are the elements of an array, row by row.

    name: as a port or parameter; title: in the FMU. references: one, or one an element. dimensions: of an array of
    FMI 3, a length or the value reference of the structural parameter that holds it (negative: -1 - reference).
    start: the FMU's own values, flat, as the FMU has them; None where one is missing. low, high: bounds in SI.
    """

    name: str
    title: str
    kind: Kind
    references: tuple[int, ...]
    causality: str
    variability: str
    initial: str = ""
    unit: Conversion = field(default_factory=Conversion)
    shape: tuple[int, ...] = ()
    dimensions: tuple[int, ...] = ()
    start: tuple[Any, ...] | None = None
    low: float | None = None
    high: float | None = None
    items: tuple[tuple[str, int], ...] = ()
    description: str = ""
    frame: str = ""

    @property
    def size(self) -> int:
        """How many values it holds, its structural parameters being as they start."""
        return prod(self.shape)

    @property
    def is_discrete(self) -> bool:
        """Whether its values change at events only."""
        return self.variability != "continuous"


def grouped(variables: Iterable[Variable], shapes: dict[str, tuple[int, ...]]) -> tuple[Variable, ...]:
    """Variables with `x[1,2]`, `x[2].y` in their names joined to arrays, in the order of their first elements.

    shapes: of arrays by name where the FMU tells more than the names do: `x` of one row, for instance.
    """
    families: dict[tuple[Any, ...], list[tuple[tuple[int, ...], Variable]]] = {}
    for one in variables:
        base, place = _split(one.title)
        about = (one.kind, one.causality, one.variability, one.initial, one.unit, len(one.shape))
        key = (base, len(place), *about) if place and not one.shape else (one.title,)
        families.setdefault(key, []).append((place, one))
    taken: set[str] = set()
    return tuple(_named(one, taken) for members in families.values() for one in _joined(members, shapes))


def _split(title: str) -> tuple[str, tuple[int, ...]]:
    """`a[2].b[1,3]` as `a.b` and (2, 1, 3)."""
    place = [int(part) for match in _INDEX.finditer(title) for part in match[1].split(",")]
    return _INDEX.sub("", title), tuple(place)


def _joined(members: list[tuple[tuple[int, ...], Variable]], shapes: dict[str, tuple[int, ...]]) -> list[Variable]:
    """One array where the places fill a box that begins at 0 or 1 along each axis, else the variables as they are."""
    places, first = {place: one for place, one in members}, members[0][1]
    if not members[0][0] or first.shape or len(places) < len(members):
        return [one for _, one in members]
    starts = [min(axis) for axis in zip(*places, strict=True)]
    shape = tuple(max(axis) - low + 1 for axis, low in zip(zip(*places, strict=True), starts, strict=True))
    if prod(shape) != len(members) or any(low not in (0, 1) for low in starts):
        return [one for _, one in members]
    base = _split(first.title)[0]
    order = product(*(range(low, low + length) for low, length in zip(starts, shape, strict=True)))
    elements = [places[place] for place in order]
    lows, highs = {one.low for one in elements}, {one.high for one in elements}
    start = [value for one in elements for value in one.start or ()]
    told = shapes.get(base, shape)
    return [
        replace(
            elements[0],
            title=base,
            references=tuple(one.references[0] for one in elements),
            shape=told if prod(told) == len(members) else shape,
            start=tuple(start) if len(start) == len(members) else None,
            low=lows.pop() if len(lows) == 1 else None,
            high=highs.pop() if len(highs) == 1 else None,
        )
    ]


def _named(one: Variable, taken: set[str]) -> Variable:
    """With a name of its own that YAML, logs and Python can have: letters, digits and _, dots between bundles."""
    name = ".".join(_word(part) for part in one.title.split("."))
    if name.startswith("_"):
        name = f"v{name}"  # pydantic has no fields that begin so
    if hasattr(Parameters, name) or name in TAKEN:
        name += "_"
    while name in taken:
        name += "_"
    taken.add(name)
    return replace(one, name=name)


def _word(part: str) -> str:
    """`der(x)` as `der_x`."""
    word = re.sub(r"\W+", "_", part, flags=re.ASCII)
    word = word.rstrip("_") if part[-1:] not in ("_", "") and word.strip("_") else word
    return word if re.match(r"[A-Za-z_]", word) else f"_{word}"


def unbundled(names: Sequence[str]) -> list[str]:
    """The names, those changed that are a bundle's too: `a` beside `a.b` becomes `a_`."""
    bundles = {".".join(name.split(".")[:k]) for name in names for k in range(1, name.count(".") + 1)}
    found: list[str] = []
    for name in names:
        while name in bundles or name in found:
            name += "_"
        found.append(name)
    return found
