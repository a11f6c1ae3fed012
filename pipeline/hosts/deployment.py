"""What a distributed run stands on: a bus, and what starts processes on it; here over zenoh, or all in this process."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from pipeline.bus.channels import Channels
from pipeline.bus.identity import Identity
from pipeline.bus.local import LocalBus
from pipeline.bus.zenoh import Address, Change, ConductorBus
from pipeline.hosts.launch import LocalProcess, Nursery

LOOK_S = 0.05  # the longest that a bus keeps whoever waits for what arrives
ENDPOINT = "tcp/127.0.0.1:7447"  # where machines connect, unless said: loopback, with zenoh's usual port


class Bus(Protocol):
    """The conductor's end of a bus; a process is addressed by its host's name and its own.

    channels: what the run records is published there; None where nobody could subscribe.
    """

    channels: Channels | None

    def attach(self, host: str, process: str) -> None:
        """Begin to talk with a process."""

    def detach(self, host: str, process: str) -> None:
        """Talk with it no longer."""

    def send(self, address: Address, data: bytes) -> None:
        """Send to an attached process."""

    def receive(self, address: Address | None) -> bytes | None:
        """What a process sends next; None after LOOK_S, or where there are changes."""

    def received(self, address: Address) -> bytes | None:
        """What a process has sent; None where nothing is there."""

    def changes(self) -> Iterator[Change]:
        """Who has appeared and vanished meanwhile."""
        ...

    def close(self) -> None:
        """Close it."""


class Process(Protocol):
    """A host's process on this machine."""

    def is_alive(self) -> bool:
        """Whether it runs."""
        ...

    def end(self, within_s: float = 0.0) -> None:
        """Wait for it to end by itself, then kill it; it is gone afterwards."""

    def collect(self) -> str:
        """What it wrote; to be called once, after its end."""
        ...


class Deployment(Protocol):
    """Opens the bus of a run and starts hosts on it."""

    def prepare(self) -> None:
        """Do beforehand what takes long. Raises HostError."""

    def open(self, run: int) -> Bus:
        """The bus of the run. Raises HostError."""
        ...

    def start(self, host: str) -> tuple[str, Process]:
        """A process that offers itself on the bus, and its name there. Raises HostError."""
        ...

    def close(self) -> None:
        """End what is left."""


@dataclass(frozen=True)
class BusOptions:
    """How a run's zenoh bus is opened. listen: endpoints for other machines. config: a zenoh configuration file."""

    listen: Sequence[str] = ()
    config: Path | None = None


class OnZenoh:
    """Processes of this machine by a nursery, others as they offer themselves."""

    def __init__(self, options: BusOptions):
        self._options = options
        self._nursery = Nursery()
        self._endpoint = ""

    def prepare(self) -> None:
        """Start the nursery, which imports while the conductor compiles."""
        self._nursery.open()

    def open(self, run: int) -> ConductorBus:
        """Raises HostError."""
        bus = ConductorBus(run, self._options.listen, self._options.config, look_s=LOOK_S)
        self._endpoint = bus.endpoint
        return bus

    def start(self, host: str) -> tuple[str, LocalProcess]:
        """Raises HostError."""
        identity, options = Identity(), self._options
        is_sealed = bool(options.listen)
        started = self._nursery.start(host, identity.secret, self._endpoint, options.config, is_sealed=is_sealed)
        return identity.name, started

    def close(self) -> None:
        """End the nursery, and with it whatever host is left."""
        self._nursery.close()


class InProcess:
    """All hosts in this process, without a network: what the zenoh bus is compared with."""

    def prepare(self) -> None:
        """Nothing to do."""

    def open(self, run: int) -> LocalBus:
        """The bus."""
        self._bus = LocalBus()
        return self._bus

    def start(self, host: str) -> tuple[str, Process]:
        """A host on it."""
        return self._bus.start(host)

    def close(self) -> None:
        """Nothing to do."""
