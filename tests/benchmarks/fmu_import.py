"""Imported FMUs: five oscillators in a ring beside libcosim, and what a step of the cable costs in each kind of host.

The oscillators' wires are all delayed, since libcosim steps all FMUs at once on the values before. Both sides step the
same five FMUs; Towline also captures every output of every step, libcosim's observer keeps the last ones only.
"""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import native_loop as loop
from pipeline.conductor import Conductor
from pipeline.fmu.build import build
from pipeline.fmu.instance import instance
from pipeline.graph import Graph, Node, alone
from pipeline.hosts.fmu.component import FmuComponent, component_of
from pipeline.hosts.launch import source_path
from pipeline.memory import lay_out
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "scenarios"
NAMES = "abcde"
RING_S = 4000
PIECE, PIECES = 20_000, 10  # steps timed at once, and how often
COSIM_PIECE, COSIM_PIECES = 400, 10  # both end after 4 s, where they are compared
STEPS = 1000
REPEATS = 5

# A component of the pool chain's size made with pythonfmu3, which calls the same compiled kernel.
SCRIPT = """
import ctypes
import numpy as np
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64

from components.compiled import bind
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

KERNEL = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


class Cable(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        node = next(one for one in build_graph(load_scenario({scene!r})).nodes if one.name == "tether")
        entry, sizes = bind(node.component), node.component.sizes(node.parameters)
        self.entry = entry
        self.kernels = KERNEL(entry.init), KERNEL(entry.step)
        n_u = sum(port.size for port in node.inputs)
        self.vectors = [node.component.pack(node.parameters), np.zeros(n_u)]
        self.vectors += [np.zeros(n) for n in (sizes.state, node.width, sizes.workspace)]
        self.addresses = [vector.ctypes.data for vector in self.vectors]
        self.time = 0.0
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        for letter, vector, causality in (("u", self.vectors[1], "input"), ("y", self.vectors[3], "output")):
            for i in range(len(vector)):
                self.register_variable(Float64(
                    f"{{letter}}[{{i + 1}}]", causality=getattr(Fmi3Causality, causality),
                    getter=lambda vector=vector, i=i: float(vector[i]),
                    setter=lambda value, vector=vector, i=i: vector.__setitem__(i, value),
                ))

    def exit_initialization_mode(self):
        self.kernels[0](0, {step_ns}, *self.addresses)

    def do_step(self, t, h):
        self.kernels[1](round((t + h) * 1e9), {step_ns}, *self.addresses)
        return True
"""


def _built(text: str, folder: Path) -> Path:
    path = folder / f"{text.partition('#')[2]}.fmu"
    path.write_bytes(build(instance(str(SCENES / text), []), 2))
    return path


def _ring(oscillator: Path) -> Graph:
    lines = [
        f"  {name}: {{fmu: {oscillator}, parameters: {{parameters.position: {2.0 - i}}}, inputs: {{neighbour: "
        f"{{from: {NAMES[i - 1]}.position, delay: true, initial: {2.0 - (i - 1) % 5}}}}}}}"
        for i, name in enumerate(NAMES)
    ]
    text = f"duration: {RING_S} s\nstep: 1 ms\nscene: false\ncomponents:\n" + "\n".join(lines)
    return build_graph(load_scenario_text(text, "ring.yaml", oscillator.parent))


def _ours(graph: Graph, piece: int, pieces: int) -> tuple[np.ndarray, float]:
    """(positions and velocities, FMU steps a second in the fastest piece, on which other load fell least)."""
    conductor = Conductor(graph)
    conductor.initialise()
    times = []
    for _ in range(pieces):
        began = time.perf_counter()
        for _ in conductor.run(conductor.tick + piece, lambda: piece):
            pass
        times.append(time.perf_counter() - began)
    found = conductor.memory.tables.board[: graph.board].reshape(5, 2).copy()
    conductor.close()
    return found, 5 * piece / min(times)


def _cosim(oscillator: Path) -> tuple[np.ndarray, float]:
    """The same of libcosim."""
    import fmpy
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)  # on standard output, which is --json's
    execution = CosimExecution.from_step_size(1_000_000)
    slaves = [CosimLocalSlave(str(oscillator), name) for name in NAMES]
    index = [execution.add_local_slave(slave) for slave in slaves]
    reference = {v.name: v.valueReference for v in fmpy.read_model_description(str(oscillator)).modelVariables}
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for i in range(5):
        execution.real_initial_value(index[i], reference["parameters.position"], 2.0 - i)
        ends = index[i - 1], reference["position"], index[i], reference["neighbour"]
        execution.connect_real_variables(*ends)
    times = []
    for _ in range(COSIM_PIECES):
        began = time.perf_counter()
        execution.step(COSIM_PIECE)
        times.append(time.perf_counter() - began)
    wanted = [reference["position"], reference["velocity"]]
    return np.array([observer.last_real_values(i, wanted) for i in index]), 5 * COSIM_PIECE / min(times)


