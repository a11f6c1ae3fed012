"""Writes a run into one MCAP file: rows of floats become protobuf messages in bulk, in chunks merged by time."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from io import BufferedWriter
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import Message
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import LIBRARY_IDENTIFIER, MCAP0_MAGIC, CompressionType

from components.contract import ImagePort, Port, parted, placed_images
from pipeline.errors import LogError
from pipeline.log import images
from pipeline.log.chunk import Block, Writer
from pipeline.log.conventions import (
    CHECKSUM_KEY,
    EVENTS,
    PORTS_KEY,
    PROFILE,
    SNAPSHOTS,
    Event,
    Snapshot,
    metadata_checksum,
)
from pipeline.log.scene import Drawing, drawings, keep_at_rate
from pipeline.log.schema import Schema, describe, describe_message, message_name, ports_to_json, template
from pipeline.log.template import HEAD_BYTES, Template

# Twice as fast as zstd in both directions; files are 5 % (long messages) to 40 % (short ones) larger.
COMPRESSION = "lz4"
CHUNK_BYTES = 1 << 20
SCENE_PERIOD_NS = 40_000_000  # 25 Hz
_HELD_CHUNKS = 8  # rows of one slice held back for merging by time never take more than this many chunks
COMPRESSIONS = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4, "none": CompressionType.NONE}
_MEDIA_TYPES = {".yaml": "application/yaml", ".json": "application/json", ".csv": "text/csv"}


def pack_rows(t_ns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Rows as `Recorder.rows` takes them, (k, 1 + n) float64, from times (k,) [ns] and values (k, n)."""
    rows = np.empty((len(t_ns), 1 + values.shape[1]))
    rows[:, 0] = np.asarray(t_ns, np.int64).view(np.float64)
    rows[:, 1:] = values
    return rows


@dataclass(frozen=True)
class ChannelSpec:
    """A component's channel: its name (the topic), output ports and facts worth keeping (model, period, ...)."""

    name: str
    ports: tuple[Port, ...]
    metadata: Mapping[str, str] = field(default_factory=dict)


class _Stream:
    """What turns a component's rows into messages of one MCAP channel, and the rows held back for merging by time."""

    def __init__(self, channel: int, template: Template):
        self.channel = channel
        self.template = template
        self.t_ns: list[np.ndarray] = []
        self.rows: list[np.ndarray] = []

    def hold(self, t_ns: np.ndarray, rows: np.ndarray) -> int:
        """Keep rows (k, n) for later; the number of bytes they will take."""
        self.t_ns.append(t_ns)
        self.rows.append(rows)
        return len(t_ns) * self.template.record_bytes

    def release(self, sequence: int) -> Block:
        """All rows held, numbered from `sequence`."""
        block = Block(self.channel, sequence, self.template, np.concatenate(self.t_ns), np.concatenate(self.rows))
        self.t_ns.clear()
        self.rows.clear()
        return block


class Audience(Protocol):
    """Takes messages as they are recorded."""

    def declare(self, topic: str, message: str, descriptors: bytes) -> None:
        """Make a channel known. message: its full protobuf name; descriptors: a FileDescriptorSet that has it."""

    def is_wanted(self, topic: str) -> bool:
        """Whether its messages are to be put."""
        ...

    def put(self, topic: str, t_ns: int, payload: bytes) -> None:
        """Take a message."""


@dataclass
class _Source:
    """A component's channel: its messages, what viewers draw of them, and its images.

    images: port, columns of a row, MCAP channel. columns: of a row with images.
    """

    name: str
    stream: _Stream
    drawings: list[tuple[Drawing, _Stream]]
    images: list[tuple[ImagePort, slice, int]]
    columns: int
    last_ns: int = -1


