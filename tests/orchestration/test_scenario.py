"""What a good scenario becomes: terms, parameters, events, seeds; from files, overrides and its resolved text.

Authority: the time model and the contract of the design; numbers worked out by hand.
"""

import hashlib
import struct
from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import ScenarioError, TowlineError, WiringError
from pipeline.graph import Event, Graph, Term
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

HERE = Path(__file__).parent
SOURCE = f"{HERE}/components/source.py"
SINK = f"{HERE}/components/sink.py"
# Board: src.motion 0..8, src.nodes 9..20, heading 21, thrust 22..24, force 25..27, pull 28, torque 29; snk.pull 30.
BOTH = f"""\
duration: 1 s
step: 20 ms
seed: 3
components:
  src: {{model: {SOURCE}}}
  snk:
    model: {SINK}
    parameters: {{length: 3 m}}
    inputs:
      end: src.motion
      force: src.force
      pull: src.pull
      matrix: src.nodes[:2, :2]
"""


def graph_of(text: str) -> Graph:
    return build_graph(load_scenario_text(text, "test.yaml", HERE))


def terms_of(old: str, new: str) -> tuple[Term, ...]:
    """Terms of snk after one edit."""
    assert old in BOTH
    return graph_of(BOTH.replace(old, new)).nodes[1].terms


def test_a_bundle_is_one_term_and_a_matrix_one_a_row():
    assert graph_of(BOTH).nodes[1].terms == (
        Term(0, 0, 9),
        Term(9, 25, 4),  # force and pull lie beside each other on both sides
        Term(13, 9, 2),
        Term(15, 12, 2),
    )


def test_sum_delay_and_initial():
    terms = terms_of(
        "src.force", "{sum: [src.force, {from: src.force, gain: -0.5, delay: true, initial: [1, 2, 3 N]}]}"
    )
    assert terms[1] == Term(9, 25, 3)
    assert terms[2] == Term(9, 25, 3, gain=-0.5, delayed=True, initial=(1.0, 2.0, 3.0), assigns=False)


def test_linear_function():
    terms = terms_of("src.pull", "{from: src.heading, gain: 2 kN/deg, offset: 1 kN}")
    assert terms[2].source == 21
    assert terms[2].gain == pytest.approx(2000 / radians(1), rel=1e-15)  # radians() rounds too
    assert terms[2].offset == (1000.0,)


def test_constants_are_one_term():
    terms = terms_of("force: src.force\n      pull: src.pull", "force: {values: [1, 2, 3], unit: kN}\n      pull: -4 N")
    assert terms[1] == Term(9, 0, 4, gain=0.0, offset=(1000.0, 2000.0, 3000.0, -4.0))


def test_parts_of_an_input():
    terms = terms_of("force: src.force", "force[0]: src.pull\n      force[1:]: {from: 'src.force[-2:]', gain: 2}")
    assert terms[1:3] == (Term(9, 28, 1), Term(10, 26, 2, gain=2.0))


@pytest.mark.parametrize(
    ("part", "index"),
    [("3", np.s_[3]), ("-1", np.s_[-1]), ("1, :", np.s_[1, :]), ("2, 0:3", np.s_[2, 0:3]), ("1:, 0", np.s_[1:, 0])],
)
def test_slices_as_numpy_has_them(part, index):
    expected = np.arange(9, 21).reshape(4, 3)[index].tolist()
    graph = graph_of(BOTH.replace("force: src.force", f"force: {{from: 'src.nodes[{part}]', gain: 1 N/m}}"))
    terms = [term for term in graph.nodes[1].terms if 9 <= term.target < 12]
    assert [term.source + i for term in terms for i in range(term.count)] == expected


def test_rates():
    graph = graph_of(BOTH.replace(f"{{model: {SOURCE}}}", f"{{model: {SOURCE}, period: 25 Hz, record: every 120 ms}}"))
    assert (graph.base_ns, graph.ticks) == (20_000_000, 50)
    assert [(node.period, node.record_every) for node in graph.nodes] == [(2, 3), (1, 1)]
    assert (
        graph_of(BOTH.replace(f"{{model: {SOURCE}}}", f"{{model: {SOURCE}, record: false}}")).nodes[0].record_every == 0
    )


def test_seeds_are_the_first_64_bits_of_sha256():
    expected = hashlib.sha256(b"3/snk").digest()[:8]
    assert graph_of(BOTH).nodes[1].seed == struct.unpack(">Q", expected)[0]


