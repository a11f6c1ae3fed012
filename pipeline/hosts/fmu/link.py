"""Messages between a host and the process in which its FMU is isolated: a header and bytes, over a stream socket."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Callable

# What is asked of the process. BEGIN, MESSAGES and RESTORE bring or fetch bytes; the others numbers.
BEGIN, INIT, STEP, SAVE, RESTORE, MESSAGES, END = range(7)
_REQUEST = struct.Struct("<Bqqq")
_REPLY = struct.Struct("<qq")
ALL_FINE, FAILED = 0, -1
LOOK_S = 0.25  # how often one that waits looks whether it is interrupted


class SilenceError(Exception):
    """The other side has not answered in time."""


class EndedError(Exception):
    """The other side is gone."""


def ask(link: socket.socket, kind: int, t_ns: int = 0, dt_ns: int = 0, data: bytes = b"") -> None:
    """Send a request. Raises EndedError."""
    try:
        link.sendall(_REQUEST.pack(kind, t_ns, dt_ns, len(data)) + data)
    except OSError as error:
        raise EndedError from error


def asked(link: socket.socket) -> tuple[int, int, int, bytes]:
    """The next request. Raises EndedError."""
    kind, t_ns, dt_ns, size = _REQUEST.unpack(_exactly(link, _REQUEST.size, lambda: None))
    return kind, t_ns, dt_ns, _exactly(link, size, lambda: None)


def answer(link: socket.socket, status: int, data: bytes) -> None:
    """Send a reply. Raises EndedError."""
    try:
        link.sendall(_REPLY.pack(status, len(data)) + data)
    except OSError as error:
        raise EndedError from error


def answered(link: socket.socket, within_s: float) -> tuple[int, bytes]:
    """The reply: status and bytes. Raises SilenceError, EndedError."""
    until = time.monotonic() + within_s

    def wait() -> None:
        while not select.select([link], [], [], min(LOOK_S, max(0.0, until - time.monotonic())))[0]:
            if time.monotonic() > until:
                raise SilenceError

    status, size = _REPLY.unpack(_exactly(link, _REPLY.size, wait))
    return status, _exactly(link, size, wait)


def _exactly(link: socket.socket, size: int, wait: Callable[[], None]) -> bytes:
    parts = []
    while size > 0:
        wait()
        try:
            part = link.recv(min(size, 1 << 20))
        except OSError as error:
            raise EndedError from error
        if not part:
            raise EndedError
        parts.append(part)
        size -= len(part)
    return b"".join(parts)
