"""The conductor of a distributed run: the same loop, its sections stepped by hosts over a bus."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from pipeline import interrupts
from pipeline.bus.messages import INITIALISE, STEP, STOPPED
from pipeline.conductor import Conductor
from pipeline.errors import HostError
from pipeline.graph import Graph, execution_order
from pipeline.hosts.assignment import to_json
from pipeline.hosts.deployment import Deployment
from pipeline.hosts.lengths import lengths, pack_saved, unpack_saved
from pipeline.hosts.supervisor import Host, Hosts
from pipeline.loop_tables import BOND_ROW, BOND_STATE, FAILED, OFFSET_ON, STATUS, TICK
from pipeline.placement import Placement
from pipeline.recovery import Link
from pipeline.sections import Section, cut
from pipeline.snapshot import Snapshot


class _Numbers:
    """Some places of a float64 array, read and written as bytes."""

    def __init__(self, array: np.ndarray, places: np.ndarray):
        """places: (n,) indices."""
        places = places.astype(np.int64)
        first, n = int(places[0]) if len(places) else 0, len(places)
        self.bytes = 8 * n
        if np.array_equal(places, np.arange(first, first + n)):  # as nearly always: a piece of memory
            piece = array[first : first + n].data.cast("B") if n else memoryview(bytearray())
            self.read, self.write = piece.tobytes, lambda data: piece.__setitem__(slice(None), data)
        else:
            self.read = lambda: array[places].tobytes()
            self.write = lambda data: array.__setitem__(places, np.frombuffer(data))


@dataclass(frozen=True)
class _Part:
    """A section's places in the conductor's memory, and what its settings are made of."""

    link: Link
    outside: _Numbers
    signals: _Numbers
    states: _Numbers
    inputs: _Numbers
    settings: tuple[_Numbers, _Numbers, np.ndarray]  # parameters, offsets, nodes


class Distributed(Conductor):
    """One run of a graph on other processes. Memory holds the board, parameters and rows; states come with replies."""

    def __init__(self, graph: Graph, placement: Placement, deployment: Deployment):
        """Compile everything; hosts are started by open(). Raises HostError."""
        sections = cut(graph, placement.hosts)
        self._assignments = {one.host: to_json(s for s in sections if s.host == one.host) for one in sections}
        if set(placement.hosts) - set(placement.limits_s):
            deployment.prepare()
        self._deployment = deployment
        try:
            super().__init__(graph)
        except BaseException:
            deployment.close()
            raise
        self._run = secrets.randbits(64)
        self._parts = [self._part(section) for section in sections]
        self._stages = [list(parts) for _, parts in groupby(self._parts, key=lambda part: part.link.section.stage)]
        self._are_due_always = all(part.link.section.is_due_always for part in self._parts)
        self._delayed_to, self._delayed_from = (_Numbers(self._tables.board, self._delayed(i)) for i in (0, 1))
        self._groups = execution_order(graph)
        self._rows = self._row_plan()
        self._bond_rows = np.zeros((len(graph.bonds), BOND_ROW))
        self._hosts: Hosts | None = None
        self._placement = placement
        self._error: HostError | None = None
        self._said = ""
        self._uncaptured: tuple[int, int] | None = None  # a tick, and the first group in the order that did not step
        self._counts: dict[str, dict[str, int]] = {}

    def _delayed(self, column: int) -> np.ndarray:
        """Places on the board that delayed copies are made to (0) or from (1)."""
        return np.concatenate([[], *(np.arange(row[column], row[column] + row[2]) for row in self._tables.delayed)])

    def _part(self, section: Section) -> _Part:
        k, nodes = self._tables, section.nodes
        signals, states, inputs, parameters = (_places(self.memory.spans[v], nodes) for v in "yxup")
        sizes = lengths(self.memory, nodes, len(section.bonds), len(section.outside))
        settings = _Numbers(self.memory.parameters, parameters), _Numbers(k.added, signals), np.array(nodes)
        return _Part(
            link=Link(section, sizes, self._settings(settings)),
            outside=_Numbers(k.board, section.outside),
            signals=_Numbers(k.board, signals),
            states=_Numbers(k.states, states),
            inputs=_Numbers(k.inputs, inputs),
            settings=settings,
        )

    def _settings(self, of: tuple[_Numbers, _Numbers, np.ndarray]) -> bytes:
        """Parameters and offsets of a section, as events left them."""
        parameters, offsets, nodes = of
        switches = self._tables.nodes[nodes, OFFSET_ON].astype(np.float64)
        return parameters.read() + offsets.read() + switches.tobytes()

    def initialise(self) -> None:
        """Run every init at t0 and capture y(t0). Raises StepError."""
        self._make(0, INITIALISE, self._stages)
        self._catch_up()
        self._raise_if_stopped(self.graph.start_ns)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot of the same graph, by hosts that are not started yet."""
        self._restore_arrays(snapshot)
        k = self._tables
        for part in self._parts:
            section = part.link.section
            energies = k.bond_energy[list(section.bonds)]
            settings = self._settings(part.settings)
            saved = pack_saved(snapshot.hosts[name] for name in part.link.saving)
            part.link.begin_at(part.signals.read(), energies.tobytes(), part.states.read(), saved, settings)

    def snapshot(self, chains: dict[str, str], ranges: dict[str, dict[str, float]]) -> Snapshot:
        """The run at this block end, where every section's last reply brought its state."""
        for part in self._parts:
            part.states.write(part.link.snapshot[2])
        return super().snapshot(chains, ranges)

    def _saved(self) -> dict[str, bytes]:
        found: dict[str, bytes] = {}
        for part in self._parts:
            found |= zip(part.link.saving, unpack_saved(part.link.snapshot[3]), strict=True)
        return found

    def host_counts(self) -> dict[str, dict[str, int]]:
        """{host: {restarts, late, refused}}."""
        return self._hosts.counts() if self._hosts else self._counts

    def close(self) -> None:
        """End all hosts."""
        hosts, self._hosts = self._hosts, None
        if hosts is not None:
            self._counts = hosts.counts()
            self.written = hosts.close()
        else:
            self._deployment.close()
        for part in self._parts:
            part.link.close()
        self.memory.close()

    def open(self) -> None:
        """Start the hosts, and wait until all are ready. Raises HostError."""
        hosts = [self._host(name) for name in self._assignments]
        with interrupts.held() as raise_if_interrupted:  # an open session keeps the process from ending
            bus = self._deployment.open(self._run)
            self._hosts = Hosts(self._run, hosts, bus, self._deployment, self._note, lambda: self.poll())
            raise_if_interrupted()
        self.channels = bus.channels
        self._hosts.start()

    def _host(self, name: str) -> Host:
        links = [part.link for part in self._parts if part.link.section.host == name]
        overdue_s = {
            link.section.number: max(self._placement.overdue_s[i] for i in link.section.nodes) for link in links
        }
        return Host(name, links, self._assignments[name], overdue_s, self._placement.limits_s.get(name))

    def _advance_to(self, until: int) -> None:
        """Tick by tick to `until`; returns early where a component or a host stops the run, or at an interrupt."""
        began = self.tick
        self._change()
        try:
            while self.tick < until and self._step():
                pass
        except KeyboardInterrupt:
            if self.tick == began:
                raise
        except HostError as error:
            self._error = error
        finally:
            self._catch_up()

    def _change(self) -> None:
        """Tell the sections what events changed."""
        if self.fired:
            for part in self._parts:
                part.link.change(self._settings(part.settings))

    def _step(self) -> bool:
        """One tick; False where a component stopped the run."""
        k, tick = self._tables, self.tick + 1
        self._delayed_to.write(self._delayed_from.read())
        if not self._make(tick, STEP, self._due(tick)):
            return False
        k.clock[TICK] = tick
        return True

    def _due(self, tick: int) -> list[list[_Part]]:
        """The sections of each stage that are due in a tick."""
        if self._are_due_always:
            return self._stages
        return [[part for part in stage if part.link.section.is_due(tick)] for stage in self._stages]

    def _make(self, tick: int, kind: int, stages: Sequence[Sequence[_Part]]) -> bool:
        """Have sections stepped stage by stage and capture their outputs; False where a component stopped the run.

        Then the stages that follow are made all the same, so that what comes before it in order is there.
        """
        stopped: list[tuple[int, int, int, str]] = []
        for parts in stages:
            self._ask(tick, kind, parts)
            stopped += [found for part in parts if (found := self._take(part)) is not None]
        first = min(stopped, default=None)
        self._uncaptured = tick, len(self._groups) if first is None else first[0]
        if first is not None:
            _, self._tables.clock[STATUS], self._tables.clock[FAILED], self._said = first
        return first is None

    def _ask(self, tick: int, kind: int, parts: Sequence[_Part]) -> None:
        """Send the sections of a stage their inputs, and wait for all replies. Raises HostError."""
        assert self._hosts is not None
        block_end = -(-tick // self.block) * self.block
        sections = [part.link.section for part in parts]
        requests = [
            (section.number, part.outside.read(), kind == INITIALISE or section.next_due(tick) > block_end)
            for section, part in zip(sections, parts, strict=True)
        ]
        self._hosts.ask(kind, requests, self.time_ns(tick), self._catch_up)

    def _take(self, part: _Part) -> tuple[int, int, int, str] | None:
        """Put a reply on the board; (place in order, status, node, what it raised) where a node stopped the run."""
        reply, section = part.link.reply, part.link.section
        assert reply is not None
        part.signals.write(reply.numbers[: part.signals.bytes])
        if section.bonds:
            self._take_bonds(part, reply.values)
        if not reply.flags & STOPPED:
            return None
        part.inputs.write(reply.numbers[len(reply.numbers) - part.inputs.bytes :])
        node, text = section.nodes[reply.failed], reply.text.decode(errors="replace")
        return next(i for i, group in enumerate(self._groups) if node in group), reply.status, node, text

    def _take_bonds(self, part: _Part, numbers: np.ndarray) -> None:
        """Captured rows and energies of a section's bonds, which follow its signals."""
        sizes, bonds = part.link.lengths, list(part.link.section.bonds)
        rows, energies = numbers[sizes.signals :][: sizes.rows], numbers[sizes.signals + sizes.rows :]
        self._bond_rows[bonds] = rows.reshape(-1, BOND_ROW)
        self._tables.bond_energy[bonds] = energies[: sizes.energies].reshape(-1, BOND_STATE)

    def _catch_up(self) -> None:
        """Append what the last tick's groups have stepped to the captured rows, while the hosts are at work."""
        if self._uncaptured is not None:
            tick, end = self._uncaptured
            self._capture(tick, end)
            self._uncaptured = None

    def _capture(self, tick: int, end: int) -> None:
        """Append what the groups before `end` in the order have stepped."""
        k, t_ns, first = self._tables, self.time_ns(tick), tick == 0
        for period, nodes, bonds in self._rows[:end]:
            if tick % period:
                continue
            for channel, start, width in nodes:
                at = k.filled[channel]
                k.capture_ns[at] = t_ns
                k.capture[at + 1 : at + 1 + width] = k.board[start : start + width]
                k.filled[channel] = at + 1 + width
            for channel, bond in () if first else bonds:
                at = k.filled[channel]
                k.capture_ns[at] = t_ns
                k.capture[at + 1 : at + 1 + BOND_ROW] = self._bond_rows[bond]
                k.filled[channel] = at + 1 + BOND_ROW

    def _row_plan(self) -> list[tuple[int, list[tuple[int, int, int]], list[tuple[int, int]]]]:
        """Of each group in order: its period, (channel, start, width) of its nodes, (channel, bond) of its bonds."""
        graph = self.graph
        return [
            (
                graph.nodes[group[0]].period,
                [(i, graph.nodes[i].start, graph.nodes[i].width) for i in group],
                [(len(graph.nodes) + j, j) for j, bond in enumerate(graph.bonds) if bond.line in group],
            )
            for group in self._groups
        ]

    def _note(self, text: str) -> None:
        """Something about a host, for the log and whoever watches."""
        self.remarks.append((self.time_ns(self.tick), text))
        self.tell(text)

    @property
    def has_stopped(self) -> bool:
        """As Conductor's; or a host failed."""
        return self._error is not None or super().has_stopped

    def _raise_if_stopped(self, t_ns: int) -> None:
        if self._error is not None:
            raise self._error
        super()._raise_if_stopped(t_ns)

    def _told(self, failed: int, status: int) -> str:
        return self._said


def _places(spans: Sequence[slice], nodes: Sequence[int]) -> np.ndarray:
    """Indices of some nodes' vectors in the array of all."""
    return np.concatenate([np.arange(spans[i].start, spans[i].stop) for i in nodes])
