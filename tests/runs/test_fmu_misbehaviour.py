"""FMUs that lie, fail, crash and hang, and archives that attack: one line, a whole log, nothing left behind."""

from __future__ import annotations

import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np
import psutil
import pytest
from foreign import ARRAYS, BAD, BALL, KINDS, MODES, PLACES, STAIR, TEXTS, VAN_DER_POL

from components.contract import Parameters
from pipeline.cli import main
from pipeline.hosts.fmu import apart
from pipeline.hosts.fmu.parameters import FmuParameters
from pipeline.hosts.fmu.variables import TAKEN
from pipeline.log.reader import open_log

STEPS = 20


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch) -> Path:
    """A folder of the test's own, in which no temporary file is left, nor a process of this one."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setenv("TMPDIR", str(temporary))
    monkeypatch.chdir(tmp_path)
    before = set(psutil.Process().children(recursive=True))
    yield tmp_path
    left = [
        p for p in psutil.Process().children(recursive=True) if p not in before and p.status() != psutil.STATUS_ZOMBIE
    ]
    assert left == []
    assert list(temporary.iterdir()) == []


def scenario(fmu: Path, parameters: str = "", more: str = "", step: str = "50 ms", beside: str = "") -> None:
    shutil.copyfile(fmu, "bad.fmu")
    Path("s.mcap").unlink(missing_ok=True)
    Path("s.yaml").write_text(
        f"duration: 1 s\nstep: {step}\ncomponents:\n{beside}"
        f"  bad: {{fmu: bad.fmu, parameters: {{{parameters}}}{more}}}\n"
    )


def behaviour(mode: str, where: str = "step", at: float = 0.5) -> str:
    return f"mode: {MODES.index(mode)}, where: {PLACES.index(where)}, at: {at} s"


def refusal(capsys) -> str:
    """The one line with which a run fails."""
    code = main(["run", "s.yaml", "--out", "s.mcap"])
    told = capsys.readouterr()
    lines = [line for line in told.err.splitlines() if not line.startswith("compiling ")]  # said on a cold cache
    assert code == 1, told.err
    assert len(lines) == 1, told.err
    assert lines[0].startswith("towline: ")
    assert told.out == ""
    return lines[0]


def logged(steps: int) -> None:
    """The log is whole up to the step that failed, and tells what ended the run."""
    log = open_log(Path("s.mcap"))
    assert log.complete
    if steps <= STEPS:
        assert "s.mcap holds a run that ended early (bad stopped the run at t = " in log.warning
    y = np.ravel(log.port("bad", "y"))
    assert y.size == steps
    assert np.abs(y - 0.05 * np.arange(steps)).max(initial=0.0) < 1e-12


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
        ("set", "fmi{}Set(Real|Float64|Integer|Int32)"),
    ],
)
@pytest.mark.parametrize("fmi", [2, 3])
def test_failing_calls(where, function, fmi, foreign, capsys):
    scenario(foreign(BAD, fmi), behaviour("fails", where, 0.0))
    assert re.search(
        f"bad stopped the run at t = 0 s: {function.format(fmi)} of bad.fmu returned error", refusal(capsys)
    )
    logged(0)


@pytest.mark.parametrize("where", ["terminate", "free"])
def test_failing_at_the_end_costs_nothing(where, foreign, capsys):
    scenario(foreign(BAD, 2), behaviour("fails", where))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)


@pytest.mark.parametrize("fmi", [2, 3])
def test_discarded_steps_are_taken_in_parts(fmi, foreign, capsys):
    """An FMU that goes no further than 20 ms at once."""
    scenario(foreign(BAD, fmi), f"{behaviour('short_steps')}, largest: 20 ms")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)


@pytest.mark.parametrize("mode", ["warns", "logs", "noisy"])
def test_talking_is_no_failure(mode, foreign, capfd):
    """What an FMU prints does not get between the one JSON object of --json."""
    scenario(foreign(BAD, 2), behaviour(mode))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0
    logged(STEPS + 1)
    assert len(capfd.readouterr().out.splitlines()) == 1


def test_an_fmu_that_ends_the_run(foreign, capsys):
    """The stair asks to terminate at its second step, at 0.5 s."""
    scenario(foreign(STAIR, 2), "last: 2")
    assert re.search(r"bad stopped the run at t = 0\.5 s: .*bad\.fmu", refusal(capsys))
    assert np.ravel(open_log(Path("s.mcap")).port("bad", "level")).tolist() == [0] * 5 + [1] * 5


ISOLATED = [
    ("crashes", "step", 11, "at t = 0.55 s: .* was killed by SIGSEGV"),
    ("exits", "step", 11, "at t = 0.55 s: .* ended with status 3"),
    ("sleeps", "step", 11, "at t = 0.55 s: .* has not returned for 0.5 s"),
    ("crashes", "start", 0, "at t = 0 s: .* was killed by SIGSEGV"),
]


@pytest.mark.parametrize(
    ("mode", "where", "steps", "why"), ISOLATED, ids=[f"{mode}-{where}" for mode, where, *_ in ISOLATED]
)
def test_isolated(mode, where, steps, why, foreign, capsys):
    good = f"  good: {{fmu: {foreign(VAN_DER_POL, 2)}}}\n"
    at = 0.5 if where == "step" else 0.0
    scenario(foreign(BAD, 2), behaviour(mode, where, at), ", isolate: true, overdue: 500 ms", beside=good)
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
    root = str(Path(__file__).parents[2])
    return subprocess.Popen(
        command, env={**os.environ, "PYTHONPATH": root}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )


def children(process: subprocess.Popen) -> list[psutil.Process]:
    """The FMU's process, once the FMU is in its endless step; both have done all their computing by then."""
    for _ in range(600):
        time.sleep(0.1)
        found = psutil.Process(process.pid).children(recursive=True)
        if found and list(Path(tempfile.gettempdir()).glob("*/binaries")):
            return found
    raise AssertionError("no process of the FMU was started")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_run_that_is_ended_leaves_no_process(number, foreign, place):
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
        for folder in (place / "temporary").iterdir():
            shutil.rmtree(folder)


