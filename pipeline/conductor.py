"""Steps a graph: events, then a slice of ticks, then what was captured is handed over; the loop and little else."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

import numpy as np

from components.contract import Port, law_ports, numbers_in, parted
from pipeline import native_loop as loop
from pipeline.bus.channels import Channels
from pipeline.digest import block_ticks
from pipeline.errors import StepError, TowlineError
from pipeline.events import EventClock, Firing
from pipeline.graph import Graph
from pipeline.loop_tables import NON_FINITE, RESIDUAL, STATUS, STEP, THROUGHPUT, TICK, UNCONVERGED, W
from pipeline.memory import lay_out
from pipeline.snapshot import Snapshot

if TYPE_CHECKING:
    from pipeline.hosts.fmu.base import FmuHost

SLICE_S = 0.05  # wall time aimed at, so that a slice stays below 0.1 s on a noisy machine
SHOWN = 9  # numbers of an input shown in a message

BOND_PORTS = (
    *law_ports("law"),
    Port("accepted.force", "N", (3,), "NED", "force of the line at the accepted motion"),
    Port("residual", "J", description="energy by which the accepted force differs from the law, summed up"),
    Port("throughput", "J", description="absolute work through the bond, summed up"),
    Port("rounds", "1", description="times the step was made"),
)


class Conductor:
    """One run of a graph in this process.

    remarks: what happened to hosts, until somebody takes it; tell: is told at once. poll: called while waiting, may
    raise KeyboardInterrupt. written: by hosts to their standard streams, after close(). channels: on the bus, for
    whoever subscribes; None where nobody could. inside: holds while compiled code runs.
    """

    channels: Channels | None = None

    def __init__(self, graph: Graph):
        """Lay the graph out in memory; compiles components that are not in the cache."""
        self.graph = graph
        self.memory = lay_out(graph)
        self.events = EventClock(graph, self.memory)
        self.block = block_ticks(graph.base_ns)
        self.fired: list[Firing] = []
        self._tables = self.memory.tables
        self.remarks: list[tuple[int, str]] = []  # (simulated time [ns], what happened to a host)
        self.tell: Callable[[str], None] = lambda _: None
        self.poll: Callable[[], None] = lambda: None
        self.inside: Callable[[], AbstractContextManager[None]] = nullcontext
        self.written = ""
        self._slice = 1
        loop.prepare(self._tables, self.memory.inits)

    @property
    def tick(self) -> int:
        """Ticks made since t0."""
        return int(self._tables.clock[TICK])

    @property
    def has_stopped(self) -> bool:
        """Whether a component stopped the run within a tick, which is half made."""
        return bool(self._tables.clock[STATUS])

    def time_ns(self, tick: int) -> int:
        """Simulated time [ns] at which a tick ends."""
        return self.graph.start_ns + tick * self.graph.base_ns

    def open(self) -> None:
        """Make ready whatever steps the graph; before initialise(), and after restore()."""

    def initialise(self) -> None:
        """Run every init at t0 and capture y(t0). Raises StepError."""
        with self.inside():
            loop.initialise(self._tables, self.memory.inits, len(self.graph.nodes), self.graph.start_ns)
        self._heed_messages()
        self._raise_if_stopped(self.graph.start_ns)

    def run(self, until: int, slice_ticks: Callable[[], int | None] = lambda: None) -> Iterator[None]:
        """Advance to tick `until` and yield after every slice, which never crosses a block end or an event.

        slice_ticks: asked before each slice, None for what suits the machine.

        The rows captured are there until the next slice. Raises StepError after yielding what led up to it.
        """
        while self.tick < until:
            self.fired = self.events.fire(self.tick)
            self._begin_rows()
            self._advance(min(until, self._next_stop(slice_ticks())))
            yield
            self._raise_if_stopped(self.time_ns(self.tick + 1))

    def captured(self) -> Iterator[tuple[int, np.ndarray]]:
        """(channel, rows) of the last slice: nodes first, then bonds; rows are (k, 1 + n), time bits first."""
        for channel, (start, length) in enumerate(zip(self.memory.row_starts, self.memory.row_lengths, strict=True)):
            end = self._tables.filled[channel]
            if end > start:
                yield channel, self._tables.capture[start:end].reshape(-1, length)

    def snapshot(self, chains: dict[str, str], ranges: dict[str, dict[str, float]]) -> Snapshot:
        """The run at this block end; chains: the digest's; ranges: the models' validity."""
        k = self._tables
        board = k.board[: self.graph.board]
        arrays = (self.memory.parameters, k.states, board, k.bond_energy.ravel())
        copies = (array.copy() for array in arrays)
        return Snapshot(self.tick, self.events.fired, chains, *copies, ranges=ranges, hosts=self._saved())

    def _saved(self) -> dict[str, bytes]:
        """States that are not in x, of those hosts that can save them. Raises StepError."""
        names = [node.name for node in self.graph.nodes]
        saved: dict[str, bytes] = {}
        for i, host in self.memory.fmus.items():
            try:
                if host.can_save:
                    saved[names[i]] = host.save()
            except TowlineError as error:
                text = f"{names[i]} cannot save its state at t = {self.time_ns(self.tick) / 1e9:.9g} s: {error}"
                raise StepError(text) from error
        return saved

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot of the same graph. Raises StepError where an FMU does not take its state back."""
        self._restore_arrays(snapshot)
        for i, host in self.memory.fmus.items():
            name = self.graph.nodes[i].name
            try:
                if name in snapshot.hosts:
                    host.restore(snapshot.hosts[name])
            except TowlineError as error:
                raise StepError(f"{name} does not take its saved state: {error}") from error

    def adopt(self, i: int, host: FmuHost) -> None:
        """Go on with a host of node i that another memory has led to the present tick."""
        span = self.memory.spans
        k = self._tables
        arrays = (self.memory.parameters, k.inputs, k.states, k.board, self.memory.workspace)
        host.move([array[span[v][i]] for array, v in zip(arrays, "puxyw", strict=True)])
        self.memory.hosts[i] = self.memory.entries[i] = host
        k.nodes[i, STEP], k.nodes[i, W] = host.step, host.workspace

    def _restore_arrays(self, snapshot: Snapshot) -> None:
        k = self._tables
        self.events.fast_forward(snapshot.fired)
        self.memory.parameters[:] = snapshot.parameters
        k.states[:] = snapshot.states
        k.board[: self.graph.board] = snapshot.board
        k.bond_energy[:] = snapshot.bond_energy.reshape(k.bond_energy.shape)
        k.clock[TICK] = snapshot.tick
        self._begin_rows()

    def host_counts(self) -> dict[str, dict[str, int]]:
        """What happened to hosts; here there are none."""
        return {}

    def close(self) -> None:
        """Give up what the run holds beside memory."""
        self.memory.close()

    def bond_energies(self) -> dict[str, dict[str, float]]:
        """Residual and throughput [J] of every bond, and how many of its steps stayed beyond the tolerance."""
        names = {"residual_J": RESIDUAL, "throughput_J": THROUGHPUT, "unconverged": UNCONVERGED}
        rows = zip(self.graph.bonds, self._tables.bond_energy, strict=True)
        return {bond.name: {name: float(row[i]) for name, i in names.items()} for bond, row in rows}

    def _begin_rows(self) -> None:
        self._tables.filled[:] = self.memory.row_starts

    def _next_stop(self, slice_ticks: int | None) -> int:
        block_end = (self.tick // self.block + 1) * self.block
        slice_end = self.tick + min(slice_ticks or self._slice, self.memory.capture_ticks)
        event = self.events.next_tick()
        return min(block_end, slice_end, block_end if event is None else event)

    def _advance(self, until: int) -> None:
        """One slice; the next one's length follows from how long this one took, at most doubling."""
        before, began = self.tick, time.perf_counter()
        self._advance_to(until)
        took = max(time.perf_counter() - began, 1e-6)
        self._slice = max(1, min(2 * self._slice, int((self.tick - before) * SLICE_S / took)))

    def _advance_to(self, until: int) -> None:
        """Make the ticks up to `until`, fewer where a component stops the run."""
        with self.inside():
            loop.advance(self._tables, until, self.graph.start_ns, self.graph.base_ns)
        self._heed_messages()

    def _heed_messages(self) -> None:
        """Take in what FMUs have logged."""
        for i, host in self.memory.fmus.items():
            for text in host.take_messages():
                self.remarks.append((self.time_ns(self.tick), f"{self.graph.nodes[i].name}: {text}"))

    def _raise_if_stopped(self, t_ns: int) -> None:
        status, failed = (int(n) for n in self._tables.clock[STATUS:])
        if status == 0:
            return
        host = self.memory.hosts.get(failed)
        if host is not None and isinstance(host.error, KeyboardInterrupt):
            raise host.error
        node = self.graph.nodes[failed]
        reason = self._reason(failed, status)
        error = StepError(f"{node.name} stopped the run at t = {t_ns / 1e9:.9g} s: {reason}{self._inputs(failed)}")
        raise error from (host.error if host is not None else None)

    def _reason(self, failed: int, status: int) -> str:
        node = self.graph.nodes[failed]
        values = self._tables.board[self.memory.spans["y"][failed]][: numbers_in(node.outputs)]
        if status == NON_FINITE and not np.isfinite(values).all():
            return f"its output {_first_non_finite(node.outputs, values)} is not finite"
        if told := self._told(failed, status):
            return told
        return node.component.status_text.get(status, f"status {status}, which it does not explain")

    def _told(self, failed: int, status: int) -> str:
        """Why a component stopped the run, as its host tells; "" where it does not."""
        host = self.memory.hosts.get(failed)
        return host.reason(status) if host is not None else ""

    def _inputs(self, failed: int) -> str:
        """The numbers it had as inputs, shortened."""
        values = self._tables.inputs[self.memory.spans["u"][failed]]
        shown, at = [], 0
        for port in parted(self.graph.nodes[failed].inputs)[0]:
            numbers = values[at : at + port.size]
            text = ", ".join(f"{v:.9g}" for v in numbers[:SHOWN]) + (", ..." if port.size > SHOWN else "")
            shown.append(f"{port.name} = [{text}] {port.unit}" if port.shape else f"{port.name} = {text} {port.unit}")
            at += port.size
        return f" (inputs: {'; '.join(shown)})" if shown else ""


def _first_non_finite(ports: tuple[Port, ...], values: np.ndarray) -> str:
    at = 0
    for port in parted(ports)[0]:
        bad = np.flatnonzero(~np.isfinite(values[at : at + port.size]))
        if len(bad):
            index = "".join(f"[{i}]" for i in np.unravel_index(bad[0], port.shape)) if port.shape else ""
            return f"{port.name}{index}"
        at += port.size
    return "(none)"
