"""towline resume: go on with a killed run from its log's last snapshot, into a new log."""

from __future__ import annotations

import argparse
from pathlib import Path

from pipeline.commands.output import compile_fresh, console, print_json, progress_bar, warn
from pipeline.commands.run import add_bus_arguments, add_recording_arguments, options_of
from pipeline.commands.summary import print_summary
from pipeline.log.reader import open_log
from pipeline.rerun import graph_of
from pipeline.resume import resume_run
from pipeline.run import default_log


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="log of a run that did not end")
    parser.add_argument("--out", type=Path, metavar="F", help="the new log (default: logs/NAME-DATE-TIME.mcap)")
    parser.add_argument("--overwrite", action="store_true", help="replace the new log if it exists")
    add_bus_arguments(parser)
    add_recording_arguments(parser)


def command(arguments: argparse.Namespace) -> int:
    """Resume it."""
    log = open_log(arguments.log)
    if log.warning:
        warn(log.warning)
    scenario, graph = graph_of(log)
    compile_fresh(graph, arguments.json)
    out = arguments.out or default_log(scenario.name)
    with progress_bar(scenario.name, graph.ticks * graph.base_ns / 1e9, quiet=arguments.json) as progress:
        result = resume_run(log, scenario, graph, out, options_of(arguments, scenario), progress)
    if arguments.json:
        print_json(result)
    else:
        print_summary(console(), result)
    return 0
