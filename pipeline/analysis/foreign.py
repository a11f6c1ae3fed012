"""Markers from an MCAP file of another tool: protobuf or JSON messages that hold a list of points."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.json_format import MessageToDict
from google.protobuf.message import DecodeError
from google.protobuf.message_factory import GetMessageClass
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Schema

from pipeline.analysis.markers import MarkerFrames, marker_frames
from pipeline.analysis.reading import Reading
from pipeline.analysis.vertical import in_ned
from pipeline.analysis.zeros import without_zeros
from pipeline.errors import LogError
from pipeline.quantities import shown

Json = Any  # what json.loads gives
# What readers of a damaged file and decoders of a strange message raise.
DAMAGED = (McapError, DecodeError, ValueError, KeyError, TypeError, RuntimeError, EOFError, OverflowError, struct.error)


@dataclass(frozen=True)
class Topic:
    """A channel of the file and how its messages become JSON objects; decode None: not a known encoding."""

    channel: Channel
    schema: Schema | None
    decode: Callable[[bytes], Json] | None

    @property
    def kind(self) -> str:
        """Encoding and schema, for messages to the user."""
        return f"{self.channel.message_encoding} {self.schema.name if self.schema else ''}".strip()


def from_mcap(path: Path, reading: Reading) -> dict[str, MarkerFrames]:
    """Markers by topic: of one topic, or of all whose messages hold points.

    A message is a frame; its points are the markers in their order, those with a coordinate null or not a number are
    not seen. Raises LogError if the file cannot be read or holds no such topic or field, by name.
    """
    try:
        with open(path, "rb") as file:
            summary = make_reader(file).get_summary()
            if summary is None:
                raise LogError(f"{path}: the file has no summary: it was interrupted; repair it (mcap recover)")
            topics = {
                channel.topic: _topic(channel, summary.schemas.get(channel.schema_id))
                for channel in summary.channels.values()
            }
            wanted = _wanted(path, topics, reading.channel)
            found = {one.channel.topic: _read(path, file, one, reading) for one in wanted}
    except OSError as error:
        raise LogError(f"{path}: cannot read the file: {error.strerror or error}") from error
    except DAMAGED as error:
        text = str(error).splitlines()
        raise LogError(f"{path}: not a readable MCAP file: {text[0] if text else type(error).__name__}") from error
    taken = {name: frames for name, frames in found.items() if frames is not None}
    if not taken and reading.field is not None:
        raise LogError(f"{path}: no channel has a list of points {reading.field}; it has {', '.join(topics) or 'none'}")
    if not taken:
        have = ", ".join(f"{name} ({one.kind})" for name, one in topics.items()) or "no channels"
        raise LogError(
            f"{path} has no markers: protobuf or json messages are needed, each with a list of at least three points "
            f"x, y, z from the first message on; it has {have}"
        )
    return taken


def _topic(channel: Channel, schema: Schema | None) -> Topic:
    if channel.message_encoding == "json":
        return Topic(channel, schema, json.loads)
    if channel.message_encoding == "protobuf" and schema is not None:
        return Topic(channel, schema, _protobuf(schema))
    return Topic(channel, schema, None)


def _protobuf(schema: Schema) -> Callable[[bytes], Json]:
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(schema.data).file:
        pool.Add(file)
    message = GetMessageClass(pool.FindMessageTypeByName(schema.name))
    return lambda data: MessageToDict(
        message.FromString(data), preserving_proto_field_name=True, always_print_fields_with_no_presence=True
    )


def _wanted(path: Path, topics: dict[str, Topic], name: str | None) -> list[Topic]:
    if name is None:
        return [one for one in topics.values() if one.decode]
    if name not in topics:
        raise LogError(f"{path} has no channel {name}; it has {', '.join(topics) or 'none'}")
    if topics[name].decode is None:
        raise LogError(f"{path}: channel {name} is {topics[name].kind}; only protobuf and json are read here")
    return [topics[name]]


def _read(path: Path, file: Any, topic: Topic, reading: Reading) -> MarkerFrames | None:
    """The topic's frames; None if its first message has no points and it was not asked for by name."""
    name = f"{path}: channel {topic.channel.topic}"
    times, rows, steps = [], [], None
    for _, _, message in make_reader(file).iter_messages(topics=[topic.channel.topic]):
        at = f"{name}: message at {message.log_time / 1e9:.9g} s"
        value = _decoded(topic, message.data, at)
        if steps is None:
            steps = _field(value, name, topic.kind, reading)
            if steps is None:
                return None
        points = _points(value, steps, at)
        if rows and len(points) != len(rows[0]):
            raise LogError(f"{at}: {len(points)} points, {len(rows[0])} before: which marker is which is not known")
        times.append(message.log_time)
        rows.append(points)
    if not rows:
        if reading.channel is not None:
            raise LogError(f"{name} has no messages")
        return None
    different = len(np.unique(times))
    if len(times) > 2 and 2 * different < len(times):  # as of a table: of equal times only the first would be kept
        raise LogError(f"{name}: {len(times)} messages have {different} different log times")
    frames = marker_frames(np.array(times), np.array(rows, np.float64), source=f"{path}: {topic.channel.topic}")
    return in_ned(without_zeros(frames), reading.up)


