"""Two machines, as network namespaces, on a wire that delays, loses, and breaks. Authority: the local run's digest.

The wire is a pair of TUN devices with this process between them, which holds every packet for 20 ms and drops 1 % of
them, as `tc netem` would; many kernels, those of most containers among them, come without netem.
"""

from __future__ import annotations

import fcntl
import heapq
import json
import os
import random
import select
import shutil
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
DELAY_S, LOSS, PARTITION_S = 0.02, 0.01, 5.0
ADDRESSES = "10.77.0.1", "10.77.0.2"
LIMIT_S = 90.0
# One round trip a tick, 40 ms: four seconds, with about four packets lost.
TEXT = """
duration: 1 s
step: 10 ms
hosts: {b: crane}
machines: {crane: {limit: 60 s}}
components:
  a: {model: motion.van_der_pol, inputs: {neighbour: {from: b.position, delay: true}}}
  b: {model: motion.van_der_pol, inputs: {neighbour: a.position}}
"""
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000  # linux/if_tun.h


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


class Wire:
    """Two namespaces and the packets between them."""

    def __init__(self) -> None:
        self.names = tuple(f"towline{os.getpid()}{end}" for end in "ab")
        self.is_cut = False
        self.carried = self.lost = 0
        self._devices: list[int] = []
        self._is_over = threading.Event()
        for name, address in zip(self.names, ADDRESSES, strict=True):
            ip("netns", "add", name)
            self._devices.append(_tun(name[-14:]))
            ip("link", "set", name[-14:], "netns", name)
            ip("-n", name, "addr", "add", f"{address}/24", "dev", name[-14:])
            for device in (name[-14:], "lo"):
                ip("-n", name, "link", "set", device, "up")
        self._thread = threading.Thread(target=self._carry)
        self._thread.start()

    def _carry(self) -> None:
        dice, under_way, count = random.Random(7), [], 0
        while not self._is_over.is_set():
            wait_s = min(0.05, max(0.0, under_way[0][0] - time.monotonic())) if under_way else 0.05
            for device in select.select(self._devices, [], [], wait_s)[0]:
                packet, count = os.read(device, 1 << 16), count + 1
                is_lost = dice.random() < LOSS
                self.lost += is_lost and not self.is_cut
                if not is_lost and not self.is_cut:
                    heapq.heappush(under_way, (time.monotonic() + DELAY_S, count, self._other(device), packet))
            while under_way and under_way[0][0] <= time.monotonic():
                *_, device, packet = heapq.heappop(under_way)
                os.write(device, packet)
                self.carried += 1

    def _other(self, device: int) -> int:
        return self._devices[1 - self._devices.index(device)]

    def close(self) -> None:
        self._is_over.set()
        self._thread.join()
        for device in self._devices:
            os.close(device)
        for name in self.names:
            ip("netns", "del", name)


def _tun(name: str) -> int:
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TUN | IFF_NO_PI))
    return device


def obstacle() -> str:
    """Why there can be no namespaces here; "" where there can."""
    if shutil.which("ip") is None:
        return "there is no `ip` (apt-get install iproute2)"
    if not os.access("/dev/net/tun", os.R_OK | os.W_OK):
        return "there is no /dev/net/tun to open"
    name = f"towline{os.getpid()}t"
    tried = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True)
    if tried.returncode == 0:
        tried = subprocess.run(["ip", "netns", "exec", name, "true"], capture_output=True, text=True)
        subprocess.run(["ip", "netns", "del", name], capture_output=True)
    return f"network namespaces are not permitted here: {tried.stderr.strip()}" if tried.returncode else ""


@pytest.fixture
def wire() -> Iterator[Wire]:
    reason = obstacle()
    if reason:
        pytest.skip(reason)
    made = Wire()
    yield made
    made.close()


def start(namespace: str, *words: str) -> subprocess.Popen:
    command = ["ip", "netns", "exec", namespace, sys.executable, "-m", "pipeline.cli", *words]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_same_digest(wire, tmp_path):
    """Delay and loss all the time, and a partition in between."""
    scenario = load_scenario_text(TEXT, "wire.yaml", ROOT / "scenarios")
    local = run_scenario(scenario, build_graph(scenario), tmp_path / "local.mcap", Options(), lambda _: None)
    (tmp_path / "wire.yaml").write_text(TEXT)
    endpoint = f"tcp/{ADDRESSES[0]}:7447"
    crane = start(wire.names[1], "host", "--connect", endpoint, "--name", "crane", "--once")
    words = ["--bus", "zenoh", "--listen", endpoint, "--out", str(tmp_path / "a.mcap"), "--json"]
    conductor = start(wire.names[0], "run", str(tmp_path / "wire.yaml"), *words)
    try:
        assert any("runs b" in line for line in crane.stderr)
        time.sleep(1.0)  # of about four
        wire.is_cut = True
        time.sleep(PARTITION_S)
        wire.is_cut = False
        out, err = conductor.communicate(timeout=LIMIT_S)
        _, said = crane.communicate(timeout=LIMIT_S)
    finally:
        for process in (conductor, crane):
            process.kill()
            process.wait()
    result = json.loads(out)
    assert (conductor.returncode, crane.returncode) == (0, 0)
    assert result["digest"] == local.digest
    assert wire.lost > 0
    assert "host crane (b) is late" in err
    print(result["wall_s"], result["hosts"], wire.carried, wire.lost, err, said)
