"""The command line as users meet it: exit status, JSON, one-line errors, nothing half-written taken for whole."""

from __future__ import annotations

import errno
import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from pipeline import installation
from pipeline.cli import main
from pipeline.commands import bench
from pipeline.commands.bench_page import Measured, update
from pipeline.errors import TowlineError
from pipeline.log.reader import open_log
from pipeline.log.recorder import Recorder
from pipeline.provenance import versions
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
POOL = str(ROOT / "scenarios" / "pool_chain.yaml")
RING = str(ROOT / "scenarios" / "van_der_pol.yaml")
TOWLINE = [sys.executable, "-m", "pipeline.cli"]
LIMIT_S = 120


def towline(*words: str, **kwargs) -> subprocess.CompletedProcess:
    return subprocess.run([*TOWLINE, *words], capture_output=True, text=True, timeout=LIMIT_S, cwd=ROOT, **kwargs)


def call(capsys, *words: str) -> tuple[int, dict]:
    """A command within this process: its exit status and its JSON."""
    status = main([*words, "--json"])
    return status, json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> str:
    path = str(tmp_path_factory.mktemp("log") / "ring.mcap")
    assert main(["run", RING, "--until", "2s", "--out", path, "--json"]) == 0
    return path


def test_help_imports_nothing_heavy():
    """What makes --help answer in less than 0.5 s."""
    heavy = ("numba", "numpy", "pint", "pydantic")
    code = "import sys, pipeline.cli as cli\ntry: cli.main(['--help'])\nexcept SystemExit: pass\n"
    code += f"print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=LIMIT_S, cwd=ROOT)
    assert done.stdout.splitlines()[-1] == "[]"


def test_run_json(capsys, tmp_path):
    status, result = call(capsys, "run", RING, "--until", "2s", "--out", str(tmp_path / "a.mcap"))
    assert status == 0
    keys = {"log", "simulated_s", "wall_s", "real_time_factor", "steps", "digest", "channels", "bonds", "validity"}
    assert set(result) == keys | {"hosts", "deadlines"}
    assert result["simulated_s"] == 2.0
    assert result["steps"] == 5 * 2000
    assert result["channels"] == {name: {"messages": 2001} for name in "abcde"}
    assert len(result["digest"]) == 64


def test_bare_number_is_si_and_set_changes_a_parameter(capsys, tmp_path):
    status, result = call(
        capsys, "run", RING, "--until", "1", "--set", "a.position=0.5", "--out", str(tmp_path / "a.mcap")
    )
    assert (status, result["simulated_s"]) == (0, 1.0)
    assert open_log(result["log"]).port("a", "position")[0] == 0.5


def test_check(capsys):
    status, result = call(capsys, "check", POOL)
    assert status == 0
    assert result["order"] == ["wall | hand", "tether", "markers"]


def test_diff_identical_and_different(capsys, log, tmp_path):
    assert call(capsys, "diff", log, log)[1]["identical"] is True
    other = str(tmp_path / "other.mcap")
    assert main(["run", RING, "--until", "2s", "--set", "a.mu=1.001", "--out", other, "--json"]) == 0
    capsys.readouterr()
    status, result = call(capsys, "diff", log, other)
    assert (status, result["identical"]) == (1, False)
    largest = max(channel["max_abs"] for channel in result["channels"].values())
    assert call(capsys, "diff", log, other, "--tolerance", str(1.01 * largest))[0] == 0
    assert call(capsys, "diff", log, other, "--tolerance", str(0.99 * largest))[0] == 1


def test_export(capsys, log, tmp_path):
    import pandas

    for kind in ("parquet", "csv"):
        status, result = call(capsys, "export", log, "--format", kind, "-o", str(tmp_path / kind))
        assert (status, len(result["files"])) == (0, 5)
    table = pandas.read_parquet(tmp_path / "parquet" / "a.parquet")
    assert table["position"].tolist() == open_log(log).port("a", "position").tolist()


