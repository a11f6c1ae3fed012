"""The summary that a run ends with: what its lines and bodies did, speed, messages, digest, bonds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np
from rich.console import Console
from rich.table import Table

from components.contract import Port
from pipeline.log.reader import Log, open_log
from pipeline.run import Result

Row = tuple[str, np.ndarray, str]


def _line(port: Port, nodes: np.ndarray) -> Iterator[Row]:
    """A line's shape (k, n, 3) in NED by its sag: depth of the lowest node below the lower end."""
    depth = nodes[:, :, 2]
    yield f"sag of {port.name}", depth.max(axis=1) - np.maximum(depth[:, 0], depth[:, -1]), port.unit


def _rows(port: Port, values: np.ndarray) -> Iterator[Row]:
    """What to show of a port's values (k, *shape): a line by its sag, a vector by its norm, others as they are."""
    if port.name == "nodes" and port.frame == "NED" and port.shape[1:] == (3,):
        yield from _line(port, values)
    elif port.shape == (3,) and port.unit == "m":
        for i, axis in enumerate(("north", "east", "down")):
            yield f"{port.name} {axis}", values[:, i], port.unit
    elif port.shape == (3,):
        yield f"|{port.name}|", np.linalg.norm(values, axis=1), port.unit
    else:
        yield port.name, values, port.unit


@dataclass
class _Range:
    """What is known of a quantity so far."""

    least: float = inf
    greatest: float = -inf
    total: float = 0.0
    count: int = 0

    def add(self, values: np.ndarray) -> None:
        self.least = min(self.least, float(values.min()))
        self.greatest = max(self.greatest, float(values.max()))
        self.total += float(values.sum())
        self.count += values.size


def _ranges(log: Log) -> dict[tuple[str, str, str], _Range]:
    """Ranges by (channel, quantity, unit), read chunk by chunk: a log may be larger than memory."""
    ranges: dict[tuple[str, str, str], _Range] = {}
    names = [name for name, info in log.channels.items() if info.metadata.get("kind") == "component"]
    for name, _, values in log.parts(names):
        at = 0
        for port in (port for port in log.channels[name].ports if port.size):
            part = values[:, at : at + port.size].reshape(len(values), *port.shape)
            for quantity, numbers, unit in _rows(port, part):
                ranges.setdefault((name, quantity, unit), _Range()).add(numbers)
            at += port.size
    return ranges


def _table(log: Log) -> Table:
    """Least, mean and greatest value of what moves in every component channel."""
    table = Table()
    for column in ("component", "quantity", "min", "mean", "max", "unit"):
        table.add_column(column, justify="right" if column in ("min", "mean", "max") else "left")
    ranges = _ranges(log)
    for name in log.channels:
        label = name
        for (channel, quantity, unit), range_ in ranges.items():
            if channel == name:
                figures = (range_.least, range_.total / range_.count, range_.greatest)
                table.add_row(label, quantity, *(f"{v:.5g}" for v in figures), "" if unit == "1" else unit)
                label = ""
        table.add_section()
    return table


def _validity(name: str, figures: dict[str, float]) -> str:
    """`tether: outside its validity range in 3.2 % of its steps (largest 1.4 of the limit: strain)`."""
    measures = {key: value for key, value in figures.items() if key not in ("largest", "outside_share")}
    largest = f"largest {figures['largest']:.3g} of the limit"
    if measures:
        largest += f": {max(measures, key=lambda key: measures[key])}"
    share = figures["outside_share"]
    where = f"outside its validity range in {100.0 * share:.3g} % of its steps" if share else "in its validity range"
    return f"{name}: {where} ({largest})"


def print_summary(console: Console, result: Result) -> None:
    """Print it; the figures are read back from the log."""
    with open_log(result.log) as log:
        console.print(_table(log))
    for name, bond in result.bonds.items():
        console.print(
            f"bond {name}: residual {bond['residual_J']:.3g} J of {bond['throughput_J']:.3g} J through it, "
            f"{bond['unconverged']:.0f} steps beyond its tolerance"
        )
    for name, host in result.hosts.items():
        if any(host.values()):
            told = f"started again {host['restarts']} times, late {host['late']} times"
            console.print(f"host {name}: {told}, {host['refused']} messages refused")
    if result.deadlines:
        missed, worst_ms = result.deadlines["missed"], 1e3 * result.deadlines["worst_s"]
        console.print(f"missed deadlines: {missed}" + (f", the worst by {worst_ms:.3g} ms" if missed else ""))
    for name, figures in result.validity.items():
        console.print(_validity(name, figures))
    console.print(
        f"{result.simulated_s:g} s in {result.wall_s:.3g} s: {result.real_time_factor:.4g} times real time, "
        f"{result.steps} component steps"
    )
    console.print(f"digest {result.digest}")
    console.print(f"log {result.log}")
