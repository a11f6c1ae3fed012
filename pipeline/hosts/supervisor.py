"""Keeps the hosts of a run at work: starts them, asks them, kills those that hang, and feeds those started again."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

from pipeline.bus.messages import (
    ASSIGN,
    DONE,
    END,
    OUT_OF_ORDER,
    READY,
    REFUSED,
    Message,
    MessageError,
    pack,
    unpack,
)
from pipeline.bus.zenoh import APPEARED, Change
from pipeline.errors import HostError
from pipeline.hosts import facts
from pipeline.hosts.deployment import Bus, Deployment, Process
from pipeline.recovery import Link

POLL_S = 0.05  # between looks at who is overdue; also the longest that one look counts, should this process be stopped
REPEAT_S = 0.5  # wall time after which an assignment, or a request to another machine, is sent again
START_S = 60.0  # wall time that a process may take from its start until it is ready; nothing is left to compile
PREPARE_S = 600.0  # the same of another machine, from its offer on: it may have all to compile
DEATHS = 5  # a host that ends so often, starting or in one step, without an answer in between stops the run
END_S = 2.0  # wall time that hosts are given to end by themselves


Request = tuple[int, bytes, bool]  # section, numbers, whether it is the last of its block


@dataclass
class Host:
    """One host as the conductor knows it. limit_s: None for a process of this machine.

    sections: as they are assigned; made once, so that a host started again refuses a file model edited meanwhile.
    address: of the process that is attached. waited_s: since it last gave a sign, while something is awaited of it.
    """

    name: str
    links: list[Link]
    sections: list[dict[str, Any]]
    overdue_s: dict[int, float]  # by section
    limit_s: float | None
    process: Process | None = None
    expected: str = ""  # the name under which its local process offers itself
    former: set[str] = field(default_factory=set)  # those of processes that were given up
    address: tuple[str, str] | None = None
    incarnation: int = 0
    is_ready: bool = False
    waited_s: float = 0.0
    repeated_s: float = 0.0
    deaths: int = 0
    restarts: int = 0
    late: int = 0
    refused: int = 0
    ignored: int = 0  # by the host itself, as it last told
    is_late: bool = False
    is_warned: bool = False  # that somebody else sends messages to it or in its name

    @property
    def open(self) -> list[Link]:
        """Sections of which an answer is awaited."""
        return [link for link in self.links if not link.is_answered]


@dataclass
class Hosts:
    """All hosts of a run. tell: takes a line about what happened to them; poll: may raise KeyboardInterrupt."""

    run: int
    hosts: list[Host]
    bus: Bus
    deployment: Deployment
    tell: Callable[[str], None]
    poll: Callable[[], None] = lambda: None
    _by_name: dict[str, Host] = field(default_factory=dict)
    _places: dict[int, tuple[Host, Link]] = field(default_factory=dict)  # by section
    _by_address: dict[tuple[str, str], Host] = field(default_factory=dict)
    _others: dict[str, list[str]] = field(default_factory=dict)  # processes that offer themselves for a taken machine
    _looked: float = 0.0

    def start(self) -> None:
        """Start the processes of this machine, and wait until all hosts are ready. Raises HostError."""
        self._by_name = {host.name: host for host in self.hosts}
        self._places = {link.section.number: (host, link) for host in self.hosts for link in host.links}
        for host in self.hosts:
            if host.limit_s is None:
                self._start(host)
            else:
                self.tell(f"waiting for host {host.name} ({_names(host)}), up to {host.limit_s:g} s")
        self._looked = time.monotonic()
        while awaited := next((host for host in self.hosts if not host.is_ready), None):
            self._heed(awaited)

    def ask(self, kind: int, requests: Iterable[Request], t_ns: int, meanwhile: Callable[[], None]) -> None:
        """Send a request to each section, do something meanwhile, and wait for all replies. Raises HostError."""
        asked = []
        for number, numbers, is_last in requests:
            host, link = self._places[number]
            is_free = host.is_ready and link.answered == link.sequence
            data = link.make(kind, self.run, host.incarnation, t_ns, numbers, is_last=is_last)
            host.waited_s = host.repeated_s = 0.0
            if is_free and host.address is not None:
                self.bus.send(host.address, data)
            link.keep(data)
            asked.append((host, link))
        meanwhile()
        self._looked = time.monotonic()
        for host, link in asked:
            while link.answered != link.sequence:
                self._heed(host)

    def counts(self) -> dict[str, dict[str, int]]:
        """{host: {restarts, late, refused}}."""
        return {
            host.name: {"restarts": host.restarts, "late": host.late, "refused": host.refused + host.ignored}
            for host in self.hosts
        }

    def close(self) -> str:
        """End all processes and the bus, whatever fails of it; returns what the processes wrote."""
        with ExitStack() as after:
            after.callback(self.deployment.close)
            after.callback(self.bus.close)
            for host in self.hosts:
                if host.address is not None:
                    self.bus.send(host.address, pack(Message(END, self.run, host.incarnation)))
            until = time.monotonic() + END_S
            written = ""
            for host in self.hosts:
                if host.process is not None:
                    host.process.end(max(0.0, until - time.monotonic()) if host.is_ready else 0.0)
                    written += host.process.collect()
        return written

    def _heed(self, host: Host) -> None:
        """Wait for what a host sends next and take it in; now and then look who is overdue."""
        data = self.bus.receive(host.address)
        if data is not None:
            self._answered(host, data)
        for change in self.bus.changes():
            self._take(change)
        if time.monotonic() - self._looked > POLL_S:
            self.poll()
            self._look()

    def _take(self, change: Change) -> None:
        """Somebody has appeared or vanished."""
        kind, name, process = change
        host = self._by_address.get((name, process))
        if kind == APPEARED:
            self._appeared(name, process)
        elif host is not None:
            self._vanished(host)
        elif process in self._others.get(name, ()):
            self._others[name].remove(process)

    def _appeared(self, name: str, process: str) -> None:
        """Give a process that offers itself its sections, if it is the one awaited."""
        host = self._by_name.get(name)
        if host is None or process in host.former:
            return
        if host.limit_s is None and (process != host.expected or host.address is not None):
            self.tell(f"another process offers itself as {name}: ignored")
        elif host.address is not None:
            self._others.setdefault(name, []).append(process)
            self.tell(f"another process offers itself as {name}: it is kept for when this one goes")
        else:
            self._attach(host, process)

    def _attach(self, host: Host, process: str) -> None:
        """Have this process be the host from now on."""
        host.address = name, _ = host.name, process
        self._by_address[host.address] = host
        self.bus.attach(name, process)
        host.incarnation += 1
        host.waited_s = 0.0
        if host.limit_s is not None and host.incarnation > 1:
            host.restarts += 1
            self.tell(f"host {host.name} is back")
        self._assign(host)

    def _assign(self, host: Host) -> None:
        assert host.address is not None
        wanted = {
            "facts": dict(facts.own()),
            "limit_s": host.limit_s or 0.0,
            "sections": host.sections,
        }
        host.repeated_s = 0.0
        message = Message(ASSIGN, self.run, host.incarnation, text=json.dumps(wanted).encode())
        self.bus.send(host.address, pack(message))

    def _vanished(self, host: Host) -> None:
        if host.limit_s is None:
            self._restart(host, "died")
            return
        self._detach(host)
        host.waited_s = 0.0
        self.tell(f"host {host.name} is away{_at(host)}: waiting for it, up to {host.limit_s:g} s")
        if others := self._others.get(host.name):
            self._attach(host, others.pop(0))

    def _detach(self, host: Host) -> None:
        if host.address is not None:
            self.bus.detach(*host.address)
            del self._by_address[host.address]
        host.address, host.is_ready = None, False

    def _answered(self, host: Host, data: bytes) -> None:
        try:
            message = unpack(data)
        except MessageError:
            self._strange(host)
            return
        if message.run != self.run or message.incarnation != host.incarnation:
            host.refused += 1  # of an incarnation that is no more
        elif message.kind == DONE:
            self._done(host, message)
        elif message.kind in (READY, REFUSED):
            self._take_decision(host, message)
        elif message.kind == OUT_OF_ORDER and host.is_ready:
            self._out_of_order(host, message)
        else:
            host.refused += 1

    def _strange(self, host: Host) -> None:
        """A message on the host's keys that it has not sent."""
        host.refused += 1
        if not host.is_warned:
            host.is_warned = True
            self.tell(f"somebody else sends in the name of host {host.name}: ignored and counted")

    def _take_decision(self, host: Host, message: Message) -> None:
        """Whether the host takes part; it says so again as often as it is asked. Raises HostError where it does not."""
        said = _said(message)
        if said is None:
            self._strange(host)
            return
        its_facts, reasons = said
        if message.kind == REFUSED:
            raise HostError(f"host {host.name} cannot take part: {'; '.join(reasons)}")
        if not host.is_ready:
            self._ready(host, its_facts)

    def _ready(self, host: Host, its_facts: facts.Facts) -> None:
        """Restore what the host had done, and feed it the requests since."""
        assert host.address is not None
        warning = facts.warning(facts.own(), its_facts, host.name)
        if warning and host.incarnation == 1:
            self.tell(warning)
        host.is_ready, host.waited_s = True, 0.0
        for link in host.links:
            restore = link.restart(self.run, host.incarnation)
            if restore is not None:
                self.bus.send(host.address, restore)
            self._ask_next(host, link)

    def _ask_next(self, host: Host, link: Link) -> None:
        if not link.is_answered and host.address is not None:
            self.bus.send(host.address, link.open_request(host.incarnation))

    def _done(self, host: Host, message: Message) -> None:
        host_of_it, link = self._places.get(message.section, (None, None))
        if link is None or host_of_it is not host or not host.is_ready or not link.take(message):
            host.refused += 1
            return
        if message.ignored > host.ignored:
            self._heed_ignored(host, message.ignored)
        host.waited_s = host.repeated_s = 0.0
        host.is_late = False
        if not link.is_answered:
            self._ask_next(host, link)
        elif host.deaths and not host.open:
            host.deaths = 0

    def _heed_ignored(self, host: Host, ignored: int) -> None:
        """What the host says that it has ignored."""
        if not host.is_warned:
            host.is_warned = True
            self.tell(f"host {host.name} is sent messages that are not of this run: ignored and counted")
        host.ignored = ignored

    def _out_of_order(self, host: Host, message: Message) -> None:
        """A host that is not where it should be begins a new incarnation, which is restored and fed."""
        if any(link.section.number == message.section and message.sequence == link.answered for link in host.links):
            return
        host.is_ready = False
        host.incarnation += 1
        self._assign(host)

    def _look(self) -> None:
        """Take in what the others have sent meanwhile; then: who is overdue, who has died."""
        for host in self.hosts:
            while host.address is not None and (data := self.bus.received(host.address)) is not None:
                self._answered(host, data)
        now = time.monotonic()
        passed, self._looked = min(now - self._looked, 2 * POLL_S), now
        for host in self.hosts:
            if host.process is not None and not host.process.is_alive():
                self._restart(host, "died")
            elif not host.is_ready or host.open:
                host.waited_s += passed
                host.repeated_s += passed
                self._watch(host)

    def _watch(self, host: Host) -> None:
        """A host that something is awaited of."""
        overdue_s = min((host.overdue_s[link.section.number] for link in host.open), default=0.0)
        if host.limit_s is None:
            self._watch_process(host, overdue_s)
        else:
            self._watch_machine(host, overdue_s, host.limit_s)
        if host.repeated_s > REPEAT_S and host.address is not None:
            self._repeat(host)

    def _watch_process(self, host: Host, overdue_s: float) -> None:
        """A process of this machine is started again."""
        if not host.is_ready and host.waited_s > START_S:
            self._restart(host, f"did not get ready within {START_S:g} s")
        elif host.is_ready and host.waited_s > overdue_s:
            host.late += 1
            self._restart(host, f"has not answered for {overdue_s:g} s")

    def _watch_machine(self, host: Host, overdue_s: float, limit_s: float) -> None:
        """Another machine is waited for."""
        is_preparing = host.address is not None and not host.is_ready
        if host.waited_s > (PREPARE_S if is_preparing else limit_s):
            waited = f"was waited for {host.waited_s:.0f} s{_at(host)}"
            remedy = f"start it by towline host --name {host.name}"
            if host.address is not None:
                remedy = "it is there and does not answer; what takes longer needs a longer `limit:`"
            raise HostError(f"host {host.name} ({_names(host)}) {waited}; {remedy}")
        if host.is_ready and host.waited_s > overdue_s and not host.is_late:
            host.is_late = True
            host.late += 1
            self.tell(f"host {host.name} ({_names(host)}) is late{_at(host)}: waiting, up to {limit_s:g} s")

    def _repeat(self, host: Host) -> None:
        """Send again what may have been lost with a connection."""
        host.repeated_s = 0.0
        if not host.is_ready:
            self._assign(host)
            return
        for link in host.open if host.limit_s is not None else ():
            self._ask_next(host, link)

    def _start(self, host: Host) -> None:
        host.waited_s = host.repeated_s = 0.0
        host.expected, host.process = self.deployment.start(host.name)

    def _restart(self, host: Host, why: str) -> None:
        """Kill what is left of a local host's process and start another. Raises HostError where that leads nowhere."""
        assert host.process is not None
        host.deaths = host.deaths + 1 if host.open or not host.is_ready else 0
        host.restarts += 1
        self._detach(host)
        host.process.end()
        written = host.process.collect().strip().splitlines()
        last_words = f"; its last words: {written[-1].strip()[:200]}" if written else ""
        host.process = None
        host.former.add(host.expected)
        what = f"host {host.name} ({_names(host)}) {why}{_at(host)}"
        if host.deaths >= DEATHS:
            overdue = "; a step that takes longer needs `overdue:`" if "answered" in why else ""
            raise HostError(f"{what}, {host.deaths} times in a row{last_words}{overdue}")
        self.tell(f"{what}{last_words}: started again")
        self._start(host)


def _said(message: Message) -> tuple[dict[str, str], list[str]] | None:
    """A host's facts, and what keeps it out; None where the message does not say that."""
    try:
        said = json.loads(message.text)
        return dict(said["facts"]), [str(reason) for reason in said["reasons"]]
    except (KeyError, TypeError, ValueError):
        return None


def _names(host: Host) -> str:
    """The components that are being stepped, or all."""
    return ", ".join(link.names for link in host.open or host.links)


def _at(host: Host) -> str:
    """The step that is awaited, as the end of a sentence."""
    return "".join(f" in its step at t = {link.t_ns / 1e9:.9g} s" for link in host.open[:1])
