"""SSP and OSP made scenarios, and scenarios of FMUs made SSPs, against fmpy, libcosim and the schemas."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
import yaml
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet
from foreign import ALL_KINDS, ARRAYS, BALL, KINDS, VAN_DER_POL
from lxml import etree

from pipeline.cli import main
from pipeline.conductor import Conductor
from pipeline.graph import Graph
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
SSP = "http://ssp-standard.org/SSP1/SystemStructure"
SPACES = f'xmlns:ssd="{SSP}Description" xmlns:ssc="{SSP}Common" xmlns:ssv="{SSP}ParameterValues" '
SPACES += f'xmlns:ssm="{SSP}ParameterMapping"'
PAIR = """
name: two
description: A pair, and what hangs on it.
duration: 1 s
step: 10 ms
start: 2 s
seed: 7
components:
  a:
    fmu: vdp.fmu
    parameters: {coupling: 0.5, mu: 2.0}
    inputs: {neighbour: {from: b.x, delay: true, initial: 1.5}}
  b: {fmu: vdp.fmu, interface: model-exchange, period: 20 ms, inputs: {neighbour: {from: a.x, gain: 0.1, offset: 3 mm}}}
  c:
    fmu: kinds.fmu
    isolate: false
    record: every 2
    parameters: {name: "näme", on: true, count: 3, gain: 2.5, choice: high, offset: 1.5 kN}
    inputs: {real_in: {from: a.x, gain: 3 N/m}, int_in: 4}
  d: {fmu: arrays.fmu, parameters: {A: [[1, 2], [3, 4]]}, inputs: {u: d2.y}}
  d2: {fmu: arrays.fmu, inputs: {"u[0]": {from: a.x, delay: true}, "u[1]": {from: b.x, gain: 2}}}
  e: {fmu: kinds.fmu, inputs: {real_in: c.real_out, on_in: c.on_out}}
events:
  - {at: 2.5 s, set: {a.mu: 3.0}}