def test_catenary(capsys):
    status, result = call(capsys, "catenary", "--length", "3.5", "--weight", "0.9", "--span", "2", "--rise", "0.5")
    assert status == 0
    assert set(result) == {"H_N", "V_a_N", "V_b_N", "C_per_m", "sag_m", "touches_seabed"}
    assert result["C_per_m"] == pytest.approx(0.9 / result["H_N"], rel=1e-15)
    assert result["V_a_N"] + result["V_b_N"] == pytest.approx(3.5 * 0.9, rel=1e-14)


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        ((), 2, "the following arguments are required: COMMAND"),
        (("run",), 2, "the following arguments are required: scenario"),
        (("run", POOL, "--rate", "-1"), 2, "must be positive and finite"),
        (("run", POOL, "--rate", "x"), 2, "argument --rate: 'x' is no number"),
        (("run", POOL, "--chunk-bytes", "x"), 2, "argument --chunk-bytes: 'x' is no whole number"),
        (("run", RING, "--out", "README.md", "--overwrite"), 1, "towline: README.md is not an MCAP file: it is not re"),
        (("run", "absent.yaml"), 1, "towline: absent.yaml:1:1 no such file"),
        (("run", POOL, "--set", "tether.lenght=3"), 1, "did you mean 'length'?"),
        (("diff", "absent.mcap", "absent.mcap"), 1, "towline: absent.mcap: cannot open the log: No such file"),
        (("resume", "README.md"), 1, "towline: README.md:"),
        (("catenary", "--length", "1", "--weight", "1", "--span", "2", "--rise", "0"), 1, "towline: no such line: "),
        (("catenary", "--length", "1 s", "--weight", "1", "--span", "2", "--rise", "0"), 1, "towline: --length: "),
    ],
)
def test_mistakes(words, status, message):
    done = towline(*words)
    assert done.returncode == status
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_existing_log_is_not_replaced(log):
    before = Path(log).read_bytes()
    done = towline("run", RING, "--until", "1s", "--out", log)
    assert (done.returncode, Path(log).read_bytes()) == (1, before)
    assert "exists already" in done.stderr


def test_a_log_is_not_resumed_into_itself(log, tmp_path):
    """By whatever name: it is read while the new one is written."""
    copy, link = tmp_path / "copy.mcap", tmp_path / "link.mcap"
    with Recorder(copy, [], attachments={"scenario.yaml": open_log(log).attachment("scenario.yaml")}) as recorder:
        recorder.snapshot(0, next(open_log(log).snapshots())[1])
    before = copy.read_bytes()
    link.hardlink_to(copy)
    for name in (copy, link):
        done = towline("resume", str(copy), "--out", str(name), "--overwrite")
        assert done.returncode == 1
        assert f"towline: {name} is the log to resume from" in done.stderr
    assert copy.read_bytes() == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("scenario", [RING, "absent.yaml"])
def test_standard_output_that_is_full(scenario):
    with open("/dev/full", "w") as full:
        command = [*TOWLINE, "check", scenario, "--json"]
        done = subprocess.run(command, stdout=full, stderr=-1, text=True, timeout=LIMIT_S, cwd=ROOT)
    assert done.returncode == 1
    reason = "cannot write to standard output: No space left" if scenario == RING else "absent.yaml:1:1 no such file"
    assert reason in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_standard_output_that_nobody_reads():
    reading, writing = os.pipe()
    os.close(reading)
    command = [*TOWLINE, "check", RING, "--json"]
    done = subprocess.run(command, stdout=writing, stderr=-1, text=True, timeout=LIMIT_S, cwd=ROOT)
    os.close(writing)
    assert (done.returncode, done.stderr) == (1, "")


def test_tables_in_a_file_are_whole(monkeypatch, capsys):
    """Where what is printed goes to no terminal, no width of one cuts a cell."""
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["check", POOL]) == 0
    shown = capsys.readouterr().err
    assert "motion.acceleration [m/s^2]" in shown
    assert "…" not in shown


def test_catenary_says_what_it_can_tell_of_a_sea_bed(capsys):
    assert main(["catenary", "--length", "3", "--weight", "1", "--span", "2", "--rise", "0"]) == 0
    shown = capsys.readouterr().err
    assert "hangs below its lower end │ yes" in shown
    assert "touches" not in shown


