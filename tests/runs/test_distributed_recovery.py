"""Hosts that die or hang, and a conductor that dies: the run goes on to the undisturbed digest, or says why it cannot.

Authority: the local run's digest; the operating system's list of processes.
"""

from __future__ import annotations

import importlib.util
import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from pipeline.errors import HostError
from pipeline.hosts.deployment import BusOptions
from pipeline.log.reader import open_log
from pipeline.rerun import graph_of
from pipeline.resume import resume_run
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
POOL = ROOT / "scenarios" / "pool_chain.yaml"
LIMIT_S = 60.0
# A component of 20 000 numbers of state, which come with every third reply only, and one that fails as `how` says.
COMPONENT = '''
"""Counts in all of its state; at 0.5 s it fails once, or always."""
import os, signal, time
from pathlib import Path
from components.contract import Component, Parameters, Port, Sizes

def fail():
    {how}

def init(t_ns, dt_ns, p, u, x, y, w):
    x[:] = 1.0
    y[0] = 1.0
    return 0

def step(t_ns, dt_ns, p, u, x, y, w):
    x *= 1.001
    y[0] = x.sum() + u[0]
    if t_ns == 500_000_000 and {when}:
        mark = Path({mark!r})
        if not mark.exists():
            {touch}
            fail()
    return 0

COMPONENT = Component(
    name="failing", parameters=Parameters, init=init, step=step, compiled=False, sizes=lambda _: Sizes(state=20_000),
    inputs=lambda _: (Port("neighbour", "1"),), outputs=lambda _: (Port("out", "1"),),
)
'''
SCENARIO = """
duration: 1 s
step: 10 ms
components:
  ring: {model: motion.van_der_pol, inputs: {neighbour: {from: failing.out, delay: true}}}
  failing: {model: ./failing.py, overdue: 300 ms, inputs: {neighbour: ring.position}}
"""
WAYS = {
    "killed": "os.kill(os.getpid(), signal.SIGKILL)",
    "hangs": "time.sleep(1000)",
    "stopped": "os.kill(os.getpid(), signal.SIGSTOP)",
}
# Ends, but not for ever, so that a run which never gives up is seen.
ENDING = "tries = Path('tries').open('ab'); tries.write(b'x'); tries.flush(); tries.tell() > 12 or os._exit(3)"
ONCE = {**WAYS, "slow": "time.sleep(0.2)"}


def failing(folder: Path, way: str, *, always: bool = False):
    mark = folder / "failed"
    touch = "pass" if always else "mark.touch()"
    only_hosts = f"os.getpid() != {os.getpid()}"
    text = COMPONENT.format(how=ONCE[way], mark=str(mark), touch=touch, when=only_hosts)
    (folder / "failing.py").write_text(text)
    return load_scenario_text(SCENARIO, "failing.yaml", folder)


def run(scenario, path, bus=None, tell=lambda _: None):
    return run_scenario(scenario, build_graph(scenario), path, Options(bus=bus, tell=tell), lambda _: None)


@pytest.mark.parametrize("way", WAYS)
def test_fails_once_within_a_step(way, tmp_path):
    """It is named with its step, started again, restored and fed; the log tells, the digest does not."""
    scenario, said, when = failing(tmp_path, way), [], []

    def tell(text: str) -> None:
        said.append(text)
        when.append(time.time())

    local = run(scenario, tmp_path / "local.mcap")
    result = run(scenario, tmp_path / "zenoh.mcap", BusOptions(), tell)
    assert result.digest == local.digest
    assert result.hosts["failing"] == {"restarts": 1, "late": int(way != "killed"), "refused": 0}
    what = "died" if way == "killed" else "has not answered for 0.3 s"
    assert said == [f"host failing (failing) {what} in its step at t = 0.5 s: started again"]
    assert [text for _, text in open_log(result.log).events()] == said
    after_s = when[0] - (tmp_path / "failed").stat().st_mtime
    assert after_s < 1.0  # 0.3 s of being overdue where it hangs, and looks 0.05 s apart
    assert after_s > 0.25 or what == "died"


