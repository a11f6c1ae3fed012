"""What --explain prints: the terms of each component's model that are on and off, and why; and what it assumes."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from pipeline.graph import Graph


def terms(graph: Graph) -> dict[str, list[dict[str, Any]]]:
    """{component: [{name, on, why}, ...]} in the order in which the models give them."""
    return {node.name: [vars(term).copy() for term in node.component.terms(node.parameters)] for node in graph.nodes}


def print_terms(console: Console, graph: Graph) -> None:
    """A table of the terms, and below it the assumptions of each model once."""
    table = Table(title="what is modelled")
    for column in ("component", "term", "", "because"):
        table.add_column(column, overflow="fold")
    for name, rows in terms(graph).items():
        label = name
        for row in rows:
            table.add_row(label, row["name"], "on" if row["on"] else "off", row["why"])
            label = ""
        table.add_section()
    if table.row_count:
        console.print(table)
    for model, assumptions in {node.component.name: node.component.assumptions for node in graph.nodes}.items():
        console.print(f"{model} assumes: {assumptions or 'nothing stated'}")
