"""A message of fixed shape as constant bytes with floats copied in, and the MCAP record around it.

A message whose fields all have fixed shape differs from the next only in its numbers, so k messages are one structured
array of k records: filled column by column from rows of floats, read back the same way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from mcap.opcode import Opcode

# An MCAP Message record before its payload: (name, type, offset).
_HEAD = (
    ("opcode", "u1", 0),
    ("length", "<u8", 1),
    ("channel", "<u2", 9),
    ("sequence", "<u4", 11),
    ("log_time", "<u8", 15),
    ("publish_time", "<u8", 23),
)
HEAD_BYTES = 31
_PREFIX_BYTES = 9  # opcode and length, which `length` does not count
_VARINT_BYTES = 5  # enough for seconds < 2^35 (the year 3058) and for nanoseconds of a second


@dataclass(frozen=True)
class Run:
    """`count` floats of a row from index `first` on, which stand in a row at byte `offset` of the message."""

    offset: int
    first: int
    count: int
    type: str = "<f8"


@dataclass(frozen=True)
class Template:
    """A message's bytes, with zeros where the runs copy floats in.

    stamps: byte offsets of google.protobuf.Timestamp bodies, both varints padded to five bytes, that take log_time.
    """

    constant: bytes
    runs: tuple[Run, ...]
    stamps: tuple[int, ...] = ()

    @property
    def floats(self) -> int:
        """Number n of floats in a row."""
        return sum(run.count for run in self.runs)

    @property
    def record_bytes(self) -> int:
        """Length of the whole MCAP record."""
        return HEAD_BYTES + len(self.constant)

    @cached_property
    def record(self) -> np.dtype:
        """The MCAP record as a packed structure: head, one field a run, two a stamp."""
        fields = list(_HEAD)
        for run in self.runs:
            fields.append((f"run{run.first}", f"({run.count},){run.type}", HEAD_BYTES + run.offset))
        for stamp in self.stamps:
            seconds = HEAD_BYTES + stamp + 1  # after its tag
            fields.append((f"seconds{stamp}", f"({_VARINT_BYTES},)u1", seconds))
            fields.append((f"nanos{stamp}", f"({_VARINT_BYTES},)u1", seconds + _VARINT_BYTES + 1))
        names, formats, offsets = zip(*fields, strict=True)
        return np.dtype(
            {"names": names, "formats": formats, "offsets": offsets, "itemsize": self.record_bytes}  # type: ignore
        )

    @cached_property
    def _fixed(self) -> np.ndarray:
        """Whether a byte of the record is the same in all messages of a channel: (record_bytes,) bool."""
        fixed = np.ones(self.record_bytes, bool)
        for name in self.record.names or ():
            kind, offset = self.record.fields[name][:2]  # type: ignore
            fixed[offset : offset + kind.itemsize] = name in ("opcode", "length", "channel")
        return fixed

    def _blank(self, channel: int) -> np.ndarray:
        """One record without numbers: (record_bytes,) uint8."""
        blank = np.frombuffer(bytes(HEAD_BYTES) + self.constant, np.uint8).copy()
        record = blank.view(self.record)
        record["opcode"] = Opcode.MESSAGE
        record["length"] = self.record_bytes - _PREFIX_BYTES
        record["channel"] = channel
        return blank

    def fill(self, channel: int, sequence: int, t_ns: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """The MCAP records of messages at t_ns: (k,) int64 with rows: (k, n) float64, as (k,) of `record`."""
        raw = np.empty(len(t_ns), f"V{self.record_bytes}")
        raw[:] = np.void(self._blank(channel).tobytes())
        records = raw.view(self.record)
        records["sequence"] = np.arange(sequence, sequence + len(t_ns)) & 0xFFFFFFFF
        records["log_time"] = t_ns
        records["publish_time"] = t_ns
        with np.errstate(over="ignore", invalid="ignore"):  # whatever the number, float32 takes what it can of it
            for run in self.runs:
                records[f"run{run.first}"] = rows[:, run.first : run.first + run.count]
        for stamp in self.stamps:
            seconds, nanos = np.divmod(t_ns, 1_000_000_000)
            records[f"seconds{stamp}"] = _padded_varint(seconds)
            records[f"nanos{stamp}"] = _padded_varint(nanos)
        return records

    def gather(self, data: bytes, offsets: np.ndarray) -> np.ndarray:
        """The records that stand at the byte offsets (k,) of a chunk's data: (k,) of `record`, a copy.

        Raises ValueError if one does not fit into the data.
        """
        if len(offsets) == 0:
            return np.empty(0, self.record)
        last = len(data) - self.record_bytes
        if int(offsets.max()) > last:
            raise ValueError(f"a message at byte {offsets.max()} runs over the end")
        at_every_byte = np.ndarray((last + 1,), f"V{self.record_bytes}", data, strides=(1,))
        return at_every_byte[offsets.astype(np.intp)].view(self.record)

    def agrees(self, records: np.ndarray, channel: int) -> bool:
        """Whether all records (k,) are messages of the channel with this template's constant bytes."""
        raw = records.view(np.uint8).reshape(len(records), self.record_bytes)
        blank = self._blank(channel)
        edges = np.flatnonzero(np.diff(self._fixed, prepend=False, append=False))
        return all(bool((raw[:, a:b] == blank[a:b]).all()) for a, b in edges.reshape(-1, 2))

    def copy_floats(self, records: np.ndarray, out: np.ndarray) -> None:
        """Write the numbers of the records (k,) into out: (k, n) float64."""
        for run in self.runs:
            out[:, run.first : run.first + run.count] = records[f"run{run.first}"]


def _padded_varint(values: np.ndarray) -> np.ndarray:
    """Non-negative integers (k,) as protobuf varints padded to five bytes: (k, 5) uint8."""
    shifts = 7 * np.arange(_VARINT_BYTES)
    groups = (values[:, None] >> shifts) & 0x7F
    groups[:, :-1] |= 0x80
    return groups.astype(np.uint8)
