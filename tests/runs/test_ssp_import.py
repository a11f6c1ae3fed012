"""SSPs made scenarios, in documents that are valid by the schemas, and in hostile ones."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from structures import SPACES, STOP, component, linear, read, refusal, ssd, value, values, wire

from pipeline.cli import main


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


def test_a_structure_is_no_scenario(capsys):
    assert main(["run", "plant.ssp"]) == 1
    assert "towline convert plant.ssp -o plant.yaml" in capsys.readouterr().err
