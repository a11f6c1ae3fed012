"""Scenes whose components are FMUs of other scenes give the native scenes' bits, wire by wire."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import ScenarioError
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def rows(name, path):
    scenario = load_scenario(SCENARIOS / f"{name}.yaml", duration="8 s")
    graph = build_graph(scenario)
    result = run_scenario(scenario, graph, path, Options(), lambda _: None)
    log = open_log(result.log)
    return {
        f"{node.name}.{port.name}": log.port(node.name, port.name)
        for node in graph.nodes
        for port in node.outputs
        if not port.name.startswith("validity")  # an FMU has these as ports too, but its parameters may leave some out
    }


@pytest.mark.parametrize(("name", "native"), [("boom_fmu", "boom_sweep"), ("dp_fmu", "supply_vessel_box")])
def test_bits_of_the_native_scene(name, native, tmp_path):
    found, expected = rows(name, tmp_path / "fmu.mcap"), rows(native, tmp_path / "native.mcap")
    assert found.keys() == expected.keys()
    for port, value in expected.items():
        assert np.array_equal(found[port].reshape(value.shape), value), port


@pytest.mark.parametrize(
    ("reference", "message"),
    [
        ("boom_sweep.yaml#rope", "no component 'rope'"),
        ("absent.yaml#boom", "absent.yaml"),
        ("boom_fmu.yaml#boom", "FMU"),
    ],
)
def test_a_reference_that_leads_nowhere(reference, message):
    text = f"duration: 1 s\nstep: 50 ms\ncomponents:\n  boom: {{fmu: '{reference}'}}\n"
    with pytest.raises(ScenarioError, match=message) as caught:
        load_scenario_text(text, "own.yaml", SCENARIOS)
    assert "own.yaml:4:15 components.boom.fmu" in str(caught.value)


def test_a_scene_made_of_itself(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text("duration: 1 s\nstep: 50 ms\ncomponents:\n  boom: {fmu: 'own.yaml#boom'}\n")
    with pytest.raises(ScenarioError, match="is made of itself"):
        load_scenario(path)