def test_a_crash_in_this_process_leaves_a_readable_log(foreign, place):
    """Not isolated: the process dies with it, the log has all that was written out, and says how to go on."""
    scenario(foreign(BAD, 2), behaviour("crashes"))
    process = started("--rate", "0.25")  # so that a second of wall time passes, at which the log is written out
    process.communicate(timeout=120)
    assert process.returncode == -signal.SIGSEGV
    assert np.ravel(open_log(Path("s.mcap")).port("bad", "y")).size >= 1
    for folder in (place / "temporary").iterdir():
        shutil.rmtree(folder)


def replaced(old: str, new: str, count: int = 1):
    return lambda text: text.replace(old, new, count)


LIES = {
    "a value reference that does not exist": (
        BAD,
        2,
        replaced('valueReference="0"', 'valueReference="900"'),
        "fmi2GetReal .*'y'",
    ),
    "a value reference beyond 32 bits": (
        BAD,
        2,
        replaced('valueReference="0"', 'valueReference="4294967296"'),
        "value reference",
    ),
    "another GUID": (BAD, 2, replaced('guid="{8c', 'guid="{9c'), "cannot be instantiated"),
    "another GUID in FMI 3": (
        BAD,
        3,
        replaced('instantiationToken="{8c', 'instantiationToken="{9c'),
        "cannot be instantiated",
    ),
    "another library": (BAD, 2, replaced('modelIdentifier="bad"', 'modelIdentifier="good"'), "no good.so"),
    "a library elsewhere": (
        BAD,
        2,
        replaced('modelIdentifier="bad"', 'modelIdentifier="../../bad"'),
        "names no library|bad.so",
    ),
    "a start value that is no number": (BAD, 2, replaced('start="1.0"', 'start="much"'), "much"),
    "an integer that is none": (BAD, 2, replaced('<Integer start="0"', '<Integer start="0.5"'), "0.5"),
    "two of a name": (BAD, 2, replaced('name="u"', 'name="at"'), "two of its variables are named 'at'"),
    "an unknown version": (BAD, 2, replaced('fmiVersion="2.0"', 'fmiVersion="4.0"'), "Unsupported FMI version"),
    "no interface": (
        BAD,
        2,
        lambda text: re.sub("<CoSimulation[^>]*>", "", text),
        "neither co-simulation nor model exchange",
    ),
    "a tool that is not here": (  # which shows by an instance that is not given
        BAD,
        2,
        lambda text: text.replace("<CoSimulation", '<CoSimulation needsExecutionTool="true"').replace("8c4e", "0000"),
        "needsExecutionTool",
    ),
    "a unit that is none": (BAD, 2, replaced('<BaseUnit s="1"', '<BaseUnit s="1" factor="0"'), "factor"),
    "no XML": (BAD, 2, replaced("</ModelVariables>", ""), "cannot be read"),
    "entities": (BAD, 2, replaced("<fmiModel", "<!DOCTYPE m [<!ENTITY e 'x'>]><fmiModel"), "document type"),
    "an array that is larger": (
        ARRAYS,
        3,
        replaced('<Dimension start="3"/>', '<Dimension start="30"/>'),
        "fmi3GetFloat64 .*'f'",
    ),
    "an array of absurd size": (
        ARRAYS,
        3,
        replaced('<Dimension start="3"/>', '<Dimension start="3000000000"/>'),
        "shape",
    ),
    "a dimension from nowhere": (
        ARRAYS,
        3,
        replaced('Dimension valueReference="1000"', 'Dimension valueReference="7"'),
        "",
    ),
    "more starts than elements": (ARRAYS, 3, replaced('start="1.0 0.0 0.0 1.0"', 'start="1 2 3"'), "'A'"),
}


