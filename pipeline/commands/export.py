"""towline export: write a log's channels as tables, one file a channel."""

from __future__ import annotations

import argparse
from pathlib import Path

from pipeline.commands.output import console, print_json, warn
from pipeline.log.reader import open_log
from pipeline.log.table import FORMATS, default_folder, export


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="a log")
    parser.add_argument("--out", "-o", type=Path, metavar="DIR", help="folder of the files (default: beside the log)")
    parser.add_argument("--format", choices=FORMATS, default="parquet", help="of the files (default: parquet)")
    parser.add_argument("--overwrite", action="store_true", help="replace files that exist")


def command(arguments: argparse.Namespace) -> int:
    """Export it."""
    log = open_log(arguments.log)
    if log.warning:
        warn(log.warning)
    folder = arguments.out or default_folder(arguments.log)
    files = [str(path) for path in export(log, folder, arguments.format, arguments.overwrite)]
    if arguments.json:
        print_json({"files": files})
    else:
        console().print("\n".join(files))
    return 0
