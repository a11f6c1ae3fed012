"""What an FMU of anyone's says of itself: variables with units, interfaces, capabilities, platforms."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any

import attrs

from pipeline.errors import TowlineError
from pipeline.fmu.archive import DOCUMENT, model_description, names, platforms

INTERFACES = {"coSimulation": "co-simulation", "modelExchange": "model exchange", "scheduledExecution": "scheduled"}
_ELEMENT = re.compile(r"\[([0-9]+(?:,[0-9]+)*)\]$")
TOLD_APART = ("modelIdentifier", "sourceFiles", "buildConfigurations")


@dataclass(frozen=True)
class Entry:
    """One variable, or an array of them; role: its causality, with the variability where that is not continuous."""

    name: str
    role: str
    type: str
    unit: str
    shape: tuple[int, ...]
    start: str
    description: str


@dataclass(frozen=True)
class Information:
    """An FMU in short. capabilities: {interface: {name: value}} as the standard names them."""

    model: str
    fmi: str
    tool: str
    description: str
    interfaces: tuple[str, ...]
    platforms: tuple[str, ...]
    step_s: float | None
    variables: tuple[Entry, ...]
    capabilities: dict[str, dict[str, str]]


def information(path: Path) -> Information:
    """What the FMU at `path` says. Raises TowlineError if it is none."""
    told, files = model_description(path), names(path)
    try:
        return _information(told, files)
    except Exception as error:  # values that are no numbers, references to what is not there
        text = (str(error).splitlines() or [type(error).__name__])[0]
        raise TowlineError(f"{path}: its {DOCUMENT} cannot be read: {text}") from error


def _information(told: Any, files: list[str]) -> Information:
    interfaces = {title: getattr(told, name) for name, title in INTERFACES.items() if getattr(told, name, None)}
    experiment = told.defaultExperiment
    return Information(
        model=told.modelName,
        fmi=told.fmiVersion,
        tool=told.generationTool or "",
        description=told.description or "",
        interfaces=tuple(interfaces),
        platforms=platforms(files),
        step_s=float(experiment.stepSize) if experiment is not None and experiment.stepSize else None,
        variables=tuple(_entries(told.modelVariables)),
        capabilities={title: _capabilities(one) for title, one in interfaces.items()},
    )


def _entries(variables: Any) -> Iterator[Entry]:
    """The variables; elements that follow each other, `nodes[1,1]` to `nodes[51,3]`, as one of their shape."""
    for _, members in groupby(map(_entry, variables), lambda one: (_ELEMENT.sub("", one.name), one.role, one.type)):
        found = list(members)
        base, last = _ELEMENT.sub("", found[0].name), found[-1]
        first, end = (_place(one.name) for one in (found[0], last))
        if len(found) == 1 or not end:
            yield from found
            continue
        shape = tuple(b - a + 1 for a, b in zip(first, end, strict=True)) if len(first) == len(end) else (len(found),)
        start = " ".join(one.start for one in found)
        yield replace(found[0], name=base, shape=shape, start=start)


def _place(name: str) -> tuple[int, ...]:
    match = _ELEMENT.search(name)
    return tuple(int(part) for part in match[1].split(",")) if match else ()


def _entry(one: Any) -> Entry:
    unit = one.unit or (one.declaredType.unit if one.declaredType is not None else None) or ""
    variability = f"{one.variability} " if one.variability not in (None, "continuous") else ""
    start = one.start if isinstance(one.start, list) else [one.start] if one.start is not None else []
    lengths = [str(length) for length in one.shape or ()]  # some hang on structural parameters
    shape = tuple(int(length) for length in lengths) if all(length.isdigit() for length in lengths) else ()
    role = f"{variability}{one.causality}"
    return Entry(one.name, role, one.type, unit, shape, " ".join(map(str, start)), one.description or "")


def _capabilities(interface: Any) -> dict[str, str]:
    """What an interface's element says, attributes that are off among it."""
    found = attrs.asdict(interface, recurse=False)
    return {name: str(value).lower() for name, value in found.items() if name not in TOLD_APART and value is not None}