def test_bench_of_an_installation_without_benchmarks(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(bench, "FOLDER", tmp_path)
    with pytest.raises(SystemExit):
        main(["bench", "--help"])
    assert "or all" not in capsys.readouterr().out
    assert main(["bench", "all"]) == 1
    assert "this installation has no benchmarks" in capsys.readouterr().err


def test_a_run_that_stopped_early_is_said_to(capsys, tmp_path):
    """By every command that reads it: the log itself is whole."""
    out = str(tmp_path / "a.mcap")

    def stopping(*_):
        raise KeyboardInterrupt

    scenario = load_scenario(POOL, (), "2s")
    graph = build_graph(scenario)
    with pytest.raises(KeyboardInterrupt):
        run_scenario(scenario, graph, Path(out), Options(slice_ticks=graph.ticks // 2), stopping)
    end = f"{open_log(out).end_ns / 1e9:.6g}"
    assert float(end) < 2.0
    page, tables = str(tmp_path / "page.html"), str(tmp_path / "tables")
    for words in (("validity", out), ("report", out, "-o", page), ("export", out, "-o", tables), ("diff", out, out)):
        capsys.readouterr()
        assert main([*words, "--json"]) == 0
        warnings = capsys.readouterr().err
        assert f"holds a run that ended early (interrupted): readable up to {end} s of simulated time" in warnings


def test_a_report_does_not_replace_its_recording(capsys, tmp_path):
    out = tmp_path / "a.mcap"
    assert main(["run", POOL, "--until", "1s", "--out", str(out), "--json"]) == 0
    before = out.read_bytes()
    assert main(["report", str(out), "--out", str(out)]) == 1
    assert "is the recording itself; give another name" in capsys.readouterr().err
    assert out.read_bytes() == before


def test_fits_say_that_they_compile_once(capsys, monkeypatch, tmp_path):
    table = tmp_path / "markers.csv"
    header = "t," + ",".join(f"{axis}{n}" for n in range(5) for axis in "xyz")
    row = ",".join(f"{n / 4 - 0.5:g},0,{-((n / 4 - 0.5) ** 2):g}" for n in range(5))
    table.write_text(f"{header}\n0,{row}\n1,{row}\n")
    marks: set[str] = set()
    monkeypatch.setattr("components.cache.is_marked", marks.__contains__)
    monkeypatch.setattr("components.cache.mark_cached", marks.add)
    for said in (True, False):
        assert main(["validity", str(table), "--tolerance", "1mm"]) == 0
        assert ("compiling the fits of the method fast (once" in capsys.readouterr().err) == said


def test_unwritable_folder(tmp_path):
    (tmp_path / "file").write_text("no folder")
    done = towline("run", RING, "--until", "1s", "--out", str(tmp_path / "file" / "a.mcap"))
    assert done.returncode == 1
    assert done.stderr.startswith("towline: ")
    assert "cannot create the log" in done.stderr


def test_disk_full(tmp_path):
    """A limit on the size of files stands for a full disk: one line, and a log that says it is not whole."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 20, 1 << 20))

    out = tmp_path / "full.mcap"
    done = towline("run", RING, "--out", str(out), "--json", preexec_fn=limit)
    assert done.returncode == 1
    assert "cannot write the log: File too large" in done.stderr
    assert "Traceback" not in done.stderr
    log = open_log(out)
    assert not log.complete
    assert "interrupted: readable up to" in log.warning


def test_cache_on_a_full_disk(tmp_path):
    """Compiled code that cannot be kept: one line with where it is kept and what helps."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (8 << 10, 8 << 10))

    kept = os.environ | {"TOWLINE_CACHE": str(tmp_path / "cache")}
    done = towline("run", RING, "--out", str(tmp_path / "a.mcap"), "--json", preexec_fn=limit, env=kept)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    told = r"File too large; compiled code is kept in .*cache/\w+: make room there, or set TOWLINE_CACHE"
    assert re.search(told, line)


def test_package_that_is_not_installed(monkeypatch, capsys, tmp_path):
    """As in an environment made before a dependency was added: told before anything is compiled, with the remedy."""

    def absent(name):
        raise PackageNotFoundError(name)

    versions.cache_clear()
    monkeypatch.setattr("pipeline.provenance.version", absent)
    monkeypatch.setattr("pipeline.commands.output.compile_side_by_side", lambda _: pytest.fail("it compiled"))
    status, result = call(capsys, "run", RING, "--out", str(tmp_path / "a.mcap"))
    assert status == 1
    assert result["error"].startswith(f"the package towline is not installed in {sys.prefix}: ")
    assert result["error"].endswith(f"run `make` there, or {sys.executable} -m pip install -e {ROOT}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ModuleNotFoundError("No module named 'cv2'", name="cv2"), "the package cv2 is not installed in"),
        (ImportError("cannot import name 'x'", name="zenoh.ext"), "the package zenoh does not fit in"),
        (ImportError("cannot import name 'x'", name="pipeline.run"), None),
        (OSError(errno.EACCES, "Permission denied", "/x"), None),
    ],
)
def test_errors_of_the_installation(error, said):
    found = installation.told(error)
    assert found is None if said is None else found.startswith(said)


def test_interrupt_closes_the_log(tmp_path):
    out = tmp_path / "interrupted.mcap"
    process = subprocess.Popen(
        [*TOWLINE, "run", RING, "--rate", "1", "--out", str(out)], cwd=ROOT, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + LIMIT_S
    while not out.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(1.5)
    os.kill(process.pid, signal.SIGINT)
    assert process.wait(LIMIT_S) == 130
    assert "towline: interrupted" in process.stderr.read()
    assert open_log(out).complete


def test_killed_run_is_read_with_a_warning_and_resumed(tmp_path):
    """From the shell, end to end: kill -9 on a paced run, export with a warning, resume to the undisturbed digest."""
    words = ("--until", "6s", "--json")
    whole = json.loads(towline("run", RING, *words, "--out", str(tmp_path / "whole.mcap")).stdout)
    out = tmp_path / "killed.mcap"
    process = subprocess.Popen([*TOWLINE, "run", RING, *words, "--rate", "1", "--out", str(out)], cwd=ROOT, stdout=-3)
    deadline = time.monotonic() + LIMIT_S
    while not out.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(2.5)
    process.kill()
    process.wait(LIMIT_S)
    exported = towline("export", str(out), "-o", str(tmp_path / "tables"))
    assert exported.returncode == 0
    assert "warning" in exported.stderr
    assert "readable up to" in exported.stderr
    resumed = json.loads(towline("resume", str(out), "--json", "--out", str(tmp_path / "resumed.mcap")).stdout)
    assert resumed["digest"] == whole["digest"]
    assert resumed["channels"] == whole["channels"]


def test_page_of_benchmarks(tmp_path):
    """A section is replaced where it stands, others stay; what rows share is said once; figures are linked."""
    page, figure = tmp_path / "docs" / "benchmarks.md", tmp_path / "docs" / "b.svg"
    page.parent.mkdir()
    rows = [{"case": "one", "us": 1.23456, "reference": "exact"}, {"case": "a|b", "us": 2.0, "reference": "exact"}]
    update(page, "b", Measured("About b.", rows, [figure], 1.0, (0.1, 0.2)))
    update(page, "a", Measured("About a.", rows[:1], [], 1.0, (0.1, 0.2)))
    first = page.read_text()
    assert first.index("## a") < first.index("## b")
    assert "| one | 1.235 |\n| a\\|b | 2 |" in first
    assert "- reference: exact" in first
    assert "![b](b.svg)" in first
    update(page, "b", Measured("About b.", [{"case": "new", "us": 3.0}], [], 1.0, (0.1, 0.2)))
    second = page.read_text()
    assert second.partition("## b")[0] == first.partition("## b")[0]
    assert "new" in second
    assert "one" not in second.partition("## b")[2]
    with pytest.raises(TowlineError, match="No such file"):
        update(tmp_path / "absent" / "page.md", "a", Measured("", rows, [], 1.0, (0.1, 0.2)))
    pairs = [{"case": str(i), "method": "a", "us": 1.0 + i, "error": 10.0**-i} for i in range(4)]
    update(page, "c", Measured("About c.", pairs, [], 1.0, (0.1, 0.2)))
    assert "![bench_c](bench_c.svg)" in page.read_text()
    drawn = (page.parent / "bench_c.svg").read_bytes()
    update(page, "c", Measured("About c.", pairs, [], 1.0, (0.1, 0.2)))
    assert (page.parent / "bench_c.svg").read_bytes() == drawn
    for few in (pairs[:3], [{**row, "error": 0.0} for row in pairs], [{**row, "us": None} for row in pairs]):
        update(page, "d", Measured("About d.", few, [], 1.0, (0.1, 0.2)))
    assert "bench_d" not in page.read_text()
    assert not (page.parent / "bench_d.svg").exists()
    unlike = [
        {"case": "x", "us": 1.0, "error": None},
        {"case": "y", "us": 2.0},
        {"case": "z", "nis": 1.0, "freedom": 3},
    ]
    update(page, "e", Measured("About e.", unlike, [], 1.0, (0.1, 0.2)))
    assert "| case | us |\n|---|---|\n| x | 1 |\n| y | 2 |\n" in page.read_text()
    assert "| case | nis | freedom |\n|---|---|---|\n| z | 1 | 3 |\n" in page.read_text()
    other = tmp_path / "README.md"
    other.write_text("# Mine")
    with pytest.raises(TowlineError, match="no page of benchmarks"):
        update(other, "a", Measured("", rows, [], 1.0, (0.1, 0.2)))
    assert other.read_text() == "# Mine"
