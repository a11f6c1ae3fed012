"""The digest of a run: for each channel a SHA-256 chain over blocks of ticks, h = SHA-256(h + block).

A block holds the rows (time as int64 nanoseconds, outputs as float64) of every step, recorded or not. The chain can
be taken up again at any block end, which is where snapshots are made.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

import numpy as np

SECOND_NS = 1_000_000_000


def block_ticks(base_ns: int) -> int:
    """Ticks a block: about one simulated second, but enough of them that handing a block over costs nothing.

    A resumed run computes at most one block again.
    """
    return min(max(SECOND_NS // base_ns, 512), 8192)


class Digest:
    """Chains of all channels, by name."""

    def __init__(self, names: list[str], chains: Mapping[str, str] | None = None):
        """chains: hexadecimal h of each channel at a block end, to go on from; none at t0."""
        self._chains = {name: bytes.fromhex((chains or {}).get(name, "")) for name in names}
        self._open = {name: hashlib.sha256(h) for name, h in self._chains.items()}

    def update(self, name: str, rows: np.ndarray) -> None:
        """Add rows of the block that is open: C-contiguous float64."""
        self._open[name].update(rows.data)

    def end_block(self) -> None:
        """Close the block of every channel."""
        for name, block in self._open.items():
            self._chains[name] = block.digest()
            self._open[name] = hashlib.sha256(self._chains[name])

    def chains(self) -> dict[str, str]:
        """h of each channel at the last block end, hexadecimal."""
        return {name: h.hex() for name, h in self._chains.items()}

    def total(self) -> str:
        """SHA-256 over names and chains, channels sorted by name, the open block included."""
        total = hashlib.sha256()
        for name in sorted(self._open):
            total.update(name.encode() + b"\0" + self._open[name].copy().digest())
        return total.hexdigest()
