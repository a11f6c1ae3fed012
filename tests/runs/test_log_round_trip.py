"""What goes into a log comes out of it, bit by bit, whatever the shapes, numbers, compression and chunk size.

Authority: the rows themselves. Tolerance: none, bits are compared (also of NaN, -0.0 and denormals).
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from components.contract import Port
from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows
from pipeline.log.schema import message_name

SHAPES = st.lists(st.integers(0, 4), max_size=3).map(tuple) | st.sampled_from([(3,), (5, 3)])
BUNDLES = st.sampled_from(["", "a.", "a.b.", "bundle."])
PORTS = st.lists(st.tuples(BUNDLES, SHAPES), max_size=6).map(
    lambda drawn: tuple(Port(f"{bundle}p{i}_position", "m", shape, "NED") for i, (bundle, shape) in enumerate(drawn))
)
BITS = st.sampled_from(
    [0, 1 << 63, 1, 0x7FF0000000000001, 0x7FF8000000000000, 0xFFF0000000000000, 0x7FE0000000000000, 0x3FF0000000000000]
)


def record(path, ports, t_ns, values, slices=1, **options):
    with Recorder(path, [ChannelSpec("one", ports)], overwrite=True, **options) as recorder:
        for part in np.array_split(np.arange(len(t_ns)), slices):
            recorder.rows(0, pack_rows(t_ns[part], values[part]))


@given(ports=PORTS, k=st.integers(0, 50), bits=st.lists(BITS, min_size=1), slices=st.integers(1, 4))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_bits_come_back(tmp_path, ports, k, bits, slices):
    n = sum(port.size for port in ports)
    values = np.resize(np.array(bits, np.uint64), (k, n)).view(np.float64)
    t_ns = np.arange(k, dtype=np.int64) * 1_234_567
    record(tmp_path / "log.mcap", ports, t_ns, values, slices, chunk_bytes=2000)
    with open_log(tmp_path / "log.mcap") as log:
        assert log.complete
        assert log.warning == ""
        assert log.channels["one"].ports == ports
        assert log.times("one").tobytes() == t_ns.tobytes()
        assert log.values("one").tobytes() == values.tobytes()
        first = 0
        for port in ports:
            truth = values[:, first : first + port.size].reshape(k, *port.shape)
            assert log.port("one", port.name).tobytes() == truth.tobytes()
            first += port.size


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
@pytest.mark.parametrize("chunk_bytes", [1, 1000, 1 << 20])
@pytest.mark.parametrize("scene_period_ns", [None, 40_000_000])
def test_compression_chunks_and_scene_change_no_value(tmp_path, compression, chunk_bytes, scene_period_ns):
    ports = (Port("nodes", "m", (5, 3), "NED"), Port("time_scale", "1"))
    t_ns = np.arange(300) * 5_000_000
    values = np.random.default_rng(1).standard_normal((300, 16))
    record(
        tmp_path / "log.mcap",
        ports,
        t_ns,
        values,
        slices=7,
        compression=compression,
        chunk_bytes=chunk_bytes,
        scene_period_ns=scene_period_ns,
    )
    with open_log(tmp_path / "log.mcap") as log:
        assert log.times("one").tobytes() == t_ns.tobytes()
        assert log.values("one").tobytes() == values.tobytes()


def test_facts_events_and_snapshots_come_back(tmp_path):
    spec = ChannelSpec("mass", (Port("x", "m"),), {"model": "vessel.mass", "period_ns": "1000000"})
    run = {"run_id": "abc", "seed": "18446744073709551615", "note": "ü\n"}
    with Recorder(
        tmp_path / "log.mcap", [spec], attachments={"scenario.yaml": b"\xff\0"}, metadata={"run": run}
    ) as recorder:
        recorder.event(0, "cut line at 12 °C")
        recorder.rows(0, pack_rows(np.array([0, 1]), np.zeros((2, 1))))
        for t_ns in (10, 20, 30):
            recorder.snapshot(t_ns, bytes([t_ns]) * 100_000)
            if t_ns == 10:
                recorder.flush()
        recorder.event(31, "")
        recorder.add_metadata("end", {"digest": "d"})
    with open_log(tmp_path / "log.mcap") as log:
        assert log.channels["mass"].metadata == spec.metadata
        assert log.metadata("run") == run
        assert log.metadata("end") == {"digest": "d"}
        assert log.metadata("nothing") == {}
        assert log.attachment("scenario.yaml") == b"\xff\0"
        assert log.events() == [(0, "cut line at 12 °C"), (31, "")]
        assert [t_ns for t_ns, _ in log.snapshots()] == [10, 20, 30]
        assert log.last_snapshot() == (30, bytes([30]) * 100_000)
        assert (log.start_ns, log.end_ns) == (0, 31)


def test_an_empty_log_is_whole(tmp_path):
    Recorder(tmp_path / "log.mcap", [ChannelSpec("mass", (Port("x", "m"),))]).close()
    with open_log(tmp_path / "log.mcap") as log:
        assert log.complete
        assert log.values("mass").shape == (0, 1)
        assert log.last_snapshot() is None


def test_the_rows_may_be_used_again_after_the_call(tmp_path):
    with Recorder(tmp_path / "log.mcap", [ChannelSpec("mass", (Port("x", "m"),))]) as recorder:
        rows = pack_rows(np.array([5]), np.array([[1.5]]))
        recorder.rows(0, rows)
        rows[:] = 0.0
    with open_log(tmp_path / "log.mcap") as log:
        assert log.values("mass")[0, 0] == 1.5


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (pack_rows(np.array([3, 2]), np.zeros((2, 1))), "goes back"),
        (pack_rows(np.array([-1]), np.zeros((1, 1))), "negative"),
        (pack_rows(np.array([1]), np.zeros((1, 2))), "3 columns where 2"),
    ],
)
def test_rows_that_make_no_sense_are_refused(tmp_path, rows, message):
    recorder = Recorder(tmp_path / "log.mcap", [ChannelSpec("mass", (Port("x", "m"),))])
    with pytest.raises(LogError, match=message):
        recorder.rows(0, rows)
    with pytest.raises(LogError, match="negative"):
        recorder.event(-1, "before the run")
    recorder.close()


@pytest.mark.parametrize("names", [("a", "a.b"), ("a.b", "a"), ("a", "a")])
def test_a_port_cannot_be_a_bundle_too(tmp_path, names):
    with pytest.raises(LogError, match="port a"):
        Recorder(tmp_path / "log.mcap", [ChannelSpec("c", tuple(Port(name, "m") for name in names))])


@given(st.text(max_size=8), st.text(max_size=8))
def test_channels_of_different_names_have_different_messages(a, b):
    assert (message_name(a) == message_name(b)) == (a == b)
    assert message_name(a).removeprefix("towline.").isidentifier()


def test_unknown_names_are_told_with_what_there_is(tmp_path):
    Recorder(tmp_path / "log.mcap", [ChannelSpec("mass", (Port("x", "m"),))]).close()
    with open_log(tmp_path / "log.mcap") as log:
        with pytest.raises(LogError, match="no channel rope; it has mass"):
            log.values("rope")
        with pytest.raises(LogError, match="mass has no port y; it has x"):
            log.port("mass", "y")
        with pytest.raises(LogError, match="no attachment"):
            log.attachment("scenario.yaml")


def test_the_recorder_holds_little(tmp_path):
    """Rows held back for merging by time are bounded, even where one channel is far ahead of the other."""
    chunk_bytes = 10_000
    channels = [ChannelSpec(name, (Port("x", "m"),)) for name in "ab"]
    with Recorder(tmp_path / "log.mcap", channels, chunk_bytes=chunk_bytes) as recorder:
        recorder.rows(0, pack_rows(np.array([10**9]), np.zeros((1, 1))))
        for t_ns in range(0, 100_000, 100):
            recorder.rows(1, pack_rows(np.arange(t_ns, t_ns + 100), np.zeros((100, 1))))
            assert recorder._held_bytes <= 9 * chunk_bytes
    with open_log(tmp_path / "log.mcap") as log:
        assert (log.times("b") == np.arange(100_000)).all()
