"""Hosts that offer themselves by `towline host`: admitted, refused, lost, back. Authority: the local run's digest."""

from __future__ import annotations

import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import psutil
import pytest

from pipeline.bus.local import LocalBus
from pipeline.bus.messages import ASSIGN, pack, unpack
from pipeline.bus.zenoh import APPEARED, VANISHED, Address, Change
from pipeline.distributed import Distributed
from pipeline.errors import HostError
from pipeline.hosts.deployment import BusOptions, InProcess
from pipeline.log.reader import open_log
from pipeline.placement import placement_of
from pipeline.run import Options, Result, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
TEXT = """
duration: {seconds} s
step: 10 ms
hosts: {{b: crane}}
machines: {{crane: {{limit: {limit}}}}}
components:
  a: {{model: motion.van_der_pol, inputs: {{neighbour: {{from: b.position, delay: true}}}}}}
  b: {{model: motion.van_der_pol, inputs: {{neighbour: a.position}}}}
"""
LIMIT_S = 60.0


def scenario_of(seconds: float = 2, limit: str = "30 s"):
    return load_scenario_text(TEXT.format(seconds=seconds, limit=limit), "machines.yaml", ROOT / "scenarios")


def run(scenario, path, options: BusOptions | None, said: list[str] | None = None, monitor=lambda _: None):
    tell = said.append if said is not None else lambda _: None
    return run_scenario(scenario, build_graph(scenario), path, Options(bus=options, tell=tell), monitor)