def _beginning(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read(len(MCAP0_MAGIC))


def _create(path: Path, overwrite: bool) -> BufferedWriter:
    """A new file, and its folder; of existing ones only logs and empty files are replaced, and only if asked.

    Raises LogError if it exists or cannot be made.
    """
    try:
        if path.exists() and not overwrite:
            raise LogError(f"{path} exists already; choose another name, or give --overwrite")
        if path.is_file() and _beginning(path) not in (b"", MCAP0_MAGIC):
            raise LogError(f"{path} is not an MCAP file: it is not replaced; choose another name")
        path.parent.mkdir(parents=True, exist_ok=True)
        return open(path, "wb" if overwrite else "xb")
    except OSError as error:
        raise LogError(f"{path}: cannot create the log: {error.strerror}") from error


class Recorder:
    """An open log. Times are simulated nanoseconds from 0 on; a channel's rows come in order of time.

    Rows are held until the next slice of simulated time begins and a chunk is full, so that chunks follow each other
    in time. On leaving the `with` block after an exception the file is left without its end, as an interrupted log.
    All methods raise LogError if the file cannot be written; what was written before stays readable as interrupted.
    """

    def __init__(
        self,
        path: Path | str,
        channels: Sequence[ChannelSpec],
        *,
        attachments: Mapping[str, bytes] | None = None,
        metadata: Mapping[str, Mapping[str, str]] | None = None,
        compression: str = COMPRESSION,
        chunk_bytes: int = CHUNK_BYTES,
        scene_period_ns: int | None = SCENE_PERIOD_NS,
        overwrite: bool = False,
    ):
        """Create the file, its folder too, and write all that is known before the first step.

        channels: in the order that `rows` counts them. compression: zstd, lz4 or none. chunk_bytes: when a chunk is
        finished, before compression. scene_period_ns: None leaves the channels for 3D viewers out.
        """
        if compression not in COMPRESSIONS:
            raise LogError(f"compression {compression!r} is not known; use one of {', '.join(COMPRESSIONS)}")
        # May refuse, so before there is a file.
        schemas = [describe(spec.name, parted(spec.ports)[0]) for spec in channels]
        self.path = Path(path)
        self._chunk_bytes = chunk_bytes
        self._scene_period_ns = scene_period_ns or 0
        self._held: list[_Stream] = []
        self._held_bytes = 0
        self._horizon_ns = -1
        self._sequences: dict[int, int] = defaultdict(int)
        self._topics: dict[str, int] = {}
        self._described: dict[int, tuple[str, Schema]] = {}  # by MCAP channel: its topic, and what its messages are
        self._audiences: list[Audience] = []
        self._schemas: dict[str, int] = {}
        self._file = _create(self.path, overwrite)
        self._open = True
        self._writer = Writer(
            self._file, chunk_size=chunk_bytes, compression=COMPRESSIONS[compression], enable_data_crcs=True
        )
        with self._guarded():
            self._writer.start(PROFILE, LIBRARY_IDENTIFIER)
            self._sources = [self._source(*both) for both in zip(channels, schemas, strict=True)]
            self._events = self._channel(EVENTS, Event)
            self._snapshots = self._channel(SNAPSHOTS, Snapshot)
            for name, data in (attachments or {}).items():
                media_type = _MEDIA_TYPES.get(Path(name).suffix, "application/octet-stream")
                self._writer.add_attachment(0, 0, name, media_type, data)
            for name, pairs in (metadata or {}).items():
                self.add_metadata(name, pairs)
            self._file.flush()

    def _source(self, spec: ChannelSpec, described: FileDescriptorSet) -> _Source:
        """Register a component's channel and those of its drawings and images."""
        numbers, _ = parted(spec.ports)
        data = described.SerializeToString(deterministic=True)
        schema = self._writer.register_schema(message_name(spec.name), SchemaEncoding.Protobuf, data)
        pairs = {**spec.metadata, PORTS_KEY: ports_to_json(spec.ports)}
        channel = self._writer.register_channel(spec.name, MessageEncoding.Protobuf, schema, pairs)
        self._described[channel] = spec.name, Schema(message_name(spec.name), data)
        found = drawings(spec.name, numbers) if self._scene_period_ns else []
        drawn = [(one, _Stream(self._channel(one.topic, one.message), one.template)) for one in found]
        seen = [
            (port, slice(1 + at.start, 1 + at.stop), self._channel(images.topic(spec.name, port.name), CompressedImage))
            for port, at in placed_images(spec.ports)
        ]
        columns = 1 + sum(port.size for port in spec.ports)
        return _Source(spec.name, _Stream(channel, template(numbers)), drawn, seen, columns)

    def _channel(self, topic: str, message: type[Message]) -> int:
        """The MCAP channel of a topic with a ready-made message type, registered at its first mention."""
        name = message.DESCRIPTOR.full_name
        if name not in self._schemas:
            data = describe_message(message).SerializeToString(deterministic=True)
            self._schemas[name] = self._writer.register_schema(name, SchemaEncoding.Protobuf, data)
        if topic not in self._topics:
            channel = self._writer.register_channel(topic, MessageEncoding.Protobuf, self._schemas[name])
            self._topics[topic] = channel
            descriptors = describe_message(message).SerializeToString(deterministic=True)
            self._described[channel] = topic, Schema(name, descriptors)
        return self._topics[topic]

    def publish(self, audience: Audience) -> None:
        """Show whoever wants it all that is recorded from here on."""
        for topic, schema in self._described.values():
            audience.declare(topic, schema.message, schema.descriptors)
        self._audiences.append(audience)

    def rows(self, channel: int, rows: np.ndarray) -> None:
        """Append messages to the channel of this number.

        rows: (k, 1 + n) float64, column 0 holds the bits of int64 nanoseconds, the others the n floats of the ports,
        those of images last; these may be left out where the images come by `image`. The array may be used again after
        the call. Raises LogError if time is negative or goes back.
        """
        if len(rows) == 0:
            return
        source = self._sources[channel]
        expected = 1 + source.stream.template.floats
        if rows.shape[1] not in (expected, source.columns):
            raise LogError(f"channel {source.name}: rows have {rows.shape[1]} columns where {expected} are expected")
        seen, rows = rows, np.array(rows[:, :expected], np.float64, order="C")
        t_ns = rows[:, 0].view(np.int64)
        if t_ns[0] < max(source.last_ns, 0) or (np.diff(t_ns) < 0).any():
            raise LogError(f"channel {source.name}: time is negative or goes back after {source.last_ns} ns")
        with self._guarded():
            self._write_if_enough(int(t_ns[0]))
            self._hold(source.stream, t_ns, rows[:, 1:])
            for drawing, stream in source.drawings:
                kept = keep_at_rate(t_ns, self._scene_period_ns, source.last_ns)
                self._hold(stream, t_ns[kept], drawing.floats(rows[kept, 1:]))
            for port, columns, number in source.images if seen.shape[1] > expected else ():
                for at, row in zip(t_ns.tolist(), seen, strict=True):
                    image = images.message(port.frame or source.name, at, port.in_words(row[columns]))
                    self._hold_message(number, at, image)
        source.last_ns = int(t_ns[-1])

    def image(self, topic: str, t_ns: int, payload: bytes) -> None:
        """Append an image as another log holds it, whose row comes without."""
        with self._guarded():
            self._write_if_enough(t_ns)
            self._hold_message(self._topics[topic], t_ns, payload)

    def event(self, t_ns: int, text: str) -> None:
        """Record what happened at t_ns."""
        self._remark(self._events, t_ns, Event(text=text))

    def snapshot(self, t_ns: int, state: bytes) -> None:
        """Record the whole state of the run at t_ns, to resume from."""
        self._remark(self._snapshots, t_ns, Snapshot(state=state))

    def _remark(self, channel: int, t_ns: int, message: Message) -> None:
        if t_ns < 0:
            raise LogError(f"{self.path}: time {t_ns} ns is negative")
        with self._guarded():
            self._hold_message(channel, t_ns, message.SerializeToString())

    def add_metadata(self, name: str, pairs: Mapping[str, str]) -> None:
        """Add a record of facts known only now, e.g. how the run ended."""
        with self._guarded():
            self._writer.add_metadata(name, {**pairs, CHECKSUM_KEY: metadata_checksum(pairs)})

    def _hold_message(self, channel: int, t_ns: int, payload: bytes) -> None:
        """Keep one message of a channel whose messages have no fixed shape."""
        self._hold(_Stream(channel, Template(payload, ())), np.array([t_ns], np.int64), np.empty((1, 0)))

    def _hold(self, stream: _Stream, t_ns: np.ndarray, rows: np.ndarray) -> None:
        if len(t_ns) == 0:
            return
        for audience in self._audiences:
            self._show(audience, stream, t_ns, rows)
        if stream not in self._held:
            self._held.append(stream)
        self._held_bytes += stream.hold(t_ns, rows)
        self._horizon_ns = max(self._horizon_ns, int(t_ns[-1]))

    def _show(self, audience: Audience, stream: _Stream, t_ns: np.ndarray, rows: np.ndarray) -> None:
        """Messages as they will stand in the log."""
        topic, _ = self._described[stream.channel]
        if not audience.is_wanted(topic):
            return
        records = stream.template.fill(stream.channel, 0, t_ns, rows)
        for at, record in zip(t_ns.tolist(), records, strict=True):
            audience.put(topic, at, record.tobytes()[HEAD_BYTES:])

    def _write_if_enough(self, t_ns: int) -> None:
        """Write what is held if it fills a chunk and a new slice begins at t_ns, or if it is too much to hold."""
        begins_slice = t_ns > self._horizon_ns
        if self._held_bytes >= (self._chunk_bytes if begins_slice else _HELD_CHUNKS * self._chunk_bytes):
            self._write_held()

    def _write_held(self) -> None:
        blocks = []
        for stream in self._held:
            block = stream.release(self._sequences[stream.channel])
            self._sequences[stream.channel] += len(block.t_ns)
            blocks.append(block)
        self._held.clear()
        self._held_bytes = 0
        if blocks:
            self._writer.add_blocks(blocks)

    def flush(self) -> None:
        """Write everything so far: a process killed after this leaves a log that is readable up to here."""
        with self._guarded():
            self._write_held()
            self._writer.flush()

    def close(self) -> None:
        """Write everything and the end of the file, without which a log counts as interrupted."""
        if not self._open:
            return
        with self._guarded():
            self._write_held()
            self._writer.finish()
            self._file.close()
        self._open = False

    def abort(self) -> None:
        """Close the file without its end, keeping what can still be written."""
        if not self._open:
            return
        with suppress(LogError):
            self.flush()
        self._drop()

    def _drop(self) -> None:
        """Close the file as it is; what Python holds in its buffer is lost."""
        self._open = False
        with suppress(OSError):
            self._file.raw.close()

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        """Leave the file as it is after whatever interrupts a write, and turn a failed one into a LogError."""
        if not self._open:
            raise LogError(f"{self.path}: the log is closed")
        try:
            yield
        except BaseException as error:
            self._drop()
            if not isinstance(error, OSError):
                raise
            raise LogError(
                f"{self.path}: cannot write the log: {error.strerror or error}; "
                "what was written before stays readable as an interrupted log"
            ) from error

    def __enter__(self) -> Self:
        """The recorder itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the log, or leave it interrupted after an exception."""
        if kind is None:
            self.close()
        else:
            self.abort()
