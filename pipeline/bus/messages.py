"""The messages between conductor and host: a fixed header, then float64 numbers, then text; little-endian."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

MAGIC = b"TWL\x01"  # the last byte is the version of this protocol
_new = tuple.__new__  # as Message(...) without a call of Python's
_FLOAT64 = np.dtype("<f8")
_HEADER = struct.Struct("<4sBBHQIIQqqiII")
HEADER_BYTES = _HEADER.size

# Kinds, from the conductor:
ASSIGN, INITIALISE, STEP, RESTORE, END = range(1, 6)
# from the host:
READY, REFUSED, DONE, OUT_OF_ORDER = range(11, 15)

# Flags of a request: it brings parameters and offsets that events changed; the reply must bring the state.
SETTINGS, WANT_STATE = 1, 2
# Flags of a reply: it brings the state; a component stopped the run, and the section's inputs are behind the rest.
STATE, STOPPED = 1, 2


class MessageError(Exception):
    """Bytes that are no message of this protocol."""


class Message(NamedTuple):
    """What one message says.

    run, incarnation: of the run, and of the host in it, which grows with each of its starts. section, sequence: the
    section's number, and its request's, counted from 0. t_ns: the end of the step. status, failed: of a component
    that stopped the run, by its place in the section. ignored: messages that the host has ignored so far, at most
    65535. numbers: (n,) float64. text: UTF-8; JSON in ASSIGN, READY and REFUSED; where a
    state is brought or restored, the bytes of FMUs' states.
    """

    kind: int
    run: int
    incarnation: int
    section: int = 0
    sequence: int = 0
    t_ns: int = 0
    flags: int = 0
    status: int = 0
    failed: int = -1
    ignored: int = 0
    numbers: bytes | memoryview = b""
    text: bytes = b""

    @property
    def values(self) -> np.ndarray:
        """The numbers as (n,) float64, read-only."""
        return np.frombuffer(self.numbers, _FLOAT64)


def pack(message: Message) -> bytes:
    """The message's bytes."""
    kind, run, incarnation, section, sequence, t_ns, flags, status, failed, ignored, numbers, text = message
    header = _HEADER.pack(
        MAGIC, kind, flags, min(ignored, 65535), run, incarnation, section, sequence, t_ns, status, failed,
        len(numbers) // 8, len(text),
    )  # fmt: skip
    return b"".join((header, numbers, text))


def pack_parts(  # as `pack`, without making a message first: once in a step on both sides
    kind: int, run: int, incarnation: int, section: int, sequence: int, t_ns: int, flags: int, ignored: int,
    numbers: int, parts: Sequence[bytes | memoryview],
) -> bytes:  # fmt: skip
    """The bytes of a message without text. numbers: how many there are in its parts."""
    header = _HEADER.pack(
        MAGIC, kind, flags, min(ignored, 65535), run, incarnation, section, sequence, t_ns, 0, -1, numbers, 0
    )
    return b"".join((header, *parts))


def readdressed(data: bytes, incarnation: int) -> bytes:
    """The same message to another incarnation."""
    return pack(unpack(data)._replace(incarnation=incarnation))


def unpack(data: bytes) -> Message:
    """Raises MessageError where the bytes are none of this protocol's, or not whole."""
    if len(data) < HEADER_BYTES or not data.startswith(MAGIC):
        raise MessageError("not a message of this version of towline")
    _, kind, flags, ignored, run, incarnation, section, sequence, t_ns, status, failed, numbers, text = (
        _HEADER.unpack_from(data)
    )
    end = HEADER_BYTES + 8 * numbers
    if len(data) != end + text:
        raise MessageError(f"{len(data)} bytes where {end + text} are announced")
    body = memoryview(data)[HEADER_BYTES:end]
    return _new(
        Message,
        (kind, run, incarnation, section, sequence, t_ns, flags, status, failed, ignored, body, data[end:]),
    )
