"""towline replay: run one component again from a log's inputs and compare, or play the whole log onto the bus."""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.table import Table

from pipeline.commands import playback
from pipeline.commands.output import console, print_json, warn
from pipeline.errors import LogError
from pipeline.graph import Graph, Node
from pipeline.log.reader import Log, open_log
from pipeline.log.recorder import ChannelSpec, Recorder
from pipeline.replay import Replay, replay_component
from pipeline.rerun import changed_node, graph_of, other_sources


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("log", type=Path, help="a log")
    wanted = parser.add_mutually_exclusive_group(required=True)
    wanted.add_argument("--component", metavar="NAME", help="the component to run again")
    wanted.add_argument("--bus", choices=["zenoh"], help="play the whole log onto the bus instead")
    parser.add_argument(
        "--set", action="append", default=[], metavar="COMP.PARAM=VALUE", help="change a parameter of it"
    )
    parser.add_argument("--out", type=Path, metavar="F", help="write its new outputs to this log")
    playback.add_arguments(parser.add_argument_group("with --bus zenoh"))


def _replay(log: Log, graph: Graph, node: Node, out: Path | None) -> Replay:
    """Replay a node, its new outputs written to a log where one is asked for."""
    if out is None:
        return replay_component(log, graph, node)
    spec = ChannelSpec(node.name, node.outputs, {"kind": "component"})
    with Recorder(out, [spec], attachments={}, metadata={"replay": {"component": node.name}}) as recorder:
        return replay_component(log, graph, node, lambda rows: recorder.rows(0, rows))


def command(arguments: argparse.Namespace) -> int:
    """Replay it; exit status 1 if nothing was changed and the outputs still differ."""
    log = open_log(arguments.log)
    if arguments.bus:
        return playback.command(log, arguments)
    for text in (log.warning, other_sources(log)):
        if text:
            warn(text)
    foreign = [s for s in arguments.set if not s.startswith(f"{arguments.component}.")]
    if foreign:
        text = f"--set {foreign[0]}: only parameters of {arguments.component} can change, the rest is replayed"
        raise LogError(text)
    graph = graph_of(log)[1]
    node = changed_node(log, graph, arguments.component, arguments.set)
    replay = _replay(log, graph, node, arguments.out)
    if arguments.json:
        ports = {name: {"max_abs": value} for name, value in replay.ports.items()}
        print_json(
            {
                "component": replay.component,
                "identical": replay.identical,
                "steps": len(replay.times_ns) - 1,
                "ports": ports,
            }
        )
    else:
        verdict = "identical to the log" if replay.identical else "different from the log"
        table = Table(title=f"{replay.component}: {len(replay.times_ns) - 1} steps, {verdict}")
        table.add_column("port")
        table.add_column("max |replayed - logged|", justify="right")
        for name, value in replay.ports.items():
            table.add_row(name, "-" if value is None else f"{value:.4g}")
        console().print(table)
    return 0 if replay.identical or arguments.set else 1
