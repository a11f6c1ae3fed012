"""Points in a decoded message: where its lists of them are, their coordinates, and which marker each is."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np

from pipeline.errors import LogError
from pipeline.quantities import shown

Json = Any  # what json.loads gives
LEAST = 3  # points of a list that may be a line's markers
IDS = ("id", "marker_id", "label", "marker", "name", "number", "index")  # members that may tell which marker a point is


def members(value: Json) -> str:
    """What a message holds, for messages to the user."""
    if not isinstance(value, dict):
        return f"a {type(value).__name__} as a whole"
    return ", ".join(map(str, list(value)[:8])) or "no fields"


def points_of(value: Json, steps: tuple[str, ...], at: str) -> tuple[list[list[float]], list[str] | None]:
    """The markers' coordinates, and their ids where all have one. Raises LogError, at the message, where none are."""
    for i, step in enumerate(steps):
        if not isinstance(value, dict) or step not in value:
            inside = f" in {'.'.join(steps[:i])}" if i else ""
            raise LogError(f"{at} has no {step}{inside}; it has {members(value)}")
        value = value[step]
    if not isinstance(value, list):
        raise LogError(f"{at}: {'.'.join(steps)} is {_shown(value)}, not a list of points")
    wrong = next((i for i, one in enumerate(value) if one is not None and not _is_point(one)), None)
    if wrong is not None:
        raise LogError(f"{at}: {'.'.join(steps)}[{wrong}] is {_shown(value[wrong])}, not a point x, y, z")
    return [_point(one) for one in value], _ids(value)


def _ids(values: list[Json]) -> list[str] | None:
    """The ids of the points, "" for one that is null; None where some have none."""
    given = [value for value in values if value is not None]
    if not all(isinstance(value, dict) for value in given):
        return None
    name = next((name for name in IDS if given and all(isinstance(one.get(name), str | int) for one in given)), None)
    return None if name is None else ["" if value is None else str(value[name]) for value in values]


def may_come(value: Json) -> bool:
    """Whether the message has a list in which later ones may hold points: empty, of nulls, or of too few points."""
    if isinstance(value, list):
        given = [one for one in value if one is not None]
        return not given or (len(value) < LEAST and all(_is_point(one) for one in given))
    return isinstance(value, dict) and any(may_come(member) for member in value.values())


def _shown(value: Json) -> str:
    return shown(value if isinstance(value, str) else json.dumps(value, default=str))


def lists_of_points(value: Json, steps: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Ways to the lists of points within a message, the outermost first."""
    for name, member in value.items() if isinstance(value, dict) else ():
        if isinstance(member, list) and _are_points(member):
            yield (*steps, name)
        yield from lists_of_points(member, (*steps, name))


def _are_points(values: list[Json]) -> bool:
    """At least three points; some may be null."""
    given = [value for value in values if value is not None]
    return len(values) >= LEAST and bool(given) and all(_is_point(value) for value in given)


def _coordinates(value: Json) -> Json:
    """What holds x, y and z of a point or of a pose."""
    return value.get("position", value) if isinstance(value, dict) else value


def _is_point(value: Json) -> bool:
    inner = _coordinates(value)
    if isinstance(inner, dict):
        return set("xyz") <= set(inner) and all(_is_number(inner[axis]) for axis in "xyz")
    return isinstance(inner, list) and len(inner) == 3 and all(_is_number(one) for one in inner)


def _is_number(value: Json) -> bool:
    """A number, as text too (protobuf's JSON writes some so), or null; a boolean is none."""
    if isinstance(value, str):
        try:
            float(value)
        except ValueError:
            return False
        return True
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def _point(value: Json) -> list[float]:
    """x, y, z; a point that is null, and what is null in it, counts as not a number."""
    inner = _coordinates(value)
    numbers = [inner[axis] for axis in "xyz"] if isinstance(inner, dict) else inner or [None] * 3
    return [_number(number) for number in numbers]


def _number(value: Json) -> float:
    try:
        return np.nan if value is None else float(value)
    except OverflowError:
        return np.nan
