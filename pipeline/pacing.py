"""Paces a run to wall time, tells missed deadlines, and lets a person pause it and make single steps."""

from __future__ import annotations

import time
from collections.abc import Callable

from pipeline.keyboard import Keys

SLICE_S = 0.05  # wall time a slice of a paced run stands for
WAIT_S = 0.1  # longest wait that an interrupt has to wait for
HELP = "space goes on, . makes one step, q ends the run"


class Pacing:
    """A run's relation to wall time.

    missed: slices that ended after their time; worst_s: the longest such delay.
    """

    def __init__(self, rate: float | None, keys: Keys | None, base_ns: int, tell: Callable[[str], None]):
        """rate: simulated seconds per second of wall time, None for as fast as it goes. keys: None for nobody there."""
        self.missed = 0
        self.worst_s = 0.0
        self._rate, self._keys, self._base_ns, self._tell = rate, keys, base_ns, tell
        self._is_paused = False
        self._began_s, self._began_tick = time.monotonic(), 0

    def begin(self, tick: int) -> None:
        """The run goes on from here, now."""
        self._began_s, self._began_tick = time.monotonic(), tick

    @property
    def slice_ticks(self) -> int | None:
        """Ticks until the next look at the clock and at the keys; None for what suits the machine."""
        if self._is_paused:
            return 1
        if self._rate is None:
            return None
        return max(1, int(self._rate * SLICE_S * 1e9) // self._base_ns)

    def wait(self, tick: int, raise_if_interrupted: Callable[[], None]) -> None:
        """After a slice: wait until it is due, and for as long as a person wants. May raise KeyboardInterrupt."""
        if not self._is_paused:
            self._wait_for_time(tick, raise_if_interrupted)
        while self._is_paused and not self._heed(WAIT_S):
            raise_if_interrupted()
            self.begin(tick)

    def _wait_for_time(self, tick: int, raise_if_interrupted: Callable[[], None]) -> None:
        due_s = self._due_s(tick)
        late_s = time.monotonic() - due_s
        if self._rate is not None and late_s > 0.0:
            self.missed += 1
            self.worst_s = max(self.worst_s, late_s)
        self._heed(0.0)
        while self._rate is not None and not self._is_paused and (left_s := due_s - time.monotonic()) > 0.0:
            self._heed(min(left_s, WAIT_S))
            raise_if_interrupted()
        if self._is_paused:
            self._tell(f"paused at t = {tick * self._base_ns / 1e9:.9g} s after the start: {HELP}")

    def _due_s(self, tick: int) -> float:
        return self._began_s + (tick - self._began_tick) * self._base_ns / 1e9 / (self._rate or 1.0)

    def _heed(self, timeout_s: float) -> bool:
        """Wait so long for a key; whether it lets a paused run make a step. Raises KeyboardInterrupt at the end."""
        if self._keys is None:
            time.sleep(timeout_s)
            return False
        key = self._keys(timeout_s)
        if key in ("q", "\x03"):
            raise KeyboardInterrupt
        if key == " ":
            self._is_paused = not self._is_paused
        elif key in (".", "n") and not self._is_paused:
            self._is_paused = True
        elif key in (".", "n"):
            return True
        return False
