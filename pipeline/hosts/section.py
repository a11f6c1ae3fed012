"""Runs one section: outside numbers in, the compiled loop over its components, their outputs and state out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline import native_loop as loop
from pipeline.graph import Graph
from pipeline.hosts.lengths import lengths, pack_saved, unpack_saved
from pipeline.loop_tables import BOND_ROW, FAILED, OFFSET_ON, STATUS, TICK
from pipeline.memory import lay_out

if TYPE_CHECKING:
    from pipeline.hosts.fmu.base import FmuHost


class SectionRunner:
    """A section's memory and the loop over it.

    What goes to and fro, in this order (each a run of float64):
    a request: numbers from outside, then maybe settings: parameters of all nodes, offsets on their signals, whether
    each node has any. A reply: signals, a row of each bond, energies of each bond, then maybe state, maybe inputs.
    What restores: signals, energies, state, settings.
    """

    def __init__(self, graph: Graph, outside: int):
        """Compile the components, or load them. Raises TowlineError where one cannot be compiled."""
        self._graph = graph
        self._memory = lay_out(graph)
        self._tables = k = self._memory.tables
        loop.prepare(k, self._memory.inits)
        self.lengths = sizes = lengths(self._memory, range(len(graph.nodes)), len(graph.bonds), outside)
        self._signals = k.board[: sizes.signals]
        self._outside = k.board[sizes.signals : sizes.signals + outside]
        self._states = k.states[: sizes.state]
        self._inputs = k.inputs[: sizes.inputs]
        rows = self._memory.row_starts[len(graph.nodes) :, None] + np.arange(1, BOND_ROW + 1)
        self._bond_rows = rows.ravel()

    @property
    def names(self) -> list[str]:
        """Of its components."""
        return [node.name for node in self._graph.nodes]

    def initialise(self, numbers: np.ndarray) -> None:
        """Run every init at t0."""
        self._take(numbers)
        loop.initialise(self._tables, self._memory.inits, len(self._graph.nodes), self._graph.start_ns)

    def step(self, numbers: np.ndarray, t_ns: int) -> None:
        """Make the steps that end at t_ns."""
        self._take(numbers)
        graph, k = self._graph, self._tables
        tick = (t_ns - graph.start_ns) // graph.base_ns
        k.clock[TICK] = tick - 1
        loop.advance(k, tick, graph.start_ns, graph.base_ns)

    def _take(self, numbers: np.ndarray) -> None:
        k, sizes = self._tables, self.lengths
        k.filled[:] = self._memory.row_starts
        k.clock[STATUS] = 0
        self._outside[:] = numbers[: sizes.outside]
        if len(numbers) > sizes.outside:
            self._set(numbers[sizes.outside :])

    def _set(self, settings: np.ndarray) -> None:
        """Parameters and offsets as events left them."""
        sizes, k = self.lengths, self._tables
        offsets, switches = sizes.parameters, sizes.parameters + sizes.signals
        self._memory.parameters[:offsets] = settings[:offsets]
        k.added[: sizes.signals] = settings[offsets:switches]
        k.nodes[:, OFFSET_ON] = settings[switches:] != 0.0

    def restore(self, numbers: np.ndarray, saved: bytes) -> None:
        """Go on from what `state` and `saved` gave, and the settings of that time. Raises TowlineError, ValueError."""
        sizes, k = self.lengths, self._tables
        signals, energies, states, settings = np.split(numbers, np.cumsum([sizes.signals, sizes.energies, sizes.state]))
        self._signals[:] = signals
        k.bond_energy[:] = energies.reshape(k.bond_energy.shape)
        self._states[:] = states
        self._set(settings)
        for host, state in zip(self._saving, unpack_saved(saved), strict=True):
            host.restore(state)

    @property
    def _saving(self) -> list[FmuHost]:
        return [host for _, host in sorted(self._memory.fmus.items()) if host.can_save]

    def saved(self) -> bytes:
        """The states that are not in x, of those FMUs that can save them. Raises TowlineError."""
        return pack_saved(host.save() for host in self._saving)

    def close(self) -> None:
        """Let FMUs go."""
        self._memory.close()

    @property
    def stopped(self) -> tuple[int, int] | None:
        """(status, node) where a component stopped the run."""
        status = int(self._tables.clock[STATUS])
        return (status, int(self._tables.clock[FAILED])) if status else None

    def reply(self, *, state: bool, inputs: bool) -> bytes:
        """The numbers of a reply, the state and the inputs where they are asked for."""
        k = self._tables
        parts = [self._signals.tobytes()]
        if len(k.bonds):
            parts += [k.capture[self._bond_rows].tobytes(), k.bond_energy.tobytes()]
        if state:
            parts.append(self._states.tobytes())
        if inputs:
            parts.append(self._inputs.tobytes())
        return b"".join(parts)

    def reason(self) -> str:
        """Why the component that stopped the run did so, as its host tells; "" where it does not."""
        status, node = self.stopped or (0, -1)
        host = self._memory.hosts.get(node)
        return host.reason(status) if host is not None else ""
