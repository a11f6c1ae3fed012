"""Hosts do not outlive the nursery that forked them. Authority: the operating system's list of processes."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys

import psutil

from pipeline.hosts.launch import Nursery, source_path

LIMIT_S = 20.0
# The nursery ends before its child can bind its life to it, as where the conductor is killed at that moment.
LATE = """
import os, sys, time
from pipeline.hosts.nursery import become_host

nursery = os.getpid()
print(nursery, flush=True)
if os.fork() == 0:
    while os.getppid() == nursery:
        time.sleep(0.01)
    print(os.getpid(), flush=True)
    wanted = {"name": "a", "secret": "", "endpoint": "unixsock-stream//tmp/nobody", "config": "", "sealed": ""}
    become_host(wanted, os.dup(1), nursery)
"""


def test_forked_too_late():
    words, env = [sys.executable, "-P", "-c", LATE], {**os.environ, "PYTHONPATH": source_path()}
    with subprocess.Popen(words, env=env, stdout=subprocess.PIPE) as nursery:
        _, host = (psutil.Process(int(nursery.stdout.readline())) for _ in range(2))
        left = psutil.wait_procs([host], LIMIT_S)[1]
    for host in left:
        host.kill()
    assert not left


class Quiet(Nursery):
    """Its processes answer once, then no more, as ones that are stopped."""

    def __init__(self) -> None:
        super().__init__()
        self.opened: list[subprocess.Popen] = []

    def open(self) -> None:
        self._socket, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._process, self._limit_s = subprocess.Popen(["sleep", "1000"]), LIMIT_S
        self.opened.append(self._process)
        host = os.pidfd_open(self._process.pid)
        socket.send_fds(its, [str(self._process.pid).encode()], [host])
        os.close(host)
        self.keep = its


def test_one_that_answers_no_more_is_replaced(monkeypatch):
    monkeypatch.setattr("pipeline.hosts.launch.FORK_S", 0.1)
    nursery = Quiet()
    try:
        for n in (1, 2):
            started = nursery.start("a", "", "", None, is_sealed=False)
            assert [started.pid == one.pid for one in nursery.opened] == [*[False] * (n - 1), True]
            assert nursery.opened[0].poll() == (None if n == 1 else -signal.SIGKILL)
    finally:
        nursery.close()
    started.end()
    started.collect()
