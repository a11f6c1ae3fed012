"""Paced runs, missed deadlines, and keys. Authority: the clock, by a wide margin; the local run's digest."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pipeline.hosts.deployment import BusOptions
from pipeline.log.reader import open_log
from pipeline.pacing import Pacing
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
RING = ROOT / "scenarios" / "van_der_pol.yaml"
MASS = ROOT / "scenarios" / "bond_mass.yaml"  # steps of 10 ms
MS = 1_000_000


class Clock:
    """A clock that goes on only as it is told; keys come at given times."""

    def __init__(self, monkeypatch, keys: dict[float, str] | None = None):
        self.now, self._keys = 100.0, {100.0 + t: key for t, key in (keys or {}).items()}
        monkeypatch.setattr("pipeline.pacing.time.monotonic", lambda: self.now)
        monkeypatch.setattr("pipeline.pacing.time.sleep", self.sleep)

    def sleep(self, seconds: float) -> None:
        self.now += seconds

    def key(self, timeout_s: float) -> str:
        pending = [t for t in sorted(self._keys) if t <= self.now + timeout_s]
        if not pending:
            self.sleep(timeout_s)
            return ""
        self.now = max(self.now, pending[0])
        return self._keys.pop(pending[0])


def paced(clock: Clock, rate=None, keys=None, said=None) -> Pacing:
    return Pacing(rate, keys, MS, (said if said is not None else []).append)


def no_interrupt() -> None:
    pass


def test_waits_until_it_is_due(monkeypatch):
    clock = Clock(monkeypatch)
    pacing = paced(clock, rate=2.0)
    pacing.begin(0)
    assert pacing.slice_ticks == 100  # 50 ms of wall time
    for tick in (100, 200, 300):
        clock.now += 0.01
        pacing.wait(tick, no_interrupt)
        assert clock.now == pytest.approx(100.0 + tick / 2000, abs=1e-9)
    assert (pacing.missed, pacing.worst_s) == (0, 0.0)


def test_missed_deadlines_are_counted_against_the_first_timeline(monkeypatch):
    """A slice that takes 80 ms more puts off two that follow, each of which needs 10 of its 50 ms."""
    clock = Clock(monkeypatch)
    pacing = paced(clock, rate=1.0)
    pacing.begin(0)
    for i, took in enumerate((0.01, 0.13, 0.01, 0.01, 0.01)):
        clock.now += took
        pacing.wait(50 * (i + 1), no_interrupt)
    assert pacing.missed == 2
    assert pacing.worst_s == pytest.approx(0.08, abs=1e-9)
    assert clock.now == pytest.approx(100.25, abs=1e-9)


def test_paused_stepped_and_gone_on(monkeypatch):
    """A pause does not count as delay; two single steps in it; then the rest at the rate."""
    clock, said = Clock(monkeypatch, {0.02: " ", 1.0: ".", 2.0: "n", 3.0: " "}), []
    pacing = paced(clock, rate=1.0, keys=None, said=said)
    pacing = Pacing(1.0, clock.key, MS, said.append)
    pacing.begin(0)
    ticks = [0]
    while ticks[-1] < 152:
        ticks.append(ticks[-1] + pacing.slice_ticks)
        pacing.wait(ticks[-1], no_interrupt)
    assert ticks == [0, 50, 51, 52, 102, 152]
    assert clock.now == pytest.approx(103.1, abs=1e-9)
    assert pacing.missed == 0
    assert said == ["paused at t = 0.05 s after the start: space goes on, . makes one step, q ends the run"]


def test_a_key_ends_the_run(monkeypatch):
    clock = Clock(monkeypatch, {0.01: "q"})
    pacing = Pacing(None, clock.key, MS, lambda _: None)
    clock.now += 0.02
    with pytest.raises(KeyboardInterrupt):
        pacing.wait(50, no_interrupt)


def test_rate_does_not_matter_to_the_digest(tmp_path):
    """And a rate that no machine reaches misses its deadlines."""
    scenario = load_scenario(RING, duration="1 s")
    graph = build_graph(scenario)
    plain = run_scenario(scenario, graph, tmp_path / "plain.mcap", Options(), lambda _: None)
    for rate, misses in ((20.0, False), (1e9, True)):
        path = tmp_path / f"{rate}.mcap"
        result = run_scenario(scenario, graph, path, Options(rate=rate), lambda _: None)
        assert result.digest == plain.digest
        assert (result.deadlines["worst_s"] > 0.0) or not misses
        assert (result.deadlines["missed"] > 0) or not misses
        assert result.wall_s >= 1.0 / rate
    assert plain.deadlines == {}


def test_paced_over_zenoh(tmp_path):
    """Not before its time, to the same digest; a delay of two slices is told."""
    scenario = load_scenario(MASS, duration="400 ms")
    graph, delays = build_graph(scenario), [0.1]
    local = run_scenario(scenario, graph, tmp_path / "local.mcap", Options(), lambda _: None)
    options = Options(rate=2.0, bus=BusOptions())

    def delay(_: float) -> None:
        time.sleep(delays.pop() if delays else 0.0)

    result = run_scenario(scenario, graph, tmp_path / "a.mcap", options, delay)
    assert result.digest == local.digest
    assert result.wall_s >= 0.2
    assert result.deadlines["missed"] >= 1
    assert result.deadlines["worst_s"] >= 0.05


@pytest.mark.parametrize("bus", ["local", "zenoh"])
def test_keys_at_a_terminal(bus, tmp_path):
    """Paused, stepped, ended: the log holds the steps, of which keys that came before the run was there make none."""
    ours, its = pty.openpty()
    log, sent = tmp_path / "a.mcap", 0
    words = [sys.executable, "-m", "pipeline.cli", "run", str(MASS), "--rate", "1", "--bus", bus]
    child = subprocess.Popen(
        [sys.executable, "-c", LEAD, *words, "--out", str(log), "--json"],
        stdin=its, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT,
    )  # fmt: skip
    said = _until(child.stderr, b"", 0.0)
    deadline = time.monotonic() + 60
    while b"ends the run" not in said and time.monotonic() < deadline:
        os.write(ours, b".")
        sent += 1
        said += _until(child.stderr, b"ends the run", 1.0)
    paused_s = float(re.search(rb"paused at t = (\S+) s", said)[1])
    os.write(ours, b"..q")
    out, _ = child.communicate(timeout=60)
    assert (child.returncode, json.loads(out)) == (130, {"error": "interrupted"})
    steps = open_log(log).times("ball")[-1] / 1e7 - paused_s / 0.01
    assert steps == pytest.approx(round(steps), abs=1e-6)  # of 10 ms
    assert 2 <= round(steps) < sent + 2  # the first key pauses
    os.close(its)
    os.close(ours)


# Makes its standard input the terminal of a session of its own, as a shell does.
LEAD = """
import fcntl, os, sys, termios
os.setsid()
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execv(sys.argv[1], sys.argv[1:])
"""


def _until(stream, wanted: bytes, seconds: float) -> bytes:
    said, deadline = b"", time.monotonic() + seconds
    while wanted not in said or not wanted:
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([stream], [], [], left)[0]:
            break
        said += os.read(stream.fileno(), 4096)
    return said
