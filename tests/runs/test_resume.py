"""A run killed with SIGKILL at random moments and resumed has the digest and the rows of the undisturbed one."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from pipeline import run as run_module
from pipeline.diff import diff_logs
from pipeline.errors import LogError
from pipeline.log.reader import Log, open_log
from pipeline.rerun import graph_of
from pipeline.resume import resume_run
from pipeline.run import RESULT, Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

KILLS = 20
LIMIT_S = 60.0
TRIES = 6
# Two rates, a delayed ring, an event before and one after most kills, and a channel that is not recorded every step.
SCENARIO = """
duration: 1000 s
step: 1 ms
components:
  a: {model: motion.van_der_pol, inputs: {neighbour: {from: c.position, delay: true, initial: 1}}}
  b: {model: motion.van_der_pol, period: 2 ms, record: every 7, inputs: {neighbour: a.position}}
  c: {model: motion.van_der_pol, period: 3 ms, inputs: {neighbour: b.position}}
events:
  - {at: 10 s, set: {a.mu: 1.5}}
  - {at: 20 s, add: {b.position: 0.1}, until: 900 s}
  - {at: 600 s, set: {a.mu: 0.5}}
"""


FOLDER = Path(__file__).parents[2] / "scenarios"
BOND = (FOLDER / "bond_mass.yaml").read_text().replace("duration: 20 s", "duration: 300 s")
BOND_KILLS = 4


def run_to(path: Path, monitor=lambda _: None, text=SCENARIO):
    scenario = load_scenario_text(text, "test.yaml", FOLDER)
    return run_scenario(scenario, build_graph(scenario), path, Options(), monitor)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("undisturbed") / "run.mcap"
    return run_to(path)


def _child(path: Path, text: str) -> None:
    run_module.FLUSH_S = 0.0  # a snapshot at every block end, so that kills fall into writing them too
    run_to(path, text=text)


def _kill_after(path: Path, share: float, undisturbed_s: float, text: str = SCENARIO) -> Log:
    """The log of a run killed at a share of its expected time; sooner where it ended before, on a machine less busy."""
    for _ in range(TRIES):
        path.unlink(missing_ok=True)
        _run_and_kill(path, share * undisturbed_s, text)
        log = open_log(path)
        if not log.complete:
            return log
        share /= 2
    raise AssertionError("every run ended before it was killed")


def _run_and_kill(path: Path, after_s: float, text: str) -> None:
    """Start a run and kill it so long after its first snapshot is in the file."""
    child = multiprocessing.get_context("fork").Process(target=_child, args=(path, text))
    child.start()
    deadline = time.monotonic() + LIMIT_S
    while not (path.exists() and path.stat().st_size > 4096) and child.is_alive() and time.monotonic() < deadline:
        time.sleep(0.001)
    time.sleep(after_s)
    if child.is_alive():
        os.kill(child.pid, signal.SIGKILL)
    child.join(LIMIT_S)
    assert not child.is_alive()


def test_killed_at_random_moments(undisturbed, tmp_path):
    shares = np.random.default_rng(20221024).uniform(0.0, 0.5, KILLS)
    resumed_from = []
    for i, share in enumerate(shares):
        path, out = tmp_path / f"killed{i}.mcap", tmp_path / f"resumed{i}.mcap"
        log = _kill_after(path, float(share), undisturbed.wall_s)
        resumed_from.append(log.last_snapshot()[0] / 1e9)
        result = resume_run(log, *graph_of(log), out, Options(), lambda _: None)
        assert result.digest == undisturbed.digest
        assert result.channels == undisturbed.channels
        assert open_log(out).metadata(RESULT)["digest"] == undisturbed.digest
        if i == 0:
            assert diff_logs(open_log(out), open_log(undisturbed.log)).identical
    assert len(set(resumed_from)) > KILLS / 2, "kills did not fall at different moments"


def test_body_on_a_bond_killed_and_resumed(tmp_path):
    """With what a bond adds to the state: laws, energies, its own channel."""
    whole = run_to(tmp_path / "whole.mcap", text=BOND)
    for i, share in enumerate(np.random.default_rng(2022).uniform(0.0, 0.5, BOND_KILLS)):
        path, out = tmp_path / f"killed{i}.mcap", tmp_path / f"resumed{i}.mcap"
        log = _kill_after(path, float(share), whole.wall_s, BOND)
        result = resume_run(log, *graph_of(log), out, Options(), lambda _: None)
        assert (result.digest, result.channels, result.bonds) == (whole.digest, whole.channels, whole.bonds)


def test_complete_run_is_not_resumed(undisturbed, tmp_path):
    log = open_log(undisturbed.log)
    with pytest.raises(LogError, match="the run is complete; there is nothing to resume"):
        resume_run(log, *graph_of(log), tmp_path / "out.mcap", Options(), lambda _: None)


def test_interrupted_run_is_resumed(undisturbed, tmp_path):
    def interrupt(simulated_s: float) -> None:
        if simulated_s > 500.0:
            raise KeyboardInterrupt

    path = tmp_path / "interrupted.mcap"
    with pytest.raises(KeyboardInterrupt):
        run_to(path, interrupt)
    log = open_log(path)
    assert log.complete
    assert log.metadata(RESULT)["ending"] == "interrupted"
    result = resume_run(log, *graph_of(log), tmp_path / "out.mcap", Options(), lambda _: None)
    assert result.digest == undisturbed.digest


def test_resumed_run_killed_at_once_is_resumed_again(undisturbed, tmp_path):
    def kill(_: float) -> None:
        raise OSError("as a crash, which leaves the log without its end")

    path, second = tmp_path / "killed.mcap", tmp_path / "second.mcap"
    _kill_after(path, 0.5, undisturbed.wall_s)
    for log_path, out, monitor in ((path, second, kill), (second, tmp_path / "third.mcap", lambda _: None)):
        log = open_log(log_path)
        try:
            result = resume_run(log, *graph_of(log), out, Options(), monitor)
        except OSError:
            assert not open_log(out).complete
    assert result.digest == undisturbed.digest
