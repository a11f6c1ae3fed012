"""A long paced run over zenoh: do memory, threads and file descriptors of conductor and hosts stay as they were?

TOWLINE_SOAK_S: wall time to run for, half an hour unless set. A host is killed each minute.
"""

from __future__ import annotations

import os
import signal
import tempfile
import time
from pathlib import Path

import numpy as np
import psutil

from pipeline.hosts.deployment import BusOptions
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENARIO = Path(__file__).parents[2] / "scenarios" / "van_der_pol.yaml"
SOAK_S = float(os.environ.get("TOWLINE_SOAK_S", "1800"))
RATE = 0.2  # simulated seconds a second: 200 ticks of five round trips, which two busy cores can keep up
WARM = 0.2  # of the time: what is allocated by then is taken as the base
KILL_S = 60.0
PARTS = 10  # of the time, whose means are told
MIB = 1 << 20
Row = dict[str, str | float]


class _Watch:
    """Looks at all processes each second while the run goes on, and kills a host now and then."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.looked = self.killed = self.began
        self.kills = 0
        self.seen: list[tuple[float, dict[str, float]]] = []

    def __call__(self, _: float) -> None:
        now = time.monotonic()
        if now - self.looked >= 1.0:
            self.looked = now
            self.seen.append((now - self.began, _usage()))
        if now - self.killed >= KILL_S:
            self.killed = now
            hosts = [host for nursery in psutil.Process().children() for host in nursery.children()]
            os.kill(hosts[self.kills % len(hosts)].pid, signal.SIGKILL)
            self.kills += 1

    def growth(self, what: str) -> tuple[float, float]:
        """Mean over the time after warming up until its middle, and how much more over the rest."""
        after = [usage[what] for t, usage in self.seen if t > WARM * self.seen[-1][0]]
        first, last = after[: len(after) // 2], after[len(after) // 2 :]
        base = sum(first) / len(first)
        return base, sum(last) / len(last) - base

    def course(self, what: str) -> str:
        """Means over equal parts of the whole time, in order."""
        parts = np.array_split([usage[what] for _, usage in self.seen], PARTS)
        return " ".join(f"{np.mean(part):.4g}" for part in parts if len(part))


def _usage() -> dict[str, float]:
    """Of this process, and the sums over those below it."""
    found = {}
    me = psutil.Process()
    for name, processes in (("conductor", [me]), ("hosts", me.children(recursive=True))):
        sums = {"MiB": 0.0, "threads": 0.0, "descriptors": 0.0}
        for process in processes:
            try:
                with process.oneshot():
                    sums["MiB"] += process.memory_info().rss / MIB
                    sums["threads"] += process.num_threads()
                    sums["descriptors"] += process.num_fds()
            except psutil.NoSuchProcess:
                continue
        found |= {f"{name}, {what}": value for what, value in sums.items()}
    return found


def rows() -> list[Row]:
    """One row a quantity: its growth from the first to the second half after warming up."""
    scenario = load_scenario(SCENARIO, duration=f"{RATE * SOAK_S:.3f} s")
    graph = build_graph(scenario)
    with tempfile.TemporaryDirectory() as folder:
        local = run_scenario(scenario, graph, Path(folder) / "local.mcap", Options(), lambda _: None)
        watch = _Watch()
        result = run_scenario(scenario, graph, Path(folder) / "a.mcap", Options(bus=BusOptions(), rate=RATE), watch)
    shared = {
        "method": f"{SOAK_S:.0f} s, {watch.kills} kills",
        "reference": "the first half after warming up",
        "digest_equal": str(result.digest == local.digest),
        "missed_deadlines": result.deadlines["missed"],
    }
    found: list[Row] = []
    for what in watch.seen[0][1]:
        base, grown = watch.growth(what)
        course = watch.course(what)
        found.append({"case": what, "base": base, "error": grown, "error_unit": "growth", "course": course, **shared})
    return found
