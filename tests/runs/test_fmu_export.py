"""Exported FMUs against the native run, equal in every bit, driven by fmpy; and against fmpy's validation."""

from __future__ import annotations

import ctypes
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from math import prod
from pathlib import Path

import fmpy
import numpy as np
import pytest
from elftools.elf.elffile import ELFFile
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from components.compiled import bind
from components.contract import N_U, N_Y, SEED_HIGH
from pipeline import catalogue
from pipeline.cli import main
from pipeline.conductor import Conductor
from pipeline.fmu import build as building
from pipeline.fmu.instance import instance
from pipeline.graph import Graph
from pipeline.quantities import si_value
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
C_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
SCENARIOS = sorted((ROOT / "scenarios").glob("*.yaml"))


# What a model that no scenario has asks for beside its parameters without a default.
ALSO = {"tether.catenary": ["weight=0.9 N/m"]}


def distinct() -> list[str]:
    """The components of all scenarios, those of equal model and sizes once: `scenario.yaml#component`."""
    found: dict[tuple, str] = {}
    for path in SCENARIOS:
        for node in build_graph(load_scenario(path)).nodes:
            header = node.component.pack(node.parameters)[:SEED_HIGH]
            found.setdefault((node.model, *header), f"{path.name}#{node.name}")
    return list(found.values())


def specimen(model: str) -> tuple[str, list[str]]:
    """How a model is exported: a component of a scenario, or the model with parameters."""
    for path in SCENARIOS:
        for node in build_graph(load_scenario(path)).nodes:
            if node.model == model:
                return f"{path.name}#{node.name}", []
    schema = catalogue.find(model, ROOT)[1].parameters.model_json_schema()
    lacking = schema.get("required", [])
    kinds = schema.get("$defs", {})
    written = [f"{name}={json.dumps(any_value(schema['properties'][name], kinds))}" for name in lacking]
    return model, written + ALSO.get(model, [])


def any_value(schema: dict, kinds: dict) -> object:
    """Some value that a JSON schema allows, for a parameter without a default; kinds: of mappings of parameters."""
    if "$ref" in schema:
        kind = kinds[schema["$ref"].rpartition("/")[2]]
        return {name: any_value(kind["properties"][name], kinds) for name in kind.get("required", [])}
    match schema.get("type"):
        case "number":
            return 1.0 + schema.get("exclusiveMinimum", schema.get("minimum", 0.0))
        case "integer":
            return 3 + schema.get("minimum", 0)
        case "array":
            items = schema.get("prefixItems") or [schema["items"]] * max(2, schema.get("minItems", 0))
            return [any_value(item, kinds) for item in items]
        case "boolean":
            return False
    return schema["enum"][0]


def compiled_models() -> list[str]:
    return [model for model in catalogue.models() if catalogue.find(model, ROOT)[1].compiled]


class Slave:
    """An FMU run by fmpy, all inputs and all outputs as vectors."""

    def __init__(self, path: Path, h: float, t0: float = 0.0):
        self.folder = fmpy.extract(str(path))
        self.about = about = fmpy.read_model_description(self.folder)
        self.is_2 = about.fmiVersion == "2.0"
        self.references = {v.name: v.valueReference for v in about.modelVariables}
        self.inputs, self.outputs = (
            [v for v in about.modelVariables if v.causality == causality] for causality in ("input", "output")
        )
        kind = FMU2Slave if self.is_2 else FMU3Slave
        self.fmu = kind(
            guid=about.guid,
            unzipDirectory=self.folder,
            modelIdentifier=about.coSimulation.modelIdentifier,
            instanceName="a",
        )
        self.fmu.instantiate()
        self.h, self.t0, self.k = h, t0, 0

    def set(self, references: list[int], values) -> None:
        (self.fmu.setReal if self.is_2 else self.fmu.setFloat64)(references, list(values))

    def get(self) -> np.ndarray:
        references = [v.valueReference for v in self.outputs]
        if self.is_2:
            return np.array(self.fmu.getReal(references))
        return np.array(self.fmu.getFloat64(references, sum(prod(v.shape or ()) for v in self.outputs)))

    def give(self, u: np.ndarray) -> None:
        if self.inputs:
            self.set([v.valueReference for v in self.inputs], u)

    def start(self, u: np.ndarray) -> np.ndarray:
        if self.is_2:
            self.fmu.setupExperiment(startTime=self.t0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=self.t0)
        self.give(u)
        self.fmu.exitInitializationMode()
        return self.get()

    def step(self, u: np.ndarray) -> np.ndarray:
        self.give(u)
        self.fmu.doStep(currentCommunicationPoint=self.t0 + self.k * self.h, communicationStepSize=self.h)
        self.k += 1
        return self.get()

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)


