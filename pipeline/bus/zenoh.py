"""The zenoh bus: one session a process, keys by host and process, and one thread that takes what arrives."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import zenoh

from pipeline.bus.channels import Channels
from pipeline.bus.configuration import close_session, configuration, open_session
from pipeline.bus.identity import Identity, Seal
from pipeline.bus.inbox import Inbox, Waiting
from pipeline.bus.socket import LocalSocket
from pipeline.errors import HostError

APPEARED, VANISHED = "appeared", "vanished"
_OFFERS = "towline/host"  # liveliness tokens of processes that offer themselves, NAME/PROCESS below it
_CONDUCTORS = "towline/run"  # liveliness tokens of conductors, by run
_TO_HOSTS, _FROM_HOSTS = "towline/in", "towline/out"  # NAME/PROCESS below them, and the conductor's below the first
LED_S = 5.0  # wall time that a host waits to hear whether the conductor that it follows is still there
_NOBODY = "towline/nobody"  # where the conductor waits while no process is attached

Address = tuple[str, str]  # a host's name and its process's


class Change(NamedTuple):
    """That a process has appeared or vanished."""

    kind: str
    host: str
    process: str


def _change(sample: zenoh.Sample) -> Change:
    *_, host, process = str(sample.key_expr).split("/")
    return Change(APPEARED if sample.kind == zenoh.SampleKind.PUT else VANISHED, host, process)


def _opened(seal: Seal | None, data: bytes | None) -> bytes | None:
    """What is inside; no bytes, which are no message, where somebody else has sealed it."""
    return data if seal is None or data is None else seal.opened(data) or b""


class _Link(NamedTuple):
    """The conductor's side of a process."""

    publisher: zenoh.Publisher
    inbox: Inbox
    seal: Seal | None


def _publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=True)


class ConductorBus:
    """The conductor's end: processes offer themselves, are attached, and messages go to and fro.

    Messages are sealed where machines may connect; the socket of this machine is its user's alone. channels: for
    whoever subscribes; None where nobody can.
    """

    def __init__(self, run: int, listen: Sequence[str], file: Path | None = None, *, look_s: float):
        """Listen at a socket of this machine (`endpoint`) and at others.

        look_s: longest time that receive() waits. Raises HostError.
        """
        self._identity = Identity()
        self._is_sealed = bool(listen)
        self._links: dict[Address, _Link] = {}
        self._changes: deque[Change | BaseException] = deque()
        self._socket = LocalSocket()
        self.endpoint = self._socket.endpoint
        try:
            self._session = open_session(configuration([self.endpoint, *listen], [], file))
        except HostError:
            self._socket.remove()
            raise
        self.channels = Channels(self._session) if listen else None
        self._waiting, self._nobody = Waiting(look_s), Inbox(self._session, _NOBODY)
        liveliness = self._session.liveliness()
        self._token = liveliness.declare_token(f"{_CONDUCTORS}/{run:016x}")
        self._offers = liveliness.declare_subscriber(f"{_OFFERS}/*/*", self._note, history=True)

    def _note(self, sample: zenoh.Sample) -> None:
        """Who appears and vanishes; zenoh swallows what a callback raises, so that is handed over as well."""
        try:
            self._changes.append(_change(sample))
        except BaseException as error:  # raised by changes()
            self._changes.append(error)
        self._waiting.end()

    def attach(self, host: str, process: str) -> None:
        """Begin to talk with a process."""
        publisher = _publisher(self._session, f"{_TO_HOSTS}/{host}/{process}/{self._identity.name}")
        inbox = Inbox(self._session, f"{_FROM_HOSTS}/{host}/{process}")
        seal = self._identity.seal_with(process) if self._is_sealed else None
        self._links[host, process] = _Link(publisher, inbox, seal)

    def detach(self, host: str, process: str) -> None:
        """Talk with it no longer."""
        link = self._links.pop((host, process), None)
        if link is not None:
            link.publisher.undeclare()
            link.inbox.close()

    def send(self, address: Address, data: bytes) -> None:
        """Send to an attached process; waits where that takes nothing, at most 5 s, after which zenoh drops it."""
        publisher, _, seal = self._links[address]
        publisher.put(data if seal is None else seal.sealed(data))

    def receive(self, address: Address | None) -> bytes | None:
        """What a process sends next; None where a while has passed, or somebody has appeared or vanished."""
        if self._changes:
            return None
        if address is None:
            self._waiting.at(self._nobody)
            return None
        _, inbox, seal = self._links[address]
        return _opened(seal, self._waiting.at(inbox))

    def received(self, address: Address) -> bytes | None:
        """What a process has sent; None where nothing is there."""
        _, inbox, seal = self._links[address]
        return _opened(seal, inbox.next_there())

    def changes(self) -> Iterator[Change]:
        """Who has appeared and vanished meanwhile."""
        while self._changes:
            change = self._changes.popleft()
            if isinstance(change, BaseException):
                raise change
            yield change

    def close(self) -> None:
        """Close the session, without which the process would not exit, and remove the socket. Raises nothing."""
        try:
            self._waiting.close()
            close_session(self._session)
        finally:
            self._socket.remove()


