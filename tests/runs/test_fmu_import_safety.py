"""FMUs that misbehave: an error that names component, function and time, the log whole, nothing left running."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil
import pytest
from foreign import BAD, MODES, PLACES, VAN_DER_POL

from pipeline.log.reader import open_log

LIMIT_S = 120.0


def bad(path: Path, mode: str, where: str = "step", at: str = "0.5 s", **own: str) -> str:
    words = "".join(f", {key}: {value}" for key, value in own.items() if key in ("isolate", "overdue"))
    more = "".join(f", {key}: {value}" for key, value in own.items() if key not in ("isolate", "overdue"))
    values = f"mode: {MODES.index(mode)}, where: {PLACES.index(where)}, at: {at}{more}"
    return f"a: {{fmu: {path}{words}, parameters: {{{values}}}}}"


def folders() -> set[str]:
    """Temporary folders of extracted FMUs."""
    return {one.name for one in Path(tempfile.gettempdir()).glob("towline-fmu*")} | {
        one.name for one in Path(tempfile.gettempdir()).glob("towline-FMU*")
    }


def is_closed(log, rows: int) -> bool:
    return log.metadata("result") != {} and len(log.port("a", "y")) == rows


SAID = {
    "fails": "DoStep of .* returned error (its last message: the winch is on fire)",
    "is_fatal": "DoStep of .* returned fatal (its last message: the winch is lost)",
    "no_status": "DoStep of .* returned status 77, which the standard does not know",
    "discards": "discards the step and gets no further than",
}


@pytest.mark.parametrize("fmi", [1, 2, 3])
def test_status_of_a_step(fmi, foreign, run):
    for mode, said in SAID.items():
        log = run(bad(foreign(BAD, fmi), mode), status=1)
        assert "a stopped the run at t = 0.51 s: " in run.result["error"], mode
        for part in said.split(".*"):
            assert part.strip() in run.result["error"]
        assert is_closed(log, 51)


def test_an_output_that_is_no_number(foreign, run):
    log = run(bad(foreign(BAD, 2), "not_finite"), status=1)
    assert "at t = 0.5 s: its output y is not finite" in run.result["error"]
    assert is_closed(log, 50)


FUNCTIONS = {
    "start": "EnterInitializationMode",
    "after_start": "ExitInitializationMode",
    "get": "Get{real} of .* for 'y'",
    "set": "Set{real} of .* for 'u'",
}


@pytest.mark.parametrize("fmi", [2, 3])
def test_error_in_any_function_names_it(fmi, foreign, run):
    for where, function in FUNCTIONS.items():
        run(bad(foreign(BAD, fmi), "fails", where, at="0 s"), status=1)
        name = f"fmi{fmi}{function.format(real='Real' if fmi == 2 else 'Float64')}"
        assert "at t = 0 s" in run.result["error"]
        for part in name.split(".*"):
            assert part.strip() in run.result["error"]


def test_steps_that_the_fmu_cuts_short_are_completed(foreign, run):
    """4 ms of the 10 at a time: by fmi2GetRealStatus in FMI 1 and 2, by early return in FMI 3; y is the time."""
    for fmi in (1, 2, 3):
        log = run(bad(foreign(BAD, fmi), "short_steps", at="0 s", largest="4 ms"))
        # 300 additions of at most 1 s
        assert log.port("a", "y") == pytest.approx([k / 100 for k in range(101)], abs=300 * 2.3e-16)


def test_steps_cut_short_need_the_capability(foreign, run):
    path = foreign(BAD, 2, edit=lambda text: text.replace('canHandleVariableCommunicationStepSize="true"', ""))
    run(bad(path, "short_steps", at="0 s", largest="4 ms"), status=1)
    assert "at t = 0.01 s" in run.result["error"]
    assert "canHandleVariableCommunicationStepSize" in run.result["error"]


def test_warnings_are_in_the_log(foreign, run):
    log = run(bad(foreign(BAD, 2), "warns", at="0.98 s"))
    texts = [text for _, text in log.events()]
    assert texts[-1] == "a: a warning with 100 % of a percent sign"


@pytest.mark.parametrize(
    ("mode", "said"),
    [("crashes", "was killed by SIGSEGV"), ("aborts", "was killed by SIGABRT"), ("exits", "ended with status 3")],
)
def test_isolated_crash_costs_no_log(mode, said, foreign, run):
    before = folders()
    log = run(bad(foreign(BAD, 2), mode, isolate="true", overdue="20 s"), status=1)
    assert f"a stopped the run at t = 0.51 s: the process of its FMU {said}" in run.result["error"]
    assert is_closed(log, 51)
    assert folders() <= before
    assert not [one for one in psutil.Process().children() if "hosts.fmu" in " ".join(one.cmdline())]


def test_isolated_hang_costs_no_log(foreign, run):
    log = run(bad(foreign(BAD, 3), "spins", isolate="true", overdue="3 s"), status=1)
    assert "at t = 0.51 s: its FMU has not returned for 3 s, and its process was ended" in run.result["error"]
    assert is_closed(log, 51)
    assert not [one for one in psutil.Process().children() if "hosts.fmu" in " ".join(one.cmdline())]


def command(folder: Path, component: str) -> subprocess.CompletedProcess[str]:
    """The run in a process of its own, for FMUs that take theirs with them."""
    scene = folder / "scene.yaml"
    scene.write_text(f"duration: 1 s\nstep: 10 ms\nscene: false\ncomponents:\n  {component}\n")
    words = [sys.executable, "-m", "pipeline.cli", "run", str(scene), "--out", str(folder / "run.mcap"), "--json"]
    return subprocess.run(words, capture_output=True, text=True, timeout=LIMIT_S, cwd=Path(__file__).parents[2])


@pytest.mark.parametrize(("mode", "where", "at"), [("sleeps", "step", "0.5 s"), ("spins", "start", "0 s")])
def test_hang_in_this_process_is_told_and_the_log_closed(mode, where, at, foreign, tmp_path):
    """A thread beside the one that hangs closes the log and ends the process."""
    before = folders()
    done = command(tmp_path, bad(foreign(BAD, 2), mode, where, at, overdue="2 s"))
    assert done.returncode == 1
    error = json.loads(done.stdout)["error"]
    what, t = ("step", "0.51") if where == "step" else ("initialization", "0")
    assert f"a stopped the run at t = {t} s: " in error
    assert f"has not returned from its {what} for 2 s" in error
    assert f"towline: {error}" in done.stderr
    assert is_closed(open_log(tmp_path / "run.mcap"), 51 if where == "step" else 0)
    assert folders() <= before


def test_what_an_fmu_prints_is_kept_from_the_results(foreign, tmp_path):
    done = command(tmp_path, bad(foreign(BAD, 2), "noisy", at="0.98 s"))
    assert done.returncode == 0
    assert json.loads(done.stdout)["steps"] == 100
    assert "the FMU speaks on standard output" in done.stderr


def test_a_crash_in_this_process_leaves_the_log_readable(foreign, tmp_path):
    """It ends the run with it, as said; isolate: true is what keeps it."""
    done = command(tmp_path, bad(foreign(BAD, 2), "crashes"))
    assert done.returncode == -signal.SIGSEGV
    assert not open_log(tmp_path / "run.mcap").complete


def test_no_process_outlives_the_run(foreign, tmp_path):
    """The conductor is killed while its isolated FMU hangs."""
    scene = tmp_path / "scene.yaml"
    component = bad(foreign(BAD, 2), "sleeps", isolate="true", overdue="100 s")
    scene.write_text(f"duration: 1 s\nstep: 10 ms\nscene: false\ncomponents:\n  {component}\n")
    words = [sys.executable, "-m", "pipeline.cli", "run", str(scene), "--out", str(tmp_path / "run.mcap")]
    run = psutil.Popen(words, cwd=Path(__file__).parents[2], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + LIMIT_S
    while not (children := run.children()) and time.monotonic() < deadline:
        time.sleep(0.05)
    (child,) = children
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    assert psutil.wait_procs([child], timeout=10)[1] == []


def test_instances_that_a_process_may_have_once(foreign, run):
    once = foreign(
        VAN_DER_POL,
        2,
        edit=lambda text: text.replace(
            'canHandleVariableCommunicationStepSize="true"',
            'canHandleVariableCommunicationStepSize="true" canBeInstantiatedOnlyOncePerProcess="true"',
        ),
    )
    run(f"a: {{fmu: {once}}}\nb: {{fmu: {once}}}", status=1)
    assert "can be instantiated only once per process, and 'a' runs it here already" in run.result["error"]
    assert "isolate: true" in run.result["error"]
    run(f"a: {{fmu: {once}}}\nb: {{fmu: {once}, isolate: true, overdue: 20 s}}", until="20 ms")


LIES = {
    "GUID": (lambda text: text.replace("8c4e810f", "00000000"), "gave no instance"),
    "value reference": (
        lambda text: text.replace('name="u" valueReference="3"', 'name="u" valueReference="77777"'),
        "'u'",
    ),
    "library": (lambda text: text.replace('modelIdentifier="bad"', 'modelIdentifier="worse"'), "worse.so"),
    "name": (lambda text: text.replace('name="at"', 'name="y"'), "two of its variables are named 'y'"),
    "start value": (lambda text: text.replace('start="1.0"', 'start="one"'), "'largest'"),
    "type": (lambda text: text.replace("<Real", "<Complex", 1), "cannot be read"),
}


@pytest.mark.parametrize("lie", LIES)
def test_descriptions_that_lie(lie, foreign, run):
    edit, said = LIES[lie]
    path = foreign(BAD, 2, edit=edit)
    run(f"a: {{fmu: {path}}}", status=1)
    assert said in run.result["error"]
    assert path.name in run.result["error"]


def test_a_library_that_lacks_a_function_or_is_none(foreign, run, tmp_path):
    import zipfile

    for content, said in ((b"no library", "cannot be loaded"), (Path(foreign.library("bad", 3)).read_bytes(), "fmi2")):
        path = tmp_path / "broken.fmu"
        with zipfile.ZipFile(foreign(BAD, 2)) as source, zipfile.ZipFile(path, "w") as out:
            out.writestr("modelDescription.xml", source.read("modelDescription.xml"))
            out.writestr("binaries/linux64/bad.so", content)
        os.utime(path, (time.time() + len(content), time.time()))
        run(f"a: {{fmu: {path}}}", status=1)
        assert said in run.result["error"]
        assert "broken.fmu" in run.result["error"]
        assert os.getcwd() != str(path.parent)
