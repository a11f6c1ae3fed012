"""The summary that a run ends with: speed, messages, digest, bonds, and what its lines and bodies did."""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table

from components.contract import Port
from pipeline.log.reader import Log, open_log
from pipeline.run import Result

SHOWN_SIZE = 3  # ports up to this size are listed number by number, larger ones as a whole


def _ports(log: Log, name: str) -> Table:
    """Least, mean and greatest value of every port of a channel."""
    values = log.values(name)
    table = Table(title=f"{name} ({len(values)} messages)", title_justify="left")
    for column in ("port", "min", "mean", "max", "unit"):
        table.add_column(column, justify="left" if column in ("port", "unit") else "right")
    for port in log.channels[name].ports:
        _, span = log.channels[name].port(port.name)
        for label, column in _columns(port, values[:, span]):
            numbers = (column.min(), column.mean(), column.max())
            table.add_row(label, *(f"{v:.5g}" for v in numbers), port.unit)
    return table


def _columns(port: Port, values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    if port.shape and port.size <= SHOWN_SIZE:
        return [(f"{port.name}[{i}]", values[:, i]) for i in range(port.size)]
    return [(port.name, values)]


def print_summary(console: Console, result: Result) -> None:
    """Print it; the figures are read back from the log."""
    log = open_log(result.log)
    for name, info in log.channels.items():
        if info.count and info.metadata.get("kind") == "component":
            console.print(_ports(log, name))
    for name, bond in result.bonds.items():
        console.print(
            f"bond {name}: residual {bond['residual_J']:.3g} J of {bond['throughput_J']:.3g} J through it, "
            f"{bond['unconverged']:.0f} steps beyond its tolerance"
        )
    console.print(
        f"{result.simulated_s:g} s in {result.wall_s:.3g} s: {result.real_time_factor:.4g} times real time, "
        f"{result.steps} component steps"
    )
    console.print(f"digest {result.digest}")
    console.print(f"log {result.log}")
