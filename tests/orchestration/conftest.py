"""Runs small graphs in every execution mode and tells what each component gave out at each of its steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.conductor import Conductor
from pipeline.errors import ScenarioError, WiringError
from pipeline.graph import Graph
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

HERE = Path(__file__).parent / "components"
Trace = dict[str, list]


def graph_from(text: str) -> Graph:
    """A graph from the body of a scenario: 1 s steps, 6 s, models from tests/orchestration/components."""
    head = "" if "duration:" in text else "duration: 6 s\n"
    return build_graph(load_scenario_text(f"{head}step: 1 s\n{text}", "test.yaml", HERE))


def trace_of(graph: Graph, slice_ticks: int | None = None) -> Trace:
    """{component: [(time [s], value or list of values), ...]} of all steps."""
    conductor = Conductor(graph)
    seen: Trace = {node.name: [] for node in graph.nodes}

    def take() -> None:
        for channel, rows in conductor.captured():
            for row in rows:
                values = row[1:].tolist()
                seen[graph.nodes[channel].name].append((int(row[:1].view("i8")[0]) / 1e9, *values))

    conductor.initialise()
    take()
    for _ in conductor.run(graph.ticks, lambda: slice_ticks):
        take()
    return seen


@pytest.fixture(params=["compiled", "python", "one tick a slice"])
def trace(request: pytest.FixtureRequest) -> Callable[[str], Trace]:
    """A function from a scenario's body to its trace, in each execution mode of one process."""

    def run(text: str) -> Trace:
        graph = graph_from(text)
        if request.param == "python":
            nodes = tuple(replace(n, component=replace(n.component, compiled=False)) for n in graph.nodes)
            graph = replace(graph, nodes=nodes)
        return trace_of(graph, 1 if request.param == "one tick a slice" else None)

    return run


@pytest.fixture
def graph() -> Callable[[str], Graph]:
    """A function from a scenario's body to its graph."""
    return graph_from


@pytest.fixture
def message() -> Callable[[str], str]:
    """A function from a broken scenario's text to the message it gets, without the file's name."""

    def of(text: str) -> str:
        with pytest.raises((ScenarioError, WiringError)) as error:
            build_graph(load_scenario_text(text, "s.yaml", HERE.parent))
        return str(error.value).replace("s.yaml:", "").replace(str(HERE.parent), "HERE")

    return of
