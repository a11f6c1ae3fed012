"""How fast messages are written to a log and read back: in bulk, against the mcap library message by message."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import SeekingReader
from mcap.writer import Writer

from components.contract import Port
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows
from pipeline.log.schema import describe, message_name

Row = dict[str, str | float]
SLICES = 20
REPEATS = 3
# (case, ports, messages in bulk, messages one by one: fewer, because it takes so much longer)
CASES = (
    ("2 doubles", (Port("position", "1"), Port("velocity", "1/s")), 1_000_000, 50_000),
    ("503 doubles", (Port("nodes", "m", (101, 3)), Port("tension", "N", (200,))), 20_000, 2_000),
)


def rows() -> list[Row]:
    """One row a case and method: messages a second, best of three, and how many values read back wrong."""
    found: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        for case, ports, many, few in CASES:
            spec = ChannelSpec("channel", ports)
            data = _walk(many, sum(port.size for port in ports))
            for compression in ("zstd", "lz4", "none"):
                write = _timed(lambda c=compression: _write_bulk(path, spec, data, c))  # noqa: B023 - called at once
                read = _timed(lambda: _read_bulk(path))
                wrong, size = _wrong(_read_bulk(path), data), path.stat().st_size / many
                found.append(_row(case, f"write in bulk, {compression}", wrong, many / write, size))
                found.append(_row(case, f"read in bulk, {compression}", wrong, many / read, size))
            write = _timed(lambda: _write_one_by_one(path, spec, data[:few]))  # noqa: B023
            read = _timed(lambda: _read_one_by_one(path, spec))  # noqa: B023
            wrong, size = _wrong(_read_one_by_one(path, spec), data[:few]), path.stat().st_size / few
            found.append(_row(case, "write with mcap and protobuf one by one, zstd", wrong, few / write, size))
            found.append(_row(case, "read with mcap and protobuf one by one, zstd", wrong, few / read, size))
    return found


def _row(case: str, method: str, wrong: int, messages_per_s: float, bytes_per_message: float) -> Row:
    return {
        "case": case,
        "method": method,
        "error": float(wrong),
        "error_unit": "values read back wrong",
        "messages_per_s": messages_per_s,
        "bytes_per_message": bytes_per_message,
        "reference": "the recorded rows, bit by bit",
    }


def _walk(k: int, n: int) -> np.ndarray:
    """Rows of k messages of n random walks: as hard to compress as what a simulation gives."""
    steps = np.random.default_rng(0).standard_normal((k, n))
    return pack_rows(np.arange(k) * 1_000_000, np.cumsum(steps, axis=0))


def _timed(run: Callable[[], object]) -> float:
    """Seconds of wall time, the best of several."""
    best = np.inf
    for _ in range(REPEATS):
        start = perf_counter()
        run()
        best = min(best, perf_counter() - start)
    return best


def _wrong(read: np.ndarray, rows: np.ndarray) -> int:
    """Number of floats (times included) whose bits differ, or that are missing."""
    if read.shape != rows.shape:
        return rows.size
    return int((read.view(np.uint64) != rows.view(np.uint64)).sum())


def _write_bulk(path: Path, spec: ChannelSpec, rows: np.ndarray, compression: str) -> None:
    with Recorder(path, [spec], compression=compression, overwrite=True) as recorder:
        for part in np.array_split(rows, SLICES):
            recorder.rows(0, part)


def _read_bulk(path: Path) -> np.ndarray:
    with open_log(path) as log:
        return pack_rows(*log.read(["channel"])["channel"])


def _message_class(spec: ChannelSpec) -> type:
    pool = DescriptorPool()
    for file in describe(spec.name, spec.ports).file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(message_name(spec.name)))


def _write_one_by_one(path: Path, spec: ChannelSpec, rows: np.ndarray) -> None:
    make = _message_class(spec)
    writer = Writer(str(path))
    writer.start()
    schema = writer.register_schema(
        message_name(spec.name), "protobuf", describe(spec.name, spec.ports).SerializeToString()
    )
    channel = writer.register_channel(spec.name, "protobuf", schema)
    times = rows[:, 0].copy().view(np.int64).tolist()
    for t_ns, values in zip(times, rows[:, 1:].tolist(), strict=True):
        fields = {}
        first = 0
        for port in spec.ports:
            fields[port.name] = values[first : first + port.size] if port.shape else values[first]
            first += port.size
        writer.add_message(channel, t_ns, make(**fields).SerializeToString(), t_ns)
    writer.finish()


def _read_one_by_one(path: Path, spec: ChannelSpec) -> np.ndarray:
    make = _message_class(spec)
    times, values = [], []
    with open(path, "rb") as file:
        for _, _, message in SeekingReader(file).iter_messages(spec.name):
            decoded = make.FromString(message.data)
            times.append(message.log_time)
            values.append(np.hstack([getattr(decoded, port.name) for port in spec.ports]))
    return pack_rows(np.array(times), np.array(values))
