"""Exported FMUs in libcosim, OSP's co-simulation library, against the native run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.conductor import Conductor
from pipeline.graph import Graph
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

pytest.importorskip("libcosimpy", reason="libcosimpy is not installed: pip install 'towline[dev]'")

from cosim import Cosim

ROOT = Path(__file__).parents[2]
# libcosim passes doubles on unchanged; the bound is the issue's, and would show a step of another length.
TOLERANCE = 1e-12
NAMES = "abcde"


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
    assert np.abs(chain_in_libcosim(fmu_of, 50) - native_nodes(delayed_chain(), 50)).max() <= TOLERANCE


def test_what_direct_wires_differ_by(fmu_of):
    """The scene's wires are direct, libcosim's ends a step late: by what the hand moves in a step, and its waves."""
    graph = build_graph(load_scenario(ROOT / "scenarios" / "pool_chain.yaml"))
    direct = native_nodes(graph, 50)
    difference = np.abs(chain_in_libcosim(fmu_of, 50) - direct).reshape(51, 3)
    assert np.abs(difference[50] - np.abs(direct - native_nodes(graph, 49)).reshape(51, 3)[50]).max() <= TOLERANCE
    assert difference.max() == pytest.approx(6.6e-4, abs=5e-6)  # README's figure


def chain_in_libcosim(fmu_of, steps: int) -> np.ndarray:
    """The pool chain's nodes, moved by its hand."""
    cosim = Cosim(20_000_000, {name: fmu_of(f"pool_chain.yaml#{name}", 2) for name in ("wall", "hand", "tether")})
    for source, end in (("wall", "end_a"), ("hand", "end_b")):
        for member in ("position", "velocity", "acceleration"):
            for axis in (1, 2, 3):
                cosim.connect(source, f"motion.{member}[{axis}]", "tether", f"{end}.{member}[{axis}]")
    assert cosim.execution.step(steps)
    return np.array(cosim.values("tether", [f"nodes[{i},{axis}]" for i in range(1, 52) for axis in (1, 2, 3)]))


def delayed_chain() -> Graph:
    """The pool chain where the ends are those of the tick before, at t0 those of t0."""
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
    return build_graph(load_scenario_text(text, "delayed.yaml", ROOT / "scenarios"))


def native_nodes(graph: Graph, steps: int) -> np.ndarray:
    """The tether's nodes by the native loop: (153,)."""
    conductor = Conductor(graph)
    conductor.initialise()
    for _ in conductor.run(steps):
        pass
    span = conductor.memory.spans["y"][[n.name for n in graph.nodes].index("tether")]
    return conductor.memory.tables.board[span][: 51 * 3].copy()
