"""A run on other processes over zenoh has the local run's bits. Authority: the local run's digest; no tolerance."""

from __future__ import annotations

import random
from contextlib import nullcontext
from pathlib import Path

import psutil
import pytest

from pipeline import run as run_module
from pipeline.diff import diff_logs
from pipeline.distributed import Distributed
from pipeline.errors import StepError
from pipeline.hosts.deployment import BusOptions, InProcess
from pipeline.log.conventions import SPEED
from pipeline.log.reader import open_log
from pipeline.placement import Hosts, placement_of
from pipeline.rerun import graph_of
from pipeline.resume import resume_run
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.snapshot import Snapshot
from pipeline.wiring import build_graph

FOLDER = Path(__file__).parents[2] / "scenarios"
# Rates, a delayed ring, an event on a section that is due later, an offset with an end, a host with two sections.
MIXED = """
duration: 3 s
step: 1 ms
hosts: {a: p, b: q, c: p, d: q}
components:
  a: {model: motion.van_der_pol, inputs: {neighbour: {from: c.position, delay: true, initial: 1}}}
  b: {model: motion.van_der_pol, period: 2 ms, record: every 7, inputs: {neighbour: a.position}}
  c: {model: motion.van_der_pol, period: 3 ms, inputs: {neighbour: {sum: [b.position, {from: d.position, delay: true,
     initial: 0.5, gain: 0.3, offset: 0.1}, 0.25]}}}
  d: {model: motion.van_der_pol, period: 6 ms, inputs: {neighbour: {from: c.position, gain: -1}}}
events:
  - {at: 100 ms, set: {a.mu: 1.5}}
  - {at: 101 ms, set: {c.mu: 1.7}}
  - {at: 200 ms, add: {b.position: 0.1}, until: 900 ms}
  - {at: 2600 ms, set: {d.mu: 0.5}}
"""


def run(scenario, path, bus=None, **options):
    return run_scenario(scenario, build_graph(scenario), path, Options(bus=bus, **options), lambda _: None)


def nothing_left() -> bool:
    me = psutil.Process()
    return not me.children(recursive=True) and not [c for c in me.net_connections() if c.status == "LISTEN"]


def test_rates_delays_and_events(tmp_path):
    """And nothing of it can be reached by a network."""
    scenario, reachable = load_scenario_text(MIXED, "mixed.yaml", FOLDER), []

    def look(_: float) -> None:
        family = [psutil.Process(), *psutil.Process().children(recursive=True)]
        reachable.append([one.net_connections("inet") for one in family])

    local = run(scenario, tmp_path / "local.mcap")
    options = Options(bus=BusOptions())
    result = run_scenario(scenario, build_graph(scenario), tmp_path / "zenoh.mcap", options, look)
    assert all(found == [[]] * 4 for found in reachable)  # two hosts, what forks them, and this process
    assert (result.digest, result.channels) == (local.digest, local.channels)
    assert list(result.hosts) == ["p", "q"]


@pytest.mark.parametrize("seed", range(8))
def test_any_grouping(seed, tmp_path, monkeypatch):
    """Sections in this process, by the same messages: components dealt to three hosts at random."""
    deal = random.Random(seed)
    scenario = load_scenario_text(MIXED, "mixed.yaml", FOLDER)
    graph = build_graph(scenario)
    local = run_scenario(scenario, graph, tmp_path / "local.mcap", Options(), lambda _: None)
    hosts = Hosts({node.name: deal.choice("pqr") for node in graph.nodes})
    conductor = Distributed(graph, placement_of(graph, hosts, {}), InProcess())
    monkeypatch.setattr("pipeline.run.conductor_of", lambda *_: conductor)
    result = run_scenario(scenario, graph, tmp_path / "sections.mcap", Options(), lambda _: None)
    assert result.digest == local.digest


