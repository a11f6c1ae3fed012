"""What a step of the pool chain's cable costs as native code, and as an exported FMU called by pointer and by fmpy.

And what libcosim, which steps all FMUs at once, makes of the scene's direct wires: the ends come a step late.
"""

from __future__ import annotations

import ctypes as c
import shutil
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from components.compiled import bind
from pipeline.conductor import Conductor
from pipeline.fmu.build import build
from pipeline.fmu.instance import instance
from pipeline.graph import Node
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENARIO = Path(__file__).parents[2] / "scenarios" / "pool_chain.yaml"
STEPS = 2000
REPEATS = 5
IN_LIBCOSIM = 50  # steps: a second
KERNEL = c.CFUNCTYPE(c.c_int64, c.c_int64, c.c_int64, *[c.c_void_p] * 5)

Run = Callable[[np.ndarray], np.ndarray]  # outputs (k, n_y) of steps with the inputs (k, n_u), the first being init's


def _recorded() -> tuple[Node, int, np.ndarray]:
    """The cable, its step [ns] and its inputs over the first steps of the scene."""
    graph = build_graph(load_scenario(SCENARIO))
    conductor = Conductor(graph)
    conductor.initialise()
    i = [node.name for node in graph.nodes].index("tether")
    span, inputs = conductor.memory.spans["u"][i], conductor.memory.tables.inputs
    rows = [inputs[span].copy()]
    for _ in conductor.run(STEPS, lambda: 1):
        rows.append(inputs[span].copy())
    return graph.nodes[i], graph.base_ns, np.array(rows)


def _native(node: Node, step_ns: int) -> Run:
    entry, sizes = bind(node.component), node.component.sizes(node.parameters)

    def run(inputs: np.ndarray) -> np.ndarray:
        vectors = [node.component.pack(node.parameters), inputs[0].copy()]
        vectors += [np.zeros(n) for n in (sizes.state, node.width, sizes.workspace)]
        addresses, outputs = [vector.ctypes.data for vector in vectors], []
        for k, row in enumerate(inputs):
            vectors[1][:] = row
            KERNEL(entry.step if k else entry.init)(k * step_ns, step_ns, *addresses)
            outputs.append(vectors[3].copy())
        return np.array(outputs)

    return run


def _by_pointer(path: Path, folder: Path) -> Run:
    """FMI 2 functions of the library, with arrays made once."""
    about = fmpy.read_model_description(str(path))
    library = c.CDLL(str(next(Path(fmpy.extract(str(path), str(folder / "library"))).rglob("*.so"))))
    library.fmi2Instantiate.restype = c.c_void_p
    references = {
        causality: [v.valueReference for v in about.modelVariables if v.causality == causality]
        for causality in ("input", "output")
    }
    u, y = (np.zeros(len(found)) for found in references.values())
    r_u, r_y = ((c.c_uint * len(found))(*found) for found in references.values())
    h = float(about.defaultExperiment.stepSize)

    def run(inputs: np.ndarray) -> np.ndarray:
        one = c.c_void_p(library.fmi2Instantiate(b"one", 1, about.guid.encode(), b"", None, 0, 0))
        give = (one, r_u, c.c_size_t(len(u)), c.c_void_p(u.ctypes.data))
        take = (one, r_y, c.c_size_t(len(y)), c.c_void_p(y.ctypes.data))
        library.fmi2SetupExperiment(one, 0, c.c_double(0.0), c.c_double(0.0), 0, c.c_double(0.0))
        library.fmi2EnterInitializationMode(one)
        outputs = []
        for k, row in enumerate(inputs):
            u[:] = row
            library.fmi2SetReal(*give)
            if k:
                library.fmi2DoStep(one, c.c_double((k - 1) * h), c.c_double(h), 1)
            else:
                library.fmi2ExitInitializationMode(one)
            library.fmi2GetReal(*take)
            outputs.append(y.copy())
        library.fmi2FreeInstance(one)
        return np.array(outputs)

    return run


