"""A stranger's reading: nothing but the mcap library's readers and protobuf must give the recorded numbers.

Authority: mcap.reader with checksum validation, and google.protobuf's decoder. Tolerance: none, bits are compared.
"""

import io
from pathlib import Path

import mcap.writer
import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import NonSeekingReader, SeekingReader

from components.contract import Port
from pipeline.log.chunk import Writer
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows

CHANNELS = [
    ChannelSpec("ring", (Port("position", "1"), Port("velocity", "1/s")), {"model": "motion.van_der_pol"}),
    ChannelSpec(
        "tether",
        (
            Port("tension", "N", (4,), "", "between the nodes"),
            Port("end_a.position", "m", (3,), "NED"),
            Port("end_a.law.mass", "kg", (3, 3), "NED"),
            Port("sag", "m"),
        ),
    ),
]
CHUNK_BYTES = 4096
COUNTS, STEPS_NS = (500, 120), (2_000_000, 10_000_000)


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> tuple[Path, list[np.ndarray], list[np.ndarray]]:
    """A log of two channels in slices, with small chunks so that there are many; its times and values."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    rng = np.random.default_rng(3)
    times = [np.arange(k) * step for k, step in zip(COUNTS, STEPS_NS, strict=True)]
    values = [rng.standard_normal((k, n)) for k, n in zip(COUNTS, (2, 17), strict=True)]
    attached, facts = {"scenario.yaml": b"run: 1"}, {"run": {"seed": "7"}}
    with Recorder(path, CHANNELS, attachments=attached, metadata=facts, chunk_bytes=CHUNK_BYTES) as recorder:
        for start in range(0, 1_200_000_000, 100_000_000):
            for channel in range(2):
                part = (times[channel] >= start) & (times[channel] < start + 100_000_000)
                recorder.rows(channel, pack_rows(times[channel][part], values[channel][part]))
            recorder.event(start, f"slice {start}")
        recorder.snapshot(1_190_000_000, b"\0state")
    return path, times, values


def decode(schema, data):
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(data)


def numbers(schema, data) -> list[float]:
    """All numbers of a message in the order of the ports, as its field names say."""
    message = decode(schema, data)
    if schema.name == "towline.ring":
        assert message.HasField("position")
        assert message.HasField("velocity")
        return [message.position, message.velocity]
    return [*message.tension, *message.end_a.position, *message.end_a.law.mass, message.sag]


@pytest.mark.parametrize("reader", [SeekingReader, NonSeekingReader])
def test_library_reads_the_recorded_numbers(written, reader):
    path, times, values = written
    found: dict[str, list] = {"ring": [], "tether": []}
    with open(path, "rb") as file:
        for schema, channel, message in reader(file, validate_crcs=True).iter_messages():
            if channel.topic in found:
                assert message.publish_time == message.log_time
                assert message.sequence == len(found[channel.topic])
                found[channel.topic].append((message.log_time, numbers(schema, message.data)))
    for name, t_ns, truth in zip(found, times, values, strict=True):
        assert [t for t, _ in found[name]] == t_ns.tolist()
        assert np.array([row for _, row in found[name]]).tobytes() == truth.tobytes()


def test_messages_stand_in_order_of_time_in_the_file(written):
    with open(written[0], "rb") as file:
        topics = ["ring", "tether"]
        times = [m.log_time for _, _, m in SeekingReader(file).iter_messages(topics, log_time_order=False)]
    assert times == sorted(times)


def test_summary_counts_what_is_there(written):
    with open(written[0], "rb") as file:
        summary = SeekingReader(file).get_summary()
    assert summary is not None
    statistics = summary.statistics
    assert statistics is not None
    counts = {summary.channels[n].topic: count for n, count in statistics.channel_message_counts.items()}
    assert counts == {
        "ring": 500,
        "tether": 120,
        "towline/events": 12,
        "towline/snapshots": 1,
        "/scene": 30,
        "/tf": 30,
    }
    assert statistics.message_count == sum(counts.values())
    assert (statistics.message_start_time, statistics.message_end_time) == (0, 1_190_000_000)
    assert statistics.chunk_count == len(summary.chunk_indexes)


def test_chunks_are_as_long_as_asked(tmp_path):
    """A chunk is finished by the message that fills it, also in a large slice; the first holds the schemas too."""
    longest_message = 200  # record head of 31 bytes, 17 floats and tags
    with Recorder(tmp_path / "log.mcap", CHANNELS, chunk_bytes=CHUNK_BYTES, scene_period_ns=None) as recorder:
        for channel, n in enumerate((2, 17)):
            recorder.rows(channel, pack_rows(np.arange(3000), np.ones((3000, n))))
    with open(tmp_path / "log.mcap", "rb") as file:
        summary = SeekingReader(file).get_summary()
    assert summary is not None
    sizes = [chunk.uncompressed_size for chunk in summary.chunk_indexes]
    assert len(sizes) > 100
    assert all(CHUNK_BYTES < size <= CHUNK_BYTES + longest_message for size in sizes[1:-1])


def test_remarks_attachments_and_metadata_are_there(written):
    with open(written[0], "rb") as file:
        reader = SeekingReader(file)
        events = [(m.log_time, decode(s, m.data).text) for s, _, m in reader.iter_messages("towline/events")]
        states = [decode(s, m.data).state for s, _, m in reader.iter_messages("towline/snapshots")]
        attachments = {one.name: one.data for one in reader.iter_attachments()}
        metadata = {one.name: one.metadata for one in reader.iter_metadata()}
    assert events == [(t, f"slice {t}") for t in range(0, 1_200_000_000, 100_000_000)]
    assert states == [b"\0state"]
    assert attachments == {"scenario.yaml": b"run: 1"}
    assert metadata["run"]["seed"] == "7"


def test_schema_tells_units_and_frames(written):
    with open(written[0], "rb") as file:
        summary = SeekingReader(file).get_summary()
    assert summary is not None
    schema = next(one for one in summary.schemas.values() if one.name == "towline.tether")
    (file,) = descriptor_pb2.FileDescriptorSet.FromString(schema.data).file
    comments = [location.leading_comments.strip() for location in file.source_code_info.location]
    assert comments == [
        "[N] shape (4,) row-major: between the nodes",
        "[m] shape (3,) row-major frame NED",
        "[kg] shape (3, 3) row-major frame NED",
        "[m]",
    ]


def test_private_names_of_the_library_are_the_ones_used():
    """The bulk addition lives off three private attributes and one method of mcap.writer.Writer."""
    writer = mcap.writer.Writer(io.BytesIO())
    for name in ("chunk_builder", "chunk_size", "statistics", "maybe_finalize_chunk"):
        assert hasattr(writer, f"_Writer__{name}"), f"mcap changed: Writer.__{name} is gone, see {Writer.__module__}"