class HostBus:
    """A host's end: it offers itself under its name until it is closed.

    It hears any conductor until it follows one, and then only that.
    """

    def __init__(
        self,
        name: str,
        connect: Sequence[str],
        identity: Identity,
        file: Path | None = None,
        *,
        look_s: float,
        is_sealed: bool = True,
    ):
        """Connect and offer; waits for a conductor that is not there yet.

        look_s: longest time that receive() waits. is_sealed: as the conductor's. Raises HostError.
        """
        self._identity, self._is_sealed = identity, is_sealed
        self._seal: Seal | None = None
        self._heard = ""  # the conductor whose message came last, by the key on which it sends
        self._session = open_session(configuration([], connect, file))
        self._anybody = f"{_TO_HOSTS}/{name}/{identity.name}/*"
        self._waiting, self._inbox = Waiting(look_s), Inbox(self._session, self._anybody)
        self._publisher = _publisher(self._session, f"{_FROM_HOSTS}/{name}/{identity.name}")
        self._token = self._session.liveliness().declare_token(f"{_OFFERS}/{name}/{identity.name}")
        self._conductor: zenoh.Subscriber[None] | None = None
        self.is_led = False

    def follow(self, run: int) -> None:
        """Hear only the conductor whose message came last, and note in is_led whether it is there."""

        def note(sample: zenoh.Sample) -> None:
            self.is_led = sample.kind == zenoh.SampleKind.PUT

        self._hear(self._heard)
        key, liveliness = f"{_CONDUCTORS}/{run:016x}", self._session.liveliness()
        self.is_led = any(reply.ok is not None for reply in liveliness.get(key, timeout=LED_S))
        self._conductor = liveliness.declare_subscriber(key, note, history=True)

    def leave(self) -> None:
        """Hear any conductor."""
        self._hear(self._anybody)

    def _hear(self, key: str) -> None:
        """Take what is sent to a key, and no more what is sent to others."""
        if self._conductor is not None:
            self._conductor.undeclare()
        self._conductor = None
        before, self._inbox = self._inbox, Inbox(self._session, key)
        before.close()

    def send(self, data: bytes) -> None:
        """Send to the conductor whose message came last."""
        self._publisher.put(data if self._seal is None else self._seal.sealed(data))

    def receive(self) -> bytes | None:
        """The next message; None where a while has passed; no bytes where it is from another than it says."""
        data = self._waiting.at(self._inbox)
        if self._conductor is None and data is not None:
            self._listen_to(self._inbox.key)
        return data if self._seal is None else _opened(self._seal, data)

    def _listen_to(self, conductor: str) -> None:
        if conductor != self._heard:
            self._seal = self._identity.seal_with(conductor.rpartition("/")[2]) if self._is_sealed else None
            self._heard = conductor

    def close(self) -> None:
        """Withdraw the offer and close the session. Raises nothing."""
        self._waiting.close()
        close_session(self._session)
