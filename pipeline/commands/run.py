"""towline run: run a scenario into a log, with a progress bar and a summary."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path

from pipeline.commands.explain import print_terms, terms
from pipeline.commands.output import BUS_CONFIG_HELP, compile_fresh, console, leave, print_json, progress_bar
from pipeline.commands.summary import print_summary
from pipeline.errors import TowlineError
from pipeline.hosts.deployment import ENDPOINT, BusOptions
from pipeline.keyboard import keyboard
from pipeline.log.recorder import CHUNK_BYTES, COMPRESSION, COMPRESSIONS, Audience
from pipeline.run import Options, run_scenario
from pipeline.scenario import Scenario, load_scenario
from pipeline.wiring import build_graph

LIVE_ENDPOINT = "127.0.0.1:8765"  # loopback, and the port that those viewers ask for by default


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("scenario", help="scenario YAML")
    parser.add_argument("--out", type=Path, metavar="F", help="the log (default: logs/NAME-DATE-TIME.mcap)")
    parser.add_argument("--overwrite", action="store_true", help="replace the log if it exists")
    parser.add_argument("--until", metavar="10s", help="simulated time to run to (default: the scenario's duration)")
    parser.add_argument(
        "--rate", type=positive, metavar="1", help="simulated seconds per second (default: as fast as it goes)"
    )
    parser.add_argument("--set", action="append", default=[], metavar="COMP.PARAM=VALUE", help="change a parameter")
    parser.add_argument("--explain", action="store_true", help="say which terms of each model are on, and why")
    parser.add_argument(
        "--live",
        nargs="?",
        const=LIVE_ENDPOINT,
        metavar="HOST:PORT",
        help=f"serve Foxglove and Lichtblick while it runs, at --rate 1 unless given (default: ws://{LIVE_ENDPOINT})",
    )
    add_bus_arguments(parser)
    add_recording_arguments(parser)


def add_bus_arguments(parser: argparse.ArgumentParser) -> None:
    """Where components run."""
    parser.add_argument("--bus", choices=["local", "zenoh"], help="where components run (default: the scenario's)")
    parser.add_argument(
        "--listen",
        action="append",
        metavar="tcp/HOST:PORT",
        help=f"where other machines connect (default: {ENDPOINT}, if the scenario has machines)",
    )
    parser.add_argument("--bus-config", type=Path, metavar="F", help=BUS_CONFIG_HELP)


def add_recording_arguments(parser: argparse.ArgumentParser) -> None:
    """How the log is written."""
    parser.add_argument(
        "--compression", choices=COMPRESSIONS, default=COMPRESSION, help=f"of the log (default: {COMPRESSION})"
    )
    parser.add_argument("--chunk-bytes", type=_bytes, default=CHUNK_BYTES, metavar="N", help="of the log, uncompressed")
    parser.add_argument("--no-scene", action="store_true", help="leave the 3D scene out of the log")


def positive(text: str) -> float:
    """A number of the command line that is above 0."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no number") from None
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError("must be positive and finite")
    return value


def _bytes(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number") from None
    if not 1024 <= value <= 1 << 30:
        raise argparse.ArgumentTypeError("must be between 1024 and 1073741824")
    return value


def bus_of(arguments: argparse.Namespace, scenario: Scenario) -> BusOptions | None:
    """The bus that was asked for; None for this process alone. Raises TowlineError for vain options."""
    if (arguments.bus or scenario.bus) == "local":
        if arguments.listen or arguments.bus_config:
            raise TowlineError("--listen and --bus-config need --bus zenoh")
        return None
    default = [ENDPOINT] if scenario.hosts.machines else []
    return BusOptions(tuple(arguments.listen or default), arguments.bus_config)


def _tell(text: str) -> None:
    """A line about a host, also under --json."""
    print(f"towline: {text}", file=sys.stderr, flush=True)


def options_of(arguments: argparse.Namespace, scenario: Scenario) -> Options:
    """Recording options and bus as given."""
    return Options(
        compression=arguments.compression,
        chunk_bytes=arguments.chunk_bytes,
        scene=not arguments.no_scene,
        rate=getattr(arguments, "rate", None),
        overwrite=arguments.overwrite,
        bus=bus_of(arguments, scenario),
        tell=_tell,
        leave=lambda text: leave(text, arguments.json),
    )


@contextmanager
def live(arguments: argparse.Namespace, name: str) -> Iterator[Audience | None]:
    """The WebSocket for viewers if it was asked for, and where it is."""
    if arguments.live is None:
        yield None
        return
    from pipeline.viewing.live import Live

    server = Live(arguments.live, name)
    _tell(f"live at {server.url}, for Foxglove and Lichtblick")
    try:
        yield server
    finally:
        server.close()


def command(arguments: argparse.Namespace) -> int:
    """Run it."""
    scenario = load_scenario(arguments.scenario, arguments.set, arguments.until)
    graph = build_graph(scenario)
    if arguments.explain and not arguments.json:
        print_terms(console(), graph)
    compile_fresh(graph, arguments.json)
    seconds = graph.ticks * graph.base_ns / 1e9
    with (
        live(arguments, scenario.name) as served,
        progress_bar(scenario.name, seconds, quiet=arguments.json) as progress,
        keyboard() as keys,
    ):
        options = replace(options_of(arguments, scenario), keys=keys, audience=served)
        if served is not None and options.rate is None:
            options = replace(options, rate=1.0)
        result = run_scenario(scenario, graph, arguments.out, options, progress)
    if arguments.json:
        print_json(asdict(result) | ({"terms": terms(graph)} if arguments.explain else {}))
    else:
        print_summary(console(), result)
    return 0
