"""Wires between elements of ports as a scenario writes them: those of a whole array as one where they are alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pipeline.ssp.variables import Element


@dataclass(frozen=True)
class Wire:
    """A wire as it will be written: into an element of an input, a mapping or text for each addend."""

    target: Element
    sources: tuple[Element, ...]
    addends: tuple[Any, ...]  # with "{}" where the source's slice goes


def inputs(wires: list[Wire]) -> dict[str, Any]:
    """The wires by input; those of all elements of an array as one where they are alike."""
    by_port: dict[str, list[Wire]] = {}
    for wire in wires:
        by_port.setdefault(wire.target.variable.name, []).append(wire)
    found: dict[str, Any] = {}
    for port, members in by_port.items():
        if _are_alike(members):
            found[port] = _joined(members[0].addends, [""] * len(members[0].addends))
            continue
        for wire in members:
            found[f"{port}{wire.target.slice}"] = _joined(wire.addends, [source.slice for source in wire.sources])
    return found


def _are_alike(members: list[Wire]) -> bool:
    """Whether they feed a whole array from whole arrays of its shape, each element in the same way."""
    first = members[0]
    port = first.target.variable
    if first.target.position is None or not port.shape or len(members) != port.size:
        return False
    in_order = sorted(members, key=lambda wire: wire.target.position or 0)
    plain = all(isinstance(a, str) or not {"offset", "initial"} & a.keys() for wire in members for a in wire.addends)
    return plain and all(
        wire.addends == first.addends
        and all(source.position == k and source.variable.shape == port.shape for source in wire.sources)
        for k, wire in enumerate(in_order)
    )


def _joined(addends: tuple[Any, ...], slices: list[str]) -> Any:
    filled = [_filled(addend, text) for addend, text in zip(addends, slices, strict=True)]
    return filled[0] if len(filled) == 1 else {"sum": filled}


def _filled(addend: Any, text: str) -> Any:
    return addend.format(text) if isinstance(addend, str) else addend | {"from": addend["from"].format(text)}
