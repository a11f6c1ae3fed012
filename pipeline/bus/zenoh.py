"""The zenoh bus: one session a process, keys by host, and what arrives handed over to the thread that asks for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

import zenoh

from pipeline.bus.channels import Channels
from pipeline.bus.configuration import configuration, open_session
from pipeline.bus.identity import Identity, Seal
from pipeline.bus.socket import LocalSocket
from pipeline.errors import HostError

MESSAGE, APPEARED, VANISHED = "message", "appeared", "vanished"
_OFFERS = "towline/host"  # liveliness tokens of processes that offer themselves, NAME/PROCESS below it
_CONDUCTORS = "towline/run"  # liveliness tokens of conductors, by run


class Arrival(NamedTuple):
    """A message from a process, or that it appeared or vanished."""

    kind: str
    host: str
    process: str
    data: bytes = b""


class _Queue:
    """What callbacks hand over: zenoh swallows their exceptions, so these are handed over as well."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[Any] = SimpleQueue()

    def callback(self, made: Callable[[zenoh.Sample], Any]) -> Callable[[zenoh.Sample], None]:
        """A callback that puts what is made of a sample into the queue."""

        def put(sample: zenoh.Sample) -> None:
            try:
                self._queue.put(made(sample))
            except BaseException as error:  # raised by get()
                self._queue.put(error)

        return put

    def get(self, timeout_s: float) -> Any:
        """The next one; None after the time."""
        try:
            item = self._queue.get(timeout=timeout_s)
        except Empty:
            return None
        if isinstance(item, BaseException):
            raise item
        return item


def _liveliness(sample: zenoh.Sample) -> Arrival:
    *_, host, process = str(sample.key_expr).split("/")
    return Arrival(APPEARED if sample.kind == zenoh.SampleKind.PUT else VANISHED, host, process)


def _sealed(seal: Seal | None, data: bytes) -> bytes:
    return data if seal is None else seal.sealed(data)


def _opened(seal: Seal | None, data: bytes) -> bytes:
    """What is inside; no bytes, which are no message, where somebody else has sealed it."""
    return data if seal is None else seal.opened(data) or b""


class _Link(NamedTuple):
    """The conductor's side of a process."""

    publisher: zenoh.Publisher
    subscriber: zenoh.Subscriber[None]
    seal: Seal | None


def _publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=True)


class ConductorBus:
    """The conductor's end: processes offer themselves, are attached, and messages go to and fro.

    Messages are sealed where machines may connect; the socket of this machine is its user's alone. channels: for
    whoever subscribes; None where nobody can.
    """

    def __init__(self, run: int, listen: Sequence[str], file: Path | None = None):
        """Listen at a socket of this machine (`endpoint`) and at others. Raises HostError."""
        self._queue = _Queue()
        self._identity = Identity()
        self._is_sealed = bool(listen)
        self._links: dict[tuple[str, str], _Link] = {}
        self._socket = LocalSocket()
        self.endpoint = self._socket.endpoint
        try:
            self._session = open_session(configuration([self.endpoint, *listen], [], file))
        except HostError:
            self._socket.remove()
            raise
        self.channels = Channels(self._session) if listen else None
        liveliness = self._session.liveliness()
        self._token = liveliness.declare_token(f"{_CONDUCTORS}/{run:016x}")
        self._offers = liveliness.declare_subscriber(f"{_OFFERS}/*/*", self._queue.callback(_liveliness), history=True)

    def attach(self, host: str, process: str) -> None:
        """Begin to talk with a process."""
        seal = self._identity.seal_with(process) if self._is_sealed else None

        def made(sample: zenoh.Sample) -> Arrival:
            return Arrival(MESSAGE, host, process, _opened(seal, sample.payload.to_bytes()))

        subscriber = self._session.declare_subscriber(f"towline/out/{host}/{process}", self._queue.callback(made))
        publisher = _publisher(self._session, f"towline/in/{host}/{process}/{self._identity.name}")
        self._links[host, process] = _Link(publisher, subscriber, seal)

    def detach(self, host: str, process: str) -> None:
        """Talk with it no longer."""
        link = self._links.pop((host, process), None)
        if link is not None:
            link.publisher.undeclare()
            link.subscriber.undeclare()

    def send(self, host: str, process: str, data: bytes) -> None:
        """Send to an attached process."""
        link = self._links[host, process]
        link.publisher.put(_sealed(link.seal, data))

    def receive(self, timeout_s: float) -> Arrival | None:
        """What arrived next; None after the time."""
        return self._queue.get(timeout_s)

    def close(self) -> None:
        """Close the session, without which the process would not exit."""
        try:
            self._session.close()
        finally:
            self._socket.remove()


class HostBus:
    """A host's end: it offers itself under its name until it is closed.

    It hears any conductor until it follows one, and then only that.
    """

    def __init__(
        self, name: str, connect: Sequence[str], identity: Identity, file: Path | None = None, *, is_sealed: bool = True
    ):
        """Connect and offer; waits for a conductor that is not there yet. is_sealed: as the conductor's. HostError."""
        self._queue, self._identity, self._is_sealed = _Queue(), identity, is_sealed
        self._seal: Seal | None = None
        self._heard = ""  # the conductor whose message came last, by its name on the bus
        self._is_following = False
        self._session = open_session(configuration([], connect, file))
        self._subscriber = self._session.declare_subscriber(
            f"towline/in/{name}/{identity.name}/*", self._queue.callback(_from_conductor)
        )
        self._publisher = _publisher(self._session, f"towline/out/{name}/{identity.name}")
        self._token = self._session.liveliness().declare_token(f"{_OFFERS}/{name}/{identity.name}")
        self._conductor: zenoh.Subscriber[None] | None = None
        self.is_led = False

    def follow(self, run: int) -> None:
        """Hear only the conductor whose message came last, and note in is_led whether it is there."""

        def note(sample: zenoh.Sample) -> None:
            self.is_led = sample.kind == zenoh.SampleKind.PUT

        self.leave()
        self._is_following = self.is_led = True
        self._conductor = self._session.liveliness().declare_subscriber(f"{_CONDUCTORS}/{run:016x}", note, history=True)

    def leave(self) -> None:
        """Hear any conductor."""
        if self._conductor is not None:
            self._conductor.undeclare()
        self._conductor, self._is_following = None, False

    def send(self, data: bytes) -> None:
        """Send to the conductor whose message came last."""
        self._publisher.put(_sealed(self._seal, data))

    def receive(self, timeout_s: float) -> bytes | None:
        """The next message; None after the time; no bytes where it is not from the conductor followed."""
        arrived = self._queue.get(timeout_s)
        if arrived is None:
            return None
        conductor, data = arrived
        if conductor != self._heard:
            if self._is_following:
                return b""
            self._seal = self._identity.seal_with(conductor) if self._is_sealed else None
            self._heard = conductor
        return _opened(self._seal, data)

    def close(self) -> None:
        """Withdraw the offer and close the session."""
        self._session.close()


def _from_conductor(sample: zenoh.Sample) -> tuple[str, bytes]:
    return str(sample.key_expr).rpartition("/")[2], sample.payload.to_bytes()
