"""Reads a log back as arrays: messages are found through the chunks' indexes and gathered without a loop over them."""

from __future__ import annotations

import os
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, ChunkIndex, Message, Metadata

from components.contract import ImagePort, Port, parted
from pipeline.errors import LogError
from pipeline.log import images
from pipeline.log.contents import DAMAGE, PREFIX, chunk_data, index_entries, read_contents
from pipeline.log.conventions import (
    CHECKSUM_KEY,
    COMPLETE,
    ENDING,
    EVENTS,
    PORTS_KEY,
    PROFILE,
    RESULT,
    SNAPSHOTS,
    Event,
    Snapshot,
    metadata_checksum,
)
from pipeline.log.schema import Schema, describe, ports_from_json, template
from pipeline.log.template import Template

if TYPE_CHECKING:
    import pandas

_CRC_BYTES = 4
FRESH_S = 10.0  # since the last write: a run writes each second, but for one block of ticks that takes longer


@dataclass(frozen=True)
class ChannelInfo:
    """A component's channel in a log. metadata: as given to the recorder.

    ports: the numbers in its messages. images: outputs that have channels of their own, see Log.images.
    """

    name: str
    ports: tuple[Port, ...]
    count: int
    metadata: Mapping[str, str]
    number: int
    template: Template
    images: tuple[ImagePort, ...] = ()

    def port(self, name: str) -> tuple[Port, slice]:
        """The port of this name and its floats' place in a row. Raises LogError if there is none."""
        first = 0
        for port in self.ports:
            if port.name == name:
                return port, slice(first, first + port.size)
            first += port.size
        raise LogError(f"channel {self.name} has no port {name}; it has {', '.join(p.name for p in self.ports)}")


def open_log(path: Path | str) -> Log:
    """Open a log, whole, interrupted or still being written: what is read is what stood in it when it was opened.

    Raises LogError if there is no such file, or it is empty, not MCAP, not Towline's or damaged beyond reading.
    """
    return Log(Path(path))


