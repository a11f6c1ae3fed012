"""The state of FMUs: runs killed and resumed, hosts killed, logs replayed; the undisturbed run's digest is right."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import shutil
import signal
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import psutil
import pytest
from foreign import BAD, BALL, EVENTS, KINDS, MODES, STAIR, STATE, VAN_DER_POL

from pipeline import run as run_module
from pipeline.cli import main
from pipeline.errors import LogError, StepError
from pipeline.hosts.deployment import BusOptions
from pipeline.log.reader import Log, open_log
from pipeline.rerun import graph_of, other_sources
from pipeline.resume import resume_run
from pipeline.run import RUN, Options, Result, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.snapshot import Snapshot
from pipeline.wiring import build_graph

LIMIT_S = 60.0
# Tunable parameters set before and after the kill, two rates, a delayed ring; the ball meets events.
SCENE = """
duration: {duration}
step: 10 ms
scene: false
components:
  a: {{fmu: {oscillator}, interface: {interface}, inputs: {{neighbour: {{from: b.x, delay: true, initial: 1}}}},
       parameters: {{coupling: 0.3}}}}
  b: {{fmu: {oscillator}, interface: {interface}, period: 20 ms, inputs: {{neighbour: a.x}},
       parameters: {{coupling: 0.2}}}}
  ball: {{fmu: {ball}, interface: {interface}, isolate: {isolate}, overdue: 20 s, parameters: {{e: 0.95}}}}
events:
  - {{at: 1 s, set: {{a.mu: 1.5}}}}
  - {{at: {late}, set: {{ball.e: 0.9, b.mu: 0.5}}}}
"""
WAYS = [(1, "co-simulation"), (2, "co-simulation"), (3, "co-simulation"), (2, "model-exchange"), (3, "model-exchange")]


def scene(foreign, fmi: int, interface: str, duration: str = "12 s", late: str = "10 s", isolate: str = "false") -> str:
    oscillator, ball = (foreign(model, fmi) for model in (VAN_DER_POL, BALL))
    own = {"duration": duration, "late": late, "isolate": isolate, "interface": interface}
    if fmi == 1:  # which has no tunable parameters
        return SCENE.split("events:")[0].format(oscillator=oscillator, ball=ball, **own)
    return SCENE.format(oscillator=oscillator, ball=ball, **own)


def run(text: str, path: Path, bus=None, said=None, progress=lambda _: None) -> Result:
    scenario = load_scenario_text(text, "test.yaml", path.parent)
    tell = said.append if said is not None else lambda _: None
    return run_scenario(scenario, build_graph(scenario), path, Options(bus=bus, tell=tell), progress)


def _child(text: str, path: Path) -> None:
    run_module.FLUSH_S = 0.0  # a snapshot at every block end
    run(text, path, progress=lambda s: os.kill(os.getpid(), signal.SIGKILL) if s > 5.5 else None)


def killed(text: str, path: Path) -> Log:
    """The log of a run that was killed after 5.5 simulated seconds; a block of the digest, of 512 ticks, is in it."""
    child = multiprocessing.get_context("fork").Process(target=_child, args=(text, path))
    child.start()
    child.join(LIMIT_S)
    assert child.exitcode == -signal.SIGKILL
    return open_log(path)


def resumed(log: Log, out: Path, bus=None) -> Result:
    scenario, graph = graph_of(log)
    return resume_run(log, scenario, graph, out, Options(bus=bus), lambda _: None)


@pytest.mark.parametrize(("fmi", "interface"), WAYS)
def test_killed_and_resumed(fmi, interface, foreign, tmp_path):
    """FMI 2 and 3 save their state; FMI 1 cannot, and is led there by its inputs in the log."""
    text = scene(foreign, fmi, interface)
    undisturbed = run(text, tmp_path / "whole.mcap")
    log = killed(text, tmp_path / "killed.mcap")
    state = log.last_snapshot()
    assert state is not None
    assert set(Snapshot.from_bytes(state[1]).hosts) == (set() if fmi == 1 else {"a", "b", "ball"})
    assert resumed(log, tmp_path / "resumed.mcap").digest == undisturbed.digest


HELD = """
duration: 12 s
step: 10 ms
scene: false
components:
  a: {{fmu: {kinds}, interface: {interface}, inputs: {{int_in: steps.level, on_in: 1, choice_in: 3, real_in: 2 kN}}}}
  steps: {{fmu: {stair}}}
"""


@pytest.mark.parametrize(("fmi", "interface"), WAYS[2:])
def test_inputs_that_rest_are_held_after_a_resumption(fmi, interface, foreign, tmp_path):
    """One input changes each quarter of a second, which is an event; those of other types were set before the kill."""
    kinds = foreign(replace(KINDS, interfaces=("CoSimulation", "ModelExchange"), flags=STATE | EVENTS), fmi)
    text = HELD.format(kinds=kinds, interface=interface, stair=foreign(replace(STAIR, flags=STATE), 2))
    undisturbed = run(text, tmp_path / "whole.mcap")
    log = killed(text, tmp_path / "killed.mcap")
    assert resumed(log, tmp_path / "resumed.mcap").digest == undisturbed.digest


def test_isolated_killed_and_resumed(foreign, tmp_path):
    text = scene(foreign, 2, "co-simulation", isolate="true")
    undisturbed = run(scene(foreign, 2, "co-simulation"), tmp_path / "whole.mcap")
    log = killed(text, tmp_path / "killed.mcap")
    assert resumed(log, tmp_path / "resumed.mcap").digest == undisturbed.digest


def test_a_failure_in_the_first_tick_of_a_block_leaves_the_snapshot_before_it(foreign, tmp_path, monkeypatch):
    """The oscillator has made the tick in which the other FMU fails; the digest's block was closed before it."""
    monkeypatch.setattr(run_module, "FLUSH_S", 0.0)
    snapshots = []
    for mode, seconds in (("fine", 5.12), ("fails", 20.0)):  # 512 ticks are a block
        text = (
            f"duration: {seconds} s\nstep: 10 ms\nscene: false\ncomponents:\n  a: {{fmu: {foreign(VAN_DER_POL, 2)}}}\n"
        )
        text += f"  b: {{fmu: {foreign(BAD, 2)}, parameters: {{mode: {MODES.index(mode)}, at: 5.12 s}}}}\n"
        with suppress(StepError):
            run(text, tmp_path / f"{mode}.mcap")
        t_ns, data = open_log(tmp_path / f"{mode}.mcap").last_snapshot()
        snapshots.append((t_ns, Snapshot.from_bytes(data)))
    (t_ns, fine), (failed_ns, failed) = snapshots
    assert t_ns == failed_ns == 5_120_000_000
    assert failed.chains == fine.chains
    assert failed.board.tobytes() == fine.board.tobytes()


