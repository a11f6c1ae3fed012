"""One run of a scenario into one log: conductor, digest, recorder, snapshots and pacing brought together."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn, Self

import numpy as np

from pipeline import interrupts
from pipeline.conductor import BOND_PORTS, Conductor
from pipeline.coupling import refuse_unstable
from pipeline.digest import Digest
from pipeline.distributed import Distributed
from pipeline.errors import LogError, StepError
from pipeline.events import Firing
from pipeline.graph import Graph
from pipeline.hosts.deployment import BusOptions, OnZenoh
from pipeline.hosts.fmu.base import FmuHost
from pipeline.keyboard import Keys
from pipeline.log.conventions import COMPLETE, ENDING, RESULT, SPEED
from pipeline.log.recorder import CHUNK_BYTES, COMPRESSION, Audience, ChannelSpec, Recorder
from pipeline.pacing import Pacing
from pipeline.placement import placement_of
from pipeline.provenance import RUN, model_files, provenance, small_fmus
from pipeline.scenario import Scenario
from pipeline.snapshot import Snapshot
from pipeline.validity_range import Ranges
from pipeline.watch import Watch

FLUSH_S = 1.0  # wall time between flushes, each with a snapshot before it
SCENARIO = "scenario.yaml"  # the log's attachment

Progress = Callable[[float], None]


def leave(text: str) -> NoReturn:
    """End this process, whose main thread is held up."""
    print(f"towline: {text}", file=sys.stderr, flush=True)
    os._exit(1)


@dataclass(frozen=True)
class Options:
    """How a run is recorded and paced; nothing here changes its digest.

    rate: simulated seconds per second of wall time, None for as fast as it goes. slice_ticks: ticks handed over at
    once, None for what suits the machine. bus: on which components run elsewhere, None for this process. tell: takes
    lines about hosts as they come. keys: by which a person pauses the run. leave: ends the process, with an error.
    audience: takes every message as it is recorded, beside who subscribes on the bus.
    """

    compression: str = COMPRESSION
    chunk_bytes: int = CHUNK_BYTES
    scene: bool = True
    rate: float | None = None
    slice_ticks: int | None = None
    overwrite: bool = False
    bus: BusOptions | None = None
    tell: Callable[[str], None] = lambda _: None
    keys: Keys | None = None
    leave: Callable[[str], NoReturn] = leave
    audience: Audience | None = None


@dataclass(frozen=True)
class Result:
    """What a run left behind.

    bonds: {name: {residual_J, throughput_J, unconverged}}; validity: see validity_range.Ranges.summary.
    hosts: {name: {restarts, late, refused}}, empty where all ran in one process. deadlines: {missed, worst_s} of a
    paced run.
    """

    log: str
    simulated_s: float
    wall_s: float
    real_time_factor: float
    steps: int
    digest: str
    channels: dict[str, dict[str, int]]
    bonds: dict[str, dict[str, float]]
    validity: dict[str, dict[str, float]]
    hosts: dict[str, dict[str, int]]
    deadlines: dict[str, float]


def conductor_of(scenario: Scenario, graph: Graph, options: Options) -> Conductor:
    """What steps the graph: here, or on hosts over a bus."""
    if options.bus is None:
        return Conductor(graph)
    overdue_s = {one.name: one.overdue_ns / 1e9 for one in scenario.instances if one.overdue_ns}
    conductor = Distributed(graph, placement_of(graph, scenario.hosts, overdue_s), OnZenoh(options.bus))
    conductor.tell = options.tell
    return conductor


def channels(graph: Graph) -> list[ChannelSpec]:
    """The log's channels in the conductor's order: one a component, then one a bond."""
    nodes = [
        ChannelSpec(
            node.name,
            node.outputs,
            {"kind": "component", "model": node.model, "record_every": str(node.record_every)},
        )
        for node in graph.nodes
    ]
    return nodes + [ChannelSpec(f"bond/{bond.name}", BOND_PORTS, {"kind": "bond"}) for bond in graph.bonds]


class Run:
    """A run in progress; a context manager that leaves a whole log, or one that says it is not whole."""

    def __init__(self, scenario: Scenario, graph: Graph, out: Path | None, options: Options):
        """Compile what is not cached and open the log; without `out` it is given a name of its own in logs/.

        Raises WiringError for a coupling that would be unstable, LogError if the log cannot be written.
        """
        refuse_unstable(graph, scenario.source)
        self.graph = graph
        self.conductor = conductor_of(scenario, graph, options)
        self.digest = Digest([node.name for node in graph.nodes])
        self._ranges = Ranges(graph)
        self._options = options
        self.pacing = Pacing(options.rate, options.keys, graph.base_ns, options.tell)
        self._steps = np.zeros(len(graph.nodes) + len(graph.bonds), np.int64)
        self._every = np.array([node.record_every for node in graph.nodes] + [1] * len(graph.bonds), np.int64)
        self.recorded = np.zeros_like(self._steps)
        self._flushed = self._noted = time.monotonic()
        self._has_started = False
        self._went: tuple[int, float] | None = None  # the tick and the wall time at which it began to go
        hosts = () if isinstance(self.conductor, Distributed) else self.conductor.memory.fmus.values()
        self._watch = Watch([host for host in hosts if not host.component.isolate], self._give_up)
        self.conductor.inside = self._watch.inside
        try:
            self._recorder = self._create(scenario, out)
        except BaseException:
            self.conductor.close()
            raise

    def _create(self, scenario: Scenario, out: Path | None) -> Recorder:
        path, options = out or default_log(scenario.name), self._options
        try:
            return Recorder(
                path,
                channels(self.graph),
                attachments=self._attachments(scenario),
                metadata={RUN: provenance(scenario, self.graph, self.conductor.block)},
                compression=options.compression,
                chunk_bytes=options.chunk_bytes,
                scene_period_ns=scenario.scene_ns if options.scene else None,
                overwrite=options.overwrite,
            )
        except LogError:
            if out is None and default_log(scenario.name) != path:  # another run took the name in between
                return self._create(scenario, None)
            raise

    def _attachments(self, scenario: Scenario) -> dict[str, bytes]:
        text = scenario.resolved_text().encode()
        return {SCENARIO: text, **model_files(self.graph), **small_fmus(self.graph)}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        """A run that ends, stops itself or is interrupted closes its log; any other failure leaves it unfinished."""
        with interrupts.held():
            self._watch.end()
            try:
                self._end(kind, error)
            finally:
                self.conductor.close()
                for line in self.conductor.written.splitlines():
                    self._options.tell(line)

    def _end(self, kind: type[BaseException] | None, error: BaseException | None) -> None:
        if kind is None:
            self._close(COMPLETE)
        elif issubclass(kind, StepError):
            self._close(str(error))
        elif issubclass(kind, KeyboardInterrupt):
            with suppress(LogError):  # a second interrupt may have fallen into a write, which ends the log there
                self._close("interrupted")
        else:
            self._recorder.abort()

    def _give_up(self, host: FmuHost, waited_s: float) -> None:
        """Close the log in place of the main thread, which an FMU holds up, and end the process."""
        conductor = self.conductor
        t_s = conductor.time_ns(conductor.tick + self._has_started) / 1e9
        what = "step" if self._has_started else "initialization"
        text = f"{host.name} stopped the run at t = {t_s:.9g} s: {host.file} has not returned from its {what} for"
        remedy = "a call that takes longer needs `overdue:`; isolate: true ends the FMU alone"
        text = f"{text} {waited_s:g} s; {remedy}"
        try:
            self._hand_over()
            self._close(text)
        finally:
            for other in conductor.memory.fmus.values():
                other.abandon()
            self._options.leave(text)

    def open(self) -> None:
        """Have all hosts ready, if there are any, and channels on their bus. Raises HostError."""
        interrupts.raise_if_lost()
        self.conductor.open()
        for audience in (self.conductor.channels, self._options.audience):
            if audience is not None:
                self._recorder.publish(audience)

    def start(self) -> None:
        """Initialise every component at t0, which is a block of its own, and make the first snapshot."""
        self.conductor.initialise()
        self._has_started = True
        with interrupts.held() as raise_if_interrupted:
            self._hand_over()
            self.digest.end_block()
            self._snapshot()
            raise_if_interrupted()

    def resume(self, snapshot: Snapshot, lead: Callable[[], None] = lambda: None) -> None:
        """Go on from a snapshot, and note it; the caller has copied the rows up to it. Raises HostError.

        lead: brings to the snapshot what is not in it.
        """
        self._has_started = True
        self.conductor.restore(snapshot)
        lead()
        self.open()
        self.digest = Digest([node.name for node in self.graph.nodes], snapshot.chains)
        self._ranges = Ranges(self.graph, snapshot.ranges)
        periods = [node.period for node in self.graph.nodes] + [
            self.graph.nodes[b.body].period for b in self.graph.bonds
        ]
        self._steps[:] = snapshot.tick // np.array(periods, np.int64) + 1
        self._steps[len(self.graph.nodes) :] -= 1  # bonds have no row at t0
        self._snapshot()

    def copy(self, channel: int, rows: np.ndarray) -> None:
        """Put rows that another log holds into this one."""
        self.recorded[channel] += len(rows)
        self._recorder.rows(channel, rows)

    def copy_image(self, topic: str, t_ns: int, payload: bytes) -> None:
        """Put an image that another log holds into this one."""
        self._recorder.image(topic, t_ns, payload)

    def copy_event(self, t_ns: int, text: str) -> None:
        """Put an event that another log holds into this one."""
        self._recorder.event(t_ns, text)

    def go(self, until: int, progress: Progress) -> None:
        """Run to tick `until`, calling progress(simulated seconds) after each slice. Raises StepError."""
        interrupts.raise_if_lost()
        self.pacing.begin(self.conductor.tick)
        self._went = self._went or (self.conductor.tick, time.monotonic())
        with interrupts.held() as raise_if_interrupted:
            self.conductor.poll = raise_if_interrupted
            for _ in self.conductor.run(until, lambda: self.pacing.slice_ticks or self._options.slice_ticks):
                self._hand_over()
                self._end_slice()
                progress(self._seconds(self.conductor.tick))
                raise_if_interrupted()
                self.pacing.wait(self.conductor.tick, raise_if_interrupted)

    def result(self, wall_s: float, since: int = 0) -> Result:
        """Summary of the run, or of its part since a tick."""
        simulated = self._seconds(self.conductor.tick)
        names = [spec.name for spec in channels(self.graph)]
        return Result(
            log=str(self._recorder.path),
            simulated_s=simulated,
            wall_s=wall_s,
            real_time_factor=(simulated - self._seconds(since)) / max(wall_s, 1e-9),
            steps=int(self._steps[: len(self.graph.nodes)].sum()) - len(self.graph.nodes),
            digest=self.digest.total(),
            channels={name: {"messages": int(n)} for name, n in zip(names, self.recorded, strict=True) if n},
            bonds=self.conductor.bond_energies(),
            validity=self._ranges.summary(),
            hosts=self.conductor.host_counts(),
            deadlines={"missed": self.pacing.missed, "worst_s": self.pacing.worst_s} if self._options.rate else {},
        )

    def _seconds(self, tick: int) -> float:
        return tick * self.graph.base_ns / 1e9

    def _end_slice(self) -> None:
        """Close the digest's block at its end, and each second write out what there is, with a snapshot if possible.

        A component that stops the run in a block's first tick leaves the clock at the end of the block before, which
        is closed already, and the state is no longer that of there.
        """
        at_block_end = self.conductor.tick % self.conductor.block == 0 and not self.conductor.has_stopped
        if at_block_end:
            self.digest.end_block()
        now = time.monotonic()
        if at_block_end and now - self._noted >= FLUSH_S:
            self._snapshot()
        elif now - self._flushed >= FLUSH_S:
            self._recorder.flush()
            self._flushed = now

    def _hand_over(self) -> None:
        """Captured rows to the digest, every one of them, and to the recorder, those that are to be recorded."""
        for firing in self.conductor.fired:
            self._recorder.event(self.conductor.time_ns(firing.tick), _event_text(firing))
        self.conductor.fired = []
        self._record_remarks()
        for channel, rows in self.conductor.captured():
            if channel < len(self.graph.nodes):
                self.digest.update(self.graph.nodes[channel].name, rows)
                self._ranges.update(channel, rows)
            every = self._every[channel]
            if every:
                kept = rows[-self._steps[channel] % every :: every]
                self._recorder.rows(channel, np.ascontiguousarray(kept))
                self.recorded[channel] += len(kept)
            self._steps[channel] += len(rows)

    def _record_remarks(self) -> None:
        for t_ns, text in self.conductor.remarks:
            self._recorder.event(t_ns, text)
        self.conductor.remarks.clear()

    def _snapshot(self) -> None:
        state = self.conductor.snapshot(self.digest.chains(), self._ranges.kept()).to_bytes()
        self._recorder.snapshot(self.conductor.time_ns(self.conductor.tick), state)
        self._recorder.flush()
        self._flushed = self._noted = time.monotonic()

    def _close(self, ending: str) -> None:
        tick = self.conductor.tick
        self._record_remarks()
        told = {"digest": self.digest.total(), ENDING: ending, "ticks": str(tick)} | self._speed(tick)
        self._recorder.add_metadata(RESULT, told)
        self._recorder.close()

    def _speed(self, tick: int) -> dict[str, str]:
        """Of this run, or of its part since it was resumed."""
        if self._went is None or tick == self._went[0]:
            return {}
        since, began = self._went
        return {SPEED: f"{self._seconds(tick - since) / max(time.monotonic() - began, 1e-9):.4g}"}


def _event_text(firing: Firing) -> str:
    return f"{firing.event.text} ends" if firing.ends else firing.event.text


def run_scenario(scenario: Scenario, graph: Graph, out: Path | None, options: Options, progress: Progress) -> Result:
    """Run a scenario from t0 to its end into a new log, which without `out` gets a name in logs/.

    Raises StepError, WiringError, LogError.
    """
    with Run(scenario, graph, out, options) as run:
        run.open()
        began = time.monotonic()
        run.start()
        run.go(graph.ticks, progress)
        wall = time.monotonic() - began
    return run.result(wall)


def default_log(name: str) -> Path:
    """logs/NAME-DATE-TIME.mcap below the working folder, a number added where that exists."""
    stem = f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    for number in range(1000):
        path = Path("logs") / f"{stem}{f'-{number}' if number else ''}.mcap"
        if not path.exists():
            return path
    raise LogError(f"logs/ holds a thousand logs named {stem}; give another name with --out")
