"""Markers from an MCAP file of another tool: protobuf or JSON messages that hold a list of points."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
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
from pipeline.analysis.message_frames import Messages
from pipeline.analysis.message_points import Json, lists_of_points, may_come, members, points_of
from pipeline.analysis.reading import Reading
from pipeline.analysis.vertical import in_ned
from pipeline.analysis.zeros import without_zeros
from pipeline.errors import LogError

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

    A message is a frame; its points are the markers by their ids, else in their order; those with a coordinate null or
    not a number are not seen. Raises LogError if the file cannot be read or holds no such topic or field, by name.
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
            f"x, y, z that are numbers; it has {have}"
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
    """The topic's frames; None if its messages have no points and it was not asked for by name.

    Messages before the first with points are frames in which no marker was seen.
    """
    name = f"{path}: channel {topic.channel.topic}"
    messages, steps, last = Messages(), None, None
    for _, _, message in make_reader(file).iter_messages(topics=[topic.channel.topic]):
        at = f"{name}: message at {message.log_time / 1e9:.9g} s"
        last = _decoded(topic, message.data, at)
        if steps is None:
            steps = _field(last, name, topic.kind, reading)
        if steps is not None:
            messages.add(message.log_time, *points_of(last, steps, at), at)
        elif reading.channel is not None or may_come(last):
            messages.add(message.log_time, [], None, at)
        else:
            return None
    if last is None and reading.channel is not None:
        raise LogError(f"{name} has no messages")
    if steps is None and reading.channel is not None:
        wanted = f"no list of points {reading.field}" if reading.field else "no list of points x, y, z"
        raise LogError(f"{name} ({topic.kind}) holds {wanted}; it has {members(last)}")
    if steps is None:
        return None
    times = messages.times
    different = len(np.unique(times))
    if len(times) > 2 and 2 * different < len(times):  # as of a table: of equal times only the first would be kept
        raise LogError(f"{name}: {len(times)} messages have {different} different log times")
    frames = marker_frames(np.array(times), messages.position(name), source=f"{path}: {topic.channel.topic}")
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
    """The way to the list of points; None if there is none."""
    found = {".".join(steps): steps for steps in lists_of_points(value, ())}
    if reading.field is not None and reading.field in found:
        return found[reading.field]
    if len(found) == 1 and reading.field is None:
        return next(iter(found.values()))
    if reading.field is None and found:
        raise LogError(f"{name} ({kind}) has several lists of points: {', '.join(found)}; choose one with --field")
    return None
