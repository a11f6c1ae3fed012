"""A channel as a table, and its export: the same numbers in pandas, parquet and CSV.

Authority: the recorded values, pyarrow's parquet reader and Python's csv and float.
Tolerance: none; all three hold float64 exactly.
"""

import csv

import numpy as np
import pyarrow.parquet
import pytest

from components.contract import Port
from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows
from pipeline.log.table import default_folder, export

PORTS = (
    Port("sag", "m", (), "", "greatest distance from the chord"),
    Port("end.position", "m", (3,), "NED"),
    Port("tension", "N", (2,)),
    Port("mass", "kg", (2, 2), "NED"),
)
COLUMNS = ["sag", "end.position.x", "end.position.y", "end.position.z", "tension[0]", "tension[1]"]
COLUMNS += ["mass[0,0]", "mass[0,1]", "mass[1,0]", "mass[1,1]"]
UNITS = ["m"] * 4 + ["N"] * 2 + ["kg"] * 4
VALUES = np.random.default_rng(0).standard_normal((30, 10)) * 10.0 ** np.arange(-5, 5)
T_NS = np.arange(30) * 100_000_000
TIMES_S = [float(f"{n // 10}.{n % 10}") for n in range(30)]  # as a person writes them


@pytest.fixture
def log(tmp_path):
    with Recorder(tmp_path / "log.mcap", [ChannelSpec("rope", PORTS)]) as recorder:
        recorder.rows(0, pack_rows(T_NS, VALUES))
    with open_log(tmp_path / "log.mcap") as log:
        yield log


def test_frame(log):
    frame = log.frame("rope")
    assert list(frame.columns) == COLUMNS
    assert frame.attrs["units"] == dict(zip(COLUMNS, UNITS, strict=True))
    assert frame.index.name == "time"
    assert frame.index.tolist() == TIMES_S
    assert frame.to_numpy().tobytes() == VALUES.tobytes()


def test_parquet(log, tmp_path):
    (path,) = export(log, tmp_path / "out", "parquet")
    table = pyarrow.parquet.read_table(path)
    assert table.column_names == ["time", *COLUMNS]
    metadata = [table.schema.field(name).metadata for name in COLUMNS]
    assert [pairs[b"unit"].decode() for pairs in metadata] == UNITS
    assert metadata[0][b"description"] == b"greatest distance from the chord"
    assert metadata[1][b"frame"] == b"NED"
    assert table.drop_columns("time").to_pandas().to_numpy().tobytes() == VALUES.tobytes()


def test_csv(log, tmp_path):
    (path,) = export(log, tmp_path / "out", "csv")
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["time [s]", *(f"{name} [{unit}]" for name, unit in zip(COLUMNS, UNITS, strict=True))]
    numbers = np.array([[float(cell) for cell in row] for row in rows])
    assert np.ascontiguousarray(numbers[:, 1:]).tobytes() == VALUES.tobytes()
    assert [row[0] for row in rows] == [f"{t:g}" for t in TIMES_S]


def test_existing_tables_are_replaced_only_if_asked(log, tmp_path):
    (path,) = export(log, tmp_path / "out", "csv")
    path.write_text("precious")
    with pytest.raises(LogError, match="exists already; choose another folder or allow overwriting"):
        export(log, tmp_path / "out", "csv")
    assert path.read_text() == "precious"
    export(log, tmp_path / "out", "csv", overwrite=True)
    assert "time [s]" in path.read_text()


def test_a_failed_write_leaves_nothing_half_written(log, tmp_path, monkeypatch):
    def full(table, path, *_):
        path.write_text("time [s],sag")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pyarrow.csv.write_csv", full)
    with pytest.raises(LogError, match="cannot export: No space left on device"):
        export(log, tmp_path / "out", "csv")
    assert list((tmp_path / "out").iterdir()) == []


def test_default_folder(tmp_path):
    """Beside the log, and never the log itself or another file."""
    assert default_folder(tmp_path / "run.mcap") == tmp_path / "run"
    assert default_folder(tmp_path / "run") == tmp_path / "run_tables"
    (tmp_path / "taken").write_text("")
    assert default_folder(tmp_path / "taken.mcap") == tmp_path / "taken_tables"


def test_what_cannot_be_exported(log, tmp_path):
    with pytest.raises(LogError, match="format 'xlsx' is not known; use one of parquet, csv"):
        export(log, tmp_path, "xlsx")
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match="cannot export"):
        export(log, tmp_path / "file", "csv")