def _oscillators(folder: Path) -> list[dict[str, Any]]:
    oscillator = _built("van_der_pol.yaml#a", folder)
    graph = _ring(oscillator)
    expected, _ = _ours(graph, COSIM_PIECE, COSIM_PIECES)
    found, ours, theirs = np.empty(0), [], []
    for _ in range(REPEATS):  # side by side, so that other load falls on both
        found, speed = _cosim(oscillator)
        theirs.append(speed)
        ours.append(_ours(graph, PIECE, PIECES)[1])
    shared = {"case": "five van der Pol FMUs in a ring, 1 ms", "error_unit": "largest difference after 4 s"}
    factor = statistics.median(a / b for a, b in zip(ours, theirs, strict=True))
    error = float(np.abs(found - expected).max())
    return [
        shared
        | {"method": "Towline", "error": error, "fmu_steps_per_s": statistics.median(ours), "times": factor}
        | {"reference": "libcosim"},
        shared
        | {"method": "libcosim", "error": error, "fmu_steps_per_s": statistics.median(theirs), "times": 1.0}
        | {"reference": "Towline"},
    ]


def _recorded(graph: Graph) -> np.ndarray:
    """The cable's inputs over the first steps of the scene, t0 first."""
    conductor = Conductor(graph)
    conductor.initialise()
    span, inputs = conductor.memory.spans["u"][2], conductor.memory.tables.inputs
    rows = [inputs[span].copy()]
    for _ in conductor.run(STEPS, lambda: 1):
        rows.append(inputs[span].copy())
    return np.array(rows)


def _stepped(graph: Graph, node: Node, u: np.ndarray) -> tuple[np.ndarray, float]:
    """(outputs, microseconds a step) of a node alone in the compiled loop."""
    memory = lay_out(alone(graph, node))
    tables, step_ns = memory.tables, node.period * graph.base_ns
    tables.inputs[: u.shape[1]] = u[0]
    loop.initialise(tables, memory.inits, 1, 0)
    y = np.zeros((len(u), node.width))
    loop.step_through(tables, u, y, 1, 2, 0, step_ns)
    began = time.perf_counter()
    end = loop.step_through(tables, u, y, 2, len(u), 0, step_ns)
    took = time.perf_counter() - began
    memory.close()
    assert end == len(u)
    return y, 1e6 * took / (len(u) - 2)


def _as_fmu(node: Node, component: FmuComponent) -> Node:
    parameters = component.parameters()
    ports = component.inputs(parameters), component.outputs(parameters)
    return replace(node, component=component, parameters=parameters, inputs=ports[0], outputs=ports[1])


def _python_fmu(folder: Path, step_ns: int) -> Path:
    """The FMU that pythonfmu3 makes of SCRIPT."""
    script = folder / "cable.py"
    script.write_text(SCRIPT.format(scene=str(SCENES / "pool_chain.yaml"), step_ns=step_ns))
    words = [sys.executable, "-m", "pythonfmu3", "build", "-f", str(script), "-d", str(folder)]
    subprocess.run(words, check=True, capture_output=True, env={**os.environ, "PYTHONPATH": source_path()})
    return folder / "Cable.fmu"


def _cable(folder: Path) -> list[dict[str, Any]]:
    graph = build_graph(load_scenario(SCENES / "pool_chain.yaml"))
    node, u = graph.nodes[2], _recorded(graph)
    exported = _built("pool_chain.yaml#tether", folder)
    nodes = {
        "native": node,
        "FMU in this process": _as_fmu(node, component_of(exported)),
        "FMU isolated": _as_fmu(node, component_of(exported, isolate=True, overdue_s=60.0)),
        "pythonfmu3 on the same kernel, in this process": _as_fmu(
            node, component_of(_python_fmu(folder, node.period * graph.base_ns))
        ),
    }
    expected = _stepped(graph, node, u)[0]
    times: dict[str, list[float]] = {method: [] for method in nodes}
    errors = {}
    for _ in range(REPEATS):
        for method, one in nodes.items():
            y, us = _stepped(graph, one, u)
            times[method].append(us)
            errors[method] = float(np.abs(y[1:] - expected[1:]).max())
    return [
        {
            "case": f"one step of the cable, 50 segments, 20 ms, {u.shape[1]} numbers in and {node.width} out",
            "method": method,
            "error": errors[method],
            "error_unit": "largest difference of an output",
            "us": statistics.median(times[method]),
            "reference": "native",
        }
        for method in nodes
    ]


def rows() -> list[dict[str, Any]]:
    """One row a way; `times`: of libcosim's FMU steps a second, by pairs of runs."""
    folder = Path(tempfile.mkdtemp(prefix="towline-bench-"))
    try:
        return [*_oscillators(folder), *_cable(folder)]
    finally:
        shutil.rmtree(folder, ignore_errors=True)
