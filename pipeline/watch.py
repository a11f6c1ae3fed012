"""Watches FMUs that run in this process: one that never returns holds the conductor up, which cannot help itself."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager

from pipeline.hosts.fmu.base import FmuHost

HANGS_S = 60.0  # wall time of one call after which an FMU is taken to hang, unless `overdue:` says another
LOOK_S = 0.1


class Watch:
    """A thread beside the conductor's. give_up: called with the FMU's host and the time waited; must not return.

    The conductor is inside() while it is in compiled code, where alone the thread may act in its place.
    """

    def __init__(self, hosts: Collection[FmuHost], give_up: Callable[[FmuHost, float], None]):
        """hosts: of FMUs in this process; without any no thread is started."""
        self._hosts, self._give_up = list(hosts), give_up
        self._outside = threading.Lock()
        self._outside.acquire()
        self._ended = threading.Event()
        if self._hosts:
            threading.Thread(target=self._look, name="towline watch", daemon=True).start()

    @contextmanager
    def inside(self) -> Iterator[None]:
        """While the conductor is in compiled code."""
        self._outside.release()
        try:
            yield
        finally:
            self._outside.acquire()  # waits for ever where the thread has given up

    def end(self) -> None:
        """End the thread."""
        self._ended.set()

    def _look(self) -> None:
        seen = dict.fromkeys(self._hosts, 0)
        since = dict.fromkeys(self._hosts, time.monotonic())
        looked = time.monotonic()
        while not self._ended.wait(LOOK_S):
            now = time.monotonic()
            stopped_s, looked = max(0.0, now - looked - 2 * LOOK_S), now  # this process may have been stopped itself
            for host in self._hosts:
                calls = host.stands_since()
                if calls != seen[host] or calls % 2 == 0:
                    seen[host], since[host] = calls, now
                    continue
                since[host] += stopped_s
                limit_s = host.component.overdue_s or HANGS_S
                if now - since[host] > limit_s and self._outside.acquire(blocking=False):
                    self._give_up(host, limit_s)
                    return