@pytest.fixture
def endpoint() -> str:
    """A port of the loopback that is free."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@contextmanager
def machine(endpoint: str, *words: str) -> Iterator[subprocess.Popen]:
    """`towline host --name crane`."""
    command = [sys.executable, "-m", "pipeline.cli", "host", "--connect", endpoint, "--name", "crane", *words]
    child = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield child
    finally:
        child.kill()
        child.communicate(timeout=LIMIT_S)


def test_offered_host_takes_part_in_runs_one_after_another(endpoint, tmp_path):
    """It stays for the next run, in which it does not answer for two seconds; Ctrl-C ends it with status 130."""
    scenario, said, stopped = scenario_of(), [], []
    local = run(scenario, tmp_path / "local.mcap", None)
    with machine(endpoint) as crane:

        def stop_it(simulated_s: float) -> None:
            if simulated_s > 0.5 and not stopped:
                stopped.append(crane.pid)
                os.kill(crane.pid, signal.SIGSTOP)
                threading.Timer(2.0, lambda: os.kill(crane.pid, signal.SIGCONT)).start()

        result = run(scenario, tmp_path / "a.mcap", BusOptions((endpoint,)))
        assert result.digest == local.digest
        assert result.hosts == {name: {"restarts": 0, "late": 0, "refused": 0} for name in ("a", "crane")}
        result = run(scenario, tmp_path / "b.mcap", BusOptions((endpoint,)), said, stop_it)
        assert result.digest == local.digest
        assert result.hosts["crane"] | {"refused": 0} == {"restarts": 0, "late": 1, "refused": 0}
        assert any("host crane (b) is late in its step at t = " in line for line in said)
        crane.send_signal(signal.SIGINT)
        _, err = crane.communicate(timeout=LIMIT_S)
    assert crane.returncode == 130
    assert err.splitlines() == [
        f"towline: host crane: offers itself at {endpoint}",
        *["towline: host crane: runs b", "towline: host crane: the run has ended"] * 2,
        "towline: interrupted",
    ]


def test_killed_machine_is_waited_for_and_fed(endpoint, tmp_path):
    """Another process takes its place: handshake, snapshot, the open request. When that is killed, nobody does."""
    scenario, said, second = scenario_of(), [], []
    local = run(scenario, tmp_path / "local.mcap", None)
    with machine(endpoint) as first, ExitStack() as after:

        def replace_it(simulated_s: float) -> None:
            if simulated_s > 0.5 and not second:
                first.kill()
                second.append(after.enter_context(machine(endpoint)))

        result = run(scenario, tmp_path / "a.mcap", BusOptions((endpoint,)), said, replace_it)
        assert result.digest == local.digest
        assert result.hosts["crane"]["restarts"] == 1
        # In its step or between two: whichever the conductor is at when it hears of the death.
        assert any(re.match(r"host crane is away( in its step at t = .* s)?: waiting for it", line) for line in said)
        assert "host crane is back" in said
        missed(endpoint, tmp_path / "b.mcap", second[0])


def missed(endpoint: str, path: Path, crane: subprocess.Popen) -> None:
    """A machine that does not come back is named with its step, after its limit; the log is whole up to there."""
    died: list[float] = []

    def kill_it(simulated_s: float) -> None:
        if simulated_s > 0.5 and not died:
            died.append(simulated_s)
            crane.kill()

    waited = r"host crane \(b\) was waited for 1 s in its step at t = .* s; start it by"
    with pytest.raises(HostError, match=waited) as error:
        run(scenario_of(limit="1 s"), path, BusOptions((endpoint,)), monitor=kill_it)
    log = open_log(path)
    assert log.complete
    assert log.metadata("result")["ending"] == str(error.value)
    assert log.times("a")[-1] >= died[0] * 1e9


def by(bus: LocalBus, scenario, monkeypatch, said: list[str]) -> Callable[..., Result]:
    """Runs a scenario whose hosts are on a bus in this process."""
    graph, deployment = build_graph(scenario), InProcess()
    deployment.open = lambda _: setattr(deployment, "_bus", bus) or bus
    conductor = Distributed(graph, placement_of(graph, scenario.hosts, {}), deployment)
    conductor.tell = said.append
    monkeypatch.setattr("pipeline.run.conductor_of", lambda *_: conductor)
    return partial(run_scenario, scenario, graph)


class Abroad(LocalBus):
    """A bus in this process; the host on another machine is told, and tells, other facts."""

    def __init__(self, key: str, value: str):
        super().__init__()
        self._key, self._value = key, value
        self.start("crane")

    def _other(self, data: bytes) -> bytes:
        message = unpack(data)
        said = json.loads(message.text)
        said["facts"][self._key] = self._value
        return pack(message._replace(text=json.dumps(said).encode()))

    def send(self, address: Address, data: bytes) -> None:
        is_there = address[0] == "crane" and unpack(data).kind == ASSIGN
        super().send(address, self._other(data) if is_there else data)
        if is_there:
            self._replies[address].append(self._other(self._replies[address].pop()))


def test_another_make_is_refused_with_both_sides_named(tmp_path, monkeypatch):
    go = by(Abroad("numba", "0.1"), scenario_of(), monkeypatch, [])
    with pytest.raises(HostError, match=r"host crane cannot take part: numba: 0.1 at the conductor, .* at crane"):
        go(tmp_path / "a.mcap", Options(), lambda _: None)


def test_another_libm_is_warned_of_in_log_and_terminal(tmp_path, monkeypatch):
    said: list[str] = []
    result = by(Abroad("libm", "feed"), scenario_of(), monkeypatch, said)(
        tmp_path / "a.mcap", Options(), lambda _: None
    )
    warning = [line for line in said if "rounds otherwise" in line]
    assert len(warning) == 1
    assert "feed at crane" in warning[0]
    assert warning[0] in [text for _, text in open_log(result.log).events()]


def test_host_that_never_comes_is_named(tmp_path, monkeypatch):
    said: list[str] = []
    go = by(LocalBus(), scenario_of(limit="100 ms"), monkeypatch, said)
    with pytest.raises(HostError, match=r"host crane \(b\) was waited for .* start it by towline host --name crane"):
        go(tmp_path / "a.mcap", Options(), lambda _: None)
    assert said == ["waiting for host crane (b), up to 0.1 s"]


class TwoCranes(LocalBus):
    """A bus in this process on which two machines offer themselves, one after the other."""

    def __init__(self) -> None:
        super().__init__()
        self.cranes = [self.start("crane")[0] for _ in range(2)]

    def attach(self, host: str, process: str) -> None:
        self.attached = process

    def lose(self, process: str) -> None:
        self._changes.append(Change(VANISHED, "crane", process))


@pytest.mark.parametrize("lost", [(0,), (1, 0)])
def test_another_machine_of_that_name(lost, tmp_path, monkeypatch):
    """It is kept for when the first one goes, unless it has gone before."""
    scenario, said, bus, left = scenario_of(limit="300 ms"), [], TwoCranes(), list(lost)
    local = run(scenario, tmp_path / "local.mcap", None)

    def lose(simulated_s: float) -> None:
        if simulated_s > 0.5 and left:
            bus.lose(bus.cranes[left.pop(0)])

    go = partial(by(bus, scenario, monkeypatch, said), tmp_path / "a.mcap", Options(slice_ticks=10), lose)
    if len(lost) == 2:
        with pytest.raises(HostError, match=r"host crane \(b\) was waited for"):
            go()
    else:
        assert go().digest == local.digest
        assert bus.attached == bus.cranes[1]
        assert "host crane is back" in said
    assert "another process offers itself as crane: it is kept for when this one goes" in said


def test_process_that_was_given_up_is_no_stranger(tmp_path, monkeypatch):
    """A conductor that was stopped for a while finds its processes gone, and back before they are killed."""
    scenario, said, bus = scenario_of(), [], TwoCranes()
    local = run(scenario, tmp_path / "local.mcap", None)

    def stop(simulated_s: float) -> None:
        if simulated_s > 0.5 and not any("died" in line for line in said):
            first = next(process for host, process in bus._hosts if host == "a")
            bus._changes.extend(Change(kind, "a", first) for kind in (VANISHED, APPEARED))

    result = by(bus, scenario, monkeypatch, said)(tmp_path / "a.mcap", Options(slice_ticks=10), stop)
    assert result.digest == local.digest
    assert not any("another process offers itself as a" in line for line in said)


def test_machine_gives_a_dead_conductor_up(endpoint, tmp_path):
    """A conductor that is killed leaves its machines free for the next one, after the run's limit."""
    path = tmp_path / "machines.yaml"
    path.write_text(TEXT.format(seconds=100, limit="1 s"))
    words = ["run", str(path), "--bus", "zenoh", "--listen", endpoint, "--rate", "1", "--out", str(tmp_path / "a.mcap")]
    with machine(endpoint, "--once") as crane:
        conductor = subprocess.Popen([sys.executable, "-m", "pipeline.cli", *words], cwd=ROOT, stderr=subprocess.PIPE)
        lines = iter(crane.stderr.readline, "")
        assert any("runs b" in line for line in lines)
        family = psutil.Process(conductor.pid).children(recursive=True)
        conductor.kill()
        conductor.communicate(timeout=LIMIT_S)
        assert any("its run is given up" in line for line in lines)
        assert not psutil.wait_procs(family, timeout=5.0)[1]
        scenario = scenario_of(limit="30 s")
        local = run(scenario, tmp_path / "local.mcap", None)
        assert run(scenario, tmp_path / "b.mcap", BusOptions((endpoint,))).digest == local.digest
        deadline = time.monotonic() + LIMIT_S
        while crane.poll() is None and time.monotonic() < deadline:
            time.sleep(0.05)
        assert crane.returncode == 0