class Log:
    """An open log. Methods that read messages raise LogError if what they need is damaged, never give wrong numbers."""

    def __init__(self, path: Path):
        """See open_log."""
        self.path = path
        try:
            self._file = open(path, "rb")  # noqa: SIM115 - closed by close
        except OSError as error:
            raise LogError(f"{path}: cannot open the log: {error.strerror}") from error
        try:
            contents = read_contents(self._file)
            if contents.profile != PROFILE:
                raise ValueError(f"the file is MCAP, but not a log of Towline (its profile is {contents.profile!r})")
            self._summary = contents.summary
            self.complete = contents.whole
            statistics = contents.summary.statistics
            if statistics is None:
                raise ValueError("the file has no statistics")
            self.start_ns, self.end_ns = statistics.message_start_time, statistics.message_end_time
            self._count = statistics.message_count
            self._counts = statistics.channel_message_counts
            self.channels = self._read_channels(self._counts)
        except (OSError, *DAMAGE) as error:
            self._file.close()
            raise LogError(f"{path}: {error}") from error

    @property
    def warning(self) -> str:
        """What the user should know before trusting the log; empty if it is whole and its run came to its end."""
        end = f"readable up to {self.end_ns / 1e9:.6g} s of simulated time"
        if not self.complete:
            fresh = time.time() - os.fstat(self._file.fileno()).st_mtime < FRESH_S
            said = "is still being written, or was interrupted" if fresh else "was interrupted"
            return f"{self.path} {said}: {end if self.channels else 'nothing is in it yet'}"
        try:
            ending = self.metadata(RESULT).get(ENDING, COMPLETE)
        except LogError as error:
            return str(error)
        return "" if ending == COMPLETE else f"{self.path} holds a run that ended early ({ending}): {end}"

    def _read_channels(self, counts: Mapping[int, int]) -> dict[str, ChannelInfo]:
        """The components' channels by name, in the order of recording. counts: messages by MCAP channel."""
        found = {}
        for number, channel in sorted(self._summary.channels.items()):
            if PORTS_KEY not in channel.metadata:
                continue
            ports, seen = parted(ports_from_json(channel.metadata[PORTS_KEY]))
            schema = self._summary.schemas[channel.schema_id]
            if FileDescriptorSet.FromString(schema.data) != describe(channel.topic, ports):
                raise ValueError(f"the schema of channel {channel.topic} does not fit its ports")
            facts = {key: value for key, value in channel.metadata.items() if key != PORTS_KEY}
            info = ChannelInfo(channel.topic, ports, counts.get(number, 0), facts, number, template(ports), seen)
            found[channel.topic] = info
        return found

    def channel(self, name: str) -> ChannelInfo:
        """What is known of a component's channel. Raises LogError if the log has no such channel."""
        if name not in self.channels:
            raise LogError(f"{self.path} has no channel {name}; it has {', '.join(self.channels) or 'none'}")
        return self.channels[name]

    def parts(self, names: Sequence[str]) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
        """Channel, times (k,) int64 [ns] and values (k, n) float64, chunk by chunk: for logs larger than memory.

        Raises LogError at the end if there were more or fewer messages than the log counts.
        """
        wanted = [self.channel(name) for name in names]
        found = {name: 0 for name in names}
        for chunk in self._chunks([one.number for one in wanted]):
            for one in wanted:
                if one.number in chunk.index.message_index_offsets:
                    records = chunk.gather(one)
                    values = np.empty((len(records), one.template.floats))
                    one.template.copy_floats(records, values)
                    found[one.name] += len(records)
                    yield one.name, records["log_time"].astype(np.int64), values
        for one in wanted:
            if found[one.name] != one.count:
                raise LogError(f"{self.path}: channel {one.name} holds {found[one.name]} of {one.count} messages")

    def read(self, names: Sequence[str] | None = None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Times (k,) int64 [ns] and values (k, n) float64 of several channels (None: all), in one pass."""
        wanted = [self.channel(name) for name in (self.channels if names is None else names)]
        times = {one.name: np.empty(one.count, np.int64) for one in wanted}
        values = {one.name: np.empty((one.count, one.template.floats)) for one in wanted}
        done = {one.name: 0 for one in wanted}
        for name, part_times, part_values in self.parts(list(times)):
            part = slice(done[name], done[name] + len(part_times))
            if part.stop > len(times[name]):
                raise LogError(f"{self.path}: channel {name} holds more messages than its {len(times[name])}")
            times[name][part], values[name][part] = part_times, part_values
            done[name] = part.stop
        return {one.name: (times[one.name], values[one.name]) for one in wanted}

    def times(self, name: str) -> np.ndarray:
        """Simulated times of a channel's messages: (k,) int64 [ns]."""
        return self.read([name])[name][0]

    def values(self, name: str) -> np.ndarray:
        """A channel's numbers: (k, n) float64, ports one after the other, arrays row-major."""
        return self.read([name])[name][1]

    def port(self, name: str, port: str) -> np.ndarray:
        """One port of a channel: (k, *shape) float64."""
        found, part = self.channel(name).port(port)
        values = self.values(name)[:, part]
        return values.reshape(len(values), *found.shape)

    def image_count(self, name: str, port: str) -> int:
        """How many images of an output there are. Raises LogError if the log has no such output."""
        channel = self.channel(name)
        if all(one.name != port for one in channel.images):
            names = ", ".join(one.name for one in channel.images) or "none"
            raise LogError(f"channel {name} has no image {port}; it has {names}")
        topic = images.topic(name, port)
        return sum(self._counts.get(n, 0) for n, one in self._summary.channels.items() if one.topic == topic)

    def image_messages(self, name: str, port: str) -> Iterator[tuple[int, bytes]]:
        """Times [ns] and messages of an image output, in order, read one by one.

        Raises LogError at the end if there were more or fewer than the log counts.
        """
        found, count = 0, self.image_count(name, port)
        for t_ns, data in self._remarks(images.topic(name, port)):
            found += 1
            yield t_ns, data
        if found != count:
            raise LogError(f"{self.path}: {found} of {count} images of {name}.{port} are there")

    def images(self, name: str, port: str) -> Iterator[tuple[int, np.ndarray]]:
        """Times [ns] and pixels of an image output, (height, width) grey or (height, width, 3) RGB, uint8."""
        about = {one.name: one for one in self.channel(name).images}
        for t_ns, data in self.image_messages(name, port):
            yield t_ns, self.image(name, about[port], t_ns, data)

    def image(self, name: str, port: ImagePort, t_ns: int, message: bytes) -> np.ndarray:
        """The pixels in a message of an image output. Raises LogError if it does not hold an image of that shape."""
        try:
            return images.pixels(port, message)
        except ValueError as error:
            raise LogError(f"{self.path}: {name}.{port.name} at {t_ns / 1e9:.9g} s: {error}") from error

    def frame(self, name: str) -> pandas.DataFrame:
        """A channel as a table: index time [s], a column a float, attrs["units"]; see pipeline.log.table."""
        from pipeline.log import table  # pandas and pyarrow take half a second to import

        return table.frame(self, name)

    def _chunks(self, numbers: Sequence[int], backwards: bool = False) -> Iterator[_OpenChunk]:
        """The chunks that hold messages of these MCAP channels, in order of the file or from its end."""
        chunks = self._summary.chunk_indexes
        for index in reversed(chunks) if backwards else chunks:
            if any(number in index.message_index_offsets for number in numbers):
                yield _OpenChunk(self, index)

    def schemas(self) -> dict[str, Schema]:
        """What the messages of each channel are, by topic: components', drawings, events, snapshots."""
        named = {channel.topic: self._summary.schemas[channel.schema_id] for channel in self._summary.channels.values()}
        return {topic: Schema(schema.name, schema.data) for topic, schema in named.items()}

    def messages(self) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time [ns] and payload of every message of every channel, in the file's order, which is that of time.

        Raises LogError at the end if there were more or fewer messages than the log counts.
        """
        topics = {number: channel.topic for number, channel in self._summary.channels.items()}
        found = 0
        for chunk in self._chunks([*topics]):
            for number, t_ns, data in chunk.messages([*topics]):
                found += 1
                yield topics[number], t_ns, data
        if found != self._count:
            raise LogError(f"{self.path}: {found} of {self._count} messages are there")

    def events(self) -> list[tuple[int, str]]:
        """What happened: (time [ns], text), in order."""
        return [(t_ns, Event.FromString(data).text) for t_ns, data in self._remarks(EVENTS)]

    def snapshots(self, backwards: bool = False) -> Iterator[tuple[int, bytes]]:
        """The run's snapshots: (time [ns], state), in order or from the last one back, read one by one."""
        for t_ns, data in self._remarks(SNAPSHOTS, backwards):
            yield t_ns, Snapshot.FromString(data).state

    def last_snapshot(self) -> tuple[int, bytes] | None:
        """The last snapshot, found from the end of the log, or None."""
        return next(self.snapshots(backwards=True), None)

    def _remarks(self, topic: str, backwards: bool = False) -> Iterator[tuple[int, bytes]]:
        """Times and payloads of a channel whose messages have no fixed shape."""
        for number in [n for n, channel in self._summary.channels.items() if channel.topic == topic]:
            for chunk in self._chunks([number], backwards):
                messages = [(t_ns, data) for _, t_ns, data in chunk.messages([number])]
                yield from reversed(messages) if backwards else messages

    def attachment_names(self) -> list[str]:
        """Names of the attached files, in the order of the file."""
        return [index.name for index in self._summary.attachment_indexes]

    def attachment(self, name: str) -> bytes:
        """The attached file of this name. Raises LogError if there is none, or its checksum is wrong."""
        for index in self._summary.attachment_indexes:
            if index.name == name:
                record = self._record(index.offset, index.length, Opcode.ATTACHMENT, f"attachment {name}")
                protected, checksum = record[:-_CRC_BYTES], int.from_bytes(record[-_CRC_BYTES:], "little")
                if zlib.crc32(protected) != checksum:
                    raise LogError(f"{self.path}: attachment {name} is damaged (its checksum is wrong)")
                return Attachment.read(ReadDataStream(BytesIO(record))).data
        raise LogError(f"{self.path} has no attachment {name}")

    def metadata(self, name: str) -> dict[str, str]:
        """The last metadata record of this name, {} if there is none. Raises LogError if its checksum is wrong."""
        for index in reversed(self._summary.metadata_indexes):
            if index.name == name:
                record = self._record(index.offset, index.length, Opcode.METADATA, f"metadata {name}")
                try:
                    pairs = Metadata.read(ReadDataStream(BytesIO(record))).metadata
                except DAMAGE as error:
                    raise LogError(f"{self.path}: metadata {name} is damaged ({error})") from error
                if pairs.pop(CHECKSUM_KEY, "") != metadata_checksum(pairs):
                    raise LogError(f"{self.path}: metadata {name} is damaged (its checksum is wrong)")
                return pairs
        return {}

    def _record(self, offset: int, length: int, opcode: Opcode, what: str) -> bytes:
        """The content of the record that an index names."""
        self._file.seek(offset)
        record = self._file.read(length)
        if len(record) != length or record[:1] != bytes([opcode]):
            raise LogError(f"{self.path}: {what} is damaged")
        return record[PREFIX.size :]

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        """The log itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()


class _OpenChunk:
    """A chunk's records in memory. Raises LogError if it is damaged."""

    def __init__(self, log: Log, index: ChunkIndex):
        self.index = index
        self._file = log._file
        start, end = index.message_start_time / 1e9, index.message_end_time / 1e9
        self._place = f"{log.path}: the chunk at byte {index.chunk_start_offset} ({start:.6g} to {end:.6g} s)"
        try:
            self._data = chunk_data(self._file, index)
        except (OSError, *DAMAGE) as error:
            raise LogError(f"{self._place} is damaged ({error})") from error

    def _entries(self, number: int) -> np.ndarray:
        """Times and offsets of a channel's messages, in order of time: (k, 2) uint64."""
        try:
            channel, entries = index_entries(self._file, self.index.message_index_offsets[number])
        except (OSError, *DAMAGE) as error:
            raise LogError(f"{self._place} has a damaged message index ({error})") from error
        if channel != number:
            raise LogError(f"{self._place} has a damaged message index")
        return entries

    def gather(self, channel: ChannelInfo) -> np.ndarray:
        """The channel's records in this chunk, in order of time: (k,) of its template's `record`."""
        entries = self._entries(channel.number)
        try:
            records = channel.template.gather(self._data, entries[:, 1])
        except ValueError as error:
            raise LogError(f"{self._place}, channel {channel.name}: {error}") from error
        right_times = bool((records["log_time"] == entries[:, 0]).all())
        if not (right_times and channel.template.agrees(records, channel.number)):
            raise LogError(f"{self._place}, channel {channel.name}: its messages do not stand where the index says")
        return records

    def messages(self, numbers: Sequence[int]) -> list[tuple[int, int, bytes]]:
        """Channel, time and payload of some channels' messages in this chunk, in their order."""
        wanted = [number for number in numbers if number in self.index.message_index_offsets]
        entries = [(offset, t_ns, number) for number in wanted for t_ns, offset in self._entries(number).tolist()]
        found = []
        for offset, t_ns, number in sorted(entries):
            try:
                opcode, length = PREFIX.unpack_from(self._data, offset)
                message = Message.read(ReadDataStream(BytesIO(self._data[offset + PREFIX.size :][:length])), length)
            except DAMAGE as error:
                raise LogError(f"{self._place} has a damaged message index ({error})") from error
            if opcode != Opcode.MESSAGE or message.channel_id != number or message.log_time != t_ns:
                raise LogError(f"{self._place} has a damaged message index")
            found.append((number, t_ns, message.data))
        return found
