"""Runs an FMU in a process of its own, so that its crash or hang costs neither the run nor the log.

The process is not started again: what an FMU does is repeated by the same inputs, its crash too.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import weakref
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import numpy as np

from components.contract import HEADER
from pipeline.fmu.archive import extracted
from pipeline.graph import Node
from pipeline.hosts.fmu import link
from pipeline.hosts.fmu.base import FmuHost
from pipeline.hosts.fmu.description import FmuError
from pipeline.hosts.launch import source_path

OVERDUE_S = 1.0  # as of any component that is not stepped in the conductor's process
START_S = 60.0  # wall time that loading, initialising, saving or restoring may take
END_S = 2.0  # that it is given to end by itself
LAST_WORDS = 200  # characters


class Process:
    """The process of one FMU. What it writes to its standard streams is kept for its last words."""

    def __init__(self) -> None:
        """Start it. Raises FmuError."""
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        self.link = ours
        self._output: IO[bytes] = TemporaryFile()  # noqa: SIM115 - closed by end()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "pipeline.hosts.fmu.process", str(os.getpid())],
                stdin=its.fileno(),
                stdout=self._output,
                stderr=self._output,
                env={**os.environ, "PYTHONPATH": source_path()},
                process_group=0,  # Ctrl-C at the terminal is the conductor's
            )
        except OSError as error:
            raise FmuError(f"cannot start a process for an FMU: {error}") from error
        finally:
            its.close()

    def ask(self, kind: int, within_s: float, t_ns: int = 0, dt_ns: int = 0, data: bytes = b"") -> bytes:
        """A request and its answer. Raises FmuError."""
        try:
            link.ask(self.link, kind, t_ns, dt_ns, data)
            status, found = link.answered(self.link, within_s)
        except link.EndedError as error:
            raise FmuError(f"the process of its FMU {self._how_it_ended()}{self._last_words()}") from error
        except link.SilenceError as error:
            self._process.kill()
            text = f"its FMU has not returned for {within_s:g} s, and its process was ended"
            raise FmuError(f"{text}; a call that takes longer needs `overdue:`{self._last_words()}") from error
        if status != link.ALL_FINE:
            raise FmuError(found.decode(errors="replace"))
        return found

    def _how_it_ended(self) -> str:
        code = self._process.wait()
        if code >= 0:
            return f"ended with status {code}, which the FMU brought about"
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        return f"was killed by {name}"

    def _last_words(self) -> str:
        self._output.seek(0)
        lines = self._output.read().decode(errors="replace").strip().splitlines()
        return f"; its last words: {lines[-1].strip()[:LAST_WORDS]}" if lines else ""

    def end(self) -> None:
        """End it, by force if need be."""
        if self._output.closed:
            return
        try:
            link.ask(self.link, link.END)
            self._process.wait(END_S)
        except (link.EndedError, subprocess.TimeoutExpired):
            self._process.kill()
            self._process.wait()
        self.link.close()
        self._output.close()


class Apart(FmuHost):
    """An FMU in a process of its own."""

    def __init__(self, node: Node, vectors: Sequence[np.ndarray], start_ns: int):
        """As FmuHost."""
        super().__init__(node, vectors, start_ns)
        self._process: Process | None = None
        self._folder: Path | None = None

    def take_messages(self) -> list[str]:
        """See FmuHost."""
        if self._process is None or self.error is not None:
            return []
        try:
            return json.loads(self._process.ask(link.MESSAGES, START_S))
        except FmuError:  # the next step tells
            return []

    def save(self) -> bytes:
        """See FmuHost."""
        assert self._process is not None
        return self._process.ask(link.SAVE, START_S)

    def restore(self, data: bytes) -> None:
        """See FmuHost."""
        self._begin().ask(link.RESTORE, START_S, data=data)

    def close(self) -> None:
        """See FmuHost."""
        if self._process is not None:
            self._process.end()
        super().close()

    def _init(self, t_ns: int, dt_ns: int, *vectors: np.ndarray) -> int:
        self._begin()
        return self._make(link.INIT, max(START_S, self.component.overdue_s), t_ns, dt_ns, vectors)

    def _advance(self, t_ns: int, dt_ns: int, *vectors: np.ndarray) -> int:
        return self._make(link.STEP, self.component.overdue_s or OVERDUE_S, t_ns, dt_ns, vectors)

    def _make(self, kind: int, within_s: float, t_ns: int, dt_ns: int, vectors: tuple[np.ndarray, ...]) -> int:
        assert self._process is not None
        p, u, _, y, _ = vectors
        data = p[HEADER:].tobytes() + u.tobytes()
        y[:] = np.frombuffer(self._process.ask(kind, within_s, t_ns, dt_ns, data), np.float64)
        return 0

    def _begin(self) -> Process:
        """Start the process and have it load the FMU. Raises FmuError."""
        if self._folder is None:
            self._folder = self.files.enter_context(extracted(self.component.description.path))
        if self._process is not None:
            self._process.end()
        self._process = Process()
        weakref.finalize(self, self._process.end)
        wanted = {
            "path": str(self.component.description.path),
            "hash": self.component.description.digest,
            "folder": str(self._folder),
            "interface": self.component.interface.name,
            "name": self.name,
            "parameters": self.parameters.model_dump(mode="json"),
            "start_ns": self.start_ns,
        }
        self._process.ask(link.BEGIN, START_S, data=json.dumps(wanted).encode())
        return self._process
