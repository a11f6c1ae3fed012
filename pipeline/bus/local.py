"""The bus within one process: hosts answer at once, by the same messages; what the zenoh bus is compared with."""

from __future__ import annotations

from collections import deque

from pipeline.bus.zenoh import APPEARED, MESSAGE, Arrival
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
        self._hosts: dict[tuple[str, str], Serving] = {}
        self._arrivals: deque[Arrival] = deque()

    def start(self, host: str) -> tuple[str, _Inside]:
        """Have a host that offers itself."""
        process = str(len(self._hosts))
        self._hosts[host, process] = Serving(host)
        self._arrivals.append(Arrival(APPEARED, host, process))
        return process, _Inside()

    def attach(self, host: str, process: str) -> None:
        """Nothing to do."""

    def detach(self, host: str, process: str) -> None:
        """Forget it."""
        self._hosts.pop((host, process), None)

    def send(self, host: str, process: str, data: bytes) -> None:
        """Have it answered."""
        reply = self._hosts[host, process].answer(data)
        if reply is not None:
            self._arrivals.append(Arrival(MESSAGE, host, process, reply))

    def receive(self, timeout_s: float) -> Arrival | None:
        """The next arrival."""
        return self._arrivals.popleft() if self._arrivals else None

    def close(self) -> None:
        """Nothing to do."""
