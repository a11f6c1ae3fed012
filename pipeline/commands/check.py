"""towline check: validate a scenario and show what would run."""

from __future__ import annotations

import argparse
from typing import Any

from rich.table import Table

from components.contract import ImagePort, Port
from pipeline.commands.explain import print_terms, terms
from pipeline.commands.output import console, print_json
from pipeline.graph import Graph, Node
from pipeline.scenario import load_scenario
from pipeline.wires import image_of
from pipeline.wiring import build_graph


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument("scenario", help="scenario YAML")
    parser.add_argument("--set", action="append", default=[], metavar="COMP.PARAM=VALUE", help="change a parameter")
    parser.add_argument("--explain", action="store_true", help="say which terms of each model are on, and why")


def _order(graph: Graph) -> list[str]:
    names = [node.name for node in graph.nodes]
    return [" | ".join("+".join(names[i] for i in group) for group in stage) for stage in graph.stages]


def _told(port: Port) -> str:
    return f"{port.name} ({image_of(port.shape)})" if isinstance(port, ImagePort) else f"{port.name} [{port.unit}]"


def _component(graph: Graph, node: Node) -> dict[str, Any]:
    """What --json says of a component; `images`, {output: shape}, where it has some."""
    images = {port.name: list(port.shape) for port in node.outputs if isinstance(port, ImagePort)}
    about = {"model": node.model, "period_s": node.period * graph.base_ns / 1e9}
    return about | ({"images": images} if images else {})


def command(arguments: argparse.Namespace) -> int:
    """Check it; errors are raised as ScenarioError or WiringError."""
    graph = build_graph(load_scenario(arguments.scenario, arguments.set))
    seconds = graph.ticks * graph.base_ns / 1e9
    if arguments.json:
        components = {node.name: _component(graph, node) for node in graph.nodes}
        found = {"ok": True, "simulated_s": seconds, "ticks": graph.ticks, "order": _order(graph)}
        print_json(found | {"components": components} | ({"terms": terms(graph)} if arguments.explain else {}))
        return 0
    table = Table(
        title=f"{arguments.scenario}: fine, {seconds:g} s in {graph.ticks} steps of {graph.base_ns / 1e6:g} ms"
    )
    for column in ("component", "model", "period", "outputs", "assumes"):
        table.add_column(column)
    for node in graph.nodes:
        outputs = ", ".join(_told(port) for port in node.outputs)
        table.add_row(
            node.name, node.model, f"{node.period * graph.base_ns / 1e6:g} ms", outputs, node.component.assumptions
        )
    out = console()
    out.print(table)
    out.print(f"order of execution: {' -> '.join(_order(graph))}")
    if arguments.explain:
        print_terms(out, graph)
    return 0
