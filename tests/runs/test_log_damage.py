"""A damaged log: cut anywhere, a flipped byte anywhere, or no log at all; never a traceback, never wrong numbers.

Authority: the recorded rows. Tolerance: none; whatever is read must be the beginning of what was recorded.
"""

import json
import os

import numpy as np
import pytest
from mcap.writer import Writer

from components.contract import Port
from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows
from pipeline.log.schema import describe, ports_to_json

CHANNELS = [ChannelSpec("a", (Port("x", "m"),)), ChannelSpec("b", (Port("v", "m/s", (2,)),))]
TIMES = np.arange(12)
VALUES = [np.random.default_rng(n).standard_normal((len(TIMES), n)) for n in (1, 2)]
FACTS = {"seed": "12345"}
SCENARIO = b"duration: 12 ns"


@pytest.fixture(params=["whole", "interrupted"])
def log(request, tmp_path):
    """A small log in three flushed parts, with its end or without."""
    path = tmp_path / "small.mcap"
    recorder = Recorder(
        path, CHANNELS, attachments={"scenario.yaml": SCENARIO}, metadata={"run": FACTS}, scene_period_ns=None
    )
    for part in np.split(np.arange(len(TIMES)), 3):
        for channel in range(2):
            recorder.rows(channel, pack_rows(TIMES[part], VALUES[channel][part]))
        recorder.event(int(TIMES[part[0]]), "part")
        recorder.snapshot(int(TIMES[part[-1]]), part.tobytes())
        recorder.flush()
    recorder.close() if request.param == "whole" else recorder.abort()
    return path


def refusal(path) -> str:
    """Why the log cannot be read; empty if all of it was read, right, and not said to be more than it is."""
    try:
        read_all(path)
    except LogError as error:
        return str(error)
    return ""


def read_all(path) -> bool:
    """Read everything and compare; whether the log says that it is whole. Raises LogError as a user would get it."""
    with open_log(path) as log:
        assert len({channel.count for channel in log.channels.values()}) <= 1  # both are cut at the same time
        for name, truth in zip("ab", VALUES, strict=True):
            if name not in log.channels:
                assert not log.complete
                continue
            t_ns, values = log.read([name])[name]
            assert t_ns.tobytes() == TIMES[: len(t_ns)].tobytes()
            assert values.tobytes() == truth[: len(t_ns)].tobytes()
            assert not log.complete or len(t_ns) == len(TIMES)
        for t_ns, state in log.snapshots():
            assert state == np.arange(t_ns - 3, t_ns + 1).tobytes()
        assert all(text == "part" for _, text in log.events())
        assert log.metadata("run") in ({}, FACTS)
        assert log.attachment("scenario.yaml") == SCENARIO
        assert log.complete == (log.warning == "")
        return log.complete


def test_undamaged(log, request):
    assert read_all(log) == ("whole" in request.node.name)


def test_cut_at_every_byte(log):
    """Cut to any length the log is refused, or readable and not whole; longer files give no less."""
    readable = []
    for size in range(log.stat().st_size - 1, -1, -1):
        os.truncate(log, size)
        reason = refusal(log)
        if reason:
            assert reason.startswith(str(log))
            assert "\n" not in reason
            continue
        with open_log(log) as cut:
            assert not cut.complete
            readable.append(cut.end_ns if cut.channels else -1)
    assert readable == sorted(readable, reverse=True)
    assert readable[0] >= TIMES[7]  # all but the last part at least
    assert readable[-1] == -1  # nothing recorded yet, but the scenario is there


@pytest.mark.parametrize("mask", [0x01, 0x80, 0xFF])
def test_flip_every_byte(log, mask):
    data = log.read_bytes()
    with open(log, "r+b", buffering=0) as file:
        for position, byte in enumerate(data):
            os.pwrite(file.fileno(), bytes([byte ^ mask]), position)
            assert "\n" not in refusal(log)
            os.pwrite(file.fileno(), data[position : position + 1], position)


def test_the_warning_says_how_much_time_is_there(tmp_path):
    path = tmp_path / "log.mcap"
    recorder = Recorder(path, CHANNELS)
    recorder.rows(0, pack_rows(np.array([0, 12_340_000_000]), np.zeros((2, 1))))
    recorder.flush()
    recorder.abort()
    with open_log(path) as log:
        assert log.warning.endswith("was interrupted: readable up to 12.34 s of simulated time")


def foreign(path, profile="", ports: str | None = None, described=b"", data=b"\0" * 9):
    """An MCAP file of someone else, in a profile, with port metadata, schema and payload of choice."""
    writer = Writer(str(path))
    writer.start(profile)
    schema = writer.register_schema("towline.thing", "protobuf", described)
    channel = writer.register_channel("thing", "protobuf", schema, {} if ports is None else {"ports": ports})
    writer.add_message(channel, 1, data, 1)
    writer.finish()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b"duration: 10 s\n", "the file is not MCAP"),
        (b"\x89MCAP", "ends within its header"),
        (b"\x89MCAP0\r\n", "ends within its header"),
        (b"\x89MCAP0\r\n" + bytes(100), "no MCAP header"),
    ],
)
def test_not_a_log(tmp_path, content, message):
    (tmp_path / "x.mcap").write_bytes(content)
    with pytest.raises(LogError, match=message):
        open_log(tmp_path / "x.mcap")


def test_foreign_mcap_is_told_apart(tmp_path):
    foreign(tmp_path / "ros.mcap", "ros2")
    with pytest.raises(LogError, match=r"not a log of Towline \(its profile is 'ros2'\)"):
        open_log(tmp_path / "ros.mcap")


@pytest.mark.parametrize("ports", ["", "{}", "[1]", "nonsense", json.dumps([{"name": "x"}])])
def test_ports_that_are_none(tmp_path, ports):
    foreign(tmp_path / "x.mcap", "towline", ports)
    with pytest.raises(LogError):
        open_log(tmp_path / "x.mcap")


def test_no_such_file_or_a_folder(tmp_path):
    with pytest.raises(LogError, match="No such file"):
        open_log(tmp_path / "x.mcap")
    with pytest.raises(LogError, match="Is a directory"):
        open_log(tmp_path)


def test_messages_that_do_not_fit_the_template(tmp_path):
    """Valid protobuf of the right schema and length, but with its fields in another order, is not misread."""
    ports = (Port("x", "m"), Port("y", "m"))
    described = describe("thing", ports).SerializeToString(deterministic=True)
    x, y = b"\x09" + np.float64(1.0).tobytes(), b"\x11" + np.float64(2.0).tobytes()
    foreign(tmp_path / "right.mcap", "towline", ports_to_json(ports), described, x + y)
    with open_log(tmp_path / "right.mcap") as log:
        assert log.values("thing").tolist() == [[1.0, 2.0]]
    foreign(tmp_path / "turned.mcap", "towline", ports_to_json(ports), described, y + x)
    with open_log(tmp_path / "turned.mcap") as log, pytest.raises(LogError, match="channel thing: its messages do not"):
        log.values("thing")


def test_schema_and_ports_must_agree(tmp_path):
    described = describe("thing", (Port("x", "m"),)).SerializeToString(deterministic=True)
    foreign(tmp_path / "x.mcap", "towline", ports_to_json((Port("x", "N"),)), described)
    with pytest.raises(LogError, match="the schema of channel thing does not fit its ports"):
        open_log(tmp_path / "x.mcap")
