"""Events at exact ticks: tunable parameters set anew, and offsets put on signals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from components.contract import Parameters
from pipeline.graph import Event, Graph
from pipeline.loop_tables import OFFSET_ON
from pipeline.memory import Memory


@dataclass(frozen=True)
class Firing:
    """One event beginning, or an offset of it ending, as the tick that starts at `tick` begins."""

    tick: int
    event: Event
    ends: bool = False


def firings(graph: Graph) -> list[Firing]:
    """All firings in order of time; those of one tick in the order of the YAML, ends first."""
    begins = [Firing(event.tick, event) for event in graph.events]
    ends = [Firing(event.until, event, ends=True) for event in graph.events if event.until >= 0]
    return sorted([*ends, *begins], key=lambda firing: firing.tick)


class EventClock:
    """Fires the events of a graph and keeps what they changed."""

    def __init__(self, graph: Graph, memory: Memory):
        self.parameters: list[Parameters] = [node.parameters for node in graph.nodes]
        self.fired = 0
        self._graph = graph
        self._memory = memory
        self._firings = firings(graph)
        self._active: list[Event] = []

    def next_tick(self) -> int | None:
        """Tick of the next firing, None after the last."""
        return self._firings[self.fired].tick if self.fired < len(self._firings) else None

    def fire(self, tick: int) -> list[Firing]:
        """Fire what is due as the tick that starts at `tick` begins; returns it."""
        due = []
        while self.next_tick() == tick:
            due.append(self._firings[self.fired])
            self._apply(due[-1])
        return due

    def fast_forward(self, fired: int) -> None:
        """Apply the first `fired` firings again, after restoring a snapshot."""
        while self.fired < fired:
            self._apply(self._firings[self.fired])

    def _apply(self, firing: Firing) -> None:
        self.fired += 1
        event = firing.event
        if firing.ends:
            self._active.remove(event)
        else:
            for i, changes in event.set:
                self._set(i, changes)
            if event.add:
                self._active.append(event)
        if event.add:
            self._put_offsets()

    def _set(self, i: int, changes: dict[str, object]) -> None:
        """Rebuild node i's p with some parameters changed (validated when the graph was built)."""
        before = self.parameters[i]
        after = type(before).model_validate({**before.model_dump(), **changes})
        node = self._graph.nodes[i]
        self._memory.parameters[self._memory.spans["p"][i]] = node.component.pack(after, node.seed)
        self.parameters[i] = after

    def _put_offsets(self) -> None:
        """Sum up the active offsets, in the order in which they began."""
        tables = self._memory.tables
        tables.added[:] = 0.0
        touched = np.zeros(len(tables.added), bool)
        for event in self._active:
            for first, values in event.add:
                tables.added[first : first + len(values)] += values
                touched[first : first + len(values)] = True
        for i, span in enumerate(self._memory.spans["y"]):
            tables.nodes[i, OFFSET_ON] = touched[span].any()
