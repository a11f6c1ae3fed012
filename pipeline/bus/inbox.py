"""What arrives at a key, for the one thread that waits for it: woken by zenoh itself, by other threads, by a clock.

Callbacks cost one or two more changes of thread a message: zenoh runs them in a thread of their own, which then has to
wake the one that waits, and to let go of the interpreter for it. Keys are exact: zenoh numbers these once, and looks
an expression with a wildcard up for every message.
"""

from __future__ import annotations

import threading
from contextlib import suppress

import zenoh
from zenoh.handlers import FifoChannel, Handler

CAPACITY = 1 << 14  # messages that nobody has taken yet, after which whoever sends has to wait
_NOTHING = b""  # a message that only wakes


class Inbox:
    """Messages at a key in order of arrival."""

    def __init__(self, session: zenoh.Session, key: str):
        """key: what is sent to it is kept from now on."""
        channel: FifoChannel[zenoh.Sample] = FifoChannel(CAPACITY)
        self._subscriber: zenoh.Subscriber[Handler[zenoh.Sample]] = session.declare_subscriber(key, channel)
        self._next, self._next_there = self._subscriber.recv, self._subscriber.try_recv
        self._session, self._expression = session, key
        self.key = key  # on which the last message came
        self._is_exact = "*" not in key

    def next(self) -> bytes | None:
        """Wait for the next message; None where the wait was ended."""
        return self._message(self._next())

    def next_there(self) -> bytes | None:
        """The next message that is there already; None where none is."""
        sample = self._next_there()
        return None if sample is None else self._message(sample)

    def _message(self, sample: zenoh.Sample) -> bytes | None:
        if not self._is_exact:
            self.key = str(sample.key_expr)
        return sample.payload.to_bytes() or None

    def wake(self) -> None:
        """Have whoever waits for the next message get one that says nothing; from any thread."""
        with suppress(zenoh.ZError):  # the session is closed
            self._session.put(self._expression, _NOTHING, allowed_destination=zenoh.Locality.SESSION_LOCAL)

    def close(self) -> None:
        """Receive no more."""
        self._subscriber.undeclare()


class Waiting:
    """One thread that waits at one inbox after another. period_s: the longest that it is kept there."""

    def __init__(self, period_s: float):
        self._inbox: Inbox | None = None
        self._period_s, self._is_over = period_s, threading.Event()
        self._clock = threading.Thread(target=self._wake_now_and_then, daemon=True)
        self._clock.start()

    def at(self, inbox: Inbox) -> bytes | None:
        """The next message in the inbox; None where the wait was ended."""
        self._inbox = inbox
        try:
            return inbox.next()
        finally:
            self._inbox = None

    def end(self) -> None:
        """End a wait; from any thread."""
        inbox = self._inbox
        if inbox is not None:
            inbox.wake()

    def close(self) -> None:
        """Stop the clock."""
        self._is_over.set()
        self._clock.join()

    def _wake_now_and_then(self) -> None:
        while not self._is_over.wait(self._period_s):
            self.end()
