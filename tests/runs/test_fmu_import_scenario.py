"""What a scenario says about FMUs: every mistake with its place and what would be right; ports, units, parameters."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from foreign import ALL_KINDS, ARRAYS, BALL, KINDS, TEXTS, VAN_DER_POL

from pipeline.errors import TowlineError, WiringError
from pipeline.hosts.fmu.component import FmuComponent, component_of
from pipeline.hosts.fmu.units import Conversion, conversion
from pipeline.hosts.fmu.variables import unbundled
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph


def built(text: str, folder: Path, *overrides: str):
    lines = "\n".join(f"  {line}" for line in text.strip().splitlines())
    whole = f"duration: 1 s\nstep: 10 ms\ncomponents:\n{lines}\n"
    return build_graph(load_scenario_text(whole, "scene.yaml", folder, overrides))


def refusal(text: str, folder: Path, *overrides: str) -> str:
    with pytest.raises(TowlineError) as caught:
        built(text, folder, *overrides)
    return str(caught.value)


def test_ports_have_units_shapes_and_descriptions(foreign, tmp_path):
    node = built(
        f"a: {{fmu: {foreign(ARRAYS, 3)}, parameters: {{n: 3, A: {[[1, 0, 0]] * 3}}}, inputs: {{u: [1 m, 1 m, 1 m]}}}}",
        tmp_path,
    ).nodes[0]
    assert [(port.name, port.unit, port.shape) for port in node.outputs] == [
        ("y", "m", (3,)),
        ("f", "m", (2, 3)),
        ("arm.tip.x", "m", ()),
    ]
    node = built(f"a: {{fmu: {foreign(VAN_DER_POL, 2)}}}", tmp_path).nodes[0]
    assert node.outputs[0].description == "position"
    assert [port.unit for port in node.outputs] == ["m", "m/s"]


def test_elements_make_arrays_row_by_row(foreign):
    component = component_of(foreign(ARRAYS, 2))
    ports = component.outputs(component.parameters())
    assert [(port.name, port.shape) for port in ports] == [("y", (2,)), ("f", (2, 3)), ("arm.tip.x", ())]
    assert component.outputs_in_fmu[1].references == (300, 301, 302, 303, 304, 305)


def test_a_port_is_no_bundle_of_others():
    assert unbundled(["a", "a.b", "c"]) == ["a_", "a.b", "c"]


class Base:
    """As fmpy reads FMI's BaseUnit."""

    def __init__(self, factor: float = 1.0, offset: float = 0.0, **powers: int):
        self.factor, self.offset = factor, offset
        for name in ("kg", "m", "s", "A", "K", "mol", "cd", "rad"):
            setattr(self, name, powers.get(name, 0))


@pytest.mark.parametrize(
    ("name", "base", "expected"),
    [
        ("kN", Base(1000.0, kg=1, m=1, s=-2), Conversion("N", 1000.0)),
        ("degC", Base(1.0, 273.15, K=1), Conversion("K", 1.0, 273.15)),
        ("rpm", Base(0.10471975511965977, rad=1, s=-1), Conversion("rad/s", 0.10471975511965977)),
        ("kg.m2", Base(kg=1, m=2), Conversion("kg*m^2")),
        ("N", Base(kg=1, m=1, s=-2), Conversion("N")),
        ("kN", None, Conversion("N", 1000.0)),
        ("knot of its own", None, Conversion()),
    ],
)
def test_units(name, base, expected):
    """By FMI's definition, else by the name; SI's names where the factor is 1."""
    assert conversion(name, base, is_relative=False) == expected


def test_differences_have_no_offset():
    assert conversion("degC", Base(1.0, 273.15, K=1), is_relative=True) == Conversion("K")


def test_mistakes_have_their_place(foreign, tmp_path):
    path = foreign(KINDS, 2)
    said = refusal(f"a:\n  fmu: {path}\n  parameters:\n    offst: 3 N\n    gain: 2 m\n    choice: medium", tmp_path)
    assert "scene.yaml:7:7 components.a.parameters.offst: unknown parameter; did you mean 'offset'?" in said
    assert "scene.yaml:8:13 components.a.parameters.gain: '2 m': 'm' does not convert to '1'" in said
    said = refusal(f"a:\n  fmu: {path}\n  parameters:\n    choice: medium\n    count: 2.5", tmp_path)
    assert (
        "scene.yaml:7:15 components.a.parameters.choice: 'medium' is no item; expected one of low, middle, high" in said
    )
    assert "scene.yaml:8:14 components.a.parameters.count: 2.5 where a whole number is expected" in said
    assert "does not convert" in refusal(f"a: {{fmu: {path}}}", tmp_path, "a.offset=3 m")
    said = refusal(f"a: {{fmu: {path}, inputs: {{real_out: 3 N}}}}", tmp_path)
    assert "a has no input 'real_out'; expected one of real_in" in said or "did you mean 'real_in'" in said


def test_an_int8_parameter_has_its_bounds(foreign, tmp_path):
    said = refusal(f"a: {{fmu: {foreign(ALL_KINDS, 3)}, parameters: {{int8_in: 128}}}}", tmp_path)
    assert "128 is out of range; must be at most 127" in said