def _by_fmpy(path: Path, folder: Path) -> Run:
    """fmpy's methods, with lists, as a Python master calls them."""
    about = fmpy.read_model_description(str(path))
    is_2 = about.fmiVersion == "2.0"
    fmpy.extract(str(path), str(folder))
    u, y = (
        [v.valueReference for v in about.modelVariables if v.causality == causality]
        for causality in ("input", "output")
    )
    h = float(about.defaultExperiment.stepSize)

    def run(inputs: np.ndarray) -> np.ndarray:
        kind, identifier = FMU2Slave if is_2 else FMU3Slave, about.coSimulation.modelIdentifier
        one = kind(guid=about.guid, unzipDirectory=str(folder), modelIdentifier=identifier, instanceName="one")
        one.instantiate()
        if is_2:
            one.setupExperiment()
        one.enterInitializationMode()
        outputs, width = [], sum(int(np.prod(v.shape or ())) for v in about.modelVariables if v.causality == "output")
        for k, row in enumerate(inputs):
            (one.setReal if is_2 else one.setFloat64)(u, row.tolist())
            if k:
                one.doStep(currentCommunicationPoint=(k - 1) * h, communicationStepSize=h)
            else:
                one.exitInitializationMode()
            outputs.append(one.getReal(y) if is_2 else one.getFloat64(y, width))
        one.terminate()
        one.freeLibrary()
        return np.array(outputs)

    return run


def _seconds(run: Run, inputs: np.ndarray) -> float:
    began = time.perf_counter()
    run(inputs)
    return time.perf_counter() - began


def _built(name: str, path: Path, fmi: int) -> Path:
    path.write_bytes(build(instance(f"{SCENARIO}#{name}", []), fmi))
    return path


def _nodes_in_libcosim(folder: Path, step_ns: int) -> tuple[np.ndarray, float]:
    """(the chain's nodes (153,) after a second, moved by the hand's FMU; seconds it took)."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)  # on standard output, which is --json's
    execution = CosimExecution.from_step_size(step_ns)
    paths = {name: _built(name, folder / f"{name}.fmu", 2) for name in ("wall", "hand", "tether")}
    slaves = {name: CosimLocalSlave(str(path), name) for name, path in paths.items()}
    index = {name: execution.add_local_slave(slave) for name, slave in slaves.items()}
    references = {
        name: {v.name: v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables}
        for name, path in paths.items()
    }
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for source, end in (("wall", "end_a"), ("hand", "end_b")):
        for name, reference in references[source].items():
            if name.startswith("motion."):
                entry = references["tether"][name.replace("motion", end)]
                execution.connect_real_variables(index[source], reference, index["tether"], entry)
    began = time.perf_counter()
    execution.step(IN_LIBCOSIM)
    took = time.perf_counter() - began
    nodes = [reference for name, reference in references["tether"].items() if name.startswith("nodes[")]
    return np.array(observer.last_real_values(index["tether"], nodes)), took


def _direct_wires(folder: Path) -> dict:
    """How far libcosim is from the native run."""
    graph = build_graph(load_scenario(SCENARIO))
    conductor = Conductor(graph)
    conductor.initialise()
    for _ in conductor.run(IN_LIBCOSIM):
        pass
    start = conductor.memory.spans["y"][[node.name for node in graph.nodes].index("tether")]
    found, took = _nodes_in_libcosim(folder, graph.base_ns)
    expected = conductor.memory.tables.board[start][: len(found)]
    return {
        "case": f"wall, hand and cable, direct wires, {graph.base_ns / 1e6:g} ms",
        "method": "libcosim, FMI 2",
        "error": float(np.abs(found - expected).max()),
        "error_unit": "m, largest difference of a node after 1 s",
        "us": 1e6 * took / IN_LIBCOSIM,
        "reference": "native run",
    }


def rows() -> list[dict]:
    """One row a way of calling it; the error is against the native code, and zero means equal bits."""
    node, step_ns, inputs = _recorded()
    folder = Path(tempfile.mkdtemp(prefix="towline-bench-"))
    try:
        paths = {fmi: _built("tether", folder / f"tether_{fmi}.fmu", fmi) for fmi in (2, 3)}
        runs = {"native code": _native(node, step_ns), "FMI 2 by pointer": _by_pointer(paths[2], folder)}
        runs |= {f"FMI {fmi} by fmpy": _by_fmpy(paths[fmi], folder / str(fmi)) for fmi in (2, 3)}
        expected = runs["native code"](inputs)
        calls = [
            {
                "case": f"cable, 50 segments, {step_ns / 1e6:g} ms, all inputs and outputs",
                "method": method,
                "error": float(np.abs(run(inputs) - expected).max()),
                "error_unit": "largest difference of an output",
                "us": 1e6 * statistics.median(_seconds(run, inputs) for _ in range(REPEATS)) / STEPS,
                "reference": "native code",
            }
            for method, run in runs.items()
        ]
        return [*calls, _direct_wires(folder)]
    finally:
        shutil.rmtree(folder, ignore_errors=True)