def test_no_state_and_no_inputs_is_refused_by_name(foreign, tmp_path):
    text = scene(foreign, 1, "co-simulation").replace("period: 20 ms,", "period: 20 ms, record: every 3,")
    log = killed(text, tmp_path / "killed.mcap")
    with pytest.raises(LogError, match="b was recorded every 3 steps"):
        resumed(log, tmp_path / "resumed.mcap")


def test_no_state_is_led_in_one_process_only(foreign, tmp_path):
    log = killed(scene(foreign, 1, "co-simulation"), tmp_path / "killed.mcap")
    with pytest.raises(LogError, match="resume with --bus local"):
        resumed(log, tmp_path / "resumed.mcap", BusOptions())


@pytest.mark.parametrize(("fmi", "interface"), [(1, "co-simulation"), (2, "co-simulation"), (3, "model-exchange")])
def test_over_zenoh_with_a_host_killed(fmi, interface, foreign, tmp_path):
    """A process each; one is killed in between, and restored or fed all its inputs anew."""
    text = scene(foreign, fmi, interface, duration="3 s", late="2 s")
    local = run(text, tmp_path / "local.mcap")
    struck, said = [], []

    def strike(simulated_s: float) -> None:
        hosts = [one for child in psutil.Process().children() for one in child.children()]
        if not struck and len(hosts) == 3 and simulated_s > 0.5:
            struck.append(hosts[-1].pid)
            hosts[-1].kill()

    result = run(text, tmp_path / "zenoh.mcap", BusOptions(), said, strike)
    assert struck, said
    assert result.digest == local.digest
    assert sum(host["restarts"] for host in result.hosts.values()) == 1


def test_replay(foreign, tmp_path, capsys):
    path = tmp_path / "whole.mcap"
    run(scene(foreign, 2, "co-simulation", duration="3 s", late="2 s"), path)
    for words in (["--component", "a"], ["--component", "ball"]):
        assert main(["replay", str(path), *words, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["identical"]
    assert main(["replay", str(path), "--component", "a", "--set", "a.mu=3", "--json"]) == 0
    assert not json.loads(capsys.readouterr().out)["identical"]


def test_the_log_names_and_holds_the_fmus(foreign, tmp_path):
    fmu = tmp_path / "moved.fmu"
    shutil.copy(foreign(VAN_DER_POL, 2), fmu)
    text = f"duration: 1 s\nstep: 10 ms\nscene: false\ncomponents:\n  a: {{fmu: {fmu}}}\n"
    undisturbed = run(text, tmp_path / "whole.mcap")
    log = open_log(tmp_path / "whole.mcap")
    assert json.loads(log.metadata(RUN)["fmus"]) == {str(fmu): hashlib.sha256(fmu.read_bytes()).hexdigest()}
    assert log.attachment(str(fmu)) == fmu.read_bytes()
    fmu.unlink()
    scenario, graph = graph_of(log)  # from the log alone
    assert (
        run_scenario(scenario, graph, tmp_path / "again.mcap", Options(), lambda _: None).digest == undisturbed.digest
    )


def test_a_changed_fmu_is_not_resumed(foreign, tmp_path):
    fmu = tmp_path / "changing.fmu"
    shutil.copy(foreign(BALL, 2), fmu)
    text = f"duration: 12 s\nstep: 10 ms\nscene: false\ncomponents:\n  a: {{fmu: {fmu}}}\n"
    log = killed(text, tmp_path / "killed.mcap")
    shutil.copy(foreign(BALL, 2, "OTHER"), fmu)
    os.utime(fmu, (time.time() + 5, time.time() + 5))
    assert "changing.fmu changed since the log was made" in (other_sources(log) or "")
    with pytest.raises(LogError, match=r"changing\.fmu changed since the log was made \(its SHA-256 was"):
        resumed(log, tmp_path / "resumed.mcap")
    shutil.copy(foreign(STAIR, 2), fmu)  # which has other parameters and ports
    os.utime(fmu, (time.time() + 9, time.time() + 9))
    with pytest.raises(LogError, match=r"changing\.fmu changed since"):
        resumed(log, tmp_path / "resumed.mcap")


def test_a_log_of_an_fmu_is_exported(foreign, tmp_path):
    run(scene(foreign, 2, "co-simulation", duration="3 s", late="2 s"), tmp_path / "run.mcap")
    words = ["export", str(tmp_path / "run.mcap"), "--format", "parquet", "--out", str(tmp_path / "tables")]
    assert main(words) == 0
    assert list((tmp_path / "tables").glob("*a*.parquet"))
