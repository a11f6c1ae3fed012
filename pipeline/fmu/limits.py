"""The numbers of a component's parameters, each with its bounds."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, get_args

import annotated_types as bound

from components.contract import Parameters
from pipeline.parameters import is_tunable, unit_of


@dataclass(frozen=True)
class Bounds:
    """What a number may be; an open bound is excluded."""

    low: float = -inf
    high: float = inf
    low_is_open: bool = False
    high_is_open: bool = False


@dataclass(frozen=True)
class Quantity:
    """One number of a parameter: its field, its place in a flat tuple (None: a scalar) and its value."""

    name: str
    index: int | None
    value: float
    bounds: Bounds
    tunable: bool


def quantities(parameters: Parameters) -> list[Quantity]:
    """All numbers of the parameters that are quantities in scalars or flat tuples of floats, in order."""
    kind, found = type(parameters), []
    for name, about in kind.model_fields.items():
        value = getattr(parameters, name)
        values = value if isinstance(value, tuple) else (value,)
        if unit_of(kind, name) is None or not all(isinstance(number, float) for number in values):
            continue
        members = _members(about.annotation, len(values)) if isinstance(value, tuple) else [()]
        for i, number in enumerate(values):
            index = i if isinstance(value, tuple) else None
            found.append(Quantity(name, index, number, _bounds((*about.metadata, *members[i])), is_tunable(kind, name)))
    return found


def _members(kind: Any, length: int) -> list[tuple[Any, ...]]:
    """What is annotated of each member of a tuple: `tuple[Annotated[float, Field(ge=0)], ...]`."""
    members = [getattr(one, "__metadata__", ()) for one in get_args(kind) if one is not Ellipsis]
    # A Field is no bound itself, but holds some.
    flat = [tuple(part for one in member for part in getattr(one, "metadata", (one,))) for member in members]
    return flat if len(flat) == length else (flat or [()])[:1] * length


def _bounds(metadata: tuple[Any, ...]) -> Bounds:
    low: Any = -inf  # pydantic allows more than numbers, and takes none of it here
    high: Any = inf
    low_is_open = high_is_open = False
    for one in metadata:
        match one:
            case bound.Gt(value):
                low, low_is_open = value, True
            case bound.Ge(value):
                low, low_is_open = value, False
            case bound.Lt(value):
                high, high_is_open = value, True
            case bound.Le(value):
                high, high_is_open = value, False
    return Bounds(float(low), float(high), low_is_open, high_is_open)
