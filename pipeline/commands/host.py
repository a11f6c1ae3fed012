"""towline host: offer this machine to a conductor, which gives it components and their parameters over the bus."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pipeline.commands.output import BUS_CONFIG_HELP, print_json
from pipeline.document import IDENTIFIER, NOT_A_NAME


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument(
        "--connect", action="append", required=True, metavar="tcp/HOST:PORT", help="where the conductor listens"
    )
    parser.add_argument("--name", type=_name, required=True, help="the host's name in the scenario")
    parser.add_argument("--once", action="store_true", help="end after one run (default: wait for the next)")
    parser.add_argument("--bus-config", type=Path, metavar="F", help=BUS_CONFIG_HELP)


def _name(text: str) -> str:
    if not IDENTIFIER.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text!r} is {NOT_A_NAME}")
    return text


def command(arguments: argparse.Namespace) -> int:
    """Offer and serve; ends with --once, or by Ctrl-C."""
    from pipeline.hosts.process import serve  # imports the compiler

    def tell(text: str) -> None:
        print(f"towline: host {arguments.name}: {text}", file=sys.stderr, flush=True)

    tell(f"offers itself at {', '.join(arguments.connect)}")
    serve(arguments.name, arguments.connect, config=arguments.bus_config, is_once=arguments.once, tell=tell)
    if arguments.json:
        print_json({"name": arguments.name})
    return 0
