"""A force handed to a body one step late is refused where it would grow, with the bond as remedy.

Authority: the growth of the plainly delayed force seen in bond_convergence, near G/M = 1 and beyond.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.coupling import LIMIT, force_loops, refuse_unstable
from pipeline.errors import WiringError
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def hanging(mass: float, step: str = "10 ms"):
    text = f"""
duration: 1 s
step: {step}
components:
  anchor: {{model: motion.fixed, parameters: {{position: [0 m, 0 m, 0 m]}}}}
  ball:
    model: vessel.mass
    parameters: {{mass: {mass} kg, takes_force: true, position: [0 m, 0 m, 1.9 m]}}
    inputs: {{force: {{from: chain.force_b, delay: true}}}}
  chain:
    model: tether.cable
    parameters: {{file: parameters/pool_chain.yaml, length: 2 m, segments: 20}}
    inputs: {{end_a: anchor.motion, end_b: ball.hook}}
"""
    return build_graph(load_scenario_text(text, "test.yaml", SCENARIOS))


def test_the_loop_is_found():
    (found,) = force_loops(hanging(1.0))
    assert (found.line, found.end, found.body) == (2, "end_b", 1)


def test_light_body_is_refused_with_the_remedy():
    with pytest.raises(WiringError) as caught:
        refuse_unstable(hanging(1.0), "test.yaml")
    message = str(caught.value)
    assert message.startswith("test.yaml:1:1 components.ball.inputs: ball takes the force of chain.end_b one step late")
    assert f"limit {LIMIT}); tie them with a bond: bonds: {{tie: {{body: ball.<end>, line: chain.end_b}}}}" in message


def test_heavy_body_is_let_through():
    refuse_unstable(hanging(1e6), "test.yaml")


def test_bonds_and_other_wires_are_no_loops():
    for scenario in sorted(SCENARIOS.glob("*.yaml")):
        assert force_loops(build_graph(load_scenario(scenario))) == []