def test_parameters_in_si():
    text = BOTH.replace(
        f"{{model: {SOURCE}}}", f"{{model: {SOURCE}, parameters: {{level: 30 cm, weights: [1 kg, 20 g, 3 t]}}}}"
    )
    parameters = graph_of(text).nodes[0].parameters
    assert parameters.level == 0.3
    assert parameters.weights == (1.0, 0.02, 3000.0)


WINDAGE = """
duration: 1 s
step: 100 ms
components:
  ship:
    model: vessel.low_speed
    parameters:
      {surge_mass: 2 t, sway_mass: 3 t, yaw_inertia: 4000 kg m^2, max_speed: 4 kn, takes_wind: true,
       windage: {frontal_area: 3 m^2, lateral_area: 900 dm^2, length: 12 m, cross: 0.9, ahead: 0.5, astern: 0.6,
                 shape: 0.5}}
    inputs: {wind: [1 m/s, 0 m/s, 0 m/s]}
"""


def test_a_parameter_may_be_a_mapping():
    """In its own units, and the resolved text reads back to the same; what is wrong inside is reported there."""
    scenario = load_scenario_text(WINDAGE, "ship.yaml", HERE)
    (ship,) = build_graph(scenario).nodes
    assert ship.parameters.windage.lateral_area == 9.0
    assert ship.parameters.hull is None
    again = load_scenario_text(scenario.resolved_text(), "again.yaml", HERE)
    assert build_graph(again).nodes[0].parameters == ship.parameters
    with pytest.raises(ScenarioError) as error:
        build_graph(load_scenario_text(WINDAGE.replace("cross: 0.9, ", "crosss: 0.9, "), "ship.yaml", HERE))
    texts = [(problem.path, problem.text) for problem in error.value.problems]
    assert texts == [
        ("components.ship.parameters.windage.crosss", "unknown parameter; did you mean 'cross'?"),
    ]


def test_events():
    graph = graph_of(
        BOTH
        + """events:
  - {at: 0.5 s, set: {snk.share: 50 %}}
  - {at: 0.2 s, add: {"src.nodes[1]": [1 m, 2 m, 3 m], src.pull: 5 kN}, until: 3 s}
"""
    )
    assert graph.events == (
        Event(10, (), ((12, (1.0, 2.0, 3.0)), (28, (5000.0,))), 150, graph.events[0].text),
        Event(25, ((1, {"share": 0.5}),), (), -1, "set snk.share = '50 %'"),
    )


BOND = f"""\
duration: 1 s
step: 20 ms
components:
  far: {{model: {SOURCE}}}
  line: {{model: {HERE}/components/string.py, inputs: {{end_a: far.motion}}}}
  ball: {{model: {HERE}/components/ball.py}}
bonds:
  hook: {{body: ball.hook, line: line.end_b}}
"""


def test_a_bond_is_two_wires_and_a_group():
    """Board: far 0..29; line: tension 30, law_b 31..45, accepted_b 46..60; ball: energy 61, hook 62..70."""
    graph = graph_of(BOND)
    _, line, ball = graph.nodes
    assert line.parameters.bond_b
    assert not line.parameters.bond_a
    assert line.terms == (Term(0, 0, 9), Term(9, 62, 9))
    assert ball.terms == (Term(0, 31, 15, delayed=True),)
    bond = graph.bonds[0]
    assert (bond.line, bond.body, bond.motion, bond.law, bond.accepted, bond.target) == (1, 2, 62, 31, 46, 0)
    assert graph.stages == (((0,),), ((2, 1),))


