"""towline diff: compare two logs; exit status 1 if they differ by more than the tolerance."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.table import Table

from pipeline.commands.output import console, print_json, warn
from pipeline.diff import Diff, diff_logs, within
from pipeline.log.reader import open_log


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("a", type=Path, help="a log")
    parser.add_argument("b", type=Path, help="another")
    parser.add_argument(
        "--tolerance", type=float, metavar="X", help="largest difference allowed (default: none at all)"
    )


def command(arguments: argparse.Namespace) -> int:
    """Compare them."""
    logs = [open_log(path) for path in (arguments.a, arguments.b)]
    for log in logs:
        if log.warning:
            warn(log.warning)
    diff = diff_logs(*logs)
    fine = diff.identical if arguments.tolerance is None else within(diff, arguments.tolerance)
    if arguments.json:
        print_json(diff)
        return 0 if fine else 1
    _print(diff)
    return 0 if fine else 1


def _print(diff: Diff) -> None:
    table = Table(title="identical" if diff.identical else "different")
    for column in ("channel", "messages a", "messages b", "times", "max |a - b|"):
        table.add_column(column, justify="left" if column == "channel" else "right")
    for name, channel in diff.channels.items():
        shown = "-" if channel.max_abs is None else f"{channel.max_abs:.3g}"
        times = "equal" if channel.times_equal else "differ"
        table.add_row(name, str(channel.messages_a), str(channel.messages_b), times, shown)
    out = console()
    out.print(table)
    for name, channel in diff.channels.items():
        for text in channel.port_differences:
            out.print(f"{name}: {text}")
