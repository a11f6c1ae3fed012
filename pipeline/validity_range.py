"""How far each model was inside or outside its stated validity range, over all steps of a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.graph import Graph, Node

LIMIT = 1.0  # a validity port above it is outside, see components.contract.Component


class _Watch:
    """One model's validity port and the measures beside it: where they stand in its outputs."""

    def __init__(self, node: Node):
        bundle = node.component.validity.rpartition(".")[0]
        self.columns: dict[str, slice] = {}
        at = 0
        for port in node.outputs:
            if port.name == node.component.validity:
                self.range = at
            elif bundle and port.name.startswith(f"{bundle}."):
                self.columns[port.name.removeprefix(f"{bundle}.")] = slice(at, at + port.size)
            at += port.size
        self.figures = {"largest": 0.0, "outside": 0.0, "steps": 0.0, **dict.fromkeys(self.columns, 0.0)}

    def add(self, values: np.ndarray) -> None:
        """Rows of outputs: (k, n_y)."""
        limit, figures = values[:, self.range], self.figures
        figures["largest"] = max(figures["largest"], float(limit.max()))
        figures["outside"] += int(np.count_nonzero(~(limit <= LIMIT)))
        figures["steps"] += len(limit)
        for name, columns in self.columns.items():
            figures[name] = max(figures[name], float(values[:, columns].max()))

    def summary(self) -> dict[str, float]:
        """Largest value, share of the steps outside, and the largest value of each measure."""
        figures = dict(self.figures)
        outside, steps = figures.pop("outside"), figures.pop("steps")
        return {"largest": figures.pop("largest"), "outside_share": outside / max(steps, 1.0), **figures}


class Ranges:
    """The validity of all models of a graph that tell it; `kept` goes into snapshots and comes back from them."""

    def __init__(self, graph: Graph, kept: Mapping[str, Mapping[str, float]] | None = None):
        self._names = [node.name for node in graph.nodes]
        self._watches = {node.name: _Watch(node) for node in graph.nodes if node.component.validity}
        for name, watch in self._watches.items():
            watch.figures |= (kept or {}).get(name, {})

    def update(self, channel: int, rows: np.ndarray) -> None:
        """Add a node's captured rows (k, 1 + n_y), time first."""
        watch = self._watches.get(self._names[channel])
        if watch is not None:
            watch.add(rows[:, 1:])

    def kept(self) -> dict[str, dict[str, float]]:
        """All figures so far."""
        return {name: dict(watch.figures) for name, watch in self._watches.items()}

    def summary(self) -> dict[str, dict[str, float]]:
        """{component: {largest, outside_share, and the largest value of each measure}}."""
        return {name: watch.summary() for name, watch in self._watches.items()}
