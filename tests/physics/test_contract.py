"""What every component owes to the contract, tested over all of them and over the nodes of all scenarios."""

from __future__ import annotations

import ctypes
import importlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numba import njit

import components
from components.compiled import OPTIONS, bind
from components.contract import Component, ImagePort
from pipeline import native_loop as loop
from pipeline.conductor import Conductor
from pipeline.graph import Graph, Node, alone
from pipeline.memory import lay_out
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
FOLDERS = sorted(path.parent for path in (ROOT / "components").glob("*/*/component.py"))
# Scenes of FMUs have nothing of their own here: what the contract asks of FMUs is tested in runs/.
SCENARIOS = sorted(path for path in (ROOT / "scenarios").glob("*.yaml") if "fmu: " not in path.read_text())


def component_of(folder: Path) -> Component:
    return importlib.import_module(f"components.{folder.parent.name}.{folder.name}.component").COMPONENT


def names(folders: list[Path]) -> list[str]:
    return [f"{folder.parent.name}.{folder.name}" for folder in folders]


def test_imported_components_are_this_repository():
    assert Path(components.__file__).parent == ROOT / "components"


@pytest.mark.parametrize("folder", FOLDERS, ids=names(FOLDERS))
def test_component_is_named_by_its_folder(folder):
    assert component_of(folder).name == f"{folder.parent.name}.{folder.name}"


@njit(**OPTIONS)
def step_once(k, t_ns):
    return loop.step_node(k, 0, t_ns)


def steps_alone(node: Node, graph: Graph, inputs: np.ndarray, poison: bool) -> np.ndarray:
    """Outputs and states of a node stepped by itself through the inputs, (k, n_y + n_x)."""
    single = replace(alone(graph, node), events=())
    memory = lay_out(single)
    tables = memory.tables
    seen = []
    for k, u in enumerate(inputs):
        tables.inputs[: len(u)] = u
        if poison:
            memory.workspace[:] = np.nan
            tables.board[:] = np.nan
        if k == 0:
            loop.initialise(tables, memory.inits, 1, 0)
        else:
            assert step_once(tables, k * node.period * graph.base_ns) == 0
        seen.append(np.concatenate([tables.board[: single.board], tables.states]))
    return np.array(seen)


def has_images(graph: Graph) -> bool:
    return any(isinstance(port, ImagePort) for node in graph.nodes for port in node.outputs)


def recorded_inputs(graph: Graph, ticks: int) -> list[np.ndarray]:
    """Each node's inputs over a short run, its own steps only: (k, n_u) a node."""
    conductor = Conductor(graph)
    conductor.initialise()
    spans, tables = conductor.memory.spans["u"], conductor.memory.tables
    seen = [[tables.inputs[span].copy()] for span in spans]
    for _ in conductor.run(ticks, lambda: 1):
        for node, span, rows in zip(graph.nodes, spans, seen, strict=True):
            if conductor.tick % node.period == 0:
                rows.append(tables.inputs[span].copy())
    return [np.array(rows) for rows in seen]


@pytest.mark.parametrize("path", SCENARIOS, ids=[path.stem for path in SCENARIOS])
def test_outputs_are_write_only_and_workspace_is_scratch(path):
    """With y and w full of NaN before every step, the same bits; y and x hold no NaN afterwards."""
    graph = build_graph(load_scenario(path))
    # Images take their time to be drawn: two of them are enough.
    ticks = min(graph.ticks, max(n.period for n in graph.nodes) if has_images(graph) else 100)
    for node, inputs in zip(graph.nodes, recorded_inputs(graph, ticks), strict=True):
        plain = steps_alone(node, graph, inputs, poison=False)
        poisoned = steps_alone(node, graph, inputs, poison=True)
        assert poisoned.tobytes() == plain.tobytes(), node.name


C_FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)
GUARD = 64


class Fenced:
    """A vector between two fences of NaN: reading beyond it spoils the result, writing there is seen."""

    def __init__(self, values: np.ndarray):
        self.whole = np.full(len(values) + 2 * GUARD, np.nan)
        self.inside = self.whole[GUARD : GUARD + len(values)]
        self.inside[:] = values
        self.address = self.inside.ctypes.data

    def intact(self) -> bool:
        return bool(np.isnan(self.whole[:GUARD]).all() and np.isnan(self.whole[len(self.whole) - GUARD :]).all())


@pytest.mark.parametrize("path", SCENARIOS, ids=[path.stem for path in SCENARIOS])
def test_no_kernel_leaves_its_vectors(path):
    """The machine code steps through a scene between fences of NaN, which stay, and gives the same bits."""
    graph = build_graph(load_scenario(path))
    for node, inputs in zip(graph.nodes, recorded_inputs(graph, 50), strict=True):
        if not node.component.compiled:  # Python's arrays have their own fences
            continue
        entry = bind(node.component)
        init, step = (C_FUNCTION(address) for address in (entry.init, entry.step))
        sizes = node.component.sizes(node.parameters)
        p, u, x, y, w = (
            Fenced(values)
            for values in (
                node.component.pack(node.parameters, node.seed),
                inputs[0],
                np.zeros(sizes.state),
                np.zeros(node.width),
                np.zeros(sizes.workspace),
            )
        )
        expected = steps_alone(node, graph, inputs, poison=False)
        for k, values in enumerate(inputs):
            u.inside[:] = values
            dt_ns = node.period * graph.base_ns
            addresses = [vector.address for vector in (p, u, x, y, w)]
            assert (init if k == 0 else step)(k * dt_ns, dt_ns, *addresses) == 0
            assert all(vector.intact() for vector in (p, u, x, y, w)), f"{node.name} at step {k}"
            assert y.inside.tobytes() == expected[k, : len(y.inside)].tobytes()