def _decoded(topic: Topic, data: bytes, at: str) -> Json:
    assert topic.decode is not None
    try:
        return topic.decode(data)
    except (*DAMAGED, RecursionError) as error:
        raise LogError(
            f"{at}: not {topic.kind}: {str(error).splitlines()[0] if str(error) else 'unreadable'}"
        ) from error


def _field(value: Json, name: str, kind: str, reading: Reading) -> tuple[str, ...] | None:
    """The way to the list of points; None if there is none and the channel was not asked for by name."""
    found = {".".join(steps): steps for steps in _lists(value, ())}
    if reading.field is not None and reading.field in found:
        return found[reading.field]
    if len(found) == 1 and reading.field is None:
        return next(iter(found.values()))
    if reading.field is None and found:
        raise LogError(f"{name} ({kind}) has several lists of points: {', '.join(found)}; choose one with --field")
    if reading.channel is None:
        return None
    wanted = f"no list of points {reading.field}" if reading.field else "no list of points x, y, z"
    raise LogError(f"{name} ({kind}) holds {wanted}; it has {_members(value)}")


def _members(value: Json) -> str:
    """What a message holds, for messages to the user."""
    if not isinstance(value, dict):
        return f"a {type(value).__name__} as a whole"
    return ", ".join(map(str, list(value)[:8])) or "no fields"


def _points(value: Json, steps: tuple[str, ...], at: str) -> list[list[float]]:
    """The markers' coordinates. Raises LogError, at the message, where there are none."""
    for i, step in enumerate(steps):
        if not isinstance(value, dict) or step not in value:
            inside = f" in {'.'.join(steps[:i])}" if i else ""
            raise LogError(f"{at} has no {step}{inside}; it has {_members(value)}")
        value = value[step]
    if not isinstance(value, list):
        raise LogError(f"{at}: {'.'.join(steps)} is {_shown(value)}, not a list of points")
    wrong = next((i for i, one in enumerate(value) if one is not None and not _is_point(one)), None)
    if wrong is not None:
        raise LogError(f"{at}: {'.'.join(steps)}[{wrong}] is {_shown(value[wrong])}, not a point x, y, z")
    return [_point(one) for one in value]


def _shown(value: Json) -> str:
    return shown(value if isinstance(value, str) else json.dumps(value, default=str))


def _lists(value: Json, steps: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Ways to the lists of points within a message, the outermost first."""
    for name, member in value.items() if isinstance(value, dict) else ():
        if isinstance(member, list) and _are_points(member):
            yield (*steps, name)
        yield from _lists(member, (*steps, name))


def _are_points(values: list[Json]) -> bool:
    """At least three points; some may be null."""
    given = [value for value in values if value is not None]
    return len(values) >= 3 and bool(given) and all(_is_point(value) for value in given)


def _coordinates(value: Json) -> Json:
    """What holds x, y and z of a point or of a pose."""
    return value.get("position", value) if isinstance(value, dict) else value


def _is_point(value: Json) -> bool:
    inner = _coordinates(value)
    if isinstance(inner, dict):
        return set("xyz") <= set(inner)
    return isinstance(inner, list) and len(inner) == 3 and not any(isinstance(one, list | dict) for one in inner)


def _point(value: Json) -> list[float]:
    """x, y, z; a point that is null, and what is null or text such as "NaN" in it, counts as not a number."""
    inner = _coordinates(value)
    numbers = [inner[axis] for axis in "xyz"] if isinstance(inner, dict) else inner or [None] * 3
    return [_number(number) for number in numbers]


def _number(value: Json) -> float:
    try:
        return float(value) if isinstance(value, int | float) else np.nan
    except OverflowError:
        return np.nan
