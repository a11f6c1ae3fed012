"""From a log back to the scenario and graph that made it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from components import cache
from pipeline.errors import LogError, ScenarioError
from pipeline.graph import Graph, Node
from pipeline.log.reader import Log
from pipeline.provenance import FMUS, MODELS_HASH, RUN, models_hash
from pipeline.run import SCENARIO
from pipeline.scenario import Scenario, load_scenario_text
from pipeline.wiring import build_graph


def scenario_of(log: Log, overrides: Sequence[str] = ()) -> Scenario:
    """The resolved scenario in a log, some parameters overridden. Raises LogError if the log holds none."""
    text = log.attachment(SCENARIO).decode()
    for name in (*_models(log), *fmus_of(log)):
        if not Path(name).exists():
            text = text.replace(name, str(_unpacked(log, name)))
    try:
        return load_scenario_text(text, f"{log.path}[{SCENARIO}]", Path(log.path).parent, overrides)
    except ScenarioError as error:
        if changed := _changed_fmu(log):
            raise LogError(f"{log.path}: {changed}, and the run's scenario does not fit it any more") from error
        raise


def fmus_of(log: Log) -> dict[str, str]:
    """SHA-256 of the FMUs that the log was made with, by path."""
    return json.loads(log.metadata(RUN).get(FMUS, "{}"))


def _changed_fmu(log: Log) -> str:
    """Which FMU is another than the log was made with; "" if none."""
    for name, digest in fmus_of(log).items():
        here = hashlib.sha256(Path(name).read_bytes()).hexdigest() if Path(name).exists() else digest
        if here != digest:
            return f"{name} changed since the log was made (its SHA-256 was {digest[:12]}..., here {here[:12]}...)"
    return ""


def _models(log: Log) -> list[str]:
    """Paths of the file models whose sources the log holds."""
    return [name for name in log.attachment_names() if name.endswith(".py")]


def _unpacked(log: Log, name: str) -> Path:
    """A file model's source, or an FMU, written out from the log, because it is no longer where it was."""
    if name not in log.attachment_names():
        raise LogError(f"{log.path}: {name} is no longer there, and the log holds no FMU of that size; put it back")
    source = log.attachment(name)
    path = cache.cache_folder() / f"model_{hashlib.sha256(source).hexdigest()[:16]}" / Path(name).name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(source)
    return path


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
    """A warning if the log was made by other components or file models than those here, None if by the same."""
    here = {name: Path(name).read_bytes() if Path(name).exists() else log.attachment(name) for name in _models(log)}
    made_by = log.metadata(RUN)
    if changed := _changed_fmu(log):
        return f"{log.path}: {changed}: results may differ"
    if made_by.get(MODELS_HASH, "") != models_hash(here):
        return f"{log.path}: {', '.join(here)} changed since the log was made: results may differ"
    if made_by.get("source_hash") != cache.source_hash():
        hashes = f"{made_by.get('source_hash', '')[:12]}, here {cache.source_hash()[:12]}"
        return f"{log.path} was made by other sources ({hashes}): results may differ"
    return None
