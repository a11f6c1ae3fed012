"""A channel as a table with named columns and units, and the export of a log to parquet or CSV."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import product
from pathlib import Path

import numpy as np
import pandas
import pyarrow
import pyarrow.csv
import pyarrow.parquet

from components.contract import Port
from pipeline.errors import LogError
from pipeline.log.reader import Log

FORMATS = ("parquet", "csv")
TIME = Port("time", "s", (), "", "simulated time")


def columns(port: Port) -> Iterator[str]:
    """Names of a port's floats: `tension`, `position.x`, `tension[3]`, `nodes[3,0]`."""
    if port.shape == (3,) and port.frame:
        yield from (f"{port.name}.{axis}" for axis in "xyz")
    elif port.shape:
        for index in product(*map(range, port.shape)):
            yield f"{port.name}[{','.join(map(str, index))}]"
    else:
        yield port.name


def frame(log: Log, channel: str) -> pandas.DataFrame:
    """A channel as a table: index simulated time [s], columns as `columns` names them, attrs["units"] by column.

    Raises LogError if there is no such channel, or it is damaged.
    """
    t_ns, values = log.read([channel])[channel]
    units = {name: port.unit for port in log.channel(channel).ports for name in columns(port)}
    index = pandas.Index(t_ns / 1e9, name=TIME.name)
    table = pandas.DataFrame(values, index, list(units))
    table.attrs["units"] = units
    return table


def default_folder(log: Path) -> Path:
    """Where a log's tables go: its name without the suffix, or NAME_tables where that is taken by a file."""
    folder = log.with_suffix("")
    return folder.with_name(f"{folder.name}_tables") if folder == log or folder.is_file() else folder


def export(log: Log, folder: Path | str, kind: str, overwrite: bool = False) -> list[Path]:
    """Write one file a channel, `<channel>.parquet` or `.csv`, into the folder; returns their paths.

    Parquet keeps unit, frame and description in each column's metadata, CSV has the unit in its header:
    `tension[0] [N]`. Both hold float64 exactly. A file has its name only once it is whole. Raises LogError if the log
    is damaged, a file cannot be written, or exists and may not be overwritten.
    """
    if kind not in FORMATS:
        raise LogError(f"format {kind!r} is not known; use one of {', '.join(FORMATS)}")
    paths = {channel: Path(folder) / f"{channel}.{kind}" for channel in log.channels}
    present = [path for path in paths.values() if path.exists()]
    if present and not overwrite:
        raise LogError(f"{present[0]} exists already; choose another folder or allow overwriting")
    for channel, path in paths.items():
        part = path.with_name(f"{path.name}.part")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(log, channel, part, kind)
            part.replace(path)
        except OSError as error:
            raise LogError(f"{path}: cannot export: {error.strerror or error}") from error
        finally:
            with suppress(OSError):
                part.unlink()
    return list(paths.values())


def _write(log: Log, channel: str, path: Path, kind: str) -> None:
    t_ns, values = log.read([channel])[channel]
    ports = (TIME, *log.channel(channel).ports)
    names = [(name, port) for port in ports for name in columns(port)]
    data = [t_ns / 1e9, *values.T]
    if kind == "csv":
        table = pyarrow.table(data, [f"{name} [{port.unit}]" for name, port in names])
        pyarrow.csv.write_csv(table, path, pyarrow.csv.WriteOptions(quoting_style="needed"))
    else:
        pyarrow.parquet.write_table(pyarrow.table(data, _schema(names)), path)


def _schema(names: Sequence[tuple[str, Port]]) -> pyarrow.Schema:
    return pyarrow.schema(
        [
            pyarrow.field(
                name,
                pyarrow.from_numpy_dtype(np.float64),
                metadata={"unit": port.unit, "frame": port.frame, "description": port.description},
            )
            for name, port in names
        ]
    )
