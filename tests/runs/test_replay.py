"""One component run again from a log gives the log's bits, and other numbers with other parameters."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.errors import LogError, StepError
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


COUNTED = """
duration: 60 s
step: 1 s
components: {a: {model: ./counter.py}, b: {model: ./relay.py, inputs: {in: a.n}}}
events: [{at: 3 s, set: {a.by: 2}}]
"""


def counted(path, text=COUNTED):
    scenario = load_scenario_text(text, "test.yaml", MODELS)
    graph = build_graph(scenario)
    with contextlib.suppress(StepError):
        run_scenario(scenario, graph, path, Options(), lambda _: None)
    return open_log(path), graph


def test_a_log_that_ends_early_is_replayed_as_far_as_it_goes(tmp_path):
    """Also a component without inputs, whose steps no other channel limits: all that is said is compared."""
    log, graph = counted(tmp_path / "run.mcap", COUNTED.replace("./relay.py", "./relay.py, parameters: {stop_at: 9}"))
    replay = replay_component(log, graph, changed_node(log, graph, "a", ()))
    assert replay.identical
    assert replay.times_ns.tobytes() == log.times("a").tobytes()
    assert len(replay.outputs) == len(log.times("a")) < 10


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ("b.stop_at=9", "it saw the number it was told to stop at"),
        ("b.poison_at=9", "its output out is not finite"),
    ],
)
def test_a_replayed_component_that_stops_says_why(tmp_path, change, reason):
    """As the run would have: 1, 2, 3, 5, 7, 9."""
    log, graph = counted(tmp_path / "run.mcap")
    with pytest.raises(StepError, match=rf"b stopped the run at t = 6 s: {reason} \(inputs: in = 9 1\)"):
        replay_component(log, graph, changed_node(log, graph, "b", [change]))


def test_a_replayed_component_that_stops_at_t0_says_why(tmp_path):
    log, graph = counted(tmp_path / "run.mcap")
    with pytest.raises(StepError, match="b stopped the run at t = 0 s: it saw the number"):
        replay_component(log, graph, changed_node(log, graph, "b", ["b.stop_at=0"]))


def test_a_replayed_python_component_that_raises_says_why(tmp_path):
    """The step that failed is made again to learn why, from the state that it began with."""

    def step(t_ns, dt_ns, p, u, x, y, w):
        x[0] += 1.0
        y[0] = x[0]
        if x[0] == 5.0:
            raise ValueError(f"{x[0]:g} steps are enough")
        return 0

    log, graph = counted(tmp_path / "run.mcap")
    node = changed_node(log, graph, "a", ())
    broken = replace(node, component=replace(node.component, compiled=False, step=step))
    with pytest.raises(StepError, match="a stopped the run at t = 5 s: its Python code raised ValueError: 5 steps are"):
        replay_component(log, graph, broken)


def test_unknown_component(tmp_path):
    scenario = load_scenario_text(MIXED, "test.yaml", MODELS)
    log, graph = logged(tmp_path / "run.mcap", scenario), build_graph(scenario)
    with pytest.raises(LogError, match="no component x; it has a, slow, b, c"):
        changed_node(log, graph, "x", ())
