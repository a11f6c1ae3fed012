"""OSP system structures made scenarios, against libcosim."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from structures import convert, graph_of, ran, read, refusal

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
    (OSP.replace('function="scaling" name="in"', 'function="ghost" name="in"'), "names the function 'ghost'"),
    (OSP.replace('<Simulator name="b"', '<Simulator name="a"'), "two simulators are named 'a'"),
    (OSP.replace('<Variable simulator="c" name="x"/>', '<Variable simulator="z" name="x"/>'), "the simulator 'z'"),
    (OSP.replace('<Sum name="both"', '<Product name="both"'), "is a Product"),
    (OSP.replace("0.01</Base", "often</Base"), "BaseStepSize 'often' is no number"),
]


@pytest.mark.parametrize(("document", "why"), HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_documents(document, why, place, capsys):
    Path("bad.ssd").write_text(document)
    text = refusal(capsys, "bad.ssd", "-o", "bad.yaml")
    assert why in text
    assert len(text.splitlines()) == 1
    assert not Path("bad.yaml").exists()
