"""Ticks a second over zenoh, against the number of processes and the payload, beside bare zenoh round trips."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import zenoh
from zenoh.handlers import FifoChannel

from pipeline.bus.configuration import close_session, configuration, open_session
from pipeline.bus.socket import LocalSocket
from pipeline.hosts.deployment import BusOptions
from pipeline.hosts.launch import source_path
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

HERE = Path(__file__).parent
PROCESSES = (1, 2, 4, 8)
PAYLOADS = (100, 1_000, 10_000, 100_000)  # bytes each way
TICKS = 4000
TRIPS = 50  # after each slice
HEADER_BYTES = 64  # about what a message has beside its payload
Row = dict[str, str | float]
Trips = Callable[[int], list[float]]


def rows() -> list[Row]:
    """One row a case: ticks a second, time a round trip, and its ratio to a bare one measured before and after it."""
    found = [_row(f"{n} processes side by side", ring(n), 1, 16) for n in PROCESSES]
    found += [_row(f"{n} processes one after another", chain(n, 1), n, 16) for n in PROCESSES[1:]]
    found += [_row(f"2 processes one after another, {size} B", chain(2, size // 8), 2, size) for size in PAYLOADS]
    return found


def ring(n: int) -> str:
    """n components that read each other late: one stage of n sections."""
    return _scenario(n, 1, "{{from: c{before}.numbers, delay: true}}")


def chain(n: int, size: int) -> str:
    """n components, each reading the one before in the same tick, the first one the last one late: n stages."""
    return _scenario(n, size, "c{before}.numbers")


def _scenario(n: int, size: int, wire: str) -> str:
    late = "{{from: c{before}.numbers, delay: true}}"
    inputs = [(wire if i else late).format(before=(i or n) - 1) for i in range(n)]
    block = f"model: ./block.py, parameters: {{size: {size}}}, record: every {TICKS}"
    components = [f"  c{i}: {{{block}, inputs: {{numbers: {wired}}}}}" for i, wired in enumerate(inputs)]
    return "\n".join([f"duration: {TICKS} ms", "step: 1 ms", "scene: false", "components:", *components])


def _row(case: str, text: str, stages: int, payload: int) -> Row:
    scenario = load_scenario_text(text, "bench.yaml", HERE / "components")
    graph = build_graph(scenario)
    with tempfile.TemporaryDirectory() as folder:
        local = run_scenario(scenario, graph, Path(folder) / "local.mcap", Options(), lambda _: None)
        with bare_trips(payload + HEADER_BYTES) as trips:
            took = _Interleaved(trips)
            result = run_scenario(scenario, graph, Path(folder) / "zenoh.mcap", Options(bus=BusOptions()), took)
    bare_us, trip_us = took.usual_us(1e-3 / stages)
    return {
        "case": case,
        "method": "zenoh, unix socket",
        "error": float(result.digest != local.digest),
        "error_unit": "digests that differ",
        "reference": "the local run",
        "ticks_per_s": 1e6 / (trip_us * stages),
        "trip_us": trip_us,
        "bare_trip_us": bare_us,
        "ratio": trip_us / bare_us,
    }


class _Interleaved:
    """Between a run's slices, bare trips: both see the same machine."""

    def __init__(self, trips: Trips):
        self._trips = trips
        self._bare_s: list[float] = []
        self._slices: list[tuple[float, float]] = []  # simulated and wall time [s]
        self._simulated_s, self._began = 0.0, 0.0

    def __call__(self, simulated_s: float) -> None:
        """After a slice; the first one, in which the processes get warm, does not count."""
        now = time.perf_counter()
        if self._began:
            self._slices.append((simulated_s - self._simulated_s, now - self._began))
        self._bare_s.append(float(np.mean(self._trips(TRIPS))))
        self._simulated_s, self._began = simulated_s, time.perf_counter()

    def usual_us(self, round_s: float) -> tuple[float, float]:
        """Mean times of a bare trip and of one of the run's, each of which stands for round_s of simulated time.

        The lower quartile of batches and of slices: what else the machine does only ever adds.
        """
        simulated, wall = np.array(self._slices).T
        run_s = np.quantile(wall / simulated, 0.25) * round_s
        return 1e6 * float(np.quantile(self._bare_s, 0.25)), 1e6 * float(run_s)


@contextmanager
def bare_trips(size: int) -> Iterator[Trips]:
    """What makes round trips of so many bytes to another process and tells the time [s] of each.

    As zenoh does it fastest here: its runtime on one thread, the other process answering from its callback, this one
    waiting at a channel of zenoh's.
    """
    socket = LocalSocket()
    session = open_session(configuration([socket.endpoint], []))
    echo = subprocess.Popen(
        [sys.executable, "-P", __file__, socket.endpoint], env={**os.environ, "PYTHONPATH": source_path()}
    )
    try:
        back = session.declare_subscriber("bare/back", FifoChannel(16))
        publisher = session.declare_publisher(
            "bare/there", congestion_control=zenoh.CongestionControl.BLOCK, express=True
        )
        while not publisher.matching_status.matching:
            time.sleep(0.05)

        def trips(n: int) -> list[float]:
            times = []
            for _ in range(n):
                began = time.perf_counter()
                publisher.put(bytes(size))
                back.recv().payload.to_bytes()
                times.append(time.perf_counter() - began)
            return times

        trips(1000)
        yield trips
    finally:
        echo.kill()
        echo.wait()
        close_session(session)
        socket.remove()


def _echo(endpoint: str) -> None:
    session = open_session(configuration([], [endpoint]))
    publisher = session.declare_publisher("bare/back", congestion_control=zenoh.CongestionControl.BLOCK, express=True)
    session.declare_subscriber("bare/there", lambda sample: publisher.put(sample.payload.to_bytes()))
    signal.pause()


if __name__ == "__main__":
    _echo(sys.argv[1])
