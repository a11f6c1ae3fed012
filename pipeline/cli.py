"""The command `towline`: its arguments, and how errors leave it; each command is a module of pipeline.commands."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import re
import sys
from collections.abc import Sequence
from typing import TextIO

from pipeline import installation, interrupts
from pipeline.errors import TowlineError

_NEGATIVE = re.compile(r"-(\.?\d|inf|nan)", re.IGNORECASE)
FINE, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130

COMMANDS = {
    "check": "check a scenario without running it",
    "run": "run a scenario into a log",
    "resume": "go on with a run that was killed, from its log",
    "replay": "run one component again from a log's inputs, or play the log onto the bus",
    "diff": "compare two logs",
    "validity": "judge whether a catenary was a valid model of a recorded line",
    "report": "write the validity of a recorded line as an HTML page",
    "view": "show a log in Rerun, or save a picture of it",
    "host": "offer this machine to a conductor on another one",
    "export": "write a log's channels as parquet or csv",
    "fmu": "build an FMU from a component, or tell what one contains",
    "convert": "make a scenario from an SSP or an OSP system structure, or an SSP from a scenario of FMUs",
    "catenary": "static catenary between two points",
    "capability": "the wind up to which thrusters hold a ship, per heading and failure",
    "coverage": "the water that a line between boats swept, and what it took of an oil patch",
    "drag": "which laws of drag the seen shape of a towed rope allows",
    "noise": "the noises of an estimator of a line that make a log most likely",
    "bench": "measure speed against error",
}


def _parser(wanted: str | None) -> argparse.ArgumentParser:
    """The parser; only the wanted command's module is imported, which keeps --help quick."""
    parser = argparse.ArgumentParser(prog="towline", description="Co-simulation of vessels with lines in the water.")
    parser.add_argument("--debug", action="store_true", help="show tracebacks")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        command.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
        command.add_argument("--json", action="store_true", help="one JSON object on standard output, nothing else")
        if name == wanted:
            importlib.import_module(f"pipeline.commands.{name}").add_arguments(command)
    return parser


def _wanted(arguments: Sequence[str]) -> str | None:
    return next((word for word in arguments if word in COMMANDS), None)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns 0 fine, 1 failed, 2 usage, 130 interrupted."""
    words = [_as_value(word) for word in (sys.argv[1:] if arguments is None else arguments)]
    is_json, is_debug = "--json" in words, "--debug" in words  # also where an interrupt comes before they are parsed
    interrupts.begin()
    try:
        parsed = _parser(_wanted(words)).parse_args(words)
        is_json, is_debug = parsed.json, parsed.debug
        return importlib.import_module(f"pipeline.commands.{parsed.command}").command(parsed)
    except TowlineError as error:
        if is_debug:
            raise
        report(str(error), is_json)
        return FAILED
    except KeyboardInterrupt:
        report("interrupted", is_json)
        return INTERRUPTED
    except BrokenPipeError:
        _silence(sys.stdout)
        _silence(sys.stderr)
        return FAILED
    except Exception as error:
        if is_debug:
            raise
        failed = f"towline itself failed: {type(error).__name__}: {error} (--debug shows where)"
        report(installation.told(error) or failed, is_json)
        return FAILED


def _as_value(word: str) -> str:
    """A negative quantity such as -1% with a space before: it is no option then, and its command says what is wrong."""
    return f" {word}" if _NEGATIVE.match(word) else word


def report(message: str, as_json: bool) -> None:
    """Tell of an error on standard error, and under --json on standard output too."""
    if as_json:
        try:
            print(json.dumps({"error": message}), flush=True)
        except OSError:  # then standard error alone tells
            _silence(sys.stdout)
    for line in message.splitlines() or [""]:
        print(f"towline: {line}", file=sys.stderr)


def _silence(stream: TextIO) -> None:
    """Send what a stream still holds nowhere: Python would complain at its exit that it cannot be written."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


if __name__ == "__main__":
    sys.exit(main())
