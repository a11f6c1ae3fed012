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


def hanging(mass: float, step: str = "10 ms", motion: str = "end_b: ball.hook", body: str = ""):
    """motion: the wires of the line's end. body: what it is, instead of a mass of the project's own."""
    own = f"model: vessel.mass, parameters: {{mass: {mass} kg, takes_force: true, position: [0 m, 0 m, 1.9 m]}}"
    text = f"""
duration: 1 s
step: {step}
components:
  anchor: {{model: motion.fixed, parameters: {{position: [0 m, 0 m, 0 m]}}}}
  ball: {{{body or own}, inputs: {{force: {{from: chain.force_b, delay: true}}}}}}
  chain:
    model: tether.cable
    parameters: {{file: parameters/pool_chain.yaml, length: 2 m, segments: 20}}
    inputs: {{end_a: anchor.motion, {motion}}}
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


@pytest.mark.parametrize("given", ["position velocity", "position"])
def test_what_the_line_is_not_told_is_estimated(given):
    """The acceleration, or the velocity too, held at zero: the mass of the body follows from what is left."""
    wires = {name: f"ball.hook.{name}" for name in given.split()}
    zero = {"velocity": "[0 m/s, 0 m/s, 0 m/s]", "acceleration": "[0 m/s^2, 0 m/s^2, 0 m/s^2]"}
    text = ", ".join(f"end_b.{name}: {value}" for name, value in (zero | wires).items())
    refuse_unstable(hanging(1e6, motion=text), "test.yaml")
    with pytest.raises(WiringError, match=r"unstable \(G/M = "):
        refuse_unstable(hanging(1.0, motion=text), "test.yaml")


def test_an_fmu_is_refused_with_a_remedy_that_it_has(fmu_of):
    """Its masses are found as those of a native body are, by trying."""
    body = fmu_of("vessel.mass", 2, "mass=1 kg", "takes_force=true", "position=[0 m, 0 m, 1.9 m]")
    heavy = fmu_of("vessel.mass", 2, "mass=1e6 kg", "takes_force=true", "position=[0 m, 0 m, 1.9 m]")
    with pytest.raises(WiringError, match="give the body by `model:` and tie them with a bond, which no FMU can be in"):
        refuse_unstable(hanging(1.0, body=f"fmu: {body}"), "test.yaml")
    refuse_unstable(hanging(1e6, body=f"fmu: {heavy}"), "test.yaml")
