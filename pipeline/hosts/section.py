"""Runs one section: outside numbers in, the compiled loop over its components, their outputs and state out."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline import native_loop as loop
from pipeline.graph import Graph
from pipeline.hosts.lengths import lengths, pack_saved, unpack_saved
from pipeline.loop_tables import BOND_ROW, FAILED, OFFSET_ON, STATUS
from pipeline.memory import lay_out

if TYPE_CHECKING:
    from pipeline.hosts.fmu.base import FmuHost

Numbers = bytes | memoryview  # float64, little-endian


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
        self._places = loop.places_of(k)
        self.lengths = sizes = lengths(self._memory, range(len(graph.nodes)), len(graph.bonds), outside)
        self._signals = k.board[: sizes.signals]
        self._outside = k.board[sizes.signals :][:outside].data.cast("B") if outside else memoryview(bytearray())
        self._states = k.states[: sizes.state]
        self._inputs = k.inputs[: sizes.inputs]
        rows = self._memory.row_starts[len(graph.nodes) :, None] + np.arange(1, BOND_ROW + 1)
        self._bond_rows = rows.ravel()

    @property
    def names(self) -> list[str]:
        """Of its components."""
        return [node.name for node in self._graph.nodes]

    def initialise(self, numbers: Numbers) -> int:
        """Run every init at t0; the status of the component that stopped the run, or 0."""
        self._take(numbers)
        k = self._tables
        k.filled[:], k.clock[STATUS] = self._memory.row_starts, 0
        loop.initialise(k, self._memory.inits, len(self._graph.nodes), self._graph.start_ns)
        return int(k.clock[STATUS])

    def step(self, numbers: Numbers, t_ns: int) -> int:
        """Make the steps that end at t_ns; the status of the component that stopped the run, or 0."""
        self._take(numbers)
        start_ns, base_ns = self._graph.start_ns, self._graph.base_ns
        tick = (t_ns - start_ns) // base_ns
        return loop.advance_at(self._places, self._memory.row_starts, tick - 1, tick, start_ns, base_ns)

    def _take(self, numbers: Numbers) -> None:
        """What comes with a request, of one of the two lengths."""
        end = self._outside.nbytes
        self._outside[:] = numbers[:end]
        if len(numbers) > end:
            self._set(np.frombuffer(numbers[end:]))

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
    def failed(self) -> int:
        """The node that stopped the run, where one did."""
        return int(self._tables.clock[FAILED])

    def reply(self, *, state: bool, inputs: bool) -> list[bytes]:
        """The numbers of a reply in parts, the state and the inputs where they are asked for."""
        k = self._tables
        parts = [self._signals.tobytes()]
        if self._bond_rows.size:
            parts += [k.capture[self._bond_rows].tobytes(), k.bond_energy.tobytes()]
        if state:
            parts.append(self._states.tobytes())
        if inputs:
            parts.append(self._inputs.tobytes())
        return parts

    def reason(self, status: int) -> str:
        """Why the component that stopped the run did so, as its host tells; "" where it does not."""
        host = self._memory.hosts.get(self.failed)
        return host.reason(status) if host is not None else ""
