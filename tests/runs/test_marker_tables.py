"""Marker tables as other tools write them: the same markers from every spelling, or one line with place and remedy.

Authority: the positions that were written. Exact, but for the rounding of the digits written (1e-9 m).
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.analysis.marker_csv import from_csv
from pipeline.analysis.reading import Reading
from pipeline.cli import main
from pipeline.errors import LogError, TowlineError

FRAMES, MARKERS = 20, 6
T = 0.02 * np.arange(FRAMES)
DOWN = Reading(up="-z")


@pytest.fixture(scope="module")
def position(line) -> np.ndarray:
    """A line that swings: (20, 6, 3), to the nanometre that is written."""
    frames = [line(0.8, 2.0, 0.3, MARKERS, 0.05 * np.sin(4 * t), 0.1 * t, (0.3, 0.2, 0.1)) for t in T]
    return np.round(np.stack(frames), 9)


def lines(position, times=None, name="{axis}{i}", separator=",", time_name="time [s]") -> list[str]:
    """Header and rows of a table with a frame a row."""
    count = position.shape[1]
    header = [time_name, *(name.format(i=i + 1, axis=axis) for i in range(count) for axis in "xyz")]
    times = [f"{t:.9g}" for t in T] if times is None else times
    rows = [[t, *(f"{v:.9f}" for v in p.ravel())] for t, p in zip(times, position, strict=True)]
    return [separator.join(map(str, row)) for row in [header, *rows]]


def written(path: Path, rows: list[str]) -> Path:
    path.write_text("\n".join(rows) + "\n")
    return path


def only(path: Path, reading: Reading = DOWN):
    cables = from_csv(path, reading)
    assert len(cables) == 1
    return next(iter(cables.values()))


@pytest.mark.parametrize(("unit", "factor"), [("s", 1), ("ms", 10**3), ("us", 10**6), ("ns", 10**9)])
@pytest.mark.parametrize("start", [0, 1_700_000_000])
def test_time_units_by_magnitude_and_step(position, tmp_path, unit, factor, start):
    """Whole numbers stay exact to the nanosecond; seconds since 1970 as decimals are exact to 240 ns in float64."""
    numbers = [round((start + t) * factor, 2) if unit == "s" else round(start * factor) + round(t * factor) for t in T]
    frames = only(written(tmp_path / "a.csv", lines(position, numbers, time_name="timestamp")))
    expected = start * 10**9 + np.rint(T * 1e9).astype(np.int64)
    assert np.abs(frames.t_ns - expected).max() <= (120 if unit == "s" and start else 0)
    assert f"taken as {unit}" in " ".join(frames.notes)


def test_times_of_day(position, tmp_path):
    """Across midnight; a text that is no time is refused with its place."""
    good = lines(position[:4], ["22:59:59", "23:59:59.980", "00:00:00.000", "00:00:00.02"], time_name="time")
    frames = only(written(tmp_path / "a.csv", good))
    assert np.diff(frames.t_ns).tolist() == [3_600_980_000_000, 20_000_000, 20_000_000]
    good[2] = good[2].replace("23:59", "23:79", 1)
    with pytest.raises(LogError, match=r"a.csv:3: .*23:79:59.980.* is not a time of day such as 12:00:00.020"):
        from_csv(written(tmp_path / "a.csv", good), Reading())


def test_the_user_knows_the_unit_better(position, tmp_path):
    path = written(tmp_path / "a.csv", lines(position, range(FRAMES), time_name="time"))
    assert np.diff(only(path).t_ns)[0] == 10**9
    assert np.diff(only(path, Reading(up="-z", time_unit="ms")).t_ns)[0] == 10**6


def test_iso_times(position, tmp_path):
    stamps = [f"2024-01-31T23:59:59.{int(1e3 * t):03d}+01:00" for t in T]
    frames = only(written(tmp_path / "a.csv", lines(position, stamps)))
    assert (np.diff(frames.t_ns) == 20_000_000).all()
    assert frames.t_ns[0] == pandas.Timestamp("2024-01-31T22:59:59Z").value


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_encodings_separators_and_line_ends(position, tmp_path, encoding, separator, end):
    rows = ["# Größe", "", *lines(position, separator=separator), "", ""]
    (tmp_path / "a.csv").write_bytes(end.join(rows).encode(encoding))
    assert (only(tmp_path / "a.csv").position == position).all()


def test_decimal_commas(position, tmp_path):
    path = written(tmp_path / "a.csv", [row.replace(".", ",") for row in lines(position, separator=";")])
    assert (only(path).position == position).all()
    path = written(tmp_path / "b.csv", [row.replace(".", ",") for row in lines(position)])
    with pytest.raises(LogError, match=r"b.csv:2: .* cells, but 19 columns have names; with decimal commas, put ';'"):
        from_csv(path, DOWN)


def test_two_cables_in_one_table(position, tmp_path):
    header = ["time [s]", *(f"{c}_{i}_{a}" for c in ("chain", "rope") for i in range(1, MARKERS + 1) for a in "xyz")]
    beside = position + np.array([0.0, 3.0, 0.0])
    both = np.concatenate([position, beside], axis=1)
    rows = [",".join(header), *lines(both)[1:]]
    path = written(tmp_path / "a.csv", rows)
    cables = from_csv(path, DOWN)
    assert list(cables) == ["chain", "rope"]
    assert (cables["chain"].position == position).all()
    np.testing.assert_allclose(cables["rope"].position, beside, rtol=0, atol=1e-9)
    assert list(from_csv(path, Reading(channel="rope"))) == ["rope"]
    with pytest.raises(LogError, match=r"a.csv has no cable tether; it has chain, rope"):
        from_csv(path, Reading(channel="tether"))


def test_a_force_is_no_marker(position, tmp_path):
    rows = lines(position, name="marker_{i}_{axis}")
    rows = [rows[0] + ",force_7_x,force_7_y,force_7_z", *(row + ",1.5,-2,9.8" for row in rows[1:])]
    frames = only(written(tmp_path / "a.csv", rows))
    assert (frames.position == position).all()
    assert "left out, with fewer than 4 markers: force (1)" in " ".join(frames.notes)


@pytest.mark.parametrize("label", ["{}", "m{}", "marker_{}"])
def test_a_row_for_each_marker(position, tmp_path, label):
    """Unsorted, and with rows twice; marker 3 is not in the third frame."""
    rows = [
        f"{T[f]:.9g},{label.format(i + 1)},{','.join(f'{v:.9f}' for v in position[f, i])}"
        for f in range(FRAMES)
        for i in range(MARKERS)
        if (f, i) != (2, 3)
    ]
    order = np.random.default_rng(0).permutation(len(rows))
    mixed = [*(rows[i] for i in order), rows[5], rows[7]]
    frames = only(written(tmp_path / "a.csv", ["time [s],marker,x,y,z", *mixed]))
    assert (frames.t_ns == np.rint(T * 1e9)).all()
    assert np.argwhere(~frames.valid).tolist() == [[2, 3]]
    assert (frames.position[frames.valid] == position[frames.valid]).all()
    assert "2 rows repeated a marker at the same time: the first of each was kept" in frames.notes


def test_zeros_are_not_seen(position, tmp_path):
    """Unless the marker is really there: the last one is moved through the origin, another stands in it."""
    spoilt = position.copy()
    spoilt[3:6, 2] = 0.0
    frames = only(written(tmp_path / "a.csv", lines(spoilt)))
    assert np.argwhere(~frames.valid).tolist() == [[3, 2], [4, 2], [5, 2]]
    assert any(note.startswith("3 positions were exactly (0, 0, 0)") for note in frames.notes)
    fixed = position - position[:, :1]
    assert only(written(tmp_path / "b.csv", lines(fixed))).valid.all()
    through = position.copy()
    through[:, -1] = np.linspace(-0.1, 0.1, FRAMES + 1)[:FRAMES, None]
    through[10, -1] = 0.0
    assert only(written(tmp_path / "c.csv", lines(through))).valid.all()


@pytest.mark.parametrize("up", ["x", "-x", "y", "-y", "z", "-z"])
def test_up(position, tmp_path, up):
    """Distances and handedness stay; up is -z in NED; told by the user or by the way the line hangs."""
    ned = position[..., [1, 0, 2]] * [1, 1, -1] if not up.startswith("-") else position  # third axis along `up`
    turned = np.roll(ned, {"x": 1, "y": 2, "z": 0}[up[-1]], axis=2)
    path = written(tmp_path / "a.csv", lines(turned))
    assert (only(path, Reading(up=up)).position == position).all()
    assert (only(path, Reading()).position == position).all()
    assert f": {up} is taken, so that the line hangs" in only(path, Reading()).notes[-1]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: rows[:1], "a.csv:1: there are names of columns, but no rows below them"),
        (lambda rows: rows[1:], "a.csv:1: numbers where the names of the columns are expected"),
        (lambda rows: [*rows[:4], rows[4].replace(",", ",lost,", 1), *rows[5:]], "a.csv:5: 20 cells, but 19 columns"),
        (lambda rows: [*rows[:4], "0.06,lost" + rows[4][rows[4].index(",", 5) :]], "a.csv:5: column 'x1': 'lost' is"),
        (lambda rows: [*rows[:4], "noon" + rows[4][4:]], "a.csv:5: column 'time [s]': 'noon' is not a number"),
        (lambda rows: [*rows[:4], rows[4][:30], *rows[5:]], "a.csv:5: 4 cells, but 19 columns have names"),
        (
            lambda rows: [rows[0], *("1" + row[row.index(",") :] for row in rows[1:])],
            "20 frames have 1 different times",
        ),
        (lambda rows: [rows[0], "1e300" + rows[1][1:]], "a.csv:2: column 'time [s]': beyond 292 years in s"),
    ],
)
def test_refusals_say_the_place(position, tmp_path, change, message):
    path = written(tmp_path / "a.csv", change(lines(position)))
    with pytest.raises(LogError) as refusal:
        from_csv(path, DOWN)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_last_line_cut_off_is_left_out(position, tmp_path):
    rows = lines(position)
    frames = only(written(tmp_path / "a.csv", [*rows[:-1], rows[-1][:40]]))
    assert len(frames.t_ns) == FRAMES - 1
    assert "the last line, 21, was cut off: left out" in frames.notes


@pytest.mark.parametrize(
    ("text", "metres"),
    [("1%", 0.02), ("1 %", 0.02), (" 1% ", 0.02), ("10 mm", 0.01), ("0.01", 0.01), ("1e-2 m ", 0.01)],
)
def test_tolerance_spellings(position, tmp_path, capsys, text, metres):
    path = str(written(tmp_path / "a.csv", lines(position)))
    assert main(["validity", path, "--length", "2", f"--tolerance={text}", "--json"]) == 0
    assert next(iter(json.loads(capsys.readouterr().out)["cables"].values()))["tolerance_mm"] == pytest.approx(
        1e3 * metres
    )


@pytest.mark.parametrize(
    "text", ["%m", "%", "", "100 %", "250%", "-1%", "0", "-3 mm", "nan", "inf %", "1%%", "1 kg", "x"]
)
def test_tolerances_that_are_none(position, tmp_path, capsys, text):
    path = str(written(tmp_path / "a.csv", lines(position)))
    assert main(["validity", path, "--tolerance", text, "--json"]) == 1
    error = json.loads(capsys.readouterr().out)["error"]
    assert error.startswith("--tolerance: ")
    assert "expected" in error
    assert "\n" not in error


SCRAPS = [
    b"",
    b"NaN",
    b"inf",
    b"-",
    b"1e400",
    b"\xff",
    b"\0",
    b'"',
    b",",
    b";",
    b"\t",
    b"\r",
    b"\n",
    b"x1",
    b"time",
    b"0",
]
SCRAPS += [
    b"9" * 400,
    b"#",
    b"2024-01-01T00:00:00",
    b"2024-13-45",
    "µ".encode(),
    b"[mm]",
    b"(",
    b"1,5",
    b"True",
    b"[ft]",
]


@st.composite
def spoilt(draw, good: bytes) -> bytes:
    """A good table after one to six cuts, insertions and replacements, in some encoding and with some line ends."""
    data = good.replace(b"\n", draw(st.sampled_from([b"\n", b"\r\n", b"\r", b"\n\n"])))
    data = data.replace(b",", draw(st.sampled_from([b",", b",", b";", b"\t", b", ", b" "])))
    for _ in range(draw(st.integers(1, 6))):
        # Half of the changes fall into the header and the first row, which decide how the rest is read.
        start = draw(st.integers(0, draw(st.sampled_from([250, len(data)]))))
        end = start + draw(st.sampled_from([0, 0, 1, 3, 12, 200]))
        data = data[:start] + draw(st.sampled_from(SCRAPS) | st.binary(max_size=8)) + data[end:]
    encoding = draw(st.sampled_from(["", "", "", "utf-16", "utf-8-sig"]))
    return data.decode("latin-1").encode(encoding) if encoding else data


def outcome(path: Path) -> str:
    """The message of a refusal, or "" for a result, which must be finite."""
    try:
        assert all(np.isfinite(frames.position).all() for frames in from_csv(path, Reading()).values())
    except TowlineError as error:
        return str(error)
    return ""


@pytest.mark.timeout(60)  # a hundred times what it takes
@given(data=st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_damage_gives_a_result_or_one_line(position, tmp_path, data):
    good = "\n".join(lines(position[:6, :4], [f"{t:.9g}" for t in T[:6]])).encode() + b"\n"
    path = tmp_path / "a.csv"
    path.write_bytes(data.draw(spoilt(good)))
    message = outcome(path)
    assert message == "" or str(path) in message
    assert "\n" not in message
