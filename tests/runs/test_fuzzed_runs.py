"""Mutated scenarios that still load are run: the log is whole, or it says that it is not; never anything in between."""

from __future__ import annotations

import re
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import TowlineError
from pipeline.log.conventions import COMPLETE, ENDING, RESULT
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
TEXT = """\
duration: 2 s
step: 20 ms
scene: 25 Hz
components:
  a:
    model: motion.van_der_pol
    parameters: {mu: 1.5, position: 2.0}
    inputs: {neighbour: {from: b.position, delay: true}}
  b: {model: motion.van_der_pol, period: 40 ms, record: every 3, inputs: {neighbour: {sum: [a.position, 0.5]}}}
  anchor: {model: motion.fixed, parameters: {position: [0 m, 0 m, 1 m]}}
  ball: {model: vessel.mass, parameters: {mass: 2 kg, weight: [0 N, 0 N, 15 N], position: [0 m, 0 m, 3.0000707 m]}}
  chain:
    model: tether.cable
    parameters: {file: parameters/pool_chain.yaml, length: 2 m, segments: 8}
    inputs: {end_a: anchor.motion}
bonds: {hook: {body: ball.hook, line: chain.end_b, tolerance: 1 mN, rounds: 4}}
events:
  - {at: 0.5 s, set: {a.mu: 3, ball.weight: [8 N, 0 N, 15 N]}}
  - {at: 1 s, add: {b.position: 0.25}, until: 1.5 s}
"""
PLACES = [match.span() for match in re.finditer(r"(?<![\w.])\d+(\.\d+)?", TEXT)]
NUMBERS = ["0", "-1", "1e-9", "0.3", "2", "7", "40", "1e6", "1e300"]
LARGEST_RUN = 2000  # ticks


@settings(max_examples=200, deadline=None)  # the first one may compile
@given(st.lists(st.tuples(st.sampled_from(PLACES), st.sampled_from(NUMBERS)), min_size=1, max_size=2))
def test_whole_or_said_to_be_not(tmp_path_factory, edits):
    """Numbers become others, their units kept: masses, lengths, times, rates, tolerances."""
    text = TEXT
    for (first, end), number in sorted(edits, reverse=True):
        text = text[:first] + number + text[end:]
    out = tmp_path_factory.mktemp("fuzz") / "run.mcap"
    try:
        scenario = load_scenario_text(text, "fuzz.yaml", SCENARIOS)
        graph = build_graph(scenario)
        if graph.ticks > LARGEST_RUN:
            return
        result = run_scenario(scenario, graph, out, Options(), lambda _: None)
    except TowlineError:
        if out.exists():
            log = open_log(out)
            assert not (log.complete and log.metadata(RESULT)[ENDING] == COMPLETE)
    else:
        log = open_log(out)
        assert log.complete
        assert log.metadata(RESULT)["digest"] == result.digest
