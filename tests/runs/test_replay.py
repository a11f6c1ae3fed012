"""One component run again from a log gives the log's bits, and other numbers with other parameters."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.replay import replay_component
from pipeline.rerun import changed_node, graph_of
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
MODELS = Path(__file__).parents[1] / "orchestration" / "components"
MIXED = """
duration: 60 s
step: 1 s
components:
  a: {model: ./counter.py}
  slow: {model: ./counter.py, period: 3 s}
  b:
    model: ./relay.py
    period: 2 s
    inputs: {in: {sum: [{from: a.n, gain: 0.3}, {from: slow.n, delay: true, initial: 9, gain: -0.7, offset: 0.1}]}}
  c: {model: ./relay.py, inputs: {in: {sum: [b.out, {from: c.out, delay: true, gain: 0.5}]}}}
events:
  - {at: 10 s, set: {a.by: 0.1}}
  - {at: 20 s, add: {a.n: 0.7}, until: 40 s}
  - {at: 25 s, add: {c.out: 0.3}}
"""


def logged(path, scenario):
    run_scenario(scenario, build_graph(scenario), path, Options(), lambda _: None)
    return open_log(path)


@pytest.mark.parametrize("name", ["a", "slow", "b", "c"])
def test_rates_delays_and_events(tmp_path, name):
    log = logged(tmp_path / "mixed.mcap", load_scenario_text(MIXED, "test.yaml", MODELS))
    graph = build_graph(load_scenario_text(MIXED, "test.yaml", MODELS))
    replay = replay_component(log, graph, changed_node(log, graph, name, ()))
    assert replay.identical
    assert replay.times_ns[-1] == 60_000_000_000


@pytest.mark.parametrize("scenario", sorted(SCENARIOS.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_component_of_every_scenario(tmp_path, scenario):
    log = logged(tmp_path / "run.mcap", load_scenario(scenario, duration="4 s"))
    graph = graph_of(log)[1]
    for node in graph.nodes:
        assert replay_component(log, graph, node).identical, node.name


def test_another_parameter_changes_the_result(tmp_path):
    log = logged(tmp_path / "run.mcap", load_scenario(SCENARIOS / "pool_chain.yaml", duration="10 s"))
    graph = graph_of(log)[1]
    thicker = changed_node(log, graph, "tether", ["tether.drag_diameter=12mm"])
    replay = replay_component(log, graph, thicker)
    assert not replay.identical
    assert 1e-4 < replay.ports["nodes"] < 0.1
    coarser = changed_node(log, graph, "tether", ["tether.segments=20"])
    assert replay_component(log, graph, coarser).ports["nodes"] is None
    with pytest.raises(LogError, match=r"with tether.end_b=free tether has other inputs than were logged"):
        changed_node(log, graph, "tether", ["tether.end_b=free"])


def test_inputs_not_recorded_every_step_are_refused(tmp_path):
    text = MIXED.replace("a: {model: ./counter.py}", "a: {model: ./counter.py, record: every 2}")
    scenario = load_scenario_text(text, "test.yaml", MODELS)
    log, graph = logged(tmp_path / "run.mcap", scenario), build_graph(scenario)
    with pytest.raises(
        LogError, match="a was recorded every 2 steps; replay needs every step of it: remove `record` of a"
    ):
        replay_component(log, graph, changed_node(log, graph, "b", ()))
    assert replay_component(log, graph, changed_node(log, graph, "slow", ())).identical


def test_unknown_component(tmp_path):
    scenario = load_scenario_text(MIXED, "test.yaml", MODELS)
    log, graph = logged(tmp_path / "run.mcap", scenario), build_graph(scenario)
    with pytest.raises(LogError, match="no component x; it has a, slow, b, c"):
        changed_node(log, graph, "x", ())