def test_fails_always(tmp_path):
    """The run stops, naming host, component and step; the log is whole up to there."""
    scenario = failing(tmp_path, "hangs", always=True)
    late = r"host failing \(failing\) has not .* in its step at t = 0.5 s, 5 times in a row; .* needs `overdue:`"
    with pytest.raises(HostError, match=late) as error:
        run(scenario, tmp_path / "zenoh.mcap", BusOptions())
    log = open_log(tmp_path / "zenoh.mcap")
    assert log.complete
    assert log.metadata("result")["ending"] == str(error.value)
    assert log.times("ring")[-1] == 490_000_000
    assert not psutil.Process().children(recursive=True)


# Three sections a tick: big on p, then middle on q, then failing on p. big's state comes with every third reply only.
TWO_SECTIONS = """
duration: 1 s
step: 10 ms
hosts: {big: p, middle: q, failing: p}
components:
  big: {model: ./big.py, inputs: {neighbour: {from: failing.out, delay: true}}}
  middle: {model: motion.van_der_pol, inputs: {neighbour: big.out}}
  failing: {model: ./failing.py, inputs: {neighbour: middle.position}}
"""


def test_fails_always_behind_another_section_of_its_host(tmp_path, monkeypatch):
    """What is fed to that one, and answered, is no progress."""
    monkeypatch.chdir(tmp_path)
    fail = COMPONENT.format(how=ENDING, mark=str(tmp_path / "mark"), touch="pass", when=f"os.getpid() != {os.getpid()}")
    (tmp_path / "failing.py").write_text(fail)
    (tmp_path / "big.py").write_text(COMPONENT.format(how="pass", mark="", touch="pass", when="False"))
    scenario = load_scenario_text(TWO_SECTIONS, "two.yaml", tmp_path)
    died = r"host p \((big, )?failing\) died in its step at t = 0.5 s, 5 times in a row$"
    with pytest.raises(HostError, match=died):
        run(scenario, tmp_path / "zenoh.mcap", BusOptions())
    assert not psutil.Process().children(recursive=True)


def test_getting_ready_does_not_count_as_overdue(tmp_path, monkeypatch):
    """Nor is a process of this machine asked again for what takes a while: nothing comes twice, to be refused."""
    monkeypatch.setattr("pipeline.hosts.supervisor.REPEAT_S", 0.05)
    slow = f"\nif os.getpid() != {os.getpid()}:\n    time.sleep(1.0)\n"
    scenario = failing(tmp_path, "slow")
    (tmp_path / "failing.py").write_text((tmp_path / "failing.py").read_text() + slow)
    scenario = load_scenario_text(SCENARIO.replace("300 ms", "800 ms"), "failing.yaml", tmp_path)
    said: list[str] = []
    result = run(scenario, tmp_path / "zenoh.mcap", BusOptions(), said.append)
    assert (tmp_path / "failed").exists()
    assert result.hosts["failing"] == {"restarts": 0, "late": 0, "refused": 0}
    assert not said


def test_file_model_edited_during_the_run(tmp_path):
    """A host that is started again would take up the new one: refused, the log whole up to there."""
    scenario = failing(tmp_path, "killed")
    path, text = tmp_path / "failing.py", (tmp_path / "failing.py").read_text()

    def edit(_: float) -> None:
        path.write_text(text.replace("1.001", "1.002"))

    options = Options(bus=BusOptions(), slice_ticks=10)
    with pytest.raises(HostError, match=r"host failing cannot take part: .*failing.py differs from the conductor's"):
        run_scenario(scenario, build_graph(scenario), tmp_path / "a.mcap", options, edit)
    log = open_log(tmp_path / "a.mcap")
    assert log.complete
    assert log.times("ring")[-1] == 490_000_000


def test_random_strikes():
    """The benchmark's strikes, fewer of them."""
    spec = importlib.util.spec_from_file_location("chaos", ROOT / "tests" / "benchmarks" / "chaos.py")
    chaos = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = chaos
    spec.loader.exec_module(chaos)
    dice, strikes = random.Random(5), 0
    for case in chaos.CASES[1:]:
        outcome = chaos.disturbed(*case, dice)
        assert outcome.is_equal
        assert outcome.left_behind == 0
        strikes += outcome.strikes.total()
    assert strikes > 0


