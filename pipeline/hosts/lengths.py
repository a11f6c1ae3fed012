"""How many numbers a section's messages hold, which both sides check."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from pipeline.bus.messages import SETTINGS, STATE, STOPPED
from pipeline.loop_tables import BOND_ROW, BOND_STATE
from pipeline.memory import Memory


@dataclass(frozen=True)
class Lengths:
    """outside: numbers from other sections; the others are sums over the section's nodes."""

    outside: int
    nodes: int
    bonds: int
    parameters: int
    inputs: int
    state: int
    signals: int

    @property
    def rows(self) -> int:
        """Of the bonds' captured rows."""
        return self.bonds * BOND_ROW

    @property
    def energies(self) -> int:
        """Of the bonds' energies."""
        return self.bonds * BOND_STATE

    @property
    def settings(self) -> int:
        """Parameters, offsets, and a switch for each node's offsets."""
        return self.parameters + self.signals + self.nodes

    def request(self, flags: int) -> int:
        """Of a request."""
        return self.outside + (self.settings if flags & SETTINGS else 0)

    def reply(self, flags: int) -> int:
        """Of a reply."""
        state, inputs = self.state if flags & STATE else 0, self.inputs if flags & STOPPED else 0
        return self.signals + self.rows + self.energies + state + inputs

    @property
    def snapshot(self) -> int:
        """Of what restores a section."""
        return self.signals + self.energies + self.state + self.settings


def pack_saved(states: Iterable[bytes]) -> bytes:
    """What FMUs of a section saved, one after another, each behind its length."""
    return b"".join(struct.pack("<Q", len(state)) + state for state in states)


def unpack_saved(data: bytes) -> Iterator[bytes]:
    """The same again. Raises struct.error or ValueError where the bytes are not whole."""
    at = 0
    while at < len(data):
        (size,) = struct.unpack_from("<Q", data, at)
        at += 8 + size
        if at > len(data):
            raise ValueError("saved states that are cut off")
        yield data[at - size : at]


def lengths(memory: Memory, nodes: Sequence[int], bonds: int, outside: int) -> Lengths:
    """Of some nodes and bonds of what is laid out in memory."""
    p, u, x, y = (sum(memory.spans[v][i].stop - memory.spans[v][i].start for i in nodes) for v in "puxy")
    return Lengths(outside, len(nodes), bonds, p, u, x, y)
