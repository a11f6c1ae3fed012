"""Runs a co-simulation FMU by the compiled step of kernel.py; what is no plain success is completed here."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.graph import Node
from pipeline.hosts.fmu.description import FmuError
from pipeline.hosts.fmu.instance import Instance
from pipeline.hosts.fmu.library import CALLS, DISCARD
from pipeline.hosts.fmu.table import DO_STEP, INSTANCE, RETURNED

_STEP = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int)
_STEP_3 = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *[ctypes.c_void_p] * 4
)
REACHED_NS = 0.5  # an FMU that ends a step so near to its end has made it: times are whole nanoseconds


class Slave(Instance):
    """A co-simulation FMU in this process."""

    def __init__(self, node: Node, vectors: Sequence[np.ndarray], start_ns: int, folder: Path | None = None):
        """As Instance."""
        super().__init__(node, vectors, start_ns, folder)
        from pipeline.hosts.fmu import kernel

        self._step = int(kernel.fmu_step.address or 0)

    @property
    def step(self) -> int:
        """The compiled step."""
        return self._step

    def _finish(self, begin_s: float, end_s: float) -> None:
        """Complete a step that was discarded, ended early or met an event. Raises FmuError."""
        library, status = self.library, int(self._table.words[RETURNED])
        at_s, stands = begin_s, 0
        while True:
            reached_s = self._reached(status, at_s, end_s)
            stands = 0 if reached_s > at_s else stands + 1
            if stands > CALLS:
                raise FmuError(f"{self.file} makes no progress at {at_s:.9g} s, after {CALLS} events there")
            at_s = reached_s
            if (end_s - at_s) * 1e9 < REACHED_NS:
                return
            if not self.component.interface.can_vary_step:
                text = f"{self.file} ended a step early, at {at_s:.9g} s, and cannot take another step size"
                raise FmuError(f"{text} (canHandleVariableCommunicationStepSize){library.last_words()}")
            status = self._do_step(at_s, end_s - at_s)

    def _reached(self, status: int, at_s: float, end_s: float) -> float:
        """Where a call of doStep has led, events met. Raises FmuError where that is nowhere."""
        library = self.library
        if status > DISCARD:
            raise library.failure(f"fmi{library.fmi}DoStep", status)
        if library.fmi < 3:
            if status < DISCARD:
                return end_s
            if library.is_terminated():
                raise FmuError(f"{self.file} ends the simulation{library.last_words()}")
            last_s = library.last_successful_time()
        else:
            needs_event, terminates, is_early = (bool(flag) for flag in self._table.flags)
            if terminates:
                raise FmuError(f"{self.file} ends the simulation{library.last_words()}")
            last_s = float(self._table.last[0]) if is_early or status == DISCARD else end_s
            if not -REACHED_NS <= (last_s - at_s) * 1e9 <= (end_s - at_s) * 1e9 + REACHED_NS:
                text = f"{self.file} says that its step from {at_s:.9g} s to {end_s:.9g} s ended at {last_s:.9g} s"
                raise FmuError(f"{text}{library.last_words()}")
            if needs_event:
                library.meet_event(lambda: None)
                return max(last_s, at_s)
        if status == DISCARD and not at_s < last_s <= end_s:
            function = f"fmi{library.fmi}DoStep".replace("fmi1", "fmi")
            text = f"{function} of {self.file} discards the step and gets no further than {last_s:.9g} s"
            raise FmuError(f"{text}{library.last_words()}; a shorter period may help")
        return last_s

    def _do_step(self, at_s: float, h: float) -> int:
        words, library = self._table.words, self.library
        if library.fmi < 3:
            return _STEP(int(words[DO_STEP]))(int(words[INSTANCE]), at_s, h, 1)
        flags, last = self._table.flags.ctypes.data, self._table.last.ctypes.data
        return _STEP_3(int(words[DO_STEP]))(int(words[INSTANCE]), at_s, h, True, flags, flags + 1, flags + 2, last)