def start(path: Path, *words: str) -> subprocess.Popen:
    """A paced run by the command line, once it has written to its log."""
    words = ("run", str(POOL), "--bus", "zenoh", "--rate", "1", "--out", str(path), "--json", *words)
    child = subprocess.Popen(
        [sys.executable, "-m", "pipeline.cli", *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT, process_group=0,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    deadline = time.monotonic() + LIMIT_S
    while not (path.exists() and path.stat().st_size > 4096) and time.monotonic() < deadline:
        assert child.poll() is None, child.stderr.read()
        time.sleep(0.05)
    return child


def gone(processes: list[psutil.Process]) -> bool:
    return not psutil.wait_procs(processes, timeout=5.0)[1]


def test_interrupt(tmp_path):
    """Ctrl-C at a terminal goes to the whole group: log closed, processes gone, status 130."""
    path = tmp_path / "a.mcap"
    child = start(path)
    family = psutil.Process(child.pid).children(recursive=True)
    assert len(family) == 5  # four hosts, and what forks them
    os.killpg(child.pid, signal.SIGINT)
    out, err = child.communicate(timeout=LIMIT_S)
    assert (child.returncode, json.loads(out), err) == (130, {"error": "interrupted"}, "towline: interrupted\n")
    assert gone(family)
    log = open_log(path)
    assert log.complete
    assert log.metadata("result")["ending"] == "interrupted"


def test_conductor_killed_and_resumed(tmp_path):
    """No host outlives it, and the log goes on over zenoh to the digest of the undisturbed run."""
    path = tmp_path / "a.mcap"
    child = start(path, "--until", "12s")
    family = psutil.Process(child.pid).children(recursive=True)
    child.kill()
    child.communicate(timeout=LIMIT_S)
    assert gone(family)
    log = open_log(path)
    assert not log.complete
    out = tmp_path / "resumed.mcap"
    result = resume_run(log, *graph_of(log), out, Options(bus=BusOptions()), lambda _: None)
    whole = run(load_scenario(POOL, duration="12 s"), tmp_path / "whole.mcap")
    assert result.digest == whole.digest


def test_hosts_heed_no_interrupt(tmp_path):
    """Ctrl-C is the conductor's: a terminal that sends it to all of them does not disturb it twice."""
    scenario, sent = load_scenario(POOL, duration="4 s"), []

    def interrupt(_: float) -> None:
        if not sent:
            sent.extend(psutil.Process().children(recursive=True))
            for process in sent:
                process.send_signal(signal.SIGINT)

    options = Options(bus=BusOptions())
    result = run_scenario(scenario, build_graph(scenario), tmp_path / "a.mcap", options, interrupt)
    assert len(sent) == 5
    assert all(not any(counts.values()) for counts in result.hosts.values())
    assert result.digest == run(scenario, tmp_path / "local.mcap").digest


def test_disk_full(tmp_path):
    """A limit on the size of files stands for a full disk: one line, a log readable up to there, and nobody left."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))

    path = tmp_path / "a.mcap"
    words = ("run", str(POOL), "--bus", "zenoh", "--out", str(path), "--json")
    child = subprocess.Popen(
        [sys.executable, "-m", "pipeline.cli", *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT, preexec_fn=limit,
    )  # fmt: skip
    family: dict[int, psutil.Process] = {}
    while child.poll() is None:
        family |= {one.pid: one for one in psutil.Process(child.pid).children(recursive=True)}
        time.sleep(0.2)
    _, err = child.communicate(timeout=LIMIT_S)
    assert child.returncode == 1
    assert "cannot write the log: File too large" in err
    assert "Traceback" not in err
    assert len(family) == 5
    assert gone(list(family.values()))
    log = open_log(path)
    assert not log.complete
    assert log.times("tether")[-1] > 0