def test_a_component_that_stops_the_run_is_told_alike(tmp_path):
    """The same message, the same rows before it; the components are Python and raise."""
    text = """
duration: 1 s
step: 100 ms
components:
  early: {model: motion.van_der_pol, inputs: {neighbour: 1}}
  bad: {model: ./bad.py, inputs: {position: early.position}}
  late: {model: motion.van_der_pol, inputs: {neighbour: bad.out}}
"""
    (tmp_path / "bad.py").write_text(BAD)
    scenario = load_scenario_text(text, "bad.yaml", tmp_path)
    said = []
    for bus in (None, BusOptions()):
        with pytest.raises(StepError) as error:
            run(scenario, tmp_path / f"{bus is None}.mcap", bus)
        said.append(str(error.value))
    assert said[0] == said[1]
    assert "bad stopped the run at t = 0.5 s: its Python code raised RuntimeError: five" in said[0]
    a, b = (open_log(tmp_path / f"{is_local}.mcap") for is_local in (True, False))
    assert a.metadata("result") | {SPEED: ""} == b.metadata("result") | {SPEED: ""}
    assert diff_logs(a, b).identical


BAD = '''
"""Raises at the fifth step."""
from components.contract import Component, Parameters, Port


def init(t_ns, dt_ns, p, u, x, y, w):
    y[0] = 0.0
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    y[0] = u[0]
    if t_ns == 500_000_000:
        raise RuntimeError("five")
    return 0


COMPONENT = Component(
    name="bad", parameters=Parameters, init=init, step=step, compiled=False,
    inputs=lambda _: (Port("position", "1"),), outputs=lambda _: (Port("out", "1"),),
)
'''


def test_a_stop_in_the_first_tick_of_a_block_leaves_the_snapshot_before_it(tmp_path, monkeypatch):
    """512 ticks are a block: the snapshot is that of a local run which ends there."""
    monkeypatch.setattr(run_module, "FLUSH_S", 0.0)
    text = "duration: {} s\nstep: 10 ms\nscene: false\ncomponents:\n"
    text += "  early: {{model: motion.van_der_pol, inputs: {{neighbour: 1}}}}\n"
    text += "  bad: {{model: ./bad.py, inputs: {{position: early.position}}}}\n"
    (tmp_path / "bad.py").write_text(BAD.replace("500_000_000", "5_130_000_000"))
    snapshots = []
    for bus, seconds in ((None, 5.12), (BusOptions(), 6.0)):
        log = tmp_path / f"{seconds}.mcap"
        with nullcontext() if bus is None else pytest.raises(StepError, match=r"bad stopped the run at t = 5\.13 s"):
            run(load_scenario_text(text.format(seconds), "bad.yaml", tmp_path), log, bus)
        t_ns, data = open_log(log).last_snapshot()
        snapshots.append((t_ns, Snapshot.from_bytes(data)))
    (t_ns, fine), (failed_ns, failed) = snapshots
    assert t_ns == failed_ns == 5_120_000_000
    assert failed.chains == fine.chains
    assert failed.board.tobytes() == fine.board.tobytes()


def test_resumed_over_zenoh(tmp_path):
    """A run that broke off, whichever way it ran, goes on over zenoh to the same digest."""
    scenario = load_scenario_text(MIXED, "mixed.yaml", FOLDER)
    whole = run(scenario, tmp_path / "whole.mcap")

    def interrupt(simulated_s: float) -> None:
        if simulated_s > 1.5:
            raise KeyboardInterrupt

    graph = build_graph(scenario)
    for bus in (None, BusOptions()):
        path = tmp_path / f"broken{bus is None}.mcap"
        with pytest.raises(KeyboardInterrupt):
            run_scenario(scenario, graph, path, Options(bus=bus), interrupt)
        log = open_log(path)
        result = resume_run(
            log, *graph_of(log), tmp_path / f"resumed{bus is None}.mcap", Options(bus=BusOptions()), lambda _: None
        )
        assert (result.digest, result.channels) == (whole.digest, whole.channels)
    assert nothing_left()
