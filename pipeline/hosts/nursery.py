"""A process that has imported the compiler and forks a host in milliseconds; it dies with the conductor, they with it.

It opens no session and starts no thread, so that forking is safe.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
import traceback
from pathlib import Path

from pipeline.hosts.death import die_with

REQUEST_BYTES = 1 << 16


def main() -> None:
    """Fork a host for each request on the socket that is standard input, until that closes.

    A request is JSON with the descriptor that takes the host's output; the answer is the id and a descriptor of the
    host's process.
    """
    if not die_with(int(sys.argv[1])):
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGCHLD, _reap)
    with socket.socket(fileno=os.dup(0)) as conductor:
        _import()
        while True:
            data, descriptors, _, _ = socket.recv_fds(conductor, REQUEST_BYTES, 1)
            if not data:
                return
            wanted, nursery = json.loads(data), os.getpid()
            pid = os.fork()
            if pid == 0:
                conductor.close()
                become_host(wanted, descriptors[0], nursery)
            descriptor = os.pidfd_open(pid)
            os.close(descriptors[0])
            socket.send_fds(conductor, [str(pid).encode()], [descriptor])
            os.close(descriptor)


def _reap(_number: int, _frame: object) -> None:
    """Take note of the hosts that have ended."""
    try:
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass
    except ChildProcessError:
        return


def _import() -> None:
    """Load what every host needs, machine code of the loop included."""
    import zenoh  # noqa: F401

    from pipeline import native_loop
    from pipeline.graph import Graph
    from pipeline.hosts import facts, serving  # noqa: F401
    from pipeline.memory import lay_out

    facts.own()
    memory = lay_out(Graph(base_ns=1, ticks=0, nodes=(), stages=(), board=0))
    native_loop.prepare(memory.tables, memory.inits)


def become_host(wanted: dict[str, str], output: int, nursery: int) -> None:
    """In the child of the nursery of that id: serve while it is there, and never return."""
    status = 1
    try:
        for standard in (1, 2):
            os.dup2(output, standard)
        sys.stdout, sys.stderr = (os.fdopen(standard, "w", buffering=1) for standard in (1, 2))
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        if die_with(nursery):
            from pipeline.hosts.process import serve

            config = Path(wanted["config"]) if wanted["config"] else None
            secret, is_sealed = wanted["secret"], bool(wanted["sealed"])
            serve(wanted["name"], [wanted["endpoint"]], secret, config, is_sealed=is_sealed, is_once=True)
            status = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


if __name__ == "__main__":
    main()
