"""Starts hosts as processes of this machine, by a nursery, and ends them; none outlives the conductor."""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import components
from pipeline.errors import HostError

_ROOT = Path(components.__file__).parent.parent
READY_S = 60.0  # wall time that the nursery may take to import everything
FORK_S = 5.0  # the same until it has forked a host, once it has answered
TRIES = 3  # of starting a host, should somebody kill the nursery meanwhile
POLL_S = 0.05  # between looks whether the nursery is still there


class LocalProcess:
    """A host's process. What it writes to its standard streams is kept until it is collected."""

    def __init__(self, pid: int, descriptor: int, output: IO[bytes]):
        """descriptor: of the process, as pidfd_open gives it."""
        self.pid = pid
        self._descriptor, self._output = descriptor, output
        self._poll = select.poll()
        self._poll.register(descriptor, select.POLLIN)

    def is_alive(self) -> bool:
        """Whether it runs."""
        return not self._poll.poll(0)

    def end(self, within_s: float = 0.0) -> None:
        """Wait for it to end by itself, then kill it; it is gone afterwards."""
        if not self._poll.poll(1000 * within_s):
            signal.pidfd_send_signal(self._descriptor, signal.SIGKILL)
            self._poll.poll()

    def collect(self) -> str:
        """What it wrote; to be called once, after its end."""
        os.close(self._descriptor)
        with self._output as output:
            output.seek(0)
            return output.read().decode(errors="replace")


class Nursery:
    """The process that forks hosts; another is started if somebody has killed it."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._socket: socket.socket | None = None
        self._limit_s = READY_S

    def open(self) -> None:
        """Start it; it imports in the meantime. Raises HostError."""
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "pipeline.hosts.nursery", str(os.getpid())],
                stdin=its.fileno(),
                stdout=subprocess.DEVNULL,
                env={**os.environ, "PYTHONPATH": source_path()},
                process_group=0,  # Ctrl-C at the terminal is the conductor's
            )
        except OSError as error:
            ours.close()
            raise HostError(f"cannot start a process for hosts: {error}") from error
        finally:
            its.close()
        self._socket, self._limit_s = ours, READY_S

    def start(self, host: str, secret: str, endpoint: str, config: Path | None, *, is_sealed: bool) -> LocalProcess:
        """A host that offers itself at the endpoint, with the identity of this secret. Raises HostError."""
        sealed = "yes" if is_sealed else ""
        wanted = {"name": host, "secret": secret, "endpoint": endpoint, "config": str(config or ""), "sealed": sealed}
        for left in reversed(range(TRIES)):
            if self._process is None or self._process.poll() is not None:
                self.close()
                self.open()
            try:
                return self._ask(json.dumps(wanted).encode())
            except (OSError, ValueError) as error:  # it has been killed or stopped meanwhile
                self.close()
                if not left:
                    raise HostError(f"the process that starts hosts fails: {error}") from error
        raise AssertionError("unreachable")

    def _ask(self, wanted: bytes) -> LocalProcess:
        """Raises OSError or ValueError where no answer comes."""
        assert self._socket is not None
        output = TemporaryFile()  # noqa: SIM115 - closed by collect()
        try:
            socket.send_fds(self._socket, [wanted], [output.fileno()])
            _await_answer(self._socket, self._limit_s)
            pid, (descriptor,), _, _ = socket.recv_fds(self._socket, 64, 1)
            self._limit_s = FORK_S
        except BaseException:
            output.close()
            raise
        return LocalProcess(int(pid), descriptor, output)

    def close(self) -> None:
        """End it, and with it all hosts that are left."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        if self._socket is not None:
            self._socket.close()
        self._process = self._socket = None


def source_path() -> str:
    """PYTHONPATH for a process that is to import what this one has imported."""
    return os.pathsep.join(filter(None, (str(_ROOT), os.environ.get("PYTHONPATH"))))


def _await_answer(link: socket.socket, limit_s: float) -> None:
    """Raises OSError where none comes."""
    until = time.monotonic() + limit_s
    while not select.select([link], [], [], POLL_S)[0]:
        if time.monotonic() > until:
            raise TimeoutError(f"it did not answer within {limit_s:g} s")
