"""The resolved scenario in a log, as far as the analysis reads it: parameters in SI units, wires, events."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, TypedDict

import numpy as np
import yaml

from pipeline.errors import LogError
from pipeline.log.reader import Log

SCENARIO = "scenario.yaml"  # the attachment with the resolved scenario
FMU_PARAMETERS = "parameters."  # FMUs of Towline have their parameters in a bundle


class Entry(TypedDict, total=False):
    """A component: texts with SI units, tables of them, counts; wires."""

    model: str
    fmu: str
    parameters: dict[str, Any]
    inputs: dict[str, Any]


@dataclass(frozen=True)
class Entries:
    """name, description: of the scenario; components by name; changed: parameters that events set, as `tether.cut`.

    bonds: by a line's end, as `tether.end_a`, the body's bundle that moves it, as `ship.hook_a`.
    """

    name: str
    components: dict[str, Entry]
    changed: frozenset[str] = frozenset()
    bonds: dict[str, str] = field(default_factory=dict)
    description: str = ""

    def given(self, component: str, parameter: str) -> Any:
        """A parameter as it stands there; None where it is not given."""
        given = self.components.get(component, {}).get("parameters", {})
        return given.get(parameter, given.get(FMU_PARAMETERS + parameter))

    def number(self, component: str, parameter: str, default: float = 0.0) -> float:
        """A scalar parameter in its SI unit."""
        value = number(self.given(component, parameter))
        return default if value is None else value

    def metres(self, component: str, parameter: str) -> float | None:
        """A length: resolved scenarios write `3.5 m`."""
        value, _, unit = str(self.given(component, parameter) or "").partition(" ")
        return float(value) if unit == "m" else None

    def array(self, component: str, parameter: str) -> np.ndarray:
        """A parameter of several numbers, () where it is not given."""
        return array(self.given(component, parameter))

    def wire(self, component: str, port: str) -> Any:
        """What feeds an input, as written."""
        return self.components.get(component, {}).get("inputs", {}).get(port)

    def source(self, component: str, port: str) -> tuple[str, str]:
        """Component and port that a plain wire or a bond comes from; ("", "") for any other wire or none."""
        wire = self.wire(component, port) or self.bonds.get(f"{component}.{port}")
        name, _, source = wire.partition(".") if isinstance(wire, str) else ("", "", "")
        return (name, source) if name in self.components else ("", "")


def number(value: Any) -> float | None:
    """`3.5 m`, or a plain number; None for what is neither."""
    if isinstance(value, bool) or value is None:
        return None
    try:
        return float(str(value).partition(" ")[0])
    except ValueError:
        return None


def array(value: Any) -> np.ndarray:
    """`{values: [...], unit: m}` or a list of quantities."""
    if isinstance(value, dict):
        value = value.get("values", [])
    return np.array(value if isinstance(value, list) else [], np.float64)


def entries(log: Log) -> Entries | None:
    """What the log's scenario says; None where it holds none."""
    try:
        document = yaml.load(log.attachment(SCENARIO), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        events = document.get("events") or []
        changed = frozenset(name for event in events for name in event.get("set", {}))
        bonds = {bond["line"]: bond["body"] for bond in (document.get("bonds") or {}).values()}
        about = str(document.get("description") or "")
        return Entries(str(document["name"]), dict(document["components"]), changed, bonds, about)
    except (LogError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        return None
