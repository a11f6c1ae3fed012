"""A run's snapshot: everything that the future depends on, as bytes, taken at a block end."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field

import numpy as np

from pipeline.errors import LogError

MAGIC = b"TOWLINE1"
_HEADER = ("tick", "fired", "chains", "ranges")
_ARRAYS = ("parameters", "states", "board", "bond_energy")


@dataclass(frozen=True)
class Snapshot:
    """Tick, events fired so far, digest chains, and all p, x, signals and bond energies (float64).

    ranges: the models' validity so far, see validity_range.Ranges.
    """

    tick: int
    fired: int
    chains: dict[str, str]
    parameters: np.ndarray
    states: np.ndarray
    board: np.ndarray
    bond_energy: np.ndarray
    ranges: dict[str, dict[str, float]] = field(default_factory=dict)

    def to_bytes(self) -> bytes:
        """Magic, length of a JSON header, header, arrays one after another."""
        arrays = [getattr(self, name) for name in _ARRAYS]
        header = {name: getattr(self, name) for name in _HEADER} | {"lengths": [a.size for a in arrays]}
        text = json.dumps(header).encode()
        return MAGIC + struct.pack("<I", len(text)) + text + b"".join(a.astype("<f8").tobytes() for a in arrays)

    @classmethod
    def from_bytes(cls, data: bytes) -> Snapshot:
        """Raises LogError if the bytes are not a whole snapshot."""
        start = len(MAGIC) + 4
        if data[: len(MAGIC)] != MAGIC or len(data) < start:
            raise LogError("the log's run snapshot is not one of this version of towline")
        (length,) = struct.unpack_from("<I", data, len(MAGIC))
        try:
            header = json.loads(data[start : start + length])
            numbers = np.frombuffer(data, "<f8", offset=start + length)
            parts = np.split(numbers, np.cumsum(header["lengths"]))
        except (ValueError, KeyError) as error:
            raise LogError(f"the log's run snapshot is damaged ({error})") from error
        if len(numbers) != sum(header["lengths"]):
            raise LogError("the log's run snapshot is damaged (wrong length)")
        return cls(header["tick"], header["fired"], header["chains"], *parts[:-1], ranges=header["ranges"])
