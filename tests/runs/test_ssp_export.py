"""Scenarios of FMUs made SSPs, and back, against fmpy and the schemas."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet
from lxml import etree
from structures import SCHEMAS, SSP, compared, convert, graph_of, ran, refusal

from pipeline.cli import main

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
