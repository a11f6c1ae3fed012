"""Hosts that offer themselves by `towline host`: admitted, refused, lost, back. Authority: the local run's digest."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
import pytest

from pipeline.errors import HostError
from pipeline.hosts.deployment import BusOptions
from pipeline.run import Options, run_scenario
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
def machine(endpoint: str, *words: str, lead: str = "") -> Iterator[subprocess.Popen]:
    """`towline host --name crane`; lead: Python that it runs first."""
    code = f"{lead}\nimport sys\nfrom pipeline.cli import main\nsys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-c", code, "host", "--connect", endpoint, "--name", "crane", *words]
    child = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield child
    finally:
        child.kill()
        child.communicate(timeout=LIMIT_S)


def test_offered_host_takes_part_in_runs_one_after_another(endpoint, tmp_path):
    """It stays for the next run, and Ctrl-C ends it with status 130."""
    scenario = scenario_of()
    local = run(scenario, tmp_path / "local.mcap", None)
    with machine(endpoint) as crane:
        for i in range(2):
            result = run(scenario, tmp_path / f"{i}.mcap", BusOptions((endpoint,)))
            assert result.digest == local.digest
            assert result.hosts == {name: {"restarts": 0, "late": 0, "refused": 0} for name in ("a", "crane")}
        crane.send_signal(signal.SIGINT)
        _, err = crane.communicate(timeout=LIMIT_S)
    assert crane.returncode == 130
    assert err.splitlines() == [
        f"towline: host crane: offers itself at {endpoint}",
        *["towline: host crane: runs b", "towline: host crane: the run has ended"] * 2,
        "towline: interrupted",
    ]


def test_another_make_is_refused_with_both_sides_named(endpoint, tmp_path):
    lead = "import pipeline.hosts.facts as f; own = dict(f.own()); own['numba'] = '0.1'; f.own = lambda: own"
    with (
        machine(endpoint, lead=lead),
        pytest.raises(HostError, match=r"host crane cannot take part: numba: .*") as error,
    ):
        run(scenario_of(), tmp_path / "a.mcap", BusOptions((endpoint,)))
    assert "at the conductor, 0.1 at crane" in str(error.value)


def test_another_libm_is_warned_of_in_log_and_terminal(endpoint, tmp_path):
    from pipeline.log.reader import open_log

    lead = "import pipeline.hosts.facts as f; own = dict(f.own()); own['libm'] = 'feed'; f.own = lambda: own"
    said: list[str] = []
    with machine(endpoint, lead=lead):
        result = run(scenario_of(), tmp_path / "a.mcap", BusOptions((endpoint,)), said)
    warning = [line for line in said if "rounds otherwise" in line]
    assert len(warning) == 1
    assert "feed at crane" in warning[0]
    assert warning[0] in [text for _, text in open_log(result.log).events()]


def test_host_that_never_comes_is_named(endpoint, tmp_path):
    said: list[str] = []
    with pytest.raises(HostError, match=r"host crane \(b\) was waited for .* start it by towline host --name crane"):
        run(scenario_of(limit="500 ms"), tmp_path / "a.mcap", BusOptions((endpoint,)), said)
    assert said == ["waiting for host crane (b), up to 0.5 s"]


def test_killed_machine_is_waited_for_and_fed(endpoint, tmp_path):
    """Another process takes its place: handshake, snapshot, the open request."""
    scenario, said, stack = scenario_of(), [], []
    local = run(scenario, tmp_path / "local.mcap", None)
    with machine(endpoint) as first:

        def replace_it(simulated_s: float) -> None:
            if simulated_s > 0.5 and not stack:
                first.kill()
                stack.append(threading.Timer(0.5, lambda: stack.append(machine(endpoint)) or stack[-1].__enter__()))
                stack[0].start()

        result = run(scenario, tmp_path / "a.mcap", BusOptions((endpoint,)), said, replace_it)
        stack[1].__exit__(None, None, None)
    assert result.digest == local.digest
    assert result.hosts["crane"]["restarts"] == 1
    assert any("host crane is away in its step at t = " in line for line in said)
    assert "host crane is back" in said


def test_machine_that_does_not_come_back_is_named_with_its_step(endpoint, tmp_path):
    """The run stops after the machine's limit, the log whole up to there."""
    from pipeline.log.reader import open_log

    path, died = tmp_path / "a.mcap", []
    with machine(endpoint) as crane:

        def kill_it(simulated_s: float) -> None:
            if simulated_s > 0.5 and not died:
                died.append(simulated_s)
                crane.kill()

        with pytest.raises(
            HostError, match=r"host crane \(b\) was waited for 1 s in its step at t = .* s; start it by"
        ) as error:
            run(scenario_of(limit="1 s"), path, BusOptions((endpoint,)), monitor=kill_it)
    log = open_log(path)
    assert log.complete
    assert log.metadata("result")["ending"] == str(error.value)
    assert log.times("a")[-1] >= died[0] * 1e9


def test_stopped_machine_is_late_and_goes_on(endpoint, tmp_path):
    """As one that does not answer for two seconds: nothing is started again."""
    scenario, said, stopped = scenario_of(), [], []
    local = run(scenario, tmp_path / "local.mcap", None)
    with machine(endpoint) as crane:

        def stop_it(simulated_s: float) -> None:
            if simulated_s > 0.5 and not stopped:
                stopped.append(crane.pid)
                os.kill(crane.pid, signal.SIGSTOP)
                threading.Timer(2.0, lambda: os.kill(crane.pid, signal.SIGCONT)).start()

        result = run(scenario, tmp_path / "a.mcap", BusOptions((endpoint,)), said, stop_it)
    assert result.digest == local.digest
    assert result.hosts["crane"] | {"refused": 0} == {"restarts": 0, "late": 1, "refused": 0}
    assert any("host crane (b) is late in its step at t = " in line for line in said)


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