@pytest.mark.parametrize("name", LIES)
def test_lying_descriptions(name, foreign, capsys):
    model, fmi, edit, why = LIES[name]
    scenario(foreign(model, fmi, edit=edit))
    text = refusal(capsys)
    assert "bad" in text
    assert re.search(why, text), text


def test_wrong_number_of_states(foreign, capsys):
    """The description has one derivative less than the binary has states."""
    path = foreign(
        BALL, 2, edit=lambda text: re.sub(r'(<Derivatives>.*?)<Unknown index="4"/>(</Derivatives>)', r"\1\2", text)
    )
    scenario(path, more=", interface: model-exchange")
    assert re.search("fmi2(Get|Set)ContinuousStates|fmi2GetDerivatives", refusal(capsys))


@pytest.mark.parametrize(
    ("fmi", "function"), [(1, "bad_fmiDoStep"), (2, "fmi2DoStep"), (3, "fmi3DoStep"), (3, "fmi3GetFloat64")]
)
def test_missing_functions(fmi, function, foreign, capsys):
    Path(f"{function}.map").write_text(f"{{ global: *; local: {function}; }};")
    scenario(foreign(BAD, fmi, f"-Wl,--version-script={function}.map"))
    text = refusal(capsys)
    assert re.search(rf"bad\.fmu.*{function.removeprefix('bad_')}", text)


def test_no_library_at_all(foreign, capsys):
    path = foreign(BAD, 2)
    with zipfile.ZipFile(path) as archive:
        document = archive.read("modelDescription.xml")
    for content, why in ((b"no library", "bad.so"), (b"", "bad.so")):
        with zipfile.ZipFile("other.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", document)
            archive.writestr("binaries/linux64/bad.so", content)
        scenario(Path("other.fmu"))
        assert why in refusal(capsys)
    with zipfile.ZipFile("other.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", document)
        archive.writestr("binaries/win64/bad.dll", b"")
    scenario(Path("other.fmu"))
    assert "no binary for this platform, linux64; it has some for win64" in refusal(capsys)


def test_harmless_lies(foreign, capsys):
    """Units that are defined nowhere, and a tool that may be there (pythonfmu writes so), refuse nothing."""
    scenario(foreign(BAD, 2, edit=replaced('unit="s"', 'unit="blubs"', 99)), behaviour("fine", at=0).replace(" s", ""))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


def test_names_that_python_does_not_have(foreign, capsys):
    edit = {"at": "_at", "mode": "1st mode", "where": "import", "u": "copy"}
    path = foreign(BAD, 2, edit=lambda text: re.sub('name="(at|mode|where|u)"', lambda m: f'name="{edit[m[1]]}"', text))
    scenario(path, "v_at: 0.5 s, v_1st_mode: 3, import: 0, copy_: 1")
    assert "returned error" in refusal(capsys)
    logged(11)
    names = {name for name in dir(FmuParameters) if not hasattr(Parameters, name)}
    assert names == set(TAKEN)
    for name in names:
        scenario(foreign(BAD, 2, edit=replaced('name="u"', f'name="{name}"')), f"{name}_: 1")
        assert main(["check", "s.yaml", "--json"]) == 0
    scenario(foreign(BAD, 2, edit=replaced("<CoSimulation", '<CoSimulation needsExecutionTool="true"')))
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


