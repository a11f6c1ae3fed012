"""Exported FMUs in libcosim, OSP's co-simulation library, against the native run."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

from pipeline.conductor import Conductor
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

pytest.importorskip("libcosimpy", reason="libcosimpy is not installed: pip install 'towline[dev]'")

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

ROOT = Path(__file__).parents[2]
# libcosim passes doubles on unchanged; the bound is the issue's, and would show a step of another length.
TOLERANCE = 1e-12
NAMES = "abcde"


class Cosim:
    """A simulation in libcosim of FMUs by name."""

    def __init__(self, step_ns: int, fmus: dict[str, Path]):
        self.execution = CosimExecution.from_step_size(step_ns)
        self.slaves = [CosimLocalSlave(str(path), name) for name, path in fmus.items()]
        self.index = {name: self.execution.add_local_slave(s) for name, s in zip(fmus, self.slaves, strict=True)}
        about = {name: fmpy.read_model_description(str(path)) for name, path in fmus.items()}
        self.references = {name: {v.name: v.valueReference for v in one.modelVariables} for name, one in about.items()}
        self.observer = CosimObserver.create_last_value()
        self.execution.add_observer(self.observer)

    def connect(self, source: str, output: str, target: str, entry: str) -> None:
        ends = self.references[source][output], self.references[target][entry]
        status = self.execution.connect_real_variables(self.index[source], ends[0], self.index[target], ends[1])
        assert status == 0

    def values(self, name: str, variables: list[str]) -> list[float]:
        return self.observer.last_real_values(self.index[name], [self.references[name][v] for v in variables])


RING = """
duration: 5 s
step: 1 ms
components:
""" + "\n".join(
    f"  {name}: {{model: motion.van_der_pol, parameters: {{position: {2.0 - i}}},"
    f" inputs: {{neighbour: {{from: {NAMES[i - 1]}.position, delay: true, initial: {2.0 - (i - 1) % 5}}}}}}}"
    for i, name in enumerate(NAMES)
)


def test_ring_of_delayed_wires(fmu_of, tmp_path):
    """libcosim steps all slaves at once on the values before, which is all wires delayed: 5000 steps, five FMUs."""
    graph = build_graph(load_scenario_text(RING, "ring.yaml", tmp_path))
    conductor = Conductor(graph)
    conductor.initialise()
    for _ in conductor.run(graph.ticks):
        pass
    expected = conductor.memory.tables.board[: graph.board].reshape(5, 2)
    cosim = Cosim(1_000_000, dict.fromkeys(NAMES, fmu_of("van_der_pol.yaml#a", 2)))
    for i, name in enumerate(NAMES):
        assert cosim.execution.real_initial_value(
            cosim.index[name], cosim.references[name]["parameters.position"], 2.0 - i
        )
        cosim.connect(NAMES[i - 1], "position", name, "neighbour")
    assert cosim.execution.step(graph.ticks)
    found = np.array([cosim.values(name, ["position", "velocity"]) for name in NAMES])
    assert np.abs(found - expected).max() <= TOLERANCE


def test_hand_and_tether(fmu_of):
    """The pool chain's hand moves its chain, 50 steps of 20 ms, against the native loop with delayed wires."""
    cosim = Cosim(20_000_000, {name: fmu_of(f"pool_chain.yaml#{name}", 2) for name in ("wall", "hand", "tether")})
    for source, end in (("wall", "end_a"), ("hand", "end_b")):
        for member in ("position", "velocity", "acceleration"):
            for axis in (1, 2, 3):
                cosim.connect(source, f"motion.{member}[{axis}]", "tether", f"{end}.{member}[{axis}]")
    nodes = [f"nodes[{i},{axis}]" for i in range(1, 52) for axis in (1, 2, 3)]
    assert cosim.execution.step(50)
    found = np.array(cosim.values("tether", nodes))
    assert np.abs(found - delayed_chain(50)).max() <= TOLERANCE


def delayed_chain(steps: int) -> np.ndarray:
    """The pool chain's nodes where the ends are those of the tick before, by the native loop; at t0 those of t0."""
    text = (ROOT / "scenarios" / "pool_chain.yaml").read_text()
    graph = build_graph(load_scenario_text(text, "pool_chain.yaml", ROOT / "scenarios"))
    first = Conductor(graph)
    first.initialise()
    start = dict(zip([n.name for n in graph.nodes], first.memory.spans["y"], strict=True))
    board = first.memory.tables.board
    ends = {"end_a.": board[start["wall"]].tolist(), "end_b.": board[start["hand"]].tolist()}
    assert "inputs: {end_a: wall.motion, end_b: hand.motion}" in text
    members = ("position", "velocity", "acceleration")
    wires = ", ".join(
        f"{end}{member}: {{from: {source}.motion.{member}, delay: true, initial: {ends[end][3 * k : 3 * k + 3]}}}"
        for end, source in (("end_a.", "wall"), ("end_b.", "hand"))
        for k, member in enumerate(members)
    )
    text = text.replace("inputs: {end_a: wall.motion, end_b: hand.motion}", f"inputs: {{{wires}}}")
    graph = build_graph(load_scenario_text(text, "delayed.yaml", ROOT / "scenarios"))
    conductor = Conductor(graph)
    conductor.initialise()
    for _ in conductor.run(steps):
        pass
    span = conductor.memory.spans["y"][[n.name for n in graph.nodes].index("tether")]
    return conductor.memory.tables.board[span][: 51 * 3].copy()
