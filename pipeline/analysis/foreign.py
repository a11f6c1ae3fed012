"""Markers from an MCAP file of another tool: protobuf or JSON messages that hold a list of points."""

from __future__ import annotations

import json
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
from pipeline.analysis.vertical import Up, in_ned
from pipeline.errors import LogError

Json = Any  # what json.loads gives


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


def from_mcap(path: Path, topic: str | None = None, up: Up | None = None) -> dict[str, MarkerFrames]:
    """Markers by topic: of one topic, or of all whose messages hold points. up: as vertical.in_ned takes it.

    A message is a frame; its points are the markers in their order, those with a coordinate null or not a number are
    not seen. Raises LogError if the file cannot be read or holds no such topic, by name.
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
            wanted = _wanted(path, topics, topic)
            found = {one.channel.topic: _read(path, file, one, topic is not None, up) for one in wanted}
    except OSError as error:
        raise LogError(f"{path}: cannot read the file: {error.strerror or error}") from error
    except (McapError, DecodeError, UnicodeDecodeError, json.JSONDecodeError) as error:
        raise LogError(f"{path}: not a readable MCAP file: {error}") from error
    return {name: frames for name, frames in found.items() if frames is not None}


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


def _read(path: Path, file: Any, topic: Topic, must: bool, up: Up | None) -> MarkerFrames | None:
    """The topic's frames; None if its first message has no points and it was not asked for by name."""
    assert topic.decode is not None
    times, rows, steps = [], [], None
    for _, _, message in make_reader(file).iter_messages(topics=[topic.channel.topic]):
        value = topic.decode(message.data)
        if steps is None:
            steps = next(_lists(value, ()), None)
            if steps is None and not must:
                return None
            if steps is None:
                raise LogError(f"{path}: channel {topic.channel.topic} ({topic.kind}) holds no list of points x, y, z")
        points = [_point(one) for one in _follow(value, steps)]
        if rows and len(points) != len(rows[0]):
            text = f"{len(points)} points at {message.log_time / 1e9:.6g} s, {len(rows[0])} before"
            raise LogError(f"{path}: channel {topic.channel.topic}: {text}: which marker is which is not known")
        times.append(message.log_time)
        rows.append(points)
    if not rows:
        return None
    position = np.array(rows, np.float64)
    return in_ned(marker_frames(np.array(times), position, source=f"{path}: {topic.channel.topic}"), up)


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


def _follow(value: Json, steps: tuple[str, ...]) -> Json:
    for step in steps:
        value = value[step]
    return value


def _coordinates(value: Json) -> Json:
    """What holds x, y and z of a point or of a pose."""
    return value.get("position", value) if isinstance(value, dict) else value


def _is_point(value: Json) -> bool:
    inner = _coordinates(value)
    return set("xyz") <= set(inner) if isinstance(inner, dict) else isinstance(inner, list) and len(inner) == 3


def _point(value: Json) -> list[float]:
    """x, y, z; a point that is null, and what is null or text such as "NaN" in it, counts as not a number."""
    inner = _coordinates(value)
    numbers = [inner[axis] for axis in "xyz"] if isinstance(inner, dict) else inner or [None] * 3
    return [float(number) if isinstance(number, int | float) else np.nan for number in numbers]
