"""What a log file holds and where: from its summary if it is whole, else by going through its records."""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from google.protobuf.message import DecodeError
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import FOOTER_SIZE, SeekingReader
from mcap.records import AttachmentIndex, Channel, Chunk, ChunkIndex, Footer, Header, MetadataIndex, Schema, Statistics
from mcap.stream_reader import MAGIC_SIZE, breakup_chunk, get_chunk_data_stream
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

PREFIX = struct.Struct("<BQ")  # opcode and length, before every record
_MESSAGE_INDEX = struct.Struct("<HI")  # channel and bytes of the entries
_ENTRY_BYTES = 16
# What reading damaged bytes through the library can raise.
DAMAGE = (
    McapError,
    ZstdError,
    DecodeError,
    ValueError,
    LookupError,
    struct.error,
    MemoryError,
    OverflowError,
    RuntimeError,
)


@dataclass(frozen=True)
class Contents:
    """Schemas, channels, and where chunks, attachments and metadata stand.

    whole: the file has its end. end_byte: where the last readable record ends.
    """

    profile: str
    summary: Summary
    whole: bool
    end_byte: int


def read_contents(file: BinaryIO) -> Contents:
    """What the file holds. Raises ValueError with the reason if it is no readable MCAP file."""
    size = os.fstat(file.fileno()).st_size
    if size == 0:
        raise ValueError("the file is empty")
    file.seek(0)
    magic = file.read(MAGIC_SIZE)
    if magic != MCAP0_MAGIC[: len(magic)]:
        raise ValueError("the file is not MCAP")
    header = _header(file, size)
    summary = _whole_summary(file, size)
    if summary is not None:
        return Contents(header.profile, summary, True, size)
    summary, end = _scan(file, size)
    return Contents(header.profile, summary, False, end)


def _header(file: BinaryIO, size: int) -> Header:
    prefix = file.read(PREFIX.size)
    if len(prefix) < PREFIX.size or MAGIC_SIZE + PREFIX.size + PREFIX.unpack(prefix)[1] > size:
        raise ValueError("the file ends within its header")
    opcode, _ = PREFIX.unpack(prefix)
    if opcode != Opcode.HEADER:
        raise ValueError("the file has no MCAP header")
    try:
        return Header.read(ReadDataStream(file))
    except DAMAGE as error:
        raise ValueError(f"the header is damaged ({error})") from error


def _whole_summary(file: BinaryIO, size: int) -> Summary | None:
    """The summary, if the file has its end and the summary's checksum is right."""
    footer_start = size - FOOTER_SIZE - MAGIC_SIZE
    if footer_start < MAGIC_SIZE:
        return None
    file.seek(footer_start)
    end = file.read()
    if end[FOOTER_SIZE:] != MCAP0_MAGIC or end[0] != Opcode.FOOTER:
        return None
    footer = Footer.read(ReadDataStream(_after(file, footer_start)))
    if not MAGIC_SIZE < footer.summary_start <= footer_start:
        return None
    file.seek(footer.summary_start)
    protected = file.read(size - MAGIC_SIZE - 4 - footer.summary_start)  # all but the checksum itself
    if zlib.crc32(protected) != footer.summary_crc:
        return None
    file.seek(0)
    return SeekingReader(file).get_summary()


def _after(file: BinaryIO, start: int) -> BinaryIO:
    """The file, placed behind the prefix of the record at byte `start`."""
    file.seek(start + PREFIX.size)
    return file


def _scan(file: BinaryIO, size: int) -> tuple[Summary, int]:
    """A summary of all records that are there as a whole, and where they end."""
    summary = Summary()
    position = MAGIC_SIZE
    while position + PREFIX.size <= size:
        file.seek(position)
        opcode, length = PREFIX.unpack(file.read(PREFIX.size))
        end = position + PREFIX.size + length
        if end > size or opcode == Opcode.DATA_END:
            break
        try:
            _note(file, summary, opcode, position, end)
        except DAMAGE:
            break
        position = end
    _drop_torn_chunk(file, summary)
    _read_channels(file, summary)
    _count(file, summary)
    return summary, position


