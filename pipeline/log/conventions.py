"""What makes an MCAP file a log of Towline: its profile, keys of metadata, and the channels beside the components'."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from typing import Any

from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass

PROFILE = "towline"  # of the MCAP header
PORTS_KEY = "ports"  # in a component channel's metadata: its ports as JSON
CHECKSUM_KEY = "crc32"  # in every metadata record: see metadata_checksum
RESULT, ENDING, COMPLETE = "result", "ending", "complete"  # metadata of how the run ended, its key, its good value
SPEED = "real_time_factor"  # another key of it
EVENTS, SNAPSHOTS = "towline/events", "towline/snapshots"  # topics: what happened; where to resume from
_PACKAGE = "towline_log"


def _describe() -> FileDescriptorProto:
    """Event {string text} and Snapshot {bytes state}."""
    file = FileDescriptorProto(name=f"{_PACKAGE}/remarks.proto", package=_PACKAGE, syntax="proto3")
    for message, field, kind in (
        ("Event", "text", FieldDescriptorProto.TYPE_STRING),
        ("Snapshot", "state", FieldDescriptorProto.TYPE_BYTES),
    ):
        file.message_type.add(name=message).field.add(
            name=field, number=1, type=kind, label=FieldDescriptorProto.LABEL_OPTIONAL
        )
    return file


_pool = DescriptorPool()
_pool.Add(_describe())
Event: Any = GetMessageClass(_pool.FindMessageTypeByName(f"{_PACKAGE}.Event"))
Snapshot: Any = GetMessageClass(_pool.FindMessageTypeByName(f"{_PACKAGE}.Snapshot"))


def metadata_checksum(pairs: Mapping[str, str]) -> str:
    """CRC-32 of a metadata record's pairs, which MCAP itself does not protect."""
    text = "\0".join(part for key in sorted(pairs) for part in (key, pairs[key]))
    return f"{zlib.crc32(text.encode()):08x}"
