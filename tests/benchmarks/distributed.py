"""Ticks a second over zenoh, against the number of processes and the payload, beside bare zenoh round trips."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue

import numpy as np
import zenoh

from pipeline.bus.socket import LocalSocket
from pipeline.bus.zenoh import configuration
from pipeline.hosts.deployment import BusOptions
from pipeline.hosts.launch import source_path
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

HERE = Path(__file__).parent
PROCESSES = (1, 2, 4, 8)
PAYLOADS = (100, 1_000, 10_000, 100_000)  # bytes each way
TICKS = 4000
TRIPS = 2000
HEADER_BYTES = 64  # about what a message has beside its payload
Row = dict[str, str | float]


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
            before, took = trips(), _Slices()
            result = run_scenario(scenario, graph, Path(folder) / "zenoh.mcap", Options(bus=BusOptions()), took)
            bare_us = 1e6 * (before + trips()) / 2
    trip_us = 1e6 * took.median_s(1e-3) / stages
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


class _Slices:
    """Notes simulated and wall time as a run tells its progress."""

    def __init__(self) -> None:
        self._seen: list[tuple[float, float]] = []

    def __call__(self, simulated_s: float) -> None:
        self._seen.append((simulated_s, time.perf_counter()))

    def median_s(self, step_s: float) -> float:
        """Wall time a tick: the median over slices, weighted by nothing, as a busy machine delays some of them."""
        simulated, wall = np.array(self._seen).T
        return float(np.median(np.diff(wall) / (np.diff(simulated) / step_s)))


@contextmanager
def bare_trips(size: int) -> Iterator[object]:
    """A function that gives the median time [s] of a round trip of so many bytes to another process."""
    socket = LocalSocket()
    session = zenoh.open(configuration([socket.endpoint], []))
    echo = subprocess.Popen(
        [sys.executable, "-P", __file__, socket.endpoint], env={**os.environ, "PYTHONPATH": source_path()}
    )
    try:
        back: SimpleQueue[bytes] = SimpleQueue()
        subscriber = session.declare_subscriber("bare/back", lambda sample: back.put(sample.payload.to_bytes()))
        publisher = session.declare_publisher(
            "bare/there", congestion_control=zenoh.CongestionControl.BLOCK, express=True
        )
        while not publisher.matching_status.matching:
            time.sleep(0.05)

        def median_s() -> float:
            times = []
            for _ in range(TRIPS):
                began = time.perf_counter()
                publisher.put(bytes(size))
                back.get(timeout=10.0)
                times.append(time.perf_counter() - began)
            return float(np.median(times))

        median_s()
        yield median_s
        subscriber.undeclare()
    finally:
        echo.kill()
        echo.wait()
        session.close()
        socket.remove()


def _echo(endpoint: str) -> None:
    session = zenoh.open(configuration([], [endpoint]))
    there: SimpleQueue[bytes] = SimpleQueue()
    session.declare_subscriber("bare/there", lambda sample: there.put(sample.payload.to_bytes()))
    publisher = session.declare_publisher("bare/back", congestion_control=zenoh.CongestionControl.BLOCK, express=True)
    while True:
        publisher.put(there.get())


if __name__ == "__main__":
    _echo(sys.argv[1])