def test_a_parameter_file_of_published_numbers(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "published.yaml").write_text(
        "level_cm: 30\nheading_deg: 90\nwet_mass_kg_per_m: 0.092\nratio: 2\nnodes: 7\n"
        "table: {csv: table.csv, columns: [t, z]}\n"
    )
    (tmp_path / "data" / "table.csv").write_text("t,x,z\n0,9,1.5\n1,9,2.5\n")
    model = f"{{model: {SOURCE}, parameters: {{file: data/published.yaml, nodes: 5}}}}"
    path = tmp_path / "s.yaml"
    path.write_text(BOTH.replace(f"{{model: {SOURCE}}}", model))
    parameters = build_graph(load_scenario(path)).nodes[0].parameters
    assert (parameters.level, parameters.wet_mass, parameters.ratio, parameters.nodes) == (0.3, 0.092, 2.0, 5)
    assert parameters.heading == np.pi / 2
    assert parameters.table == ((0.0, 1.5), (1.0, 2.5))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("levle_m: 3", "published.yaml:1:1 levle_m: unknown parameter; did you mean 'level'?"),
        ("level_kg: 3", "published.yaml:1:1 level_kg: unknown parameter; did you mean 'level'?"),
        ("level_m: 3\nlevel: 3 m", "published.yaml:2:1 level: 'level' is given twice; keep one"),
        (
            "level: 3",
            "published.yaml:1:8 components.src.parameters.level: "
            "3 has no unit; expected a quantity in m, such as '3 m'",
        ),
        (
            "table: {csv: t.csv, columns: y}",
            "published.yaml:1:8 components.src.parameters.table.columns: t.csv has no column 'y'; expected one of t, z",
        ),
        ("table: {csv: t.csv}", "t.csv:3:1 components.src.parameters.table: 'two' is not a number; expected a number"),
        ("- 1", "published.yaml:1:1 expected a mapping of parameters"),
        ("a: 1\na: 2", "published.yaml:2:1 duplicate key 'a', first on line 1; keep one"),
    ],
)
def test_a_broken_parameter_file(tmp_path, text, expected):
    (tmp_path / "published.yaml").write_text(text)
    (tmp_path / "t.csv").write_text("t,z\n1,2\n1,two\n")
    text = BOTH.replace(f"{{model: {SOURCE}}}", f"{{model: {SOURCE}, parameters: {{file: published.yaml}}}}")
    with pytest.raises(ScenarioError) as error:
        load_scenario_text(text, "s.yaml", tmp_path)
    assert expected in str(error.value).splitlines()


def test_overrides(tmp_path):
    (tmp_path / "s.yaml").write_text(BOTH + "events: [{at: 0.5 s, set: {snk.share: 0.5}}]\n")
    scenario = load_scenario(tmp_path / "s.yaml", ["snk.length=2", "src.heading=90 deg", "src.weights=[1, 2 g]"], "0.4")
    graph = build_graph(scenario)
    assert graph.nodes[1].parameters.length == 2.0
    assert graph.nodes[0].parameters.heading == np.pi / 2
    assert graph.nodes[0].parameters.weights == (1.0, 0.002)
    assert graph.ticks == 20
    assert graph.events == ()  # the end comes first


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("snk.length", "--set 'snk.length' is no override; expected component.parameter=value"),
        ("sink.length=2", "--set sink: unknown component 'sink'; did you mean 'snk'?"),
        ("snk.lenght=2", "--set snk.lenght: unknown parameter; did you mean 'length'?"),
        ("snk.length=-2", "--set components.snk.parameters.length: -2 m is out of range; must be above 0 m"),
        (
            "snk.length=2 kg",
            "--set components.snk.parameters.length: '2 kg':"
            " 'kg' does not convert to 'm'; expected a quantity in m, such as '1 m'",
        ),
        (
            "snk.length=[",
            "--set snk.length: not YAML: while parsing a flow node did not find expected node content",
        ),
    ],
)
def test_broken_overrides(override, expected):
    with pytest.raises(ScenarioError) as error:
        load_scenario_text(BOTH, "s.yaml", HERE, [override])
    assert str(error.value) == expected


@pytest.mark.parametrize(
    ("until", "expected"),
    [
        ("0.123", "--until duration: 123 ms is not a multiple of the step of 20 ms; nearest is 120 ms"),
        (
            "20 ms",
            "--until components.src.period: its period of 40 ms is longer than the run of 20 ms: it would never step",
        ),
        ("-1", "--until '-1' is not above zero; expected e.g. '10 s'"),
    ],
)
def test_until_is_blamed_for_what_it_breaks(until, expected):
    text = BOTH.replace(f"{{model: {SOURCE}}}", f"{{model: {SOURCE}, period: 40 ms}}")
    with pytest.raises(TowlineError) as error:
        build_graph(load_scenario_text(text, "s.yaml", HERE, (), until))
    assert str(error.value) == expected


def test_an_override_is_blamed_for_what_it_breaks():
    """Also where no value alone is wrong: here the number of signals that follows from it."""
    text = f"duration: 1 s\nstep: 20 ms\ncomponents: {{src: {{model: {SOURCE}}}}}"
    with pytest.raises(WiringError) as error:
        build_graph(load_scenario_text(text, "s.yaml", HERE, ["src.nodes=10000000"]))
    assert str(error.value).startswith("--set components.src: test.source cannot be set up")


