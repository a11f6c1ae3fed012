"""towline report: a log, or a table of markers, as one HTML page with an animation, tables and figures."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from pipeline.analysis.page.charts import Window
from pipeline.analysis.recording import is_log
from pipeline.analysis.report import report, write
from pipeline.commands import validity
from pipeline.commands.output import console, print_json
from pipeline.errors import TowlineError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments: those of validity, and the page."""
    validity.add_arguments(parser)
    parser.add_argument("--out", "-o", type=Path, metavar="F", help="the page (default: beside the log, .html)")
    parser.add_argument("--overwrite", action="store_true", help="replace the page if it exists")
    parser.add_argument("--window", nargs=2, metavar=("T0", "T1"), help="what figures show at first [s] (default: all)")


def _page_path(arguments: argparse.Namespace) -> Path:
    """Where the page goes. Raises TowlineError if something is there that must not be replaced."""
    out = arguments.out or arguments.log.with_suffix(".html")
    if out.exists():
        if arguments.log.exists() and out.samefile(arguments.log):
            raise TowlineError(f"{out} is the recording itself; give another name with --out")
        if not arguments.overwrite:
            raise TowlineError(f"{out} exists; give another name with --out, or --overwrite")
    return out


def command(arguments: argparse.Namespace) -> int:
    """Judge, draw and write."""
    start = time.perf_counter()
    window = None if arguments.window is None else Window(*validity.seconds(arguments.window))
    out = _page_path(arguments)
    found, unjudged = validity.cables(arguments, needed=not is_log(arguments.log))
    try:
        write(out, report(arguments.log, is_log(arguments.log), found, window, unjudged))
    except OSError as error:
        raise TowlineError(f"{out}: cannot write the report: {error.strerror or error}") from error
    wall_s = time.perf_counter() - start
    if arguments.json:
        cables = {cable.recording.name: cable.as_json() for cable in found}
        print_json({"report": str(out), "wall_s": wall_s, "cables": cables})
    else:
        console().print(f"report {out} ({out.stat().st_size / 1e6:.2g} MB, {wall_s:.2g} s)")
    return 0
