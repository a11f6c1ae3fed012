"""towline replay LOG --bus zenoh: the whole log onto the bus, for live viewers and for components under test."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import asdict
from pathlib import Path

from pipeline.commands.output import BUS_CONFIG_HELP, console, print_json, warn
from pipeline.commands.run import positive
from pipeline.errors import TowlineError
from pipeline.log.reader import Log
from pipeline.playback import Player
from pipeline.quantities import nanoseconds

DEFAULT_RATE = 1.0


def add_arguments(parser: argparse._ArgumentGroup) -> None:
    """The arguments of this use of the command."""
    parser.add_argument(
        "--rate", type=positive, default=DEFAULT_RATE, metavar="1", help="simulated seconds per second (default: 1)"
    )
    parser.add_argument("--until", metavar="10s", help="simulated time to play to (default: the log's end)")
    parser.add_argument("--loop", action="store_true", help="begin again at the end, until Ctrl-C")
    parser.add_argument("--wait", action="store_true", help="begin when somebody subscribes")
    parser.add_argument("--listen", action="append", metavar="tcp/HOST:PORT", help="where subscribers connect")
    parser.add_argument("--connect", action="append", metavar="tcp/HOST:PORT", help="subscribers or a router to join")
    parser.add_argument("--bus-config", type=Path, metavar="F", help=BUS_CONFIG_HELP)


def command(log: Log, arguments: argparse.Namespace) -> int:
    """Play it."""
    from pipeline.bus.channels import CHANNELS, Channels  # imports zenoh
    from pipeline.bus.configuration import close_session, configuration, open_session
    from pipeline.hosts.deployment import ENDPOINT

    if arguments.set or arguments.out:
        raise TowlineError("--set and --out belong to --component: on the bus the log is played as it is")
    if log.warning:
        warn(log.warning)
    until_ns = _until_ns(log, arguments.until)
    connect = arguments.connect or []
    listen = arguments.listen or ([] if connect else [ENDPOINT])
    session = open_session(configuration(listen, connect, arguments.bus_config))
    try:
        player = Player(log, Channels(session), arguments.rate)
        print(f"towline: {CHANNELS}/** at {', '.join([*listen, *connect])}", file=sys.stderr, flush=True)
        if arguments.wait:
            player.wait()
        began = time.monotonic()
        player.play(until_ns)
        while arguments.loop:
            player.play(until_ns)
    finally:
        close_session(session)
    wall_s, played = time.monotonic() - began, player.played
    if arguments.json:
        print_json({"log": str(log.path), "wall_s": wall_s, **asdict(played)})
    else:
        late = f"the latest {1e3 * played.worst_late_s:.3g} ms after its time"
        console().print(f"{played.messages} messages in {wall_s:.3g} s, {late}")
    return 0


def _until_ns(log: Log, text: str | None) -> int:
    """Raises TowlineError."""
    if text is None:
        return log.end_ns
    try:
        return nanoseconds(text, bare=True)
    except ValueError as error:
        raise TowlineError(f"--until: {error}") from error
