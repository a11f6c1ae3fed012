"""FMUs that fail, end, crash and hang: an error with component, function and time, the log whole, no process left."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
from foreign import BAD, STAIR, VAN_DER_POL
from misbehaving import STEPS, behaviour, logged, refusal, scenario

from pipeline.cli import main
from pipeline.hosts.fmu import apart
from pipeline.log.reader import open_log

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.usefixtures("clean_place")

FAILURES = {
    "fails": r"{}DoStep of bad.fmu returned error \(its last message: the winch is on fire\)",
    "is_fatal": r"{}DoStep of bad.fmu returned fatal \(its last message: the winch is lost\)",
    "discards": r"{}DoStep of bad.fmu discards the step and gets no further than 0.5 s",
    "no_status": r"{}DoStep of bad.fmu returned status 77, which the standard does not know",
}


@pytest.mark.parametrize("fmi", [1, 2, 3])
@pytest.mark.parametrize("mode", FAILURES)
def test_failing_steps(mode, fmi, foreign, capsys):
    scenario(foreign(BAD, fmi), behaviour(mode))
    text = refusal(capsys)
    assert re.search(
        "bad stopped the run at t = 0.55 s: " + FAILURES[mode].format("fmi" if fmi == 1 else f"fmi{fmi}"), text
    )
    logged(11)


@pytest.mark.parametrize("fmi", [1, 2, 3])
def test_an_output_that_is_not_finite(fmi, foreign, capsys):
    scenario(foreign(BAD, fmi), behaviour("not_finite"))
    assert "bad stopped the run at t = 0.5 s: its output y is not finite" in refusal(capsys)
    logged(10)


@pytest.mark.parametrize(
    ("where", "function"),
    [
        ("start", "fmi{}EnterInitializationMode"),
        ("after_start", "fmi{}ExitInitializationMode"),
        ("get", "fmi{}Get(Real|Float64)"),
        ("set", "fmi{}Set(Real|Float64)"),
    ],
)
@pytest.mark.parametrize("fmi", [2, 3])
def test_failing_calls(where, function, fmi, foreign, capsys):
    scenario(foreign(BAD, fmi), behaviour("fails", where, 0.0))
    text = refusal(capsys)
    assert re.search(f"bad stopped the run at t = 0 s: {function.format(fmi)} of bad.fmu returned error", text)
    assert {"get": " for 'y'", "set": " for 'u'"}.get(where, "") in text
    logged(0)


@pytest.mark.parametrize("where", ["terminate", "free"])
def test_failing_at_the_end_costs_nothing(where, foreign, capsys):
    scenario(foreign(BAD, 2), behaviour("fails", where))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)


@pytest.mark.parametrize("fmi", [1, 2, 3])
def test_discarded_steps_are_taken_in_parts(fmi, foreign, capsys):
    """An FMU that goes no further than 20 ms at once: FMI 1 and 2 are asked how far, FMI 3 returns early."""
    scenario(foreign(BAD, fmi), f"{behaviour('short_steps')}, largest: 20 ms")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)


def test_steps_cut_short_need_the_capability(foreign, capsys):
    path = foreign(BAD, 2, edit=lambda text: text.replace('canHandleVariableCommunicationStepSize="true"', ""))
    scenario(path, f"{behaviour('short_steps')}, largest: 20 ms")
    text = refusal(capsys)
    assert "at t = 0.05 s" in text
    assert "canHandleVariableCommunicationStepSize" in text


@pytest.mark.parametrize("ended_s", ["1e9", "-1.0", "(HUGE_VAL - HUGE_VAL)"])
def test_steps_that_end_nowhere(ended_s, foreign, capsys):
    """Early return, at an event within the step, and a last time that is not within it."""
    scenario(foreign(STAIR, 3, f"REACHED={ended_s}"), "interval: 225 ms")
    text = refusal(capsys)
    assert re.search(
        r"at t = 0\.25 s: bad\.fmu says that its step from 0\.2 s to 0\.25 s ended at (1e\+09|-1|-?nan) s", text
    )


@pytest.mark.parametrize("mode", ["warns", "logs", "noisy"])
def test_talking_is_no_failure(mode, foreign, capfd):
    """What an FMU prints does not get between the one JSON object of --json."""
    scenario(foreign(BAD, 2), behaviour(mode))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)
    out, told = capfd.readouterr()
    assert len(out.splitlines()) == 1
    assert ("the FMU speaks on standard output" in told) == (mode == "noisy")
    texts = {text for _, text in open_log(Path("s.mcap")).events()}
    assert ("bad: a warning with 100 % of a percent sign" in texts) == (mode == "warns")


def test_an_fmu_that_ends_the_run(foreign, capsys):
    """The stair asks to terminate at its second step, at 0.5 s."""
    scenario(foreign(STAIR, 2), "last: 2")
    assert re.search(r"bad stopped the run at t = 0\.5 s: .*bad\.fmu", refusal(capsys))
    assert np.ravel(open_log(Path("s.mcap")).port("bad", "level")).tolist() == [0] * 5 + [1] * 5


ISOLATED = [
    ("crashes", "step", 11, "at t = 0.55 s: .* was killed by SIGSEGV"),
    ("aborts", "step", 11, "at t = 0.55 s: .* was killed by SIGABRT"),
    ("exits", "step", 11, "at t = 0.55 s: .* ended with status 3"),
    ("sleeps", "step", 11, "at t = 0.55 s: .* has not returned for 0.5 s, and its process was ended"),
    ("spins", "step", 11, "at t = 0.55 s: .* has not returned for 0.5 s, and its process was ended"),
    ("crashes", "start", 0, "at t = 0 s: .* was killed by SIGSEGV"),
]


@pytest.mark.parametrize(
    ("mode", "where", "steps", "why"), ISOLATED, ids=[f"{mode}-{where}" for mode, where, *_ in ISOLATED]
)
def test_isolated(mode, where, steps, why, foreign, capsys):
    good = f"  good: {{fmu: {foreign(VAN_DER_POL, 2)}}}\n"
    at = 0.5 if where == "step" else 0.0
    fmi = 3 if mode == "spins" else 2
    scenario(foreign(BAD, fmi), behaviour(mode, where, at), ", isolate: true, overdue: 500 ms", beside=good)
    assert re.search(f"bad stopped the run {why}", refusal(capsys))
    logged(steps)
    good_rows = np.ravel(open_log(Path("s.mcap")).port("good", "x")).size
    assert good_rows in (steps, steps + 1)  # it had its turn before the one that failed


def test_isolated_hang_at_the_start(foreign, capsys, monkeypatch):
    monkeypatch.setattr(apart, "START_S", 1.0)  # however loaded the machine is, a hang is a hang
    scenario(foreign(BAD, 2), behaviour("sleeps", "start", 0.0), ", isolate: true, overdue: 500 ms")
    assert "has not returned for 1 s" in refusal(capsys)
    logged(0)


def test_isolated_crash_while_loading(foreign, capsys):
    scenario(foreign(BAD, 2, "AT_LOADING=__builtin_trap()"), behaviour("fine"), ", isolate: true")
    assert "was killed by SIGILL" in refusal(capsys)


@pytest.mark.parametrize("mode", ["crashes", "sleeps"])
def test_isolated_end(mode, foreign, capsys):
    """The run is over by then: its log is whole, and the process does not stay."""
    scenario(foreign(BAD, 2), behaviour(mode, "terminate", 0.0), ", isolate: true")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)


def started(*words: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "pipeline.cli", "run", "s.yaml", "--out", "s.mcap", *words]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True, **pipes)


def children(process: subprocess.Popen) -> list[psutil.Process]:
    """The FMU's process, once the FMU is in its endless step; both have done all their computing by then."""
    for _ in range(600):
        time.sleep(0.1)
        found = psutil.Process(process.pid).children(recursive=True)
        if found and list(Path(tempfile.gettempdir()).glob("*/binaries")):
            return found
    raise AssertionError("no process of the FMU was started")


