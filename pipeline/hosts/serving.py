"""What a host answers: it steps its sections in sequence, repeats its last reply, and refuses the rest."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from pipeline.bus.messages import (
    ASSIGN,
    DONE,
    END,
    INITIALISE,
    OUT_OF_ORDER,
    READY,
    REFUSED,
    RESTORE,
    SETTINGS,
    STATE,
    STEP,
    STOPPED,
    WANT_STATE,
    Message,
    MessageError,
    pack,
    pack_parts,
    unpack,
)
from pipeline.errors import TowlineError
from pipeline.hosts import facts
from pipeline.hosts.assignment import AssignmentError, from_json
from pipeline.hosts.section import SectionRunner

TEXT_BYTES = 4096  # of what a component raised


@dataclass
class _Place:
    """A section being run: how long requests are, the last one executed (-1: none), and its reply."""

    runner: SectionRunner
    bytes: int
    bytes_with_settings: int
    sequence: int = -1
    reply: bytes = b""


def _place(runner: SectionRunner) -> _Place:
    return _Place(runner, 8 * runner.lengths.request(0), 8 * runner.lengths.request(SETTINGS))


class Serving:
    """A host's side of the protocol; knows nothing of how messages travel."""

    def __init__(self, name: str):
        self.name = name
        self.run = 0
        self.ended = False
        self.limit_s = 0.0  # how long the run lets this host stay away
        self._incarnation = 0
        self._sections: dict[int, _Place] = {}
        self._ready = b""
        self._ignored = 0

    @property
    def components(self) -> list[str]:
        """Names of what it runs."""
        return [name for place in self._sections.values() for name in place.runner.names]

    def abandon(self) -> None:
        """Forget the run; another may be taken up."""
        for place in self._sections.values():
            place.runner.close()
        self.run, self._incarnation, self._sections, self._ready, self.ended = 0, 0, {}, b"", False

    def answer(self, data: bytes) -> bytes | None:
        """The reply to a message; None to one that is ignored."""
        try:
            message = unpack(data)
        except MessageError:
            return self._ignore()
        kind = message.kind
        if kind == ASSIGN:
            return self._assign(message)
        if message.run != self.run or message.incarnation != self._incarnation:
            return self._ignore()
        place = self._sections.get(message.section)
        if place is not None and kind in (STEP, INITIALISE):
            return self._execute(place, message)
        if kind == END:
            self.ended = True
            return None
        if place is not None and kind == RESTORE:
            return self._restore(place, message)
        return self._ignore()

    def _ignore(self) -> None:
        self._ignored += 1

    def _assign(self, message: Message) -> bytes | None:
        """Take sections up, unless another run has this host, or the conductor is not of the same make."""
        if self.run not in (0, message.run) or message.incarnation < self._incarnation:
            return self._ignore()
        if message.run == self.run and message.incarnation == self._incarnation:
            return self._ready
        reasons: list[str] = []
        try:
            wanted = json.loads(message.text)
            reasons = facts.refusals(wanted["facts"], facts.own(), self.name) or facts.refusal_of_edits(self.name)
            if not reasons:
                self._take_up(wanted)
        except (AssignmentError, TowlineError) as error:
            reasons = [f"{self.name}: {error}"]
        except (AttributeError, KeyError, TypeError, ValueError) as error:  # not an assignment of this protocol
            reasons = [f"{self.name} cannot read its assignment: {type(error).__name__}: {error}"]
        said = {"facts": dict(facts.own()), "reasons": reasons}
        kind = REFUSED if reasons else READY
        reply = pack(Message(kind, message.run, message.incarnation, text=json.dumps(said).encode()))
        if not reasons:
            self.run, self._incarnation, self._ready = message.run, message.incarnation, reply
        return reply

    def _take_up(self, wanted: dict[str, Any]) -> None:
        assigned = from_json(wanted["sections"])
        for place in self._sections.values():
            place.runner.close()
        self._sections = {one.number: _place(SectionRunner(one.graph, one.outside)) for one in assigned}
        self.limit_s = float(wanted["limit_s"])

    def _restore(self, place: _Place, message: Message) -> None:
        if len(message.values) != place.runner.lengths.snapshot:
            return self._ignore()
        place.runner.restore(message.values, message.text)
        place.sequence, place.reply = message.sequence, b""

    def _execute(self, place: _Place, message: Message) -> bytes | None:
        """The request that is next in sequence; the last one's reply again; no other."""
        runner, sequence, flags = place.runner, message.sequence, message.flags
        if len(message.numbers) != (place.bytes_with_settings if flags & SETTINGS else place.bytes):
            return self._ignore()
        if sequence == place.sequence and place.reply:
            return place.reply
        if sequence != place.sequence + 1:
            self._ignored += 1
            return self._out_of_order(place, message)
        if message.kind == STEP:
            status = runner.step(message.numbers, message.t_ns)
        else:
            status = runner.initialise(message.numbers)
        place.sequence, place.reply = sequence, self._done(place, message, status)
        return place.reply

    def _out_of_order(self, place: _Place, message: Message) -> bytes:
        last = max(place.sequence, 0)
        return pack(Message(OUT_OF_ORDER, self.run, self._incarnation, message.section, last, ignored=self._ignored))

    def _done(self, place: _Place, message: Message, status: int) -> bytes:
        flags = (STATE if message.flags & WANT_STATE else 0) | (STOPPED if status else 0)
        parts = place.runner.reply(state=flags & STATE != 0, inputs=status != 0)
        where = self.run, self._incarnation, message.section, message.sequence, message.t_ns
        saved = place.runner.saved() if flags == STATE else b""
        if not status and not saved:
            return pack_parts(DONE, *where, flags, self._ignored, sum(map(len, parts)) // 8, parts)
        text = place.runner.reason(status).encode()[:TEXT_BYTES] if status else saved
        failed, numbers = place.runner.failed if status else -1, b"".join(parts)
        return pack(Message(DONE, *where, flags, status, failed, self._ignored, numbers, text))
