"""Goes on with a run that was killed: rows up to the last snapshot are copied, the rest is computed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from heapq import merge
from operator import itemgetter
from pathlib import Path

import numpy as np

from pipeline.distributed import Distributed
from pipeline.errors import LogError
from pipeline.graph import Graph
from pipeline.log.conventions import COMPLETE, ENDING, RESULT
from pipeline.log.images import topic
from pipeline.log.reader import Log
from pipeline.log.recorder import pack_rows
from pipeline.replay import led_to
from pipeline.rerun import other_sources
from pipeline.run import Options, Progress, Result, Run, channels
from pipeline.scenario import Scenario
from pipeline.snapshot import Snapshot


def last_snapshot(log: Log) -> Snapshot:
    """The snapshot to go on from. Raises LogError if the run ended or the log holds none."""
    if log.metadata(RESULT).get(ENDING) == COMPLETE:
        raise LogError(f"{log.path}: the run is complete; there is nothing to resume")
    state = log.last_snapshot()
    if state is None:
        raise LogError(f"{log.path}: holds no run snapshot; run the scenario again")
    return Snapshot.from_bytes(state[1])


def _copy(log: Log, run: Run, graph: Graph, until_ns: int) -> None:
    """Rows, images and events up to a time, about in its order."""
    numbers = {spec.name: channel for channel, spec in enumerate(channels(graph)) if spec.name in log.channels}
    outputs = [(name, port.name) for name in numbers for port in log.channels[name].images]
    streams = [_rows(log, run, numbers, until_ns), *(_images(log, run, *output, until_ns) for output in outputs)]
    for _, copy in merge(*streams, key=itemgetter(0)):
        copy()
    for t_ns, text in log.events():
        if t_ns < until_ns:
            run.copy_event(t_ns, text)


def _rows(log: Log, run: Run, numbers: Mapping[str, int], until_ns: int) -> Iterator[tuple[int, Callable[[], None]]]:
    """What copies rows, chunk by chunk, after the time of the last one."""
    for name, times, values in log.parts(list(numbers)):
        kept = int(np.searchsorted(times, until_ns, side="right"))
        yield int(times.max(initial=-1)), partial(run.copy, numbers[name], pack_rows(times[:kept], values[:kept]))


def _images(log: Log, run: Run, name: str, port: str, until_ns: int) -> Iterator[tuple[int, Callable[[], None]]]:
    """What copies the images of an output, each at its time."""
    for t_ns, data in log.image_messages(name, port):
        if t_ns > until_ns:
            return
        yield t_ns, partial(run.copy_image, topic(name, port), t_ns, data)


def _lead_fmus(log: Log, run: Run, graph: Graph, snapshot: Snapshot) -> None:
    """Bring FMUs that cannot save their state to the snapshot, by all their inputs since t0. Raises LogError."""
    for i, host in run.conductor.memory.fmus.items():
        name = graph.nodes[i].name
        if host.can_save:
            continue
        if isinstance(run.conductor, Distributed):
            text = f"the FMU of {name} cannot save its state, which is computed anew in this process only"
            raise LogError(f"{log.path}: {text}; resume with --bus local")
        run.conductor.adopt(i, led_to(log, graph, i, snapshot.tick))


def resume_run(log: Log, scenario: Scenario, graph: Graph, out: Path, options: Options, progress: Progress) -> Result:
    """Run from the log's last snapshot to the end of its scenario into a new, whole log.

    Every part of the run is in the snapshot, so channels recorded at a lower rate do not stand in the way; except for
    FMUs that cannot save their state, which need all their inputs.
    Raises LogError, also where the components here are not those that made the log, and StepError.
    """
    snapshot = last_snapshot(log)
    if out.exists() and out.samefile(log.path):
        raise LogError(
            f"{out} is the log to resume from, which is read while the new one is written; give another name"
        )
    warning = other_sources(log)
    if warning:
        raise LogError(f"{warning}; check out those sources, or run the scenario again")
    with Run(scenario, graph, out, options) as run:
        began = time.monotonic()
        _copy(log, run, graph, run.conductor.time_ns(snapshot.tick))
        run.resume(snapshot, lambda: _lead_fmus(log, run, graph, snapshot))
        run.go(graph.ticks, progress)
        wall = time.monotonic() - began
    return run.result(wall, since=snapshot.tick)
