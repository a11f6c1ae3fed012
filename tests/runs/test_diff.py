"""Two logs compared: what is the same, what differs and by how much, of what size they may be.

Authority: the rows that were written. Tolerance: none; differences of small whole numbers are exact.
"""

from __future__ import annotations

import json
import tracemalloc
from itertools import pairwise

import numpy as np
import pytest

from components.contract import Port
from pipeline.cli import main
from pipeline.diff import Diff, diff_logs, within
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows

PORTS = (Port("x", "m", (), "NED"), Port("v", "m/s", (2,)))
MS = 1_000_000
ROWS = np.random.default_rng(0).integers(-9, 9, (100, 3)).astype(np.float64)


def write(path, t_ns, rows, ports=PORTS, name="rope", chunk_bytes=1 << 20):
    with Recorder(path, [ChannelSpec(name, ports)], chunk_bytes=chunk_bytes) as recorder:
        for first, end in pairwise([*range(0, len(t_ns), 10), len(t_ns)]):
            recorder.rows(0, pack_rows(t_ns[first:end], rows[first:end]))
    return path


def compared(a, b) -> Diff:
    with open_log(a) as log_a, open_log(b) as log_b:
        return diff_logs(log_a, log_b)


@pytest.fixture
def original(tmp_path):
    return write(tmp_path / "a.mcap", np.arange(100) * 10 * MS, ROWS)


def test_same_rows_in_other_chunks_are_identical(original, tmp_path):
    b = write(tmp_path / "b.mcap", np.arange(100) * 10 * MS, ROWS, chunk_bytes=1024)
    diff = compared(original, b)
    assert diff.identical
    assert diff.channels["rope"].max_abs == 0.0
    assert within(diff, 0.0)


@pytest.mark.parametrize("chunk_bytes", [1024, 1 << 20])
def test_largest_difference(original, tmp_path, chunk_bytes):
    rows = ROWS.copy()
    rows[7, 1] += 3.0
    rows[93, 2] -= 5.0
    b = write(tmp_path / "b.mcap", np.arange(100) * 10 * MS, rows, chunk_bytes=chunk_bytes)
    diff = compared(original, b)
    assert not diff.identical
    assert diff.channels["rope"].max_abs == 5.0
    assert within(diff, 5.0)
    assert not within(diff, 4.999)


def test_times_that_differ_are_beyond_any_tolerance(original, tmp_path):
    """1 s at 10 ms against 2 s at 20 ms: as many messages, half of them at times of the other log."""
    rows = np.concatenate([ROWS[::2], ROWS[::2]])
    diff = compared(original, write(tmp_path / "b.mcap", np.arange(100) * 20 * MS, rows))
    channel = diff.channels["rope"]
    assert (channel.messages_a, channel.messages_b, channel.times_equal) == (100, 100, False)
    assert channel.max_abs == 0.0  # at the times of both
    assert not diff.identical
    assert not within(diff, 1e9)


def test_shorter_log(original, tmp_path):
    diff = compared(original, write(tmp_path / "b.mcap", np.arange(40) * 10 * MS, ROWS[:40]))
    channel = diff.channels["rope"]
    assert (channel.messages_b, channel.max_abs, channel.times_equal) == (40, 0.0, False)
    assert not within(diff, 1e9)


@pytest.mark.parametrize(
    ("ports", "text"),
    [
        ((Port("x", "km", (), "NED"), PORTS[1]), "x [m] NED in a, x [km] NED in b"),
        ((Port("x", "m"), PORTS[1]), "x [m] NED in a, x [m] in b"),
        ((Port("x", "m", (2,), "NED"), Port("v", "m/s")), "x [m] NED in a, x [m] (2,) NED in b"),
        ((PORTS[1], PORTS[0]), "order x, v in a, v, x in b"),
        ((Port("y", "m", (), "NED"), PORTS[1]), "x [m] NED in a, no x in b"),
    ],
    ids=["unit", "frame", "shape", "order", "name"],
)
def test_ports_that_differ(original, tmp_path, ports, text, capsys):
    """The same bits mean something else in other units, frames, shapes or names."""
    b = write(tmp_path / "b.mcap", np.arange(100) * 10 * MS, ROWS, ports)
    diff = compared(original, b)
    assert not diff.identical
    assert not within(diff, 1e9)
    assert diff.channels["rope"].max_abs is None
    assert diff.channels["rope"].port_differences[0] == text
    assert main(["diff", str(original), str(b)]) == 1
    assert f"rope: {text}" in capsys.readouterr().err


def test_a_description_is_but_text(original, tmp_path):
    ports = (Port("x", "m", (), "NED", "place"), PORTS[1])
    assert compared(original, write(tmp_path / "b.mcap", np.arange(100) * 10 * MS, ROWS, ports)).identical


def test_a_channel_in_one_log_only(original, tmp_path):
    diff = compared(original, write(tmp_path / "b.mcap", np.arange(100) * 10 * MS, ROWS, name="boom"))
    assert not diff.identical
    assert not within(diff, 1e9)
    assert diff.channels["rope"].port_differences == ("only in a",)
    assert diff.channels["boom"].port_differences == ("only in b",)


def test_what_is_no_number_is_null_in_json(original, tmp_path, capsys):
    rows = ROWS.copy()
    rows[3, 0] = np.nan
    b = write(tmp_path / "b.mcap", np.arange(100) * 10 * MS, rows)
    assert main(["diff", str(original), str(b), "--tolerance", "1e9", "--json"]) == 1

    def refuse(text):
        raise AssertionError(f"{text} is not JSON")

    result = json.loads(capsys.readouterr().out, parse_constant=refuse)
    assert result["channels"]["rope"]["max_abs"] is None
    assert compared(b, b).identical
    assert compared(b, b).channels["rope"].max_abs == 0.0


@pytest.mark.parametrize("last_s", [20, 1])
def test_memory_does_not_grow_with_the_log(tmp_path, last_s):
    """24 MB of rows against as many, or against few: held are some chunks (8 of 64 kB a log, several copies each)."""
    ports, paths = (Port("x", "m", (150,)),), [tmp_path / "a.mcap", tmp_path / "b.mcap"]
    for path, seconds in zip(paths, (20, last_s), strict=True):
        with Recorder(path, [ChannelSpec("rope", ports)], chunk_bytes=1 << 16) as recorder:
            for first in range(0, 1000 * seconds, 50):
                rows = np.full((50, 150), float(first))
                recorder.rows(0, pack_rows(np.arange(first, first + 50) * MS, rows))
    tracemalloc.start()
    try:
        diff = compared(*paths)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert diff.identical == (last_s == 20)
    assert peak < 6 << 20