def test_bounds_of_whole_numbers_may_be_zero(foreign, tmp_path):
    """`count` from 0 to 4.5: bounds that are no whole numbers allow those between them."""
    path = foreign(KINDS, 2, edit=lambda text: re.sub(r'(name="count".*?start="0")', r'\1 min="0" max="4.5"', text))
    assert "must be at least 0" in refusal(f"a: {{fmu: {path}, parameters: {{count: -1}}}}", tmp_path)
    assert "must be at most 4" in refusal(f"a: {{fmu: {path}, parameters: {{count: 5}}}}", tmp_path)
    built(f"a: {{fmu: {path}, parameters: {{count: 4}}}}", tmp_path)


def test_no_bond_ties_an_fmu(fmu_of, tmp_path):
    """Though it be made of components that have these ends; what can be done is said, in one line for each."""
    ball, chain = (fmu_of(f"bond_mass.yaml#{name}", 2) for name in ("ball", "chain"))
    text = f"duration: 1 s\nstep: 10 ms\ncomponents:\n  ball: {{fmu: {ball}}}\n  chain: {{fmu: {chain}}}\n"
    scene = load_scenario_text(f"{text}bonds:\n  hook: {{body: ball.hook, line: chain.end_b}}\n", "s.yaml", tmp_path)
    with pytest.raises(WiringError) as caught:
        build_graph(scene)
    for place, name in (("7:16", "ball"), ("7:33", "chain")):
        why = "a bond repeats a step and takes laws of force, for which FMI has no words"
        remedy = "give the component by `model:`, or wire the FMU's force without a bond"
        assert f"'{name}' is an FMU, whose ends no bond can tie: {why}; {remedy}" in str(caught.value)
        assert f"s.yaml:{place} bonds.hook." in str(caught.value)
    assert len(str(caught.value).splitlines()) == 2


def test_fixed_parameters_are_not_set_by_events(foreign, tmp_path):
    text = f"a: {{fmu: {foreign(KINDS, 2)}}}\nevents: [{{at: 0.5 s, set: {{a.gain: 2}}}}]"
    lines = text.splitlines()
    whole = f"duration: 1 s\nstep: 10 ms\ncomponents:\n  {lines[0]}\n{lines[1]}\n"
    with pytest.raises(TowlineError, match=r"'a\.gain' is fixed during a run"):
        build_graph(load_scenario_text(whole, "scene.yaml", tmp_path))


def test_texts_that_change_are_refused_by_name(foreign, tmp_path):
    path = foreign(TEXTS, 3)
    built(f"a: {{fmu: {path}, parameters: {{name: 'x', text_in: 'y'}}}}", tmp_path)  # as start values they are fine
    said = refusal(f"a: {{fmu: {path}}}\nb: {{fmu: {path}, inputs: {{real_in: a.text_out}}}}", tmp_path)
    assert "'text_out' is a string, which changes during a run; only numbers can be wired" in said
    said = refusal(f"a: {{fmu: {path}, inputs: {{text_in: 3}}}}", tmp_path)
    assert "'text_in' is a string, which changes during a run" in said


def test_model_and_fmu(foreign, tmp_path):
    path = foreign(KINDS, 2)
    assert "both a model and an FMU" in refusal(f"a: {{fmu: {path}, model: motion.fixed}}", tmp_path)
    assert "the key 'model' is missing" in refusal("a: {period: 10 ms}", tmp_path)
    assert "is for FMUs; leave it out" in refusal("a: {model: motion.van_der_pol, isolate: true}", tmp_path)
    said = refusal(f"a: {{fmu: {path}, interface: model-exchange}}", tmp_path)
    assert "has no model-exchange; it has co-simulation" in said
    assert "not possible; expected" in refusal(f"a: {{fmu: {path}, interface: scheduled}}", tmp_path)
    assert "scene.yaml:4:12 components.a.fmu: " in refusal("a: {fmu: nowhere.fmu}", tmp_path)


def test_co_simulation_is_the_first_choice(foreign):
    path = foreign(BALL, 3)
    assert component_of(path).interface.name == "co-simulation"
    assert component_of(path, "model-exchange").interface.name == "model-exchange"


def test_fixed_internal_steps_divide_the_period(foreign, tmp_path):
    path = foreign(BALL, 3, edit=lambda t: t.replace('hasEventMode="true"', 'fixedInternalStepSize="0.004"'))
    said = refusal(f"a: {{fmu: {path}}}", tmp_path)
    assert "steps by 0.004 s (fixedInternalStepSize), and 0.01 s is no multiple of that" in said
    assert isinstance(built(f"a: {{fmu: {path}, period: 20 ms}}", tmp_path).nodes[0].component, FmuComponent)


def test_resolved_scenario_gives_the_same_graph(foreign, tmp_path):
    path = foreign(ARRAYS, 3)
    own = "isolate: true, parameters: {arm.span: 3 m}, inputs: {u: [1 m, 2 m]}"
    text = f"a: {{fmu: {path}, interface: co-simulation, {own}}}"
    whole = f"duration: 1 s\nstep: 10 ms\ncomponents:\n  {text}\n"
    first = load_scenario_text(whole, "scene.yaml", tmp_path)
    again = load_scenario_text(first.resolved_text(), "again.yaml", Path("/"))
    assert build_graph(again).nodes[0].parameters == build_graph(first).nodes[0].parameters
    assert build_graph(again).nodes[0].component.isolate


def test_scenes_without_fmus_do_not_load_fmpy():
    code = "import sys; from pipeline.scenario import load_scenario; load_scenario('scenarios/van_der_pol.yaml'); "
    code += "print('fmpy' in sys.modules, 'lxml' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert found.stdout.split() == ["False", "False"], found.stderr