"""


@pytest.fixture(scope="module")
def fmus(foreign, tmp_path_factory) -> Path:
    """A folder of FMUs."""
    folder = tmp_path_factory.mktemp("system")
    for name, model, fmi in (
        ("vdp", VAN_DER_POL, 2),
        ("kinds", KINDS, 2),
        ("arrays", ARRAYS, 2),
        ("ball", BALL, 2),
        ("arrays3", ARRAYS, 3),
        ("kinds3", ALL_KINDS, 3),
    ):
        (folder / f"{name}.fmu").write_bytes(foreign(model, fmi).read_bytes())
    return folder


@pytest.fixture
def place(fmus, tmp_path, monkeypatch) -> Path:
    """A folder of the test's own with the FMUs in it."""
    for path in fmus.iterdir():
        (tmp_path / path.name).symlink_to(path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def convert(capsys, *words: str) -> list[str]:
    """Convert, and give what was not kept."""
    code = main(["convert", *words, "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == 0, told
    return told["notes"]


def refusal(capsys, *words: str) -> str:
    assert main(["convert", *words]) == 1
    return capsys.readouterr().err


def graph_of(path: str) -> Graph:
    return build_graph(load_scenario(path))


def compared(graph: Graph) -> list:
    """All of a graph that a run depends on."""
    nodes = [
        (n.name, n.period, n.record_every, n.seed, n.terms, n.component.interface, n.component.isolate)
        for n in graph.nodes
    ]
    fed = [{port.name for port in n.inputs} for n in graph.nodes]  # whose start values come to the same as constants
    values = [n.parameters.model_dump(exclude=names) for n, names in zip(graph.nodes, fed, strict=True)]
    return [graph.base_ns, graph.ticks, graph.start_ns, graph.stages, graph.events, nodes, values]


def test_round_trip_gives_the_same_graph(place, capsys):
    (place / "pair.yaml").write_text(PAIR)
    notes = convert(capsys, "pair.yaml")
    assert notes == [
        f"{what}: kept as annotations, which only Towline reads"
        for what in (
            "which wires are delayed, and what they carry before the first step",
            "b: period",
            "c: isolate, record",
            "step_s, seed, events",
        )
    ]
    assert convert(capsys, "pair.ssp", "-o", "back.yaml") == []
    assert compared(graph_of("back.yaml")) == compared(graph_of("pair.yaml"))
    first = (place / "pair.ssp").read_bytes()
    convert(capsys, "pair.yaml", "-o", "same.ssp")
    assert (place / "same.ssp").read_bytes() == first


def test_round_trip_gives_the_same_digest(place, capsys):
    (place / "pair.yaml").write_text(PAIR.replace("interface: model-exchange, ", ""))
    convert(capsys, "pair.yaml")
    convert(capsys, "pair.ssp", "-o", "back.yaml")
    digests = set()
    for name in ("pair", "back"):
        assert main(["run", f"{name}.yaml", "--out", f"{name}.mcap", "--json"]) == 0
        digests.add(json.loads(capsys.readouterr().out)["digest"])
    assert len(digests) == 1


def test_written_documents_are_valid(place, capsys):
    """By the schemas of SSP 1.0 that fmpy has."""
    (place / "pair.yaml").write_text(PAIR)
    convert(capsys, "pair.yaml")
    with zipfile.ZipFile("pair.ssp") as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
        assert sorted(archive.namelist()) == [
            "SystemStructure.ssd",
            "resources/arrays.fmu",
            "resources/kinds.fmu",
            "resources/vdp.fmu",
        ]
    for name, elements in (
        ("SystemStructureDescription", [root]),
        ("SystemStructureParameterValues", list(root.iter(f"{{{SSP}ParameterValues}}ParameterSet"))),
    ):
        schema = etree.XMLSchema(file=str(SCHEMAS / f"{name}.xsd"))
        assert elements
        for element in elements:
            schema.assertValid(etree.fromstring(etree.tostring(element)))


def ran(graph: Graph) -> dict[str, np.ndarray]:
    """What the board holds at the end of a run, by component."""
    conductor = Conductor(graph)
    try:
        conductor.initialise()
        for _ in conductor.run(graph.ticks):
            pass
        memory = conductor.memory
        return {node.name: memory.tables.board[memory.spans["y"][i]].copy() for i, node in enumerate(graph.nodes)}
    finally:
        conductor.close()


def test_ssp_in_fmpy(place, capsys):
    """fmpy steps all on the values before, the first ones zero; it reads neither parameters in an SSD nor functions."""
    (place / "ring.yaml").write_text(
        "duration: 2 s\nstep: 10 ms\ncomponents:\n"
        "  a: {fmu: vdp.fmu, parameters: {coupling: 0.5}, inputs: {neighbour: {from: b.v, gain: 1 s, delay: true}}}\n"
        "  b: {fmu: vdp.fmu, parameters: {coupling: 0.3}, inputs: {neighbour: {from: a.v, gain: 1 s, delay: true}}}\n"
    )
    convert(capsys, "ring.yaml")
    values = [
        Parameter(name=f"{name}.coupling", type="Real", value=value) for name, value in (("a", "0.5"), ("b", "0.3"))
    ]
    rows = simulate_ssp("ring.ssp", stop_time=1.995, step_size=0.01, parameter_set=ParameterSet(parameters=values))
    found = ran(graph_of("ring.yaml"))
    assert len(rows) == 200
    for name in ("a", "b"):
        last = [rows[f"{name}.{variable}"][-1] for variable in ("x", "v")]
        # the same functions called with the same numbers; only the time is added up otherwise, which they do not read
        assert np.abs(last - found[name]).max() <= 1e-12


def ssd(elements: str, connections: str = "", more: str = "", outer: str = "", units: str = "") -> str:
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<ssd:SystemStructureDescription {SPACES} version="1.0" name="plant">'
        f'<ssd:System name="plant">{outer}<ssd:Elements>{elements}</ssd:Elements>'
        + (f"<ssd:Connections>{connections}</ssd:Connections>" if connections else "")
        + f"</ssd:System>{units}{more}</ssd:SystemStructureDescription>"
    )


def component(name: str, fmu: str, inside: str = "") -> str:
    return (
        f'<ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="{fmu}">{inside}</ssd:Component>'
    )


def wire(start: str, end: str, inside: str = "", more: str = "") -> str:
    """A connection; `.x`: of the system itself."""
    names = {}
    for key, (element, _, connector) in (("start", start.partition(".")), ("end", end.partition("."))):
        names |= {f"{key}Connector": connector} | ({f"{key}Element": element} if element else {})
    attributes = " ".join(f'{key}="{value}"' for key, value in names.items())
    return (
        f"<ssd:Connection {attributes} {more}>{inside}</ssd:Connection>"
        if inside
        else f"<ssd:Connection {attributes} {more}/>"
    )


def values(*parameters: str, prefix: str = "", units: str = "") -> str:
    listed = "".join(parameters)
    return (
        f'<ssd:ParameterBindings><ssd:ParameterBinding prefix="{prefix}"><ssd:ParameterValues>'
        '<ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>'
        f"{listed}</ssv:Parameters>{units}</ssv:ParameterSet></ssd:ParameterValues>"
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def value(name: str, kind: str, text: str, unit: str = "") -> str:
    return (
        f'<ssv:Parameter name="{name}"><ssv:{kind} value="{text}"{f" unit={unit!r}" if unit else ""}/></ssv:Parameter>'
    )


def linear(factor: float | str, offset: float = 0.0) -> str:
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


def read(capsys, document: str, name: str = "plant.ssd", *words: str) -> tuple[dict, list[str]]:
    """The scenario of a document that is valid by the schema, and what was not kept."""
    if name.endswith(".ssd"):
        etree.XMLSchema(file=str(SCHEMAS / "SystemStructureDescription.xsd")).assertValid(
            etree.fromstring(document.encode())
        )
    Path(name).write_text(document)
    notes = convert(capsys, name, "-o", "read.yaml", "--overwrite", *words)
    graph_of("read.yaml")
    return yaml.safe_load(Path("read.yaml").read_text()), notes


STOP = '<ssd:DefaultExperiment startTime="0" stopTime="2.5"/>'


def test_times_and_direct_wires(place, capsys):
    document = ssd(
        component("A", "vdp.fmu") + component("B", "vdp.fmu"),
        wire("A.x", "B.neighbour") + wire("B.x", "A.neighbour"),
        more=STOP,
    )
    scenario, notes = read(capsys, document)
    assert (scenario["duration"], scenario["step"]) == ("2.5 s", "10 ms")
    assert notes == [
        "'A' is named 'a'",
        "'B' is named 'b'",
        "B.x -> A.neighbour is delayed: it closes a cycle of direct wires",
        "no step is told; 10 ms is the shortest of the FMUs' own",
    ]
    assert scenario["components"] == {
        "a": {"fmu": "vdp.fmu", "inputs": {"neighbour": {"from": "b.x", "delay": True, "initial": 2.0}}},
        "b": {"fmu": "vdp.fmu", "inputs": {"neighbour": "a.x"}},
    }
    assert "# - B.x -> A.neighbour is delayed" in Path("read.yaml").read_text()
    scenario, notes = read(capsys, document, "plant.ssd", "--wires", "delayed", "--step", "5 ms", "--duration", "0.1")
    assert (scenario["duration"], scenario["step"]) == ("100 ms", "5 ms")
    assert [entry["inputs"]["neighbour"]["delay"] for entry in scenario["components"].values()] == [True, True]
    assert len(notes) == 2


def test_step_of_the_master_and_interface(place, capsys):
    about = '<ssd:Annotations><ssc:Annotation type="org.openmodelica"><oms:SimulationInformation xmlns:oms="oms">'
    about += '<oms:FixedStepMaster stepSize="1e-3"/></oms:SimulationInformation></ssc:Annotation></ssd:Annotations>'
    document = ssd(component("a", "vdp.fmu"), more='<ssd:DefaultExperiment startTime="1" stopTime="1.0105"/>')
    document = document.replace("</ssd:System>", f"{about}</ssd:System>")
    document = document.replace('source="vdp.fmu"', 'source="vdp.fmu" implementation="ModelExchange"')
    scenario, notes = read(capsys, document)
    assert (scenario["start"], scenario["duration"], scenario["step"]) == ("1 s", "11 ms", "1 ms")
    assert scenario["components"]["a"]["interface"] == "model-exchange"
    assert notes == ["the stop time is no multiple of the step; 11 ms are run"]


def test_sub_systems_units_and_transformations(place, capsys):
    """numbers: c.real_out [kN] -> sub.f [N] -> sub.k.real_in [kN], doubled and raised by 5 N on the way in."""
    port = '<ssd:Connector name="{}" kind="{}">{}</ssd:Connector>'
    newton, kilo = '<ssc:Real unit="N"/>', '<ssc:Real unit="kN"/>'
    inner = (
        f'<ssd:System name="sub"><ssd:Connectors>{port.format("f", "input", newton)}'
        + port.format("back", "output", kilo)
        + f"</ssd:Connectors><ssd:Elements>{component('k', 'kinds.fmu')}</ssd:Elements><ssd:Connections>"
        + wire(".f", "k.real_in", linear(1.0, 0.5))
        + wire("k.real_out", ".back")
        + "</ssd:Connections></ssd:System>"
    )
    units = "<ssd:Units>" + "".join(
        f'<ssc:Unit name="{name}"><ssc:BaseUnit kg="1" m="1" s="-2" factor="{factor}"/></ssc:Unit>'
        for name, factor in (("N", 1), ("kN", 1000))
    )
    document = ssd(
        component("c", "kinds.fmu") + inner + component("d", "kinds.fmu"),
        wire("c.real_out", "sub.f", linear(2.0, 5.0)) + wire("sub.back", "d.real_in"),
        units=units + "</ssd:Units>",
        more=STOP,
    )
    scenario, _ = read(capsys, document)
    # (2 * F + 5 N) in kN, raised by 0.5 kN
    fed = {"from": "c.real_out", "gain": 2.0, "offset": "505.0 N"}
    assert scenario["components"]["sub_k"]["inputs"] == {"real_in": fed}
    assert scenario["components"]["d"]["inputs"] == {"real_in": "sub_k.real_out"}


def test_suppressed_conversion_and_units_that_do_not_convert(place, capsys):
    document = ssd(
        component("a", "vdp.fmu") + component("c", "kinds.fmu") + component("d", "kinds.fmu"),
        wire("a.x", "c.real_in") + wire("a.x", "d.real_in", linear(2.0), 'suppressUnitConversion="true"'),
        more=STOP,
    )
    scenario, notes = read(capsys, document)
    assert scenario["components"]["c"]["inputs"] == {"real_in": {"from": "a.x", "gain": "1000.0 N/m"}}
    assert scenario["components"]["d"]["inputs"] == {"real_in": {"from": "a.x", "gain": "2000.0 N/m"}}
    assert (
        notes[0] == "connection a.x -> c.real_in: from m to N, which do not convert; the numbers are taken as they are"
    )


def test_maps_of_values(place, capsys):
    """Boolean and integer maps are linear functions where a line goes through their entries; else they are listed."""

    def map_of(kind: str, *pairs: tuple) -> str:
        entries = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in pairs)
        return f"<ssc:{kind}MappingTransformation>{entries}</ssc:{kind}MappingTransformation>"

    document = ssd(
        component("c", "kinds.fmu") + component("d", "kinds.fmu"),
        wire("c.on_out", "d.on_in", map_of("Boolean", ("true", "false"), ("false", "true")))
        + wire("c.int_out", "d.int_in", map_of("Integer", (1, 10), (2, 20), (3, 35)))
        + wire("c.choice_out", "d.choice_in", map_of("Enumeration", ("low", "high"), ("high", "low"))),
        more=STOP,
    )
    scenario, notes = read(capsys, document)
    assert scenario["components"]["d"]["inputs"] == {"on_in": {"from": "c.on_out", "gain": -1.0, "offset": 1.0}}
    assert notes[:2] == [
        "connection c.int_out -> d.int_in: it maps values by no linear function; it is left out",
        "connection c.choice_out -> d.choice_in: it maps values by no linear function; it is left out",
    ]


def test_parameters(place, capsys):
    """Outer levels count more than inner ones, later ones more than earlier; files, mappings and units."""
    (place / "set.ssv").write_text(
        f'<ssv:ParameterSet {SPACES} version="1.0" name="s"><ssv:Parameters>{value("strength", "Real", "0.25")}'
        f"{value('unused', 'Real', '1')}</ssv:Parameters></ssv:ParameterSet>"
    )
    (place / "map.ssm").write_text(
        f'<ssm:ParameterMapping {SPACES} version="1.0"><ssm:MappingEntry source="strength" target="coupling">'
        f"{linear(2.0, 0.5)}</ssm:MappingEntry></ssm:ParameterMapping>"
    )
    from_file = (
        '<ssd:ParameterBindings><ssd:ParameterBinding source="set.ssv"><ssd:ParameterMapping source="map.ssm"/>'
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )
    ton = '<ssv:Units><ssc:Unit name="MN"><ssc:BaseUnit kg="1" m="1" s="-2" factor="1e6"/></ssc:Unit></ssv:Units>'
    inside = values(
        value("gain", "Real", "1.0"),
        value("offset", "Real", "0.002", "MN"),
        value("name", "String", "a &lt; b"),
        value("on", "Boolean", "true"),
        value("count", "Integer", "-4"),
        value("choice", "Enumeration", "middle"),
        value("nothing", "Real", "1"),
        value("real_out", "Real", "1"),
        units=ton,
    )
    outer = (
        '<ssd:Connectors><ssd:Connector name="mu" kind="parameter"><ssc:Real/></ssd:Connector></ssd:Connectors>'
        + values(value("gain", "Real", "3.5"), prefix="c.").removesuffix("</ssd:ParameterBindings>")
        + values(value("d.A[1,2]", "Real", "7"), value("mu", "Real", "0.5")).removeprefix("<ssd:ParameterBindings>")
    )
    document = ssd(
        component("a", "vdp.fmu", from_file) + component("c", "kinds.fmu", inside) + component("d", "arrays.fmu"),
        wire(".mu", "a.mu", linear(4.0)),
        outer=outer,
        more=STOP,
    )
    scenario, notes = read(capsys, document)
    parameters = {name: entry["parameters"] for name, entry in scenario["components"].items()}
    assert parameters["a"] == {"coupling": 1.0, "mu": 2.0}
    assert parameters["c"] == {
        "gain": 3.5,
        "offset": "2000.0 N",
        "name": "a < b",
        "on": True,
        "count": -4,
        "choice": "middle",
    }
    assert parameters["d"] == {"A": [[1.0, 7.0], [0.0, 1.0]]}
    assert "c has no variable 'nothing', whose value is not set" in notes


def test_what_is_not_kept_is_listed(place, capsys):
    box = '<ssd:ElementGeometry x1="0" y1="0" x2="1" y2="1"/>'
    reference = (
        '<ssd:SignalDictionaryReference name="bus" dictionary="d"><ssd:Connectors>'
        '<ssd:Connector name="s" kind="inout"/></ssd:Connectors></ssd:SignalDictionaryReference>'
    )
    outer = '<ssd:Connectors><ssd:Connector name="wind" kind="input"/></ssd:Connectors>'
    document = ssd(
        component("a", "vdp.fmu", box) + component("c", "kinds.fmu") + reference,
        wire(".wind", "c.real_in") + wire("a.x", "ghost.u") + wire("a.y", "c.int_in") + wire("bus.s", "a.neighbour"),
        outer=outer,
        more=STOP,
    )
    scenario, notes = read(capsys, document)
    assert not any("inputs" in entry for entry in scenario["components"].values())
    assert notes[-1] == "a.y is none of its numbers; what it is wired to is left out"
    assert notes[:-1] == [
        "bus: a signal dictionary's; what is wired by it is not kept",
        "connection a.x -> ghost.u: there is no ghost.u; it is left out",
        "connection bus.s -> a.neighbour: there is no bus.s; it is left out",
        "wind: an input of the whole system; c.real_in is not wired",
        "drawings (ElementGeometry) are not kept",
        "no step is told; 10 ms is the shortest of the FMUs' own",
    ]


OSP = """<?xml version="1.0" encoding="utf-8"?>
<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">
  <StartTime>0.0</StartTime>
  <EndTime>0.5</EndTime>
  <BaseStepSize>0.01</BaseStepSize>
  <Algorithm>fixedStep</Algorithm>
  <Simulators>
    <Simulator name="a" source="vdp.fmu"><InitialValues>
      <InitialValue variable="coupling"><Real value="0.5"/></InitialValue>
    </InitialValues></Simulator>
    <Simulator name="b" source="vdp.fmu" stepSize="0.0101"><InitialValues>
      <InitialValue variable="coupling"><Real value="0.25"/></InitialValue>
      <InitialValue variable="mu"><Real value="1.5"/></InitialValue>
    </InitialValues></Simulator>
    <Simulator name="c" source="vdp.fmu"><InitialValues>
      <InitialValue variable="coupling"><Real value="0.75"/></InitialValue>
    </InitialValues></Simulator>
    <Simulator name="p" source="arrays.fmu"/>
    <Simulator name="q" source="arrays.fmu"/>
    <Simulator name="k" source="kinds.fmu"><InitialValues>
      <InitialValue variable="count"><Integer value="2"/></InitialValue>
      <InitialValue variable="on"><Boolean value="true"/></InitialValue>
      <InitialValue variable="name"><String value="crane"/></InitialValue>
    </InitialValues></Simulator>
  </Simulators>
  <Functions>
    <LinearTransformation name="scaling" factor="0.5" offset="0.125"/>
    <Sum name="both" inputCount="2"/>
    <VectorSum name="vectors" inputCount="2" dimension="2"/>
  </Functions>
  <Connections>
    <SignalConnection><Variable simulator="a" name="x"/><Signal function="scaling" name="in"/></SignalConnection>
    <SignalConnection>
      <Signal function="scaling" name="out"/><Variable simulator="b" name="neighbour"/>
    </SignalConnection>
    <SignalConnection><Variable simulator="a" name="v"/><Signal function="both" name="in[0]"/></SignalConnection>
    <SignalConnection><Variable simulator="b" name="x"/><Signal function="both" name="in[1]"/></SignalConnection>
    <SignalConnection><Signal function="both" name="out"/><Variable simulator="c" name="neighbour"/></SignalConnection>
    <VariableConnection>
      <Variable simulator="c" name="x"/><Variable simulator="a" name="neighbour"/>
    </VariableConnection>
    <VariableConnection><Variable simulator="p" name="u[1]"/><Variable simulator="a" name="x"/></VariableConnection>
    <VariableConnection><Variable simulator="b" name="v"/><Variable simulator="p" name="u[2]"/></VariableConnection>
    <SignalGroupConnection>
      <VariableGroup simulator="p" name="given"/><SignalGroup function="vectors" name="in[0]"/>
    </SignalGroupConnection>
    <SignalGroupConnection>
      <VariableGroup simulator="p" name="given"/><SignalGroup function="vectors" name="in[1]"/>
    </SignalGroupConnection>
    <SignalGroupConnection>
      <SignalGroup function="vectors" name="out"/><VariableGroup simulator="q" name="taken"/>
    </SignalGroupConnection>
    <VariableConnection>
      <Variable simulator="p" name="y[1]"/><Variable simulator="k" name="real_in"/>
    </VariableConnection>
  </Connections>
</OspSystemStructure>
"""
GROUPS = """<?xml version="1.0" encoding="utf-8"?>
<OspModelDescription xmlns="https://open-simulation-platform.com/OspModelDescription/1.0.0" version="1.0">
  <VariableGroups>
    <Generic name="given"><Variable ref="y[1]"/><Variable ref="y[2]"/></Generic>
    <Generic name="taken"><Variable ref="u[1]"/><Variable ref="u[2]"/></Generic>
  </VariableGroups>
</OspModelDescription>
"""


def test_osp_in_libcosim(place, capsys):
    """libcosim runs the structure itself: sums, functions, groups, steps that are no multiple, initial values."""
    cosim = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is not installed").CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    Path("OspSystemStructure.xml").write_text(OSP)
    Path("arrays_OspModelDescription.xml").write_text(GROUPS)
    notes = convert(capsys, "OspSystemStructure.xml", "-o", "read.yaml")
    assert "b: its step of 0.0101 s is no multiple of the base step; 0.01 s is taken, as libcosim does" in notes
    found = ran(graph_of("read.yaml"))
    execution = cosim.from_osp_config_file(str(place / "OspSystemStructure.xml"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    assert execution.step(50)
    index = {name: execution.slave_index_from_instance_name(name) for name in "abcpqk"}
    for name, references in (("a", [0, 1]), ("b", [0, 1]), ("c", [0, 1]), ("p", [16, 17]), ("q", [16, 17])):
        expected = observer.last_real_values(index[name], references)
        assert np.abs(found[name][:2] - expected).max() <= 1e-12, name
        assert any(expected), name
    assert found["k"][0] == observer.last_real_values(index["k"], [1])[0] * 1e3  # kN
    assert found["k"][1:4].tolist() == [2, 1, 5]


PORTS = """<OspModelDescription xmlns="https://open-simulation-platform.com/OspModelDescription/1.0.0" version="1.0">
  <VariableGroups><LinearMechanicalPort name="port">{}</LinearMechanicalPort></VariableGroups>
</OspModelDescription>"""
FORCE = '<Force name="force"><Variable ref="{}"/></Force>'
VELOCITY = '<LinearVelocity name="velocity"><Variable ref="{}"/></LinearVelocity>'
JOINED = """<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">
  <StartTime>0.0</StartTime><BaseStepSize>0.01</BaseStepSize><Algorithm>fixedStep</Algorithm>
  <Simulators><Simulator name="a" source="vdp.fmu"/><Simulator name="p" source="arrays.fmu"/></Simulators>
  <Connections><VariableGroupConnection>
    <VariableGroup simulator="{}" name="port"/><VariableGroup simulator="{}" name="port"/>
  </VariableGroupConnection></Connections>
</OspSystemStructure>"""


def test_groups_of_variables_in_libcosim(place, capsys):
    """Whichever end is named first; where the parts' orders differ, libcosim would join a force to a velocity."""
    cosim = pytest.importorskip("libcosimpy.CosimExecution", reason="libcosimpy is not installed").CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    Path("van_der_pol_OspModelDescription.xml").write_text(PORTS.format(FORCE.format("x") + VELOCITY.format("v")))
    for ends in ("ap", "pa"):
        Path("OspSystemStructure.xml").write_text(JOINED.format(*ends))
        Path("arrays_OspModelDescription.xml").write_text(PORTS.format(FORCE.format("u[1]") + VELOCITY.format("u[2]")))
        notes = convert(capsys, "OspSystemStructure.xml", "-o", f"{ends}.yaml", "--duration", "0.5 s")
        assert not any("order" in text for text in notes)
        execution = cosim.from_osp_config_file(str(place / "OspSystemStructure.xml"))
        observer = CosimObserver.create_last_value()
        execution.add_observer(observer)
        assert execution.step(50)
        expected = observer.last_real_values(execution.slave_index_from_instance_name("p"), [16, 17])
        assert all(expected)
        assert np.abs(ran(graph_of(f"{ends}.yaml"))["p"][:2] - expected).max() <= 1e-12
    before = yaml.safe_load(Path("ap.yaml").read_text())["components"]
    Path("arrays_OspModelDescription.xml").write_text(PORTS.format(VELOCITY.format("u[2]") + FORCE.format("u[1]")))
    Path("OspSystemStructure.xml").write_text(JOINED.format(*"ap"))
    scenario, notes = read(capsys, JOINED.format(*"ap"), "OspSystemStructure.xml")
    assert scenario["components"] == before
    text = "list their parts in different orders; they are joined by type here, and by libcosim in the order written"
    assert f"the groups a.port and p.port {text}" in notes
    Path("arrays_OspModelDescription.xml").write_text(PORTS.format(FORCE.format("u[1]")))
    refused = refusal(capsys, "OspSystemStructure.xml", "-o", "unlike.yaml")
    assert "a VariableGroupConnection joins 2 and 1 variables" in refused


def test_slower_simulators_of_osp(place, capsys):
    Path("OspSystemStructure.xml").write_text(OSP.replace("0.0101", "0.021"))
    Path("arrays_OspModelDescription.xml").write_text(GROUPS)
    scenario, notes = read(capsys, OSP.replace("0.0101", "0.021"), "OspSystemStructure.xml")
    assert scenario["components"]["b"]["period"] == "20 ms"
    assert (
        "b: steps by 0.02 s; it reads its inputs as its last base step begins, and libcosim as its own step does"
        in notes
    )
    both = {
        "sum": [{"from": "a.v", "gain": "1.0 m/(m/s)", "delay": True}, {"from": "b.x", "delay": True, "initial": 2.0}]
    }
    assert scenario["components"]["c"]["inputs"]["neighbour"] == both


HOSTILE = [
    (ssd(component("a", "../../etc/passwd")), "there is no file '../../etc/passwd'"),
    (ssd(component("a", "http://127.0.0.1:9/a.fmu")), "is not a file of the package"),
    (ssd(component("a", "nothing.fmu")), "there is no file 'nothing.fmu'"),
    (ssd(component("a", "vdp.fmu").replace("x-fmu-sharedlibrary", "x-ssp-package")), "only FMUs are read"),
    (
        ssd(component("a", "vdp.fmu")).replace("<ssd:System ", "<ssd:Other ").replace("</ssd:System>", "</ssd:Other>"),
        "no System",
    ),
    ("<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "document type"),
    ("<other/>", "its root is other"),
    ("<ssd", "cannot be read"),
    (ssd(component("a", "vdp.fmu"), wire("a.x", "a.neighbour", linear(1e400))), "is no finite number"),
    (ssd(component("a", "vdp.fmu"), wire("a.x", "a.neighbour") * 2), "is fed by 2 connections"),
    (ssd(component("a", "vdp.fmu"), more='<ssd:DefaultExperiment stopTime="soon"/>'), "'soon' is no number of seconds"),
    (ssd(component("a", "vdp.fmu"), more='<ssd:DefaultExperiment startTime="2" stopTime="1"/>'), "give --duration"),
    (
        ssd(component("a", "vdp.fmu", values(value("mu", "Real", "fast")))),
        "the parameter mu 'fast' is no finite number",
    ),
    (ssd(component("a", "vdp.fmu", values(value("mu", "Boolean", "perhaps")))), "is neither true nor false"),
    (ssd(component("a", "vdp.fmu"), wire("a.x", "a.neighbour", linear("1e99999999"))), "is no finite number"),
    (ssd(component("a", "vdp.fmu"), more='<ssd:DefaultExperiment stopTime="1e-99999999"/>'), "is no number of seconds"),
    (ssd(component("a", "a" * 300)), "cannot be read: File name too long"),
    (
        ssd(component("a", "vdp.fmu", values(value("mu", "Real", "1")).replace("value=", "worth="))),
        "is no finite number",
    ),
    (ssd(component("a", "set.ssv")), "set.ssv"),
    (ssd("").replace("<ssd:Elements></ssd:Elements>", ""), "there is no FMU in it"),
    (OSP.replace('function="scaling" name="in"', 'function="ghost" name="in"'), "names the function 'ghost'"),
    (OSP.replace('<Simulator name="b"', '<Simulator name="a"'), "two simulators are named 'a'"),
    (OSP.replace('<Variable simulator="c" name="x"/>', '<Variable simulator="z" name="x"/>'), "the simulator 'z'"),
    (OSP.replace('<Sum name="both"', '<Product name="both"'), "is a Product"),
    (OSP.replace("0.01</Base", "often</Base"), "BaseStepSize 'often' is no number"),
]


@pytest.mark.parametrize(("document", "why"), HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_documents(document, why, place, capsys):
    (place / "set.ssv").write_text("no FMU")
    Path("bad.ssd").write_text(document)
    text = refusal(capsys, "bad.ssd", "-o", "bad.yaml")
    assert why in text
    assert len(text.splitlines()) == 1
    assert not Path("bad.yaml").exists()


def test_hostile_archives(place, capsys):
    for name, content in (("../evil", b"x"), ("SystemStructure.ssd", b"<a/>")):
        with zipfile.ZipFile("bad.ssp", "w") as archive:
            archive.writestr(name, content)
        text = refusal(capsys, "bad.ssp")
        assert len(text.splitlines()) == 1
        assert "leads out" in text or "its root is a" in text
    with zipfile.ZipFile("bad.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", ssd(component("a", "../vdp.fmu")))
    assert "leads out of the package" in refusal(capsys, "bad.ssp")
    with zipfile.ZipFile("bad.ssp", "w") as archive:
        archive.writestr("other.ssd", "<a/>")
    assert "there is no file 'SystemStructure.ssd'" in refusal(capsys, "bad.ssp")


def test_what_an_ssp_cannot_say_is_listed(place, capsys):
    (place / "no.yaml").write_text(
        "duration: 1 s\nstep: 10 ms\ncomponents:\n"
        "  wall: {model: motion.fixed, parameters: {position: [0 m, 0 m, 0 m]}}\n"
        "  a: {fmu: vdp.fmu, inputs: {neighbour: {sum: [b.x, {from: b.x, gain: -1}]}}}\n"
        "  b: {fmu: vdp.fmu, inputs: {neighbour: 'wall.motion.position[0]'}}\n"
        "  c: {fmu: arrays3.fmu, parameters: {A: [[1, 2], [3, 4]]}}\n"
        "  d: {fmu: arrays3.fmu, inputs: {u: c.y}}\n"
        "  e: {fmu: vdp.fmu, inputs: {neighbour: {sum: [a.x, 0 m]}}}\n"
    )
    lines = refusal(capsys, "no.yaml").splitlines()
    assert lines == [
        "towline: no.yaml: 'wall' is the model motion.fixed and no FMU (build one by towline fmu build no.yaml#wall); "
        "an SSP cannot say so",
        "towline: no.yaml: 'a.neighbour' is fed by a sum; an SSP cannot say so",
        "towline: no.yaml: 'd.u' is an array of FMI 3, which is wired; an SSP cannot say so",
        "towline: no.yaml: 'e.neighbour' is fed by a sum; an SSP cannot say so",
        "towline: no.yaml: 'c.A' is an array of FMI 3; an SSP cannot say so",
    ]
    assert not Path("no.ssp").exists()


def test_files_are_not_replaced_unasked(place, capsys):
    (place / "pair.yaml").write_text(PAIR)
    convert(capsys, "pair.yaml")
    assert "pair.ssp exists; give another --out, or --overwrite" in refusal(capsys, "pair.yaml")
    assert "pair.yaml exists" in refusal(capsys, "pair.ssp")
    assert "is converted to" in refusal(capsys, "pair.yaml", "-o", "x.yaml")
    assert "no such file" in refusal(capsys, "none.ssd")
    convert(capsys, "pair.yaml", "--overwrite")


def test_a_structure_is_no_scenario(capsys):
    assert main(["run", "plant.ssp"]) == 1
    assert "towline convert plant.ssp -o plant.yaml" in capsys.readouterr().err


def test_values_of_fmi_3(place, capsys):
    """Every type there and back: whole numbers beyond 2^31 are no Integer of SSP 1.0's, and are listed."""
    (place / "kinds.yaml").write_text(
        "duration: 1 s\nstep: 10 ms\ncomponents:\n"
        "  c: {fmu: kinds3.fmu, parameters: {blob: 0a0b, short_in: 0.5, int8_in: -3, uint64_in: 7, choice: middle}}\n"
    )
    convert(capsys, "kinds.yaml")
    convert(capsys, "kinds.ssp", "-o", "back.yaml")
    assert compared(graph_of("back.yaml")) == compared(graph_of("kinds.yaml"))
    Path("kinds.yaml").write_text(Path("kinds.yaml").read_text().replace("uint64_in: 7", f"large: {2**40}"))
    assert f"'c.large' is {2**40}, beyond the Integer of SSP 1.0" in refusal(capsys, "kinds.yaml", "--overwrite")