@pytest.mark.parametrize(("mode", "where", "at"), [("sleeps", "step", 0.5), ("spins", "start", 0.0)])
def test_hang_in_this_process_is_told_and_the_log_closed(mode, where, at, foreign):
    """A thread beside the one that hangs closes the log and ends the process."""
    scenario(foreign(BAD, 2), behaviour(mode, where, at), ", overdue: 2 s")
    process = started("--json")
    out, told = process.communicate(timeout=120)
    assert process.returncode == 1
    error = json.loads(out)["error"]
    what, t = ("step", "0.55") if where == "step" else ("initialization", "0")
    assert f"bad stopped the run at t = {t} s: " in error
    assert f"has not returned from its {what} for 2 s" in error
    assert f"towline: {error}" in told
    logged(11 if where == "step" else 0)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_run_that_is_ended_leaves_no_process(number, foreign, clean_place):
    scenario(foreign(BAD, 2), behaviour("sleeps", at=0.5), ", isolate: true, overdue: 60 s")
    process = started()
    try:
        theirs = children(process)
        time.sleep(1.0)
        process.send_signal(number)
        _, told = process.communicate(timeout=30)
        assert process.returncode == (-9 if number == signal.SIGKILL else 130)
        _, alive = psutil.wait_procs(theirs, timeout=10)
        assert [one for one in alive if one.status() != psutil.STATUS_ZOMBIE] == []  # init need not reap them
        assert number == signal.SIGKILL or told.splitlines()[-1] == "towline: interrupted"
    finally:
        process.kill()
    if number == signal.SIGKILL:  # what is left is swept by the next run; here by the test
        for folder in (clean_place / "temporary").iterdir():
            shutil.rmtree(folder)


def test_a_crash_in_this_process_leaves_a_readable_log(foreign, clean_place):
    """Not isolated: the process dies with it, the log has all that was written out, and says how to go on."""
    scenario(foreign(BAD, 2), behaviour("crashes"))
    process = started("--rate", "0.25")  # so that a second of wall time passes, at which the log is written out
    process.communicate(timeout=120)
    assert process.returncode == -signal.SIGSEGV
    log = open_log(Path("s.mcap"))
    assert not log.complete
    assert np.ravel(log.port("bad", "y")).size >= 1
    for folder in (clean_place / "temporary").iterdir():
        shutil.rmtree(folder)
