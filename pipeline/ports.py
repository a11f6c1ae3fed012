"""What is wrong with the ports and sizes that a component declares: they become indices, files and protobuf fields."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from components.contract import Port, Sizes
from pipeline.quantities import is_unit, shown

_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)


def faults(kind: str, ports: Sequence[Port]) -> Iterator[str]:
    """What is wrong with a component's inputs or outputs (kind: "input" or "output"), naming the port."""
    names: set[str] = set()
    for port in ports:
        fault = _fault(port) or _clash(port.name, names)
        if fault:
            yield f"{kind} {shown(port.name)} {fault}"
        names.add(port.name)


def size_faults(sizes: Sizes) -> Iterator[str]:
    """What is wrong with the lengths of state and workspace."""
    for name, length in (("state", sizes.state), ("workspace", sizes.workspace)):
        if not _is_count(length):
            yield f"its {name} takes {length} numbers; expected a whole number, 0 or more"


def _fault(port: Port) -> str:
    if not isinstance(port.name, str) or not _NAME.fullmatch(port.name):
        return "is no name; expected letters, digits and _, with a dot between a bundle and its member"
    if not isinstance(port.shape, tuple) or not all(_is_count(length) for length in port.shape):
        return f"has the shape {port.shape}; expected a tuple of whole numbers, 0 or more"
    if not isinstance(port.unit, str) or not is_unit(port.unit):
        return f"is in {shown(port.unit)}, which is not a known unit; expected one such as 'm/s', or '1' for none"
    return ""


def _clash(name: str, others: set[str]) -> str:
    """What a port's name cannot be beside those of the ports before it."""
    if name in others:
        return "stands twice; expected one port of a name"
    for other in sorted(others):
        if other.startswith(f"{name}.") or name.startswith(f"{other}."):
            return f"stands beside {shown(other)}: a name is a port or a bundle, not both"
    return ""


def _is_count(length: object) -> bool:
    return isinstance(length, int) and not isinstance(length, bool) and length >= 0


def validity_faults(validity: str, outputs: Sequence[Port]) -> Iterator[str]:
    """What is wrong with the output that a component names as its validity."""
    if validity and not any(port.name == validity and port.shape == () for port in outputs):
        yield f"its validity is '{validity}', which is no scalar output of it"
