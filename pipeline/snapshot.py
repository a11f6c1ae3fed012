"""A run's snapshot: everything that the future depends on, as bytes, taken at a block end."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field

import numpy as np

from pipeline.errors import LogError

MAGIC = b"TOWLINE1"
_HEADER = ("tick", "fired", "chains", "ranges")
_BYTES = "hosts"  # in the header: lengths of what hosts saved, which stands behind the arrays
_ARRAYS = ("parameters", "states", "board", "bond_energy")


@dataclass(frozen=True)
class Snapshot:
    """Tick, events fired so far, digest chains, and all p, x, signals and bond energies (float64).

    ranges: the models' validity so far, see validity_range.Ranges. hosts: {component: bytes}, the states that are in an
    FMU instead of x.
    """

    tick: int
    fired: int
    chains: dict[str, str]
    parameters: np.ndarray
    states: np.ndarray
    board: np.ndarray
    bond_energy: np.ndarray
    ranges: dict[str, dict[str, float]] = field(default_factory=dict)
    hosts: dict[str, bytes] = field(default_factory=dict)

    def to_bytes(self) -> bytes:
        """Magic, length of a JSON header, header, arrays one after another, bytes of hosts one after another."""
        arrays = [getattr(self, name) for name in _ARRAYS]
        header = {name: getattr(self, name) for name in _HEADER} | {"lengths": [a.size for a in arrays]}
        header[_BYTES] = {name: len(state) for name, state in self.hosts.items()}
        text = json.dumps(header).encode()
        parts = [*(a.astype("<f8").tobytes() for a in arrays), *self.hosts.values()]
        return MAGIC + struct.pack("<I", len(text)) + text + b"".join(parts)

    @classmethod
    def from_bytes(cls, data: bytes) -> Snapshot:
        """Raises LogError if the bytes are not a whole snapshot."""
        start = len(MAGIC) + 4
        if data[: len(MAGIC)] != MAGIC or len(data) < start:
            raise LogError("the log's run snapshot is not one of this version of towline")
        (length,) = struct.unpack_from("<I", data, len(MAGIC))
        try:
            header = json.loads(data[start : start + length])
            numbers = np.frombuffer(data, "<f8", count=sum(header["lengths"]), offset=start + length)
            parts = np.split(numbers, np.cumsum(header["lengths"]))
            hosts, at = {}, start + length + numbers.nbytes
            for name, size in header[_BYTES].items():
                hosts[name], at = data[at : at + size], at + size
        except (ValueError, KeyError) as error:
            raise LogError(f"the log's run snapshot is damaged ({error})") from error
        if len(data) != at:
            raise LogError("the log's run snapshot is damaged (wrong length)")
        return cls(header["tick"], header["fired"], header["chains"], *parts[:-1], ranges=header["ranges"], hosts=hosts)
