"""What 3D viewers draw of a run: lines, bodies and frames as foxglove messages, z-up, made in bulk from recorded rows.

Every message is a pure function of one component's row, so components are drawn apart: each its own entities on
/scene, its own frames on /tf and its own cloud of nodes below /points.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp

from components.contract import Port
from pipeline.log.template import Run, Template

WORLD = "world"  # root frame of the viewers: east, north, up
_LINE_PIXELS = 3.0
_SPHERE_METRES = 0.1
_FLOAT32 = 4
_LINE_COLOR = Color(r=1.0, g=0.6, b=0.1, a=1.0)
_SPHERE_COLOR = Color(r=0.2, g=0.6, b=1.0, a=1.0)
# Values that need all five bytes of their varints; the real ones are written over them, padded to the same length.
_STAMP = Timestamp(seconds=(1 << 34) + 0x2A2A2A, nanos=(1 << 29) + 0x2A2A2A)


@dataclass(frozen=True)
class Drawing:
    """A viewer's message made of a component's row: the template takes row[columns], every third (down) negated."""

    topic: str
    message: type[Message]
    template: Template
    columns: np.ndarray

    def floats(self, rows: np.ndarray) -> np.ndarray:
        """(k, n) outputs of the component -> (k, m) numbers of the message."""
        points = rows[:, self.columns]
        np.negative(points[:, 2::3], out=points[:, 2::3])
        return points


def drawings(component: str, ports: Sequence[Port]) -> list[Drawing]:
    """What there is to draw of a component's outputs.

    Ports of shape (k, 3) in m and NED are lines of nodes; those of shape (3,) named `position` (or `..._position`, or
    `bundle.position`) are points: a sphere and a frame.
    """
    placed = list(_placed(ports))
    lines = [(port, first) for port, first in placed if len(port.shape) == 2]
    points = [(port, first) for port, first in placed if len(port.shape) == 1]
    found = []
    if placed:
        found.append(_drawing("/scene", _scene(component, lines, points), [*lines, *points]))
    if points:
        found.append(_drawing("/tf", _frames(component, points), points))
    found += [_cloud(f"/points/{component}.{port.name}", port, first) for port, first in lines]
    return found


def keep_at_rate(t_ns: np.ndarray, period_ns: int, last_ns: int) -> np.ndarray:
    """Which rows stand at or just after a multiple of the period: (k,) bool. last_ns: time of the row before, or -1."""
    number = t_ns // period_ns
    return np.diff(number, prepend=last_ns // period_ns) > 0


def _placed(ports: Sequence[Port]) -> Iterator[tuple[Port, int]]:
    """The ports that can be drawn, each with its first float's index in a row."""
    first = 0
    for port in ports:
        line = len(port.shape) == 2 and port.shape[0] > 1 and port.shape[1] == 3
        point = port.shape == (3,) and port.name.endswith("position")
        if (line or point) and port.unit == "m" and port.frame == "NED":
            yield port, first
        first += port.size


def _east_north_down(placed: Sequence[tuple[Port, int]]) -> np.ndarray:
    """The columns of a row in which the placed ports' points stand, each as east, north, down."""
    columns = [first + 3 * i + axis for port, first in placed for i in range(port.size // 3) for axis in (1, 0, 2)]
    return np.array(columns)


def _numbers(count: int) -> Iterator[float]:
    """Doubles whose bytes can be found again in a message (any seed would do)."""
    return iter(np.random.default_rng(0).random(count).tolist())


def _drawing(topic: str, message: Message, placed: Sequence[tuple[Port, int]]) -> Drawing:
    """A drawing whose message was filled with _numbers in the order of the placed ports' points."""
    columns = _east_north_down(placed)
    data = message.SerializeToString(deterministic=True)
    runs = []
    offset = 0
    for column, number in enumerate(_numbers(len(columns))):
        offset = data.index(np.float64(number).tobytes(), offset)
        runs.append(Run(offset, column, 1))
    return Drawing(topic, type(message), Template(data, tuple(runs), _stamps(data)), columns)


def _stamps(data: bytes) -> tuple[int, ...]:
    """Where the bodies of all timestamps stand."""
    stamp = _STAMP.SerializeToString()
    found = []
    at = data.find(stamp)
    while at >= 0:
        found.append(at)
        at = data.find(stamp, at + len(stamp))
    return tuple(found)


def _scene(component: str, lines: Sequence[tuple[Port, int]], points: Sequence[tuple[Port, int]]) -> SceneUpdate:
    """One entity a port: a strip through a line's nodes, a sphere at a point."""
    scene = SceneUpdate()
    numbers = _numbers(sum(port.size for port, _ in [*lines, *points]))
    for port, _ in lines:
        entity = scene.entities.add(timestamp=_STAMP, frame_id=WORLD, id=f"{component}.{port.name}")
        strip = entity.lines.add(
            type=LinePrimitive.LINE_STRIP, thickness=_LINE_PIXELS, scale_invariant=True, color=_LINE_COLOR
        )
        strip.pose.orientation.w = 1.0
        for _ in range(port.shape[0]):
            strip.points.add(x=next(numbers), y=next(numbers), z=next(numbers))
    for port, _ in points:
        entity = scene.entities.add(timestamp=_STAMP, frame_id=WORLD, id=f"{component}.{port.name}")
        sphere = entity.spheres.add(color=_SPHERE_COLOR)
        sphere.pose.position.x, sphere.pose.position.y, sphere.pose.position.z = (next(numbers) for _ in range(3))
        sphere.pose.orientation.w = 1.0
        sphere.size.x = sphere.size.y = sphere.size.z = _SPHERE_METRES
    return scene


def _frames(component: str, points: Sequence[tuple[Port, int]]) -> FrameTransforms:
    """A frame at each point, parallel to the world's."""
    frames = FrameTransforms()
    numbers = _numbers(3 * len(points))
    for port, _ in points:
        name = f"{component}.{port.name}".removesuffix(".position")
        frame = frames.transforms.add(timestamp=_STAMP, parent_frame_id=WORLD, child_frame_id=name)
        frame.translation.x, frame.translation.y, frame.translation.z = (next(numbers) for _ in range(3))
        frame.rotation.w = 1.0
    return frames


def _cloud(topic: str, port: Port, first: int) -> Drawing:
    """A line's nodes as x, y, z in float32, what every viewer reads."""
    nodes = np.fromiter(_numbers(port.size), np.float64, port.size).astype("<f4").tobytes()
    cloud = PointCloud(timestamp=_STAMP, frame_id=WORLD, point_stride=3 * _FLOAT32, data=nodes)
    cloud.pose.orientation.w = 1.0
    for axis, name in enumerate("xyz"):
        cloud.fields.add(name=name, offset=axis * _FLOAT32, type=PackedElementField.FLOAT32)
    data = cloud.SerializeToString(deterministic=True)
    runs = (Run(data.index(nodes), 0, port.size, "<f4"),)
    return Drawing(topic, PointCloud, Template(data, runs, _stamps(data)), _east_north_down([(port, first)]))
