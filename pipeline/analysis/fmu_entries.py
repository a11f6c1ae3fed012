"""Parameters of lines that are FMUs of Towline, by the descriptions of the FMUs that a log holds."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.analysis.scenario_entries import FMU_PARAMETERS, Entries
from pipeline.errors import TowlineError
from pipeline.fmu.information import Entry, information
from pipeline.log.reader import Log

TOOL = "towline "  # generationTool begins with it: others may mean something else by the same names
KINDS = {"Real": float, "Float64": float, "Integer": int, "Int32": int, "Int64": int}


def with_fmus(log: Log, found: Entries, names: Iterable[str]) -> Entries:
    """The entries with what these components' FMUs were built with, under what the scenario gives itself."""
    told = {name: _parameters(log, str(found.components[name].get("fmu"))) for name in names if _is_fmu(found, name)}
    components = dict(found.components)
    for name, parameters in told.items():
        entry = components[name]
        components[name] = {**entry, "parameters": {**parameters, **(entry.get("parameters") or {})}}
    return replace(found, components=components)


def _is_fmu(found: Entries, name: str) -> bool:
    return "fmu" in found.components.get(name, {})


def _parameters(log: Log, path: str) -> dict[str, Any]:
    """As a resolved scenario writes them; none where the log does not hold the FMU, or it is not of Towline."""
    if path not in log.attachment_names():
        return {}
    with tempfile.TemporaryDirectory() as folder:
        archive = Path(folder) / "attached.fmu"
        try:
            archive.write_bytes(log.attachment(path))
            told = information(archive)
            if not told.tool.startswith(TOOL):
                return {}
            return {one.name: _value(one) for one in told.variables if one.name.startswith(FMU_PARAMETERS)}
        except (TowlineError, ValueError):
            return {}


def _value(one: Entry) -> Any:
    """`18.288 m`, `{values: [...], unit: m}`, a number, a switch or a text."""
    if one.type == "Boolean":
        return one.start.lower() in ("true", "1")
    if one.type not in KINDS:
        return one.start
    values = np.array([KINDS[one.type](part) for part in one.start.split()]).reshape(one.shape)
    if one.shape:
        return {"values": values.tolist(), "unit": one.unit}
    return f"{values.item()} {one.unit}" if one.unit else values.item()
