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
from importlib.util import find_spec
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
from specimens import SCENARIOS, compiled_models, distinct, scene, specimen
from symbols import LIBC_AND_LIBM, undefined_symbols

from components.compiled import bind
from components.contract import N_U, N_Y
from pipeline import catalogue
from pipeline.cli import main
from pipeline.conductor import Conductor
from pipeline.fmu import build as building
from pipeline.fmu.instance import Instance, instance
from pipeline.graph import Graph
from pipeline.quantities import si_value

ROOT = Path(__file__).parents[2]
C_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


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
    graphs = {name: scene(name) for name in SCENARIOS}
    ticks = {name: min(99, graph.ticks, *(event.tick for event in graph.events)) for name, graph in graphs.items()}
    return {name: (graph, recorded(graph, ticks[name])) for name, graph in graphs.items()}


@pytest.mark.parametrize("model", compiled_models())
def test_object_code_needs_libc_and_libm_only(model):
    """The ground for FMUs without Python: no symbol of the interpreter or of numba's runtime is left undefined.

    Here, where the same code goes into FMUs: its compiling takes most of the time.
    """
    assert undefined_symbols(catalogue.find(model, ROOT)[1]) <= LIBC_AND_LIBM


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


@pytest.mark.parametrize(("text", "fmi"), distinct())
def test_run_in_fmpy_has_the_native_bits(text, fmi, fmu_of, native):
    file, _, name = text.partition("#")
    graph, rows = native[file]
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


COSIM_STEPS = 20
COSIM_LIMIT_S = 60.0  # of a process that takes a second or two
IN_COSIM = [*compiled_models(), "catenary_riser.yaml#riser"]


@pytest.mark.skipif(not find_spec("libcosimpy"), reason="libcosimpy is not installed: pip install 'towline[dev]'")
@pytest.mark.parametrize("which", IN_COSIM)
def test_component_alone_in_libcosim_has_the_native_bits(which, fmu_of, native, tmp_path):
    """libcosim reads outputs before it sets the initial inputs, from which on they are held; doubles pass unchanged.

    The riser beside: between ends that both are at the origin it has no static equilibrium.
    """
    text, overrides = (which, []) if "#" in which else specimen(which)
    file, _, name = text.partition("#")
    if name:
        graph, rows = native[file]
        node = next(node for node in graph.nodes if node.name == name)
        of = Instance(node.component, node.parameters, node.seed, node.period * graph.base_ns)
        u = rows[name][0][0].copy()
    else:
        of = instance(text, overrides)
        u = 0.3 * np.sin(np.arange(of.component.pack(of.parameters)[N_U]))  # some numbers
    expected = held(of, u)
    path, out = fmu_of(text, 2, *overrides), tmp_path / "rows.json"
    inputs, outputs = (
        [
            v.valueReference
            for v in fmpy.read_model_description(str(path), validate=False).modelVariables
            if v.causality == causality
        ]
        for causality in ("input", "output")
    )
    asked = {"path": str(path), "step_ns": of.step_ns, "steps": COSIM_STEPS, "out": str(out), "outputs": outputs}
    asked["inputs"] = list(zip(inputs, u, strict=True))
    words = [sys.executable, str(ROOT / "tests" / "fmus" / "cosim_alone.py"), json.dumps(asked)]
    environment = os.environ | {"TMPDIR": str(tmp_path)}  # libcosim leaves what it extracts where it is ended
    done = subprocess.run(words, capture_output=True, text=True, timeout=COSIM_LIMIT_S, env=environment)
    assert done.returncode == 0, f"{text}: {done.stderr[-1000:]}"
    assert np.array(json.loads(out.read_text())).tobytes() == expected.tobytes(), text


def held(of: Instance, u: np.ndarray) -> np.ndarray:
    """Outputs of COSIM_STEPS native steps after init, all with the same inputs: (k, n_y)."""
    entry, sizes = bind(of.component), of.component.sizes(of.parameters)
    p = of.component.pack(of.parameters, of.seed)
    x, y, w = (np.zeros(int(n)) for n in (sizes.state, p[N_Y], sizes.workspace))
    rows = []
    for k in range(COSIM_STEPS + 1):
        call = C_FUNCTION(entry.step if k else entry.init)
        assert call(k * of.step_ns, of.step_ns, *(v.ctypes.data for v in (p, u, x, y, w))) == 0
        rows.append(y.copy())
    return np.array(rows[1:])


@pytest.mark.parametrize("fmi", [2, 3])
def test_parameter_changed_between_steps_has_the_bits_of_the_event(fmi, fmu_of):
    """bond_mass lightens the ball at 1 s by an event; the FMU's tunable parameter is set in the same tick."""
    graph = scene("bond_mass.yaml")
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
    graph = scene("pool_chain.yaml")
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


@pytest.mark.parametrize("fmi", [2, 3])
def test_inputs_start_as_the_scenario_says(fmi, fmu_of):
    """vessel_drift holds its thrusts, a current comes by a direct wire; a delay closes van_der_pol's ring."""

    def starts(text: str, *names: str) -> list[float]:
        listed = fmpy.read_model_description(str(fmu_of(text, fmi))).modelVariables
        found = {v.name: v.start for v in listed if v.name.partition("[")[0] in names}
        return [float(word) for start in found.values() for word in start.split()]

    thrusts = starts("vessel_drift.yaml#thrusters", "command.thrust")
    assert thrusts == [40e3, 40e3, 10e3, 10e3, 20e3, 30e3]
    assert starts("rov_dive.yaml#rov", "current") == [0, 0, 0]
    assert starts("van_der_pol.yaml#a", "neighbour") == [-2]
    slave = Slave(fmu_of("van_der_pol.yaml#a", fmi), 0.001)
    get = slave.fmu.getReal if fmi == 2 else slave.fmu.getFloat64
    assert list(get([slave.references["neighbour"]])) == [-2]
    slave.fmu.freeInstance()


def test_same_component_gives_the_same_file(fmu_of, tmp_path):
    """From a process of its own, which may compile in another order."""
    out = tmp_path / "again.fmu"
    path = str(ROOT / "scenarios" / "van_der_pol.yaml")
    words = [sys.executable, "-m", "pipeline.cli", "fmu", "build", f"{path}#b", "-o", str(out), "--json"]
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