@pytest.mark.parametrize(
    ("wire", "why"),
    [
        ("{text_in: bad.text_length}", "text_in.*String|text_in.*string"),
        ("{real_in: other.text_out}", "text_out.*string|text_out.*String"),
    ],
)
def test_texts_that_change_are_refused_by_name(wire, why, foreign, capsys):
    scenario(foreign(TEXTS, 2), more=f", inputs: {wire}", beside=f"  other: {{fmu: {foreign(TEXTS, 2)}}}\n")
    assert re.search(why, refusal(capsys), re.IGNORECASE)


def test_once_per_process(foreign, capsys):
    """Two of an FMU that can be instantiated once only: told apart by processes, or refused."""
    edit = replaced("<CoSimulation", '<CoSimulation canBeInstantiatedOnlyOncePerProcess="true"')
    path = foreign(BAD, 2, "ONCE", edit=edit)
    scenario(path, beside=f"  first: {{fmu: {path}}}\n")
    assert re.search("OncePerProcess|once", refusal(capsys))
    scenario(path, beside=f"  first: {{fmu: {path}, isolate: true}}\n")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


def test_fixed_steps(foreign, capsys):
    edit = replaced("<CoSimulation", '<CoSimulation fixedInternalStepSize="0.01"')
    path = foreign(BAD, 3, "FIXED_STEP=0.01", edit=edit)
    scenario(path, step="12.5 ms")
    assert "fixedInternalStepSize" in refusal(capsys)
    scenario(path, step="10 ms")
    assert main(["run", "s.yaml", "--out", "s.mcap", "--json"]) == 0


def test_parameters_that_are_wrong(foreign, capsys):
    for parameters, why in (
        ("mode: 0.5", "0.5"),
        ("mode: fast", "fast"),
        ("mode: 3000000000", "3000000000"),
        ("at: 5 m", "'m' does not convert to 's'"),
        ("at: 5", "has no unit"),
        ("wher: 1", "did you mean 'where'"),
        ("y: 1 s", "y"),
    ):
        scenario(foreign(BAD, 2), parameters)
        text = refusal(capsys)
        assert why in text
        assert text.startswith("towline: s.yaml:4:")
    scenario(foreign(KINDS, 2), "choice: huge")
    assert "expected one of low, middle, high" in refusal(capsys)


def hostile(path: Path, name: str, content: bytes = b"x", mode: int = stat.S_IFREG | 0o644) -> None:
    about = zipfile.ZipInfo(name)
    about.create_system, about.external_attr = 3, mode << 16
    shutil.copyfile(path, "hostile.fmu")
    with zipfile.ZipFile("hostile.fmu", "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(about, content, zipfile.ZIP_DEFLATED)


@pytest.mark.parametrize(
    ("name", "mode", "content", "why"),
    [
        ("../evil", stat.S_IFREG, b"x", "leads out"),
        ("resources/link", stat.S_IFLNK, b"/etc/passwd", "is a link"),
        ("resources/zeros", stat.S_IFREG, bytes(210_000_000), "zip bomb"),
        ("resources/a/" * 20, stat.S_IFREG, b"", "no name that a file can have"),
    ],
)
def test_hostile_archives(name, mode, content, why, foreign, capsys, place):
    hostile(foreign(BAD, 2), name, content, mode | 0o644)
    scenario(Path("hostile.fmu"))
    assert why in refusal(capsys)
    assert not (place.parent / "evil").exists()


def test_a_damaged_archive(foreign, capsys):
    data = foreign(BAD, 2).read_bytes()
    for damaged in (data[:-100], data[: len(data) // 2], b"", data.replace(b"\x7fELF", b"\x7fELG"), os.urandom(1000)):
        Path("damaged.fmu").write_bytes(damaged)
        scenario(Path("damaged.fmu"))
        if damaged != data:
            assert "bad.fmu" in refusal(capsys)
