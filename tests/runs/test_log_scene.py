"""What 3D viewers get: foxglove messages at 25 Hz, z-up, decoded by protobuf with foxglove's own schemas.

Authority: the recorded rows turned by hand from NED to ENU, google.protobuf's decoder. Tolerance: none for doubles; the
points of clouds are float32, so they must equal the doubles rounded to float32.
"""

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.reader import SeekingReader

from components.contract import Port
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows
from pipeline.log.scene import drawings, keep_at_rate

ROPE = ChannelSpec(
    "rope",
    (Port("tension", "N", (3,)), Port("nodes", "m", (4, 3), "NED"), Port("end_b.position", "m", (3,), "NED")),
)
SHIP = ChannelSpec("ship", (Port("position", "m", (3,), "NED"), Port("speed", "m/s")))
START_NS = 3_000_000_000_000_000_123  # a late start: seconds need more than 28 bits
STEP_NS = 15_000_000


@pytest.fixture(scope="module")
def messages(tmp_path_factory):
    """Decoded messages by topic, each with its time, and the recorded rows of rope and ship."""
    path = tmp_path_factory.mktemp("scene") / "log.mcap"
    rng = np.random.default_rng(0)
    t_ns = START_NS + np.arange(100) * STEP_NS
    values = [rng.standard_normal((100, 18)), rng.standard_normal((100, 4))]
    values[0][0] = 0.0
    with Recorder(path, [ROPE, SHIP]) as recorder:
        for part in np.array_split(np.arange(100), 9):
            for channel in range(2):
                recorder.rows(channel, pack_rows(t_ns[part], values[channel][part]))
    found = {}
    with open(path, "rb") as file:
        for schema, channel, message in SeekingReader(file, validate_crcs=True).iter_messages():
            pool = descriptor_pool.DescriptorPool()
            for one in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
                pool.Add(one)
            decoded = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name)).FromString(message.data)
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found, t_ns, values


def east_north_up(ned: np.ndarray) -> list[list[float]]:
    return [[y, x, -z] for x, y, z in ned.reshape(-1, 3).tolist()]


def kept(t_ns) -> list[int]:
    """Rows at or just after each multiple of 40 ms, found one by one."""
    rows = [0]
    for i in range(1, len(t_ns)):
        if t_ns[i] // 40_000_000 > t_ns[i - 1] // 40_000_000:
            rows.append(i)
    return rows


def xyz(point) -> list[float]:
    return [point.x, point.y, point.z]


def test_lines_and_points_are_drawn(messages):
    found, t_ns, (rope, ship) = messages
    scenes = found["/scene"]
    assert len(scenes) == 2 * len(kept(t_ns))
    by_id = {entity.id: [] for _, scene in scenes for entity in scene.entities}
    assert sorted(by_id) == ["rope.end_b.position", "rope.nodes", "ship.position"]
    for time, scene in scenes:
        for entity in scene.entities:
            assert entity.frame_id == "world"
            assert entity.timestamp.ToNanoseconds() == time
            by_id[entity.id].append((time, entity))
    for row, (time, entity) in zip(kept(t_ns), by_id["rope.nodes"], strict=True):
        assert time == t_ns[row]
        assert [xyz(point) for point in entity.lines[0].points] == east_north_up(rope[row, 3:15])
    for row, (_, entity) in zip(kept(t_ns), by_id["rope.end_b.position"], strict=True):
        assert [xyz(entity.spheres[0].pose.position)] == east_north_up(rope[row, 15:18])
    for row, (_, entity) in zip(kept(t_ns), by_id["ship.position"], strict=True):
        assert [xyz(entity.spheres[0].pose.position)] == east_north_up(ship[row, :3])


def test_frames_move_with_the_points(messages):
    found, t_ns, (_, ship) = messages
    own = [(t, one) for t, frames in found["/tf"] for one in frames.transforms if one.child_frame_id == "ship"]
    for row, (time, frame) in zip(kept(t_ns), own, strict=True):
        assert frame.parent_frame_id == "world"
        assert frame.timestamp.ToNanoseconds() == time == t_ns[row]
        assert [xyz(frame.translation)] == east_north_up(ship[row, :3])
        assert (frame.rotation.x, frame.rotation.y, frame.rotation.z, frame.rotation.w) == (0, 0, 0, 1)
    assert {one.child_frame_id for _, frames in found["/tf"] for one in frames.transforms} == {"ship", "rope.end_b"}


def test_nodes_are_a_cloud(messages):
    found, t_ns, (rope, _) = messages
    for row, (time, cloud) in zip(kept(t_ns), found["/points/rope.nodes"], strict=True):
        assert cloud.timestamp.ToNanoseconds() == time
        assert [(field.name, field.offset) for field in cloud.fields] == [("x", 0), ("y", 4), ("z", 8)]
        points = np.frombuffer(cloud.data, "<f4").reshape(-1, 3)
        assert points.tolist() == np.array(east_north_up(rope[row, 3:15])).astype(np.float32).tolist()


@pytest.mark.parametrize("step_ns", [1_000_000, 7_000_000, 40_000_000, 100_000_000])
def test_rate_is_the_same_in_slices_of_any_length(step_ns):
    t_ns = np.arange(500) * step_ns
    for slices in (1, 2, 50, 500):
        parts, last = [], -1
        for part in np.array_split(t_ns, slices):
            parts.append(keep_at_rate(part, 40_000_000, last))
            last = int(part[-1])
        assert np.flatnonzero(np.concatenate(parts)).tolist() == kept(t_ns)


def test_what_has_no_place_is_not_drawn():
    ports = (
        Port("position", "1"),
        Port("law.mass", "kg", (3, 3), "NED"),
        Port("velocity", "m/s", (3,), "NED"),
        Port("offset", "m", (3,), "body"),
        Port("lengths", "m", (3,), "NED"),
    )
    assert drawings("c", ports) == []
