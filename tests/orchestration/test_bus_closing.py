"""Closing a bus raises nothing and ends, whatever the other side does. Authority: zenoh's own behaviour, provoked."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import zenoh

from pipeline.bus.configuration import close_session
from pipeline.bus.identity import Identity
from pipeline.bus.zenoh import APPEARED, VANISHED, ConductorBus, HostBus
from pipeline.hosts.launch import source_path

LIMIT_S = 60.0
HOST = """
import sys, time
from pipeline.bus.identity import Identity
from pipeline.bus.zenoh import HostBus
bus = HostBus("crane", [sys.argv[1]], Identity(), look_s=0.05, is_sealed=False)
time.sleep(1000)
"""


@pytest.fixture
def bus():
    bus = ConductorBus(7, [], look_s=0.05)
    yield bus
    bus.close()


def change(bus: ConductorBus) -> tuple[str, tuple[str, str]]:
    until = time.monotonic() + LIMIT_S
    while time.monotonic() < until:
        bus.receive(None)
        for kind, host, process in bus.changes():
            return kind, (host, process)
    raise TimeoutError


def test_closed_twice_and_what_is_left_afterwards(bus):
    folder = Path(bus.endpoint.removeprefix("unixsock-stream/")).parent
    assert folder.is_dir()
    before = threading.active_count()
    for _ in range(2):
        bus.close()
    assert not folder.exists()
    assert threading.active_count() < before


def test_a_host_closes_after_its_conductor(bus):
    host = HostBus("crane", [bus.endpoint], Identity(), look_s=0.05, is_sealed=False)
    kind, address = change(bus)
    assert (kind, address[0]) == (APPEARED, "crane")
    bus.attach(*address)
    bus.send(address, b"to")
    host.receive()
    host.send(b"fro")
    assert bus.receive(address) == b"fro"
    bus.close()
    for _ in range(2):
        host.close()


@pytest.mark.parametrize(("run", "is_there"), [(7, True), (8, False)])
def test_a_host_follows_whom_it_finds(run, is_there, bus):
    """A conductor may have died while the host was compiling for it."""
    host = HostBus("crane", [bus.endpoint], Identity(), look_s=0.05, is_sealed=False)
    _, address = change(bus)
    bus.attach(*address)
    bus.send(address, b"to")
    assert host.receive() == b"to"
    host.follow(run)
    assert host.is_led == is_there
    host.close()


def test_session_that_zenoh_cannot_close():
    """As it says where it gives up waiting."""

    class Stuck:
        def close(self) -> None:
            raise zenoh.ZError("close operation timed out!")

    close_session(Stuck())


def test_a_peer_that_takes_nothing(bus):
    """Stopped, as behind a broken wire: sending waits until zenoh drops it, and closing does not raise."""
    child = subprocess.Popen(
        [sys.executable, "-P", "-c", HOST, bus.endpoint], env={**os.environ, "PYTHONPATH": source_path()}
    )
    try:
        _, address = change(bus)
        bus.attach(*address)
        os.kill(child.pid, signal.SIGSTOP)
        flood = threading.Thread(target=lambda: send_until_refused(bus, address), daemon=True)
        flood.start()
        time.sleep(0.5)
        assert flood.is_alive()  # it waits
        began = time.monotonic()
        bus.close()
        assert time.monotonic() - began < 25.0  # 5 s of the sender's wait and 10 s of closing, and a busy machine
    finally:
        child.kill()
        child.wait()
    flood.join(LIMIT_S)
    assert not flood.is_alive()


def send_until_refused(bus: ConductorBus, address: tuple[str, str]) -> None:
    try:
        for _ in range(1000):
            bus.send(address, bytes(100_000))
    except zenoh.ZError:
        return


def test_a_host_that_is_killed_vanishes_at_once(bus):
    child = subprocess.Popen(
        [sys.executable, "-P", "-c", HOST, bus.endpoint], env={**os.environ, "PYTHONPATH": source_path()}
    )
    try:
        appeared = change(bus)
        child.kill()
        assert change(bus) == (VANISHED, appeared[1])
    finally:
        child.kill()
        child.wait()
