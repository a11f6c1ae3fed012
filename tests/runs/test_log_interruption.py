"""A run that dies, or a disk that refuses: what was flushed stays readable and nothing half-written passes for whole.

Authority: the rows that were written. Tolerance: none.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from components.contract import Port
from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows

SPEC = ChannelSpec("a", (Port("x", "m", (10,)),))
TIMEOUT_S = 60  # for a child process that takes about a second

WRITE = """
import resource, sys
import numpy as np
from components.contract import Port
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows
if sys.argv[2] != "0":
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
recorder = Recorder(sys.argv[1], [ChannelSpec("a", (Port("x", "m", (10,)),))])
rng = np.random.default_rng(0)
for second in range(200):
    t_ns = np.arange(second * 1000, (second + 1) * 1000) * 1_000_000
    recorder.rows(0, pack_rows(t_ns, rng.standard_normal((1000, 10))))
    recorder.flush()
    print(second, flush=True)
"""


def truth(count: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.concatenate([rng.standard_normal((1000, 10)) for _ in range(-(-count // 1000))])[:count]


def start(path: Path, limit: int = 0) -> subprocess.Popen:
    command = [sys.executable, "-c", WRITE, str(path), str(limit)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_killed_after_a_flush(tmp_path):
    path = tmp_path / "log.mcap"
    child = start(path)
    assert child.stdout is not None
    for line in child.stdout:
        if line.strip() == "5":
            break
    os.kill(child.pid, signal.SIGKILL)
    child.communicate(timeout=TIMEOUT_S)
    with open_log(path) as log:
        assert not log.complete
        values = log.values("a")
        assert len(values) >= 6000
        assert values.tobytes() == truth(len(values)).tobytes()


def test_file_size_limit(tmp_path):
    """A write that fails half-way (here at RLIMIT_FSIZE, as on a full disk) leaves an interrupted log."""
    path = tmp_path / "log.mcap"
    child = start(path, 1_000_000)
    out, err = child.communicate(timeout=TIMEOUT_S)
    assert child.returncode == 1
    last = err.strip().splitlines()[-1]
    assert last.startswith(f"pipeline.errors.LogError: {path}: cannot write the log: File too large")
    with open_log(path) as log:
        assert "interrupted" in log.warning
        values = log.values("a")
        assert len(values) >= 1000 * len(out.split())
        assert values.tobytes() == truth(len(values)).tobytes()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_disk_full_at_the_first_write():
    with pytest.raises(LogError, match="No space left on device"):
        Recorder("/dev/full", [SPEC], overwrite=True)


def test_after_a_failed_write_nothing_more_is_written(tmp_path, monkeypatch):
    recorder = Recorder(tmp_path / "log.mcap", [SPEC])
    recorder.rows(0, pack_rows(np.arange(5), np.ones((5, 10))))
    recorder.flush()
    size = (tmp_path / "log.mcap").stat().st_size

    def full() -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recorder._writer, "flush", full)
    recorder.rows(0, pack_rows(np.arange(5, 10), np.ones((5, 10))))
    with pytest.raises(LogError, match="No space left on device"):
        recorder.flush()
    for refused in (recorder.flush, lambda: recorder.event(0, "x"), lambda: recorder.add_metadata("x", {})):
        with pytest.raises(LogError, match="the log is closed"):
            refused()
    recorder.close()
    recorder.abort()
    assert (tmp_path / "log.mcap").stat().st_size == size
    with open_log(tmp_path / "log.mcap") as log:
        assert not log.complete
        assert len(log.values("a")) == 5


def test_an_exception_in_the_run_leaves_an_interrupted_log(tmp_path):
    with pytest.raises(ZeroDivisionError), Recorder(tmp_path / "log.mcap", [SPEC]) as recorder:  # noqa: PT012
        recorder.rows(0, pack_rows(np.arange(5), np.ones((5, 10))))
        raise ZeroDivisionError
    with open_log(tmp_path / "log.mcap") as log:
        assert not log.complete
        assert len(log.values("a")) == 5


def test_an_interrupt_within_a_write(tmp_path, monkeypatch):
    """Ctrl-C between two halves of a chunk: what was flushed before is there, what is half-made is not written."""
    recorder = Recorder(tmp_path / "log.mcap", [SPEC])
    recorder.rows(0, pack_rows(np.arange(5), np.ones((5, 10))))
    recorder.flush()
    recorder.rows(0, pack_rows(np.arange(5, 10), np.ones((5, 10))))

    def interrupted(*_) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(recorder._writer, "_note", interrupted)
    with pytest.raises(KeyboardInterrupt):
        recorder.flush()
    recorder.abort()
    with open_log(tmp_path / "log.mcap") as log:
        assert not log.complete
        assert len(log.values("a")) == 5


def test_an_existing_file_is_kept_unless_asked(tmp_path):
    (tmp_path / "log.mcap").write_text("precious")
    with pytest.raises(LogError, match="exists already"):
        Recorder(tmp_path / "log.mcap", [SPEC])
    with pytest.raises(LogError, match="is not an MCAP file: it is not replaced"):
        Recorder(tmp_path / "log.mcap", [SPEC], overwrite=True)
    assert (tmp_path / "log.mcap").read_text() == "precious"


def test_a_log_or_an_empty_file_is_replaced_if_asked(tmp_path):
    (tmp_path / "log.mcap").touch()
    for rows in (3, 5):
        with Recorder(tmp_path / "log.mcap", [SPEC], overwrite=True) as recorder:
            recorder.rows(0, pack_rows(np.arange(rows), np.ones((rows, 10))))
        with open_log(tmp_path / "log.mcap") as log:
            assert (log.complete, len(log.values("a"))) == (True, rows)


@pytest.mark.parametrize("ending", ["complete", "interrupted", "rope stopped the run at t = 3 s: it broke"])
def test_a_run_that_ended_early_is_said_to(tmp_path, ending):
    """Its log has its end and all its messages, but not the whole run."""
    with Recorder(tmp_path / "log.mcap", [SPEC]) as recorder:
        recorder.rows(0, pack_rows(np.array([0, 2_500_000_000]), np.ones((2, 10))))
        recorder.add_metadata("result", {"ending": ending})
    with open_log(tmp_path / "log.mcap") as log:
        assert log.complete
        whole = f"holds a run that ended early ({ending}): readable up to 2.5 s of simulated time"
        assert log.warning.endswith(whole if ending != "complete" else "")
        assert (log.warning == "") == (ending == "complete")


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match="cannot create the log"):
        Recorder(tmp_path / "file" / "log.mcap", [SPEC])


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder(tmp_path):
    (tmp_path / "locked").mkdir(mode=0o500)
    with pytest.raises(LogError, match="Permission denied"):
        Recorder(tmp_path / "locked" / "log.mcap", [SPEC])


def test_what_is_refused_leaves_no_file(tmp_path):
    with pytest.raises(LogError, match="compression 'zip' is not known; use one of zstd, lz4, none"):
        Recorder(tmp_path / "log.mcap", [SPEC], compression="zip")
    with pytest.raises(LogError, match="stands twice"):
        Recorder(tmp_path / "log.mcap", [ChannelSpec("a", (Port("x", "m"), Port("x", "m")))])
    assert not (tmp_path / "log.mcap").exists()
