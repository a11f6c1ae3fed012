"""Signals by name: references such as `tether.nodes[3]`, slices, bundles, and where they lie in a vector."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from components.contract import ImagePort, Port
from pipeline.catalogue import closest
from pipeline.quantities import shown

_REFERENCE = re.compile(r"([a-z][a-z0-9_]*)\.([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\[([^\[\]]*)\])?", re.ASCII)
_COMPONENT = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
_PORT = re.compile(r"([A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*)(?:\[([^\[\]]*)\])?", re.ASCII)
_INDEX = re.compile(r"(-?[0-9]{1,9})|(-?[0-9]{1,9})?:(-?[0-9]{1,9})?")


@dataclass(frozen=True)
class Reference:
    """`component.port[slice]`; port may be a bundle, or "" for all outputs; slice is None where there is none."""

    component: str
    port: str
    slice: str | None = None

    def __str__(self) -> str:
        """As written."""
        return ".".join(filter(None, (self.component, self.port))) + ("" if self.slice is None else f"[{self.slice}]")


@dataclass(frozen=True)
class Signal:
    """Part of a vector (a board, a u): its indices in row-major order of its shape.

    words: of an image, the number of float64 that hold it; then indices has the first of them alone.
    """

    label: str
    indices: tuple[int, ...]
    shape: tuple[int, ...]
    unit: str
    frame: str
    words: int = 0


def reference(text: str) -> Reference:
    """Raises ValueError where the text is no reference."""
    match = _REFERENCE.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{shown(text)} is no signal; expected component.port, component.port[3] or a constant")
    return Reference(*match.groups())


def source(text: str) -> Reference:
    """The same, or a component's name alone for the bundle of its outputs."""
    return Reference(text.strip(), "") if _COMPONENT.fullmatch(text.strip()) else reference(text)


def port_and_slice(text: str) -> tuple[str, str | None]:
    """Raises ValueError where the text is no port with or without a slice."""
    match = _PORT.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{shown(text)} is no port; expected port or port[3]")
    return match[1], match[2]


def locate(
    owner: str, ports: tuple[Port, ...], start: int, name: str, part: str | None, *, kind: str
) -> dict[str, Signal]:
    """The signals of a port ({"": signal}) or of a bundle ({member: signal}) in a vector where ports begin at start.

    name: of the port or bundle; "": all ports. kind: "input" or "output", for messages. Raises ValueError.
    """
    members: dict[str, Signal] = {}
    for port in ports:
        if not name or port.name == name or port.name.startswith(f"{name}."):
            label = f"{owner}.{port.name}" if owner else port.name
            members[port.name[len(name) + 1 :] if name else port.name] = _signal(label, start, port, part)
        start += port.size
    if not members:
        names = list(dict.fromkeys(n for p in ports for n in (p.name, p.name.rpartition(".")[0]) if n))
        raise ValueError(f"{f'{owner} has ' if owner else ''}no {kind} '{name}'{closest(name, names)}")
    if part is not None and "" not in members:
        raise ValueError(f"'{name or owner}' is a bundle of {', '.join(members)}; slice one of these")
    return members


def runs(indices: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Maximal contiguous runs of indices: (position in the list, first index, count)."""
    found: list[tuple[int, int, int]] = []
    for position, index in enumerate(indices):
        if found and index == found[-1][1] + found[-1][2]:
            first = found[-1]
            found[-1] = (first[0], first[1], first[2] + 1)
        else:
            found.append((position, index, 1))
    return found


def _signal(label: str, start: int, port: Port, part: str | None) -> Signal:
    if isinstance(port, ImagePort):
        if part is not None:
            raise ValueError(f"{label} is an image, which has no slices; expected {label}")
        return Signal(label, (start,), port.shape, port.unit, port.frame, port.size)
    indices = np.arange(start, start + port.size).reshape(port.shape)
    if part is not None:
        label = f"{label}[{part}]"
        indices = np.asarray(indices[_selection(label, port, part)])
    flat = tuple(int(i) for i in indices.ravel())
    return Signal(label, flat, tuple(indices.shape), port.unit, port.frame)


def _selection(label: str, port: Port, part: str) -> tuple[int | slice, ...]:
    """`3`, `1:4`, `2, :` as NumPy takes them, nothing out of range and nothing empty."""
    texts = [text.strip() for text in part.split(",")]
    if len(texts) > len(port.shape):
        raise ValueError(f"{label}: {len(texts)} indices; expected at most {len(port.shape)}")
    selection: list[int | slice] = []
    for text, length in zip(texts, port.shape, strict=False):
        match = _INDEX.fullmatch(text)
        if match is None:
            raise ValueError(f"{label}: '{text}' is no index; expected 3, 1:4 or :")
        if match[1] is not None:
            selection.append(_index(label, int(match[1]), length))
            continue
        first, last = (int(bound) if bound else None for bound in match.group(2, 3))
        span = range(length)[first:last]
        outside = any(bound is not None and not -length <= bound <= length for bound in (first, last))
        if outside or len(span) == 0:
            raise ValueError(f"{label}: '{text}' is out of range; there are {length}, 0 to {length - 1}")
        selection.append(slice(span.start, span.stop))
    return tuple(selection)


def _index(label: str, index: int, length: int) -> int:
    if not -length <= index < length:
        raise ValueError(f"{label}: {index} is out of range; there are {length}, 0 to {length - 1}")
    return index
