"""What is wrong with the ports and sizes that a component declares: they become indices, files and protobuf fields."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from components.contract import Component, ImagePort, Port, Sizes
from pipeline.quantities import is_unit, shown

_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)


def faults(kind: str, ports: Sequence[Port]) -> Iterator[str]:
    """What is wrong with a component's inputs or outputs (kind: "input" or "output"), naming the port."""
    names: set[str] = set()
    is_behind_image = False
    for port in ports:
        fault = _fault(port) or _image_fault(port, is_behind_image) or _clash(port.name, names)
        if fault:
            yield f"{kind} {shown(port.name)} {fault}"
        names.add(port.name)
        is_behind_image = is_behind_image or isinstance(port, ImagePort)


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


def _image_fault(port: Port, is_behind_image: bool) -> str:
    if not isinstance(port, ImagePort):
        return "stands behind an image; expected images last" if is_behind_image else ""
    if len(port.shape) not in (2, 3) or port.shape[2:] not in ((), (3,)) or not all(port.shape):
        return f"is an image of {port.shape}; expected (height, width) for grey or (height, width, 3) for RGB"
    if port.unit != "pixel":
        return f"is an image in {port.unit}; expected 'pixel'"
    return ""


def image_faults(component: Component, ports: Sequence[Port]) -> Iterator[str]:
    """Which of a component's ports are images though it is compiled."""
    for port in ports if component.compiled else ():
        if isinstance(port, ImagePort):
            text = "is an image, which only Python components can have; expected COMPONENT with compiled=False"
            yield f"{shown(port.name)} {text}"


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
