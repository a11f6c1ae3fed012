"""A run's own duties beside stepping: writing out in time, pacing that can be interrupted, names of logs."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import pytest

from pipeline import run as run_module
from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.run import Options, default_log, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

MODELS = Path(__file__).parents[1] / "orchestration" / "components"
COUNT = "duration: 60 s\nstep: 1 s\ncomponents: {a: {model: ./counter.py}}\n"


def run(out, options=None, monitor=lambda _: None):
    scenario = load_scenario_text(COUNT, "test.yaml", MODELS)
    return run_scenario(scenario, build_graph(scenario), out, options or Options(), monitor)


def test_written_out_between_block_ends(tmp_path, monkeypatch):
    """A block here is 512 ticks; what came before a crash in its midst is in the file all the same."""
    monkeypatch.setattr(run_module, "FLUSH_S", 0.0)

    def crash(simulated_s: float) -> None:
        if simulated_s >= 10.0:
            os.kill(os.getpid(), signal.SIGKILL)

    child = os.fork()
    if child == 0:
        run(tmp_path / "crashed.mcap", Options(slice_ticks=1), crash)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    log = open_log(tmp_path / "crashed.mcap")
    assert not log.complete
    assert log.values("a")[:, 0].tolist() == list(range(11))


def test_interrupt_while_waiting_for_real_time(tmp_path):
    """A tick of 1 s at a thousandth of real time would wait for 1000 s; an interrupt waits for 0.1 s."""
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "paced.mcap", Options(rate=0.001))
    timer.join()
    assert time.monotonic() - began < 30.0
    assert open_log(tmp_path / "paced.mcap").metadata("result")["ending"] == "interrupted"


def test_logs_without_a_name_do_not_collide(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    paths = {run(None).log for _ in range(3)}
    assert len(paths) == 3
    assert all(Path(path).exists() and path.startswith("logs/test-") for path in paths)
    assert not default_log("test").exists()


def test_existing_log_is_kept_unless_told(tmp_path):
    out = tmp_path / "a.mcap"
    run(out)
    with pytest.raises(LogError, match="exists already"):
        run(out)
    run(out, Options(overwrite=True))
