"""Plays a log to an audience: every message at its time, its bytes as they stand in the log."""

from __future__ import annotations

import time
from dataclasses import dataclass

from pipeline.log.reader import Log
from pipeline.log.recorder import Audience

WAIT_S = 0.1  # between looks whether anybody is there


@dataclass
class Played:
    """What was played so far. worst_late_s: the longest that a message was put after its time."""

    messages: int = 0
    worst_late_s: float = 0.0


class Player:
    """A log and its audience. rate: simulated seconds per second of wall time."""

    def __init__(self, log: Log, audience: Audience, rate: float):
        self.played = Played()
        self._log, self._audience, self._rate = log, audience, rate
        self._topics = log.schemas()
        for topic, schema in self._topics.items():
            audience.declare(topic, schema.message, schema.descriptors)

    def wait(self) -> None:
        """Until somebody wants any of it."""
        while not any(self._audience.is_wanted(topic) for topic in self._topics):
            time.sleep(WAIT_S)

    def play(self, until_ns: int) -> None:
        """Once, from the log's start to a simulated time. Raises LogError."""
        began_s = time.monotonic()
        for topic, t_ns, data in self._log.messages():
            if t_ns > until_ns:
                break
            due_s = began_s + (t_ns - self._log.start_ns) / 1e9 / self._rate
            late_s = time.monotonic() - due_s
            if late_s < 0.0:
                time.sleep(-late_s)
            self._audience.put(topic, t_ns, data)
            self.played.worst_late_s = max(self.played.worst_late_s, late_s)
            self.played.messages += 1
