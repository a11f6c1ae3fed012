"""The zenoh bus: one session a process, keys by host, and what arrives handed over to the thread that asks for it."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple

import zenoh

from pipeline.bus.socket import LocalSocket
from pipeline.errors import HostError

MESSAGE, APPEARED, VANISHED = "message", "appeared", "vanished"
LEASE_MS = 5000  # a transport that is silent for so long is closed; four times as often something is sent
RETRY_MS = 200  # between attempts to connect
_OFFERS = "towline/host"  # liveliness tokens of processes that offer themselves, NAME/PROCESS below it
_CONDUCTORS = "towline/run"  # liveliness tokens of conductors, by run


class Arrival(NamedTuple):
    """A message from a process, or that it appeared or vanished."""

    kind: str
    host: str
    process: str
    data: bytes = b""


def configuration(listen: Sequence[str], connect: Sequence[str], file: Path | None = None) -> zenoh.Config:
    """Peers at explicit endpoints: no scouting, no gossip, no shared memory (killed processes would leave segments).

    file: a zenoh configuration (JSON5) with what else there is to say, such as TLS and access control. Raises HostError
    if it cannot be read.
    """
    try:
        config = zenoh.Config.from_file(str(file)) if file else zenoh.Config()
    except Exception as error:  # zenoh's own, and OSError
        raise HostError(f"{file}: no zenoh configuration: {error}") from error
    settings = {
        "mode": "peer",
        "listen/endpoints": list(listen),
        "connect/endpoints": list(connect),
        "connect/timeout_ms": -1 if connect else 0,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": RETRY_MS, "period_max_ms": 5 * RETRY_MS, "period_increase_factor": 2},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "transport/shared_memory/enabled": False,
    }
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def open_session(config: zenoh.Config) -> zenoh.Session:
    """Raises HostError where an endpoint cannot be listened at or connected to."""
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        raise HostError(f"zenoh cannot be started: {str(error).splitlines()[0][:300]}") from error


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


def _publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    return session.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK, express=True)


class ConductorBus:
    """The conductor's end: processes offer themselves, are attached, and messages go to and fro."""

    def __init__(self, run: int, listen: Sequence[str], file: Path | None = None):
        """Listen at a socket of this machine (`endpoint`) and at others. Raises HostError."""
        self._queue = _Queue()
        self._links: dict[tuple[str, str], tuple[zenoh.Publisher, zenoh.Subscriber[None]]] = {}
        self._socket = LocalSocket()
        self.endpoint = self._socket.endpoint
        try:
            self._session = open_session(configuration([self.endpoint, *listen], [], file))
        except HostError:
            self._socket.remove()
            raise
        liveliness = self._session.liveliness()
        self._token = liveliness.declare_token(f"{_CONDUCTORS}/{run:016x}")
        self._offers = liveliness.declare_subscriber(f"{_OFFERS}/*/*", self._queue.callback(_liveliness), history=True)

    def attach(self, host: str, process: str) -> None:
        """Begin to talk with a process."""

        def made(sample: zenoh.Sample) -> Arrival:
            return Arrival(MESSAGE, host, process, sample.payload.to_bytes())

        subscriber = self._session.declare_subscriber(f"towline/out/{host}/{process}", self._queue.callback(made))
        self._links[host, process] = _publisher(self._session, f"towline/in/{host}/{process}"), subscriber

    def detach(self, host: str, process: str) -> None:
        """Talk with it no longer."""
        for one in self._links.pop((host, process), ()):
            one.undeclare()

    def send(self, host: str, process: str, data: bytes) -> None:
        """Send to an attached process."""
        self._links[host, process][0].put(data)

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
    """A host's end: it offers itself under its name until it is closed."""

    def __init__(self, name: str, connect: Sequence[str], process: str = "", file: Path | None = None):
        """Connect and offer; waits for a conductor that is not there yet. Raises HostError."""
        self._queue, process = _Queue(), process or secrets.token_hex(8)
        self._session = open_session(configuration([], connect, file))
        self._subscriber = self._session.declare_subscriber(
            f"towline/in/{name}/{process}", self._queue.callback(lambda sample: sample.payload.to_bytes())
        )
        self._publisher = _publisher(self._session, f"towline/out/{name}/{process}")
        self._token = self._session.liveliness().declare_token(f"{_OFFERS}/{name}/{process}")
        self._conductor: zenoh.Subscriber[None] | None = None
        self.is_led = False

    def watch(self, run: int) -> None:
        """Note whether the run's conductor is there in is_led."""

        def note(sample: zenoh.Sample) -> None:
            self.is_led = sample.kind == zenoh.SampleKind.PUT

        if self._conductor is not None:
            self._conductor.undeclare()
        self.is_led = True
        self._conductor = self._session.liveliness().declare_subscriber(f"{_CONDUCTORS}/{run:016x}", note, history=True)

    def send(self, data: bytes) -> None:
        """Send to the conductor."""
        self._publisher.put(data)

    def receive(self, timeout_s: float) -> bytes | None:
        """The conductor's next message; None after the time."""
        return self._queue.get(timeout_s)

    def close(self) -> None:
        """Withdraw the offer and close the session."""
        self._session.close()