def test_an_override_cannot_untie_a_bond():
    with pytest.raises(ScenarioError) as error:
        load_scenario_text(BOND, "s.yaml", HERE, ["line.bond_b=false"])
    expected = "--set components.line.parameters.bond_b: false, but bond 'hook' turns it on"
    assert str(error.value).startswith(expected)
    assert build_graph(load_scenario_text(BOND, "s.yaml", HERE, ["line.bond_b=true"])).bonds


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("a b-1.yaml", "a b-1"),
        (".hidden.yaml", "hidden"),
        ("tow (øre).yaml", "tow __re_"),
        (f"{'x' * 99}.yaml", "x" * 64),
    ],
)
def test_a_file_names_a_scenario_without_a_name(file, name):
    """The resolved text names it, so the name must be one that the text may hold."""
    scenario = load_scenario_text(BOTH, file, HERE)
    assert scenario.name == name
    assert load_scenario_text(scenario.resolved_text(), "log", "/").name == name


def test_all_kinds_of_problems_are_reported_together():
    """A wrong unit, an unknown key, a wrong wire and a wrong event of one file, in the order they stand."""
    two = f"  two: {{model: {SINK}, parameters: {{length: 1 m}}, inputs: {{end: src.nodes}}}}"
    text = BOTH.replace("length: 3 m", "length: 3 kg").replace("seed: 3", "sede: 3")
    text = text.replace("components:\n", f"components:\n{two}\n") + "events: [{at: 2 s, set: {src.ratio: x}}]"
    with pytest.raises(ScenarioError) as error:
        load_scenario_text(text, "s.yaml", HERE)
    found = [(problem.place.line, problem.path) for problem in error.value.problems]
    assert found == [
        (3, "sede"),
        (5, "components.two.inputs"),
        (5, "components.two.inputs"),
        (5, "components.two.inputs"),
        (5, "components.two.inputs.end"),
        (9, "components.snk.parameters.length"),
        (15, "events[0].set.src.ratio"),
    ]


EVERYTHING = f"""\
duration: 1 s
step: 20 ms
start: 3 s
seed: 12345678901234567890
scene: false
components:
  far:
    model: components/source.py
    period: 40 ms
    record: every 80 ms
    parameters:
      level: 1 ft
      heading: 0.1 deg
      weights: [1 lb, 0.1 kg, {5e-324!r} kg]
      wet_mass: {0.1 + 0.2!r} kg/m
      table: [[0, 0.1], [1.0e-7, {1 / 3!r}]]
  snk:
    model: components/sink.py
    parameters: {{length: 3 yd}}
    inputs:
      end: far.motion
      force: {{sum: [far.force, {{from: far.force, gain: 0.1, delay: true, initial: [0.1, 2, 3 kN]}}]}}
      pull: {{from: far.heading, gain: 0.1 N/deg, offset: 1 lbf}}
      matrix: [[1 m, 2 m], [3 m, 0.1 in]]
  line: {{model: components/string.py, inputs: {{end_a: far.motion}}}}
  ball: {{model: components/ball.py}}
bonds:
  hook: {{body: ball.hook, line: line.end_b, rounds: 3}}
events:
  - {{at: 3.5 s, set: {{snk.share: 0.3}}}}
  - {{at: 3.2 s, add: {{"far.nodes[:, 1]": [1 m, 2 m, 3 m, 0.1 ft]}}, until: 3.4 s}}
"""


def test_the_resolved_text_gives_the_same_graph():
    """Bit for bit, from another folder, and it is its own resolved text."""
    scenario = load_scenario_text(EVERYTHING, "everything.yaml", HERE)
    again = load_scenario_text(scenario.resolved_text(), "log", "/")
    first, second = build_graph(scenario), build_graph(again)
    assert second == first
    for a, b in zip(first.nodes, second.nodes, strict=True):
        assert a.component.pack(a.parameters, a.seed).tobytes() == b.component.pack(b.parameters, b.seed).tobytes()
    assert again.resolved_text() == scenario.resolved_text()
    assert replace(again, tree=scenario.tree, source="", folder=HERE).name == "everything"


def test_the_resolved_text_holds_the_overrides():
    scenario = load_scenario_text(EVERYTHING, "everything.yaml", HERE, ["snk.length=0.1"], "0.4 s")
    again = load_scenario_text(scenario.resolved_text(), "log", "/")
    assert build_graph(again) == build_graph(scenario)
    assert again.duration_ns == 400_000_000
    assert len(again.happenings) == 1


def test_the_scenarios_of_this_repository_load():
    paths = sorted((HERE.parents[1] / "scenarios").glob("*.yaml"))
    assert paths
    for path in paths:
        assert build_graph(load_scenario(path)).ticks > 0


def test_the_scenario_that_the_broken_ones_come_from_is_fine():
    text = (Path(__file__).parent / "good.yaml").read_text()
    assert build_graph(load_scenario_text(text, "good.yaml", Path(__file__).parent)).ticks == 50
