"""From a log back to the scenario and graph that made it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from components import compiled
from pipeline.errors import LogError
from pipeline.graph import Graph, Node
from pipeline.log.reader import Log
from pipeline.run import RUN, SCENARIO
from pipeline.scenario import Scenario, load_scenario_text
from pipeline.wiring import build_graph


def scenario_of(log: Log, overrides: Sequence[str] = ()) -> Scenario:
    """The resolved scenario in a log, some parameters overridden. Raises LogError if the log holds none."""
    text = log.attachment(SCENARIO).decode()
    return load_scenario_text(text, f"{log.path}[{SCENARIO}]", Path(log.path).parent, overrides)


def graph_of(log: Log) -> tuple[Scenario, Graph]:
    """The resolved scenario in a log, and its graph built anew. Raises LogError if the log holds none."""
    scenario = scenario_of(log)
    return scenario, build_graph(scenario)


def changed_node(log: Log, graph: Graph, name: str, overrides: Sequence[str]) -> Node:
    """A node of the log's graph with other parameters; the nodes that take its outputs are not asked.

    Raises LogError if there is no such node, or its inputs would be others than the log holds.
    """
    node = next((node for node in graph.nodes if node.name == name), None)
    if node is None:
        raise LogError(f"{log.path}: no component {name}; it has {', '.join(node.name for node in graph.nodes)}")
    parameters = next(one.parameters for one in scenario_of(log, overrides).instances if one.name == name)
    component = node.component
    if component.inputs(parameters) != node.inputs:
        raise LogError(f"{log.path}: with {', '.join(overrides)} {name} has other inputs than were logged")
    return replace(node, parameters=parameters, outputs=component.outputs(parameters))


def other_sources(log: Log) -> str | None:
    """A warning if the log was made by other components than those here, None if by the same."""
    made_by = log.metadata(RUN).get("source_hash")
    if made_by == compiled.source_hash():
        return None
    hashes = f"{str(made_by)[:12]}, here {compiled.source_hash()[:12]}"
    return f"{log.path} was made by other sources ({hashes}): results may differ"