def _note(file: BinaryIO, summary: Summary, opcode: int, position: int, end: int) -> None:
    """Add one record of the data section, whose content begins where the file stands, to the summary."""
    stream = ReadDataStream(file)
    length = end - position
    if opcode == Opcode.CHUNK:
        start_ns, end_ns, size = stream.read8(), stream.read8(), stream.read8()
        stream.read4()  # checksum
        compression = stream.read_prefixed_string()
        summary.chunk_indexes.append(
            ChunkIndex(length, position, compression, stream.read8(), end_ns, 0, {}, start_ns, size)
        )
    elif opcode == Opcode.MESSAGE_INDEX:
        offsets = summary.chunk_indexes[-1].message_index_offsets
        if offsets.setdefault(stream.read2(), position) != position:
            raise ValueError("a channel has two indexes")
    elif opcode == Opcode.ATTACHMENT:
        log_time, create_time = stream.read8(), stream.read8()
        name, media_type = stream.read_prefixed_string(), stream.read_prefixed_string()
        summary.attachment_indexes.append(
            AttachmentIndex(position, length, log_time, create_time, stream.read8(), name, media_type)
        )
    elif opcode == Opcode.METADATA:
        summary.metadata_indexes.append(MetadataIndex(position, length, stream.read_prefixed_string()))
    elif opcode != Opcode.HEADER:
        raise ValueError("the recorder writes no such record here")


def entry_count(file: BinaryIO, position: int) -> tuple[int, int]:
    """Channel and number of messages that the MessageIndex at this byte is for. Raises one of DAMAGE if it is none."""
    file.seek(position)
    opcode, length = PREFIX.unpack(file.read(PREFIX.size))
    channel, entries_bytes = _MESSAGE_INDEX.unpack(file.read(_MESSAGE_INDEX.size))
    if opcode != Opcode.MESSAGE_INDEX or length != entries_bytes + _MESSAGE_INDEX.size or entries_bytes % _ENTRY_BYTES:
        raise ValueError("a message index is damaged")
    return channel, entries_bytes // _ENTRY_BYTES


def index_entries(file: BinaryIO, position: int) -> tuple[int, np.ndarray]:
    """Channel and entries (log_time, offset) of the MessageIndex at this byte: (k, 2) uint64."""
    channel, count = entry_count(file, position)
    entries = np.frombuffer(file.read(count * _ENTRY_BYTES), "<u8")
    return channel, entries.reshape(count, 2)


def read_chunk(file: BinaryIO, index: ChunkIndex) -> Chunk:
    """The chunk as it stands in the file."""
    return Chunk.read(ReadDataStream(_after(file, index.chunk_start_offset)))


def chunk_data(file: BinaryIO, index: ChunkIndex) -> bytes:
    """A chunk's records, decompressed. Raises one of DAMAGE if its checksum is wrong."""
    chunk = read_chunk(file, index)
    if chunk.uncompressed_size != index.uncompressed_size:
        raise ValueError("its size is wrong")
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    return stream.read(length)


def _drop_torn_chunk(file: BinaryIO, summary: Summary) -> None:
    """Forget the last chunk if not all of its messages are indexed: the writer died between the two."""
    if not summary.chunk_indexes:
        return
    last = summary.chunk_indexes[-1]
    try:
        data = chunk_data(file, last)
        position = messages = 0
        while position < len(data):
            opcode, length = PREFIX.unpack_from(data, position)
            messages += opcode == Opcode.MESSAGE
            position += PREFIX.size + length
        indexed = sum(entry_count(file, at)[1] for at in last.message_index_offsets.values())
    except DAMAGE:
        messages, indexed = 1, 0
    if messages != indexed:
        summary.chunk_indexes.pop()


def _read_channels(file: BinaryIO, summary: Summary) -> None:
    """Schemas and channels stand in the first chunk. Raises ValueError if that is damaged."""
    if not summary.chunk_indexes:
        return
    try:
        records = breakup_chunk(read_chunk(file, summary.chunk_indexes[0]), validate_crc=True)
    except DAMAGE as error:
        raise ValueError(f"the first chunk is damaged ({error}), and with it the channels") from error
    for record in records:
        if isinstance(record, Schema):
            summary.schemas[record.id] = record
        elif isinstance(record, Channel):
            summary.channels[record.id] = record
    indexed = {number for chunk in summary.chunk_indexes for number in chunk.message_index_offsets}
    if indexed - summary.channels.keys():
        raise ValueError("a message index names a channel that is not there")


def _count(file: BinaryIO, summary: Summary) -> None:
    """The numbers of messages, for which a whole file has its statistics."""
    counts: dict[int, int] = {}
    for chunk in summary.chunk_indexes:
        for channel, position in chunk.message_index_offsets.items():
            counts[channel] = counts.get(channel, 0) + entry_count(file, position)[1]
    start = min((chunk.message_start_time for chunk in summary.chunk_indexes), default=0)
    end = max((chunk.message_end_time for chunk in summary.chunk_indexes), default=0)
    summary.statistics = Statistics(
        attachment_count=len(summary.attachment_indexes),
        channel_count=len(summary.channels),
        channel_message_counts=counts,
        chunk_count=len(summary.chunk_indexes),
        message_count=sum(counts.values()),
        message_start_time=start,
        message_end_time=end,
        metadata_count=len(summary.metadata_indexes),
        schema_count=len(summary.schemas),
    )
