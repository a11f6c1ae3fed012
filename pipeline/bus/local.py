"""The bus within one process: hosts answer at once, by the same messages; what the zenoh bus is compared with."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import count

from pipeline.bus.zenoh import APPEARED, Address, Change
from pipeline.hosts.serving import Serving


class _Inside:
    """A host without a process of its own."""

    pid = 0

    def is_alive(self) -> bool:
        """Always."""
        return True

    def end(self, within_s: float = 0.0) -> None:
        """Nothing to end."""

    def collect(self) -> str:
        """Nothing was written."""
        return ""


class LocalBus:
    """Hosts by (name, process); messages are answered as they are sent."""

    channels = None

    def __init__(self) -> None:
        self._hosts: dict[Address, Serving] = {}
        self._replies: dict[Address, deque[bytes]] = {}
        self._changes: deque[Change] = deque()
        self._numbers = count()

    def start(self, host: str) -> tuple[str, _Inside]:
        """Have a host that offers itself."""
        process = str(next(self._numbers))
        self._hosts[host, process] = Serving(host)
        self._replies[host, process] = deque()
        self._changes.append(Change(APPEARED, host, process))
        return process, _Inside()

    def attach(self, host: str, process: str) -> None:
        """Nothing to do."""

    def detach(self, host: str, process: str) -> None:
        """Forget it."""
        self._hosts.pop((host, process), None)

    def send(self, address: Address, data: bytes) -> None:
        """Have it answered."""
        reply = self._hosts[address].answer(data)
        if reply is not None:
            self._replies[address].append(reply)

    def receive(self, address: Address | None) -> bytes | None:
        """What a host has answered."""
        return self.received(address) if address else None

    def received(self, address: Address) -> bytes | None:
        """The same."""
        replies = self._replies[address]
        return replies.popleft() if replies else None

    def changes(self) -> Iterator[Change]:
        """Who has appeared."""
        while self._changes:
            yield self._changes.popleft()

    def close(self) -> None:
        """Nothing to do."""
