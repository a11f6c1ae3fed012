"""The mcap library's writer with one addition: messages of fixed shape, in bulk, merged by time into chunks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mcap.writer
import numpy as np
from mcap._chunk_builder import ChunkBuilder
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import MessageIndex

from pipeline.log.template import Template

_ENTRY_BYTES = 16  # log_time and offset of one message in a MessageIndex


@dataclass(frozen=True)
class Block:
    """Messages of one channel in time order. t_ns: (k,) int64; rows: (k, n) float64, n floats of the template."""

    channel: int
    sequence: int
    template: Template
    t_ns: np.ndarray
    rows: np.ndarray

    def records(self, first: int, last: int) -> np.ndarray:
        """Their MCAP records from message `first` to before `last`."""
        part = slice(first, last)
        return self.template.fill(self.channel, self.sequence + first, self.t_ns[part], self.rows[part])


class _BulkIndex(MessageIndex):
    """A MessageIndex whose entries (log_time, offset) come as arrays instead of tuples."""

    def __init__(self, channel_id: int):
        super().__init__(channel_id, [])
        self.parts: list[np.ndarray] = []

    def write(self, stream: RecordBuilder) -> None:
        entries = np.concatenate(self.parts)
        entries = entries[np.argsort(entries[:, 0], kind="stable")]
        stream.start_record(Opcode.MESSAGE_INDEX)
        stream.write2(self.channel_id)
        stream.write4(len(entries) * _ENTRY_BYTES)
        stream.write(entries.tobytes())
        stream.finish_record()


class Writer(mcap.writer.Writer):
    """The library's Writer plus `add_blocks`; schemas, compression, checksums, summary and footer stay the library's.

    It bears its parent's name so that `self.__chunk_builder` and the like mean the parent's own: the library has no
    public way to put finished bytes into a chunk. tests/runs/test_log_reading.py fails if that ever changes.
    """

    @property
    def _builder(self) -> ChunkBuilder:
        """The chunk in progress."""
        assert self.__chunk_builder is not None
        return self.__chunk_builder

    def add_blocks(self, blocks: Sequence[Block]) -> None:
        """Write all messages of the blocks in order of time (then of the blocks), finishing chunks as they fill."""
        order = np.argsort(np.concatenate([block.t_ns for block in blocks]), kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        ranks = np.split(rank, np.cumsum([len(block.t_ns) for block in blocks])[:-1])
        sizes = np.repeat([block.template.record_bytes for block in blocks], [len(block.t_ns) for block in blocks])
        ends = np.cumsum(sizes[order])
        done = 0
        while done < len(order):
            written = ends[done - 1] if done else 0
            room = max(0, self.__chunk_size - self._builder.count)
            stop = min(len(order), int(np.searchsorted(ends, written + room, "right")) + 1)
            self._add_piece(blocks, ranks, ends, done, stop)
            self.__maybe_finalize_chunk()
            done = stop

    def _add_piece(
        self, blocks: Sequence[Block], ranks: Sequence[np.ndarray], ends: np.ndarray, first: int, last: int
    ) -> None:
        """Put the messages of these ranks into the chunk in progress. ends: where each ends, counted from rank 0."""
        builder = self._builder
        origin = int(ends[first - 1]) if first else 0
        data = np.empty(int(ends[last - 1]) - origin, np.uint8)
        for block, own in zip(blocks, ranks, strict=True):
            a, b = np.searchsorted(own, (first, last))
            if a == b:
                continue
            size = block.template.record_bytes
            offsets = ends[own[a:b]] - size - origin
            at_every_byte = np.ndarray((len(data) - size + 1,), f"V{size}", data, strides=(1,))  # type: ignore
            at_every_byte[offsets] = block.records(int(a), int(b)).view(f"V{size}")
            self._note(block, int(a), int(b), offsets + builder.count)
        builder.record_writer.write(data.data)

    def _note(self, block: Block, a: int, b: int, offsets: np.ndarray) -> None:
        """Count messages a to b of a block in the statistics, the chunk's time range and its index."""
        builder, statistics = self._builder, self.__statistics
        start, end = int(block.t_ns[a]), int(block.t_ns[b - 1])
        builder.message_start_time = min(start, builder.message_start_time) if builder.num_messages else start
        builder.message_end_time = max(end, builder.message_end_time)
        builder.num_messages += b - a
        index = builder.message_indices.setdefault(block.channel, _BulkIndex(block.channel))
        assert isinstance(index, _BulkIndex)
        index.parts.append(np.column_stack((block.t_ns[a:b], offsets)).astype("<u8"))
        first = statistics.message_count == 0
        statistics.message_start_time = start if first else min(start, statistics.message_start_time)
        statistics.message_end_time = max(end, statistics.message_end_time)
        statistics.message_count += b - a
        statistics.channel_message_counts[block.channel] += b - a
