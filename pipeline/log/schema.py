"""The protobuf schema of a channel: a component's ports as a field tree with units and frames, and its template.

A dotted port name becomes nested messages, a scalar a double with explicit presence, an array a packed repeated double
in row-major order. Every field is always written, so that all messages of a channel have the same length.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count

from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.message import Message

from components.contract import ImagePort, Port
from pipeline.errors import LogError
from pipeline.log.template import Run, Template

PACKAGE = "towline"
_I64, _LEN = 1, 2  # protobuf wire types
_MESSAGE_TYPE, _FIELD, _NESTED_TYPE = 4, 2, 3  # field numbers in descriptor.proto, for paths of comments


@dataclass(frozen=True)
class Schema:
    """message: full name of a channel's protobuf message; descriptors: a serialised FileDescriptorSet that has it."""

    message: str
    descriptors: bytes


@dataclass
class _Bundle:
    """A node of the field tree: members by name, in order of first mention."""

    members: dict[str, _Bundle | tuple[Port, int]] = field(default_factory=dict)


def message_name(channel: str) -> str:
    """The full protobuf name of a channel's message; different channels give different names."""
    return f"{PACKAGE}.{_identifier(channel)}"


def _identifier(name: str) -> str:
    """A protobuf identifier, one to one: characters that may not stand in one are written as _x<hex>_."""
    safe = re.sub(r"[^A-Za-z0-9_]|_x", lambda match: f"_x{ord(match[0][0]):x}_{match[0][1:]}", name)
    return f"_x_{safe}" if not safe or safe[0].isdigit() else safe


def _tree(ports: Sequence[Port]) -> _Bundle:
    """The ports as a tree; leaves carry the index of the port's first float.

    Raises LogError if one name is both a port and a bundle, or stands twice.
    """
    root = _Bundle()
    first = 0
    for port in ports:
        bundle = root
        *path, leaf = port.name.split(".")
        for step in path:
            member = bundle.members.setdefault(step, _Bundle())
            if not isinstance(member, _Bundle):
                raise LogError(f"port {port.name}: {step} is a port already, so it cannot hold others")
            bundle = member
        if leaf in bundle.members:
            raise LogError(f"port {port.name} stands twice, or is a bundle of ports too")
        bundle.members[leaf] = (port, first)
        first += port.size
    return root


def describe(channel: str, ports: Sequence[Port]) -> FileDescriptorSet:
    """The schema of a channel's messages, with unit, shape, frame and description of each port as its comment."""
    file = FileDescriptorProto(name=f"{PACKAGE}/{_identifier(channel)}.proto", package=PACKAGE, syntax="proto3")
    message = file.message_type.add(name=_identifier(channel))
    _describe_bundle(_tree(ports), message, message_name(channel), (_MESSAGE_TYPE, 0), file)
    return FileDescriptorSet(file=[file])


def _describe_bundle(
    bundle: _Bundle, message: DescriptorProto, full_name: str, path: tuple[int, ...], file: FileDescriptorProto
) -> None:
    for number, (name, member) in zip(count(1), bundle.members.items(), strict=False):
        entry = message.field.add(name=_identifier(name), number=number, label=FieldDescriptorProto.LABEL_OPTIONAL)
        if isinstance(member, _Bundle):
            nested = message.nested_type.add(name=f"{_identifier(name)}_xbundle")
            entry.type = FieldDescriptorProto.TYPE_MESSAGE
            entry.type_name = f".{full_name}.{nested.name}"
            nested_path = (*path, _NESTED_TYPE, len(message.nested_type) - 1)
            _describe_bundle(member, nested, f"{full_name}.{nested.name}", nested_path, file)
            continue
        port, _ = member
        entry.type = FieldDescriptorProto.TYPE_DOUBLE
        if port.shape:
            entry.label = FieldDescriptorProto.LABEL_REPEATED
        else:
            entry.proto3_optional = True
            entry.oneof_index = len(message.oneof_decl)
            message.oneof_decl.add(name=f"_xoneof_{entry.name}")
        file.source_code_info.location.add(
            path=(*path, _FIELD, number - 1), span=(0, 0, 0), leading_comments=f" {comment(port)}\n"
        )


def comment(port: Port) -> str:
    """What a reader of the schema should know of a port, e.g. `[m] shape (3,), frame NED: end of the line`."""
    parts = [f"[{port.unit}]"]
    if port.shape:
        parts.append(f"shape ({', '.join(map(str, port.shape))}{',' if len(port.shape) == 1 else ''}) row-major")
    if port.frame:
        parts.append(f"frame {port.frame}")
    text = " ".join(parts)
    return f"{text}: {port.description}" if port.description else text


def template(ports: Sequence[Port]) -> Template:
    """The bytes of a message of these ports, as `describe` numbers the fields."""
    runs: list[Run] = []
    return Template(_encode(_tree(ports), 0, runs), tuple(runs))


def _encode(bundle: _Bundle, start: int, runs: list[Run]) -> bytes:
    """A bundle's bytes with zeros for floats; start: where they will stand in the message; runs: added to."""
    data = b""
    for number, member in enumerate(bundle.members.values(), 1):
        if isinstance(member, _Bundle):
            head = _varint(number << 3 | _LEN)
            body_bytes = len(_encode(member, 0, []))
            head += _varint(body_bytes)
            data += head + _encode(member, start + len(data) + len(head), runs)
            continue
        port, first = member
        if port.size == 0:
            continue
        head = _varint(number << 3 | _LEN) + _varint(8 * port.size) if port.shape else _varint(number << 3 | _I64)
        runs.append(Run(start + len(data) + len(head), first, port.size))
        data += head + bytes(8 * port.size)
    return data


def _varint(value: int) -> bytes:
    data = bytearray()
    while value > 0x7F:
        data.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*data, value])


def ports_to_json(ports: Sequence[Port]) -> str:
    """The ports as the channel's metadata keeps them."""
    return json.dumps(
        [
            {"name": p.name, "unit": p.unit, "shape": p.shape, "frame": p.frame, "description": p.description}
            | ({"image": True} if isinstance(p, ImagePort) else {})
            for p in ports
        ]
    )


def ports_from_json(text: str) -> tuple[Port, ...]:
    """The ports of `ports_to_json`. Raises ValueError if the text is something else."""
    try:
        return tuple(
            (ImagePort if p.get("image") else Port)(
                p["name"], p["unit"], tuple(map(int, p["shape"])), p["frame"], p["description"]
            )
            for p in json.loads(text)
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not a list of ports: {error}") from error


def describe_message(message: type[Message]) -> FileDescriptorSet:
    """The schema of a ready-made message: its file with all files that it imports, imports first."""
    files = {}

    def collect(file) -> None:
        for imported in file.dependencies:
            collect(imported)
        files.setdefault(file.name, file)

    collect(message.DESCRIPTOR.file)
    result = FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(result.file.add())
    return result
