"""From a log back to the scenario and graph that made it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from components import compiled
from pipeline.graph import Graph
from pipeline.log.reader import Log
from pipeline.run import RUN, SCENARIO
from pipeline.scenario import Scenario, load_scenario_text
from pipeline.wiring import build_graph


def graph_of(log: Log, overrides: Sequence[str] = ()) -> tuple[Scenario, Graph]:
    """The resolved scenario in a log, some parameters overridden, and its graph built anew.

    Raises LogError if the log holds none.
    """
    text = log.attachment(SCENARIO).decode()
    scenario = load_scenario_text(text, f"{log.path}[{SCENARIO}]", Path(log.path).parent, overrides)
    return scenario, build_graph(scenario)


def other_sources(log: Log) -> str | None:
    """A warning if the log was made by other components than those here, None if by the same."""
    made_by = log.metadata(RUN).get("source_hash")
    if made_by == compiled.source_hash():
        return None
    return f"{log.path} was made by other sources ({str(made_by)[:12]}, here {compiled.source_hash()[:12]}): results may differ"