def recorded(graph: Graph, ticks: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Inputs and outputs of each node over a short native run, its own steps only: (k, n_u) and (k, n_y)."""
    conductor = Conductor(graph)
    conductor.initialise()
    memory = conductor.memory
    vectors = [(memory.tables.inputs, memory.spans["u"]), (memory.tables.board, memory.spans["y"])]
    rows = {node.name: ([], []) for node in graph.nodes}
    for tick in range(ticks + 1):
        for i, node in enumerate(graph.nodes):
            if tick % node.period == 0:
                for found, (array, spans) in zip(rows[node.name], vectors, strict=True):
                    found.append(array[spans[i]].copy())
        if tick < ticks:
            for _ in conductor.run(tick + 1, lambda: 1):
                pass
    return {name: (np.array(u), np.array(y)) for name, (u, y) in rows.items()}


@pytest.fixture(scope="session")
def native() -> dict[str, tuple[Graph, dict]]:
    """What each scene's first ticks give natively, up to its first event."""
    graphs = {path.name: build_graph(load_scenario(path)) for path in SCENARIOS}
    ticks = {name: min(99, graph.ticks, *(event.tick for event in graph.events)) for name, graph in graphs.items()}
    return {name: (graph, recorded(graph, ticks[name])) for name, graph in graphs.items()}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("model", compiled_models())
def test_every_component_exports_and_validates(model, fmi, fmu_of):
    """fmpy's validation: schema, names, units, start values, model structure. The library asks for libc and libm."""
    text, overrides = specimen(model)
    path = fmu_of(text, fmi, *overrides)
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        (library,) = [name for name in archive.namelist() if name.endswith(".so")]
        with archive.open(library) as file:
            elf = ELFFile(file)
            needed = {tag.needed for tag in elf.get_section_by_name(".dynamic").iter_tags("DT_NEEDED")}
            symbols = [symbol.name for symbol in elf.get_section_by_name(".dynsym").iter_symbols()]
    assert needed <= {"libm.so.6", "libc.so.6"}
    assert not [name for name in symbols if re.match(r"_?Py|numba|NRT", name)]
    prefix = f"fmi{fmi}"
    assert all(name.startswith(prefix) or name == "" or name in needed_of(path, library) for name in symbols)


def needed_of(path: Path, library: str) -> set[str]:
    """The symbols that a library leaves to libc and libm."""
    with zipfile.ZipFile(path) as archive, archive.open(library) as file:
        symbols = ELFFile(file).get_section_by_name(".dynsym").iter_symbols()
        return {symbol.name for symbol in symbols if symbol["st_shndx"] == "SHN_UNDEF"}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("text", distinct())
def test_run_in_fmpy_has_the_native_bits(text, fmi, fmu_of, native):
    scene, _, name = text.partition("#")
    graph, rows = native[scene]
    node = next(node for node in graph.nodes if node.name == name)
    u, y = rows[name]
    slave = Slave(fmu_of(text, fmi), node.period * graph.base_ns / 1e9, graph.start_ns / 1e9)
    found = np.array([slave.start(u[0]), *(slave.step(row) for row in u[1:])])
    slave.close()
    assert found.tobytes() == y.tobytes()


def alone() -> list[str]:
    return [model for model in compiled_models() if "#" not in specimen(model)[0]]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("model", alone())
def test_model_of_no_scenario_has_the_native_bits(model, fmi, fmu_of):
    """Against the C entry points that the native loop calls, over inputs that vary; a status there is an error here."""
    text, overrides = specimen(model)
    of = instance(text, overrides)
    entry, sizes = bind(of.component), of.component.sizes(of.parameters)
    p = of.component.pack(of.parameters, of.seed)
    u, x, y, w = (np.zeros(int(n)) for n in (p[N_U], sizes.state, p[N_Y], sizes.workspace))
    slave = Slave(fmu_of(text, fmi, *overrides), of.step_ns / 1e9)
    for k in range(50):
        u[:] = 0.3 * np.sin(np.arange(len(u)) + 0.1 * k)
        address = entry.step if k else entry.init
        status = C_FUNCTION(address)(k * of.step_ns, of.step_ns, *(v.ctypes.data for v in (p, u, x, y, w)))
        if status != 0:
            with pytest.raises(FMICallException):
                (slave.step if k else slave.start)(u)
            break
        assert (slave.step if k else slave.start)(u).tobytes() == y.tobytes()


@pytest.mark.parametrize("fmi", [2, 3])
def test_parameter_changed_between_steps_has_the_bits_of_the_event(fmi, fmu_of):
    """bond_mass lightens the ball at 1 s by an event; the FMU's tunable parameter is set in the same tick."""
    graph = build_graph(load_scenario(ROOT / "scenarios" / "bond_mass.yaml"))
    u, y = recorded(graph, 150)["ball"]
    slave = Slave(fmu_of("bond_mass.yaml#ball", fmi), graph.base_ns / 1e9)
    names = ["parameters.weight"] if fmi == 3 else [f"parameters.weight[{i}]" for i in (1, 2, 3)]
    found = [slave.start(u[0])]
    for k, row in enumerate(u[1:]):
        if k == 100:
            slave.set([slave.references[name] for name in names], [8.0, 0.0, 15.0])
        found.append(slave.step(row))
    slave.close()
    assert np.array(found).tobytes() == y.tobytes()


@pytest.mark.parametrize("fmi", [2, 3])
def test_ports_are_named_with_units_and_shapes(fmi, fmu_of):
    """The model description gives back the component's ports: name, order, shape, unit, frame."""
    graph = build_graph(load_scenario(ROOT / "scenarios" / "pool_chain.yaml"))
    node = next(node for node in graph.nodes if node.name == "tether")
    with zipfile.ZipFile(fmu_of("pool_chain.yaml#tether", fmi)) as archive:
        text = archive.read("modelDescription.xml").decode()
    ports = re.findall(r'<Port direction="(.*?)" name="(.*?)" unit="(.*?)" shape="(.*?)" frame="(.*?)" />', text)
    expected = [
        (direction, port.name, port.unit, " ".join(map(str, port.shape)), port.frame)
        for direction, found in (("input", node.inputs), ("output", node.outputs))
        for port in found
    ]
    assert ports == expected
    about = fmpy.read_model_description(str(fmu_of("pool_chain.yaml#tether", fmi)))
    outputs = [(v.name, v.unit or "1") for v in about.modelVariables if v.causality == "output"]
    if fmi == 3:
        assert outputs == [(port.name, port.unit) for port in node.outputs]
    else:
        assert len(outputs) == node.width
        assert outputs[:4] == [("nodes[1,1]", "m"), ("nodes[1,2]", "m"), ("nodes[1,3]", "m"), ("nodes[2,1]", "m")]
    for unit in about.unitDefinitions:
        assert unit.baseUnit.factor == si_value(f"1 {unit.name}", unit.name)  # the project's ports are in SI
    newton = next(unit.baseUnit for unit in about.unitDefinitions if unit.name == "N")
    assert (newton.kg, newton.m, newton.s) == (1, 1, -2)


def test_same_component_gives_the_same_file(fmu_of, tmp_path):
    """From a process of its own, which may compile in another order."""
    out = tmp_path / "again.fmu"
    scene = str(ROOT / "scenarios" / "van_der_pol.yaml")
    words = [sys.executable, "-m", "pipeline.cli", "fmu", "build", f"{scene}#b", "-o", str(out), "--json"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["model"] == "motion.van_der_pol"
    assert out.read_bytes() == fmu_of("van_der_pol.yaml#b", 2).read_bytes()


@pytest.mark.parametrize("fmi", [2, 3])
def test_sources_compile_without_a_warning(fmi, fmu_of, monkeypatch):
    kept = [flag for flag in building.FLAGS if flag != "-w"]
    strict = (*kept, "-Wall", "-Wextra", "-Wpedantic", "-Wno-unused-parameter", "-Werror")
    monkeypatch.setattr(building, "FLAGS", strict)
    assert fmu_of("components.motion.fixed", fmi, "position=[1 m, 2 m, 3 m]").exists()


def test_info_tells_ports_units_and_capabilities(fmu_of, capsys):
    assert main(["fmu", "info", str(fmu_of("pool_chain.yaml#tether", 2)), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["model"], told["fmi"], told["step_s"]) == ("tether.cable", "2.0", 0.02)
    variables = {one["name"]: one for one in told["variables"]}
    assert (variables["nodes"]["shape"], variables["nodes"]["unit"]) == ([51, 3], "m")
    assert variables["parameters.axial_stiffness"]["role"] == "tunable parameter"
    assert variables["parameters.segments"]["role"] == "constant local"
    assert told["capabilities"]["co-simulation"]["canGetAndSetFMUstate"] == "true"
    assert main(["fmu", "info", str(fmu_of("pool_chain.yaml#hand", 3))]) == 0
    assert "motion.acceleration" in capsys.readouterr().err


def told_error(capsys, *words: str) -> str:
    """The one line that a command which fails leaves."""
    assert main(["fmu", *words]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    return lines[0]


def test_errors_are_one_line(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fixed = ["build", "motion.fixed", "--param", "position=[1 m, 2 m, 3 m]"]
    assert "did you mean 'tether.cable'?" in told_error(capsys, "build", "tether.cabel")
    assert "did you mean 'position'?" in told_error(capsys, *fixed, "--param", "positon=[1 m, 2 m, 3 m]")
    assert "has no component 'x'" in told_error(capsys, "build", f"{ROOT}/scenarios/bond_mass.yaml#x")
    assert "--step" in told_error(capsys, *fixed, "--step", "0 s")
    assert "cannot be written" in told_error(capsys, *fixed, "-o", "no/such/folder.fmu")
    (tmp_path / "bad.fmu").write_bytes(b"PK\x05\x06" + bytes(18))
    assert "it has no modelDescription.xml" in told_error(capsys, "info", "bad.fmu")
    with zipfile.ZipFile("broken.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription fmiVersion='2.0'")
    assert "its modelDescription.xml cannot be read" in told_error(capsys, "info", "broken.fmu")
    with zipfile.ZipFile("bomb.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", bytes(300_000_000))
    assert "claims 300 MB" in told_error(capsys, "info", "bomb.fmu")
    monkeypatch.setenv("PATH", os.fspath(tmp_path))
    assert "no C compiler found (cc, gcc, clang)" in told_error(capsys, *fixed)


def test_python_component_is_refused(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(
        "from components.contract import Component, Parameters, Port\n"
        "def step(t_ns, dt_ns, p, u, x, y, w):\n    y[0] = 1.0\n    return 0\n"
        "COMPONENT = Component('own', Parameters, step, step, lambda _: (Port('v', '1'),), compiled=False)\n"
    )
    assert "own is a Python callable" in told_error(capsys, "build", "./own.py")


@pytest.mark.parametrize("fmi", [2, 3])
def test_state_is_taken_on_by_fmpy(fmi, fmu_of, native):
    """Serialized, and given to another instance: the bits of the run it was taken from."""
    u, y = native["pool_chain.yaml"][1]["tether"]
    one, other = (Slave(fmu_of("pool_chain.yaml#tether", fmi), 0.02) for _ in range(2))
    one.start(u[0])
    for row in u[1:40]:
        one.step(row)
    if fmi == 2:
        data = one.fmu.serializeFMUstate(one.fmu.getFMUstate())
        other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(data))
    else:
        data = one.fmu.serializeFMUState(one.fmu.getFMUState())
        other.fmu.setFMUState(other.fmu.deserializeFMUState(data))
    other.k = one.k
    assert np.array([other.step(row) for row in u[40:]]).tobytes() == y[40:].tobytes()


def test_constants_and_wrong_calls_of_fmi_3(fmu_of):
    slave = Slave(fmu_of("pool_chain.yaml#tether", 3), 0.02)
    fmu, at = slave.fmu, slave.references
    assert list(fmu.getInt64([at["parameters.segments"]])) == [50]
    assert list(fmu.getBoolean([at["parameters.bond_a"]])) == [False]
    assert list(fmu.getString([at["parameters.end_a"]])) == ["driven"]
    assert fmu.getFloat64([at["time"]]) == [0.0]
    for wrong in (
        lambda: fmu.getFloat64([at["nodes"]], 3),
        lambda: fmu.setFloat64([at["parameters.length"]], [0.0]),
        lambda: fmu.setInt64([at["parameters.segments"]], [10]),
        lambda: fmu.getInt32([at["parameters.segments"]]),
        lambda: fmu.doStep(0.0, 0.02),
        fmu.enterEventMode,
    ):
        with pytest.raises(FMICallException, match="status 3"):
            wrong()
    slave.fmu.freeInstance()
