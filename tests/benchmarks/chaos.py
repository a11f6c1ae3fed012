"""Runs over zenoh whose processes are killed and stopped at random moments: do they end, with the local run's bits?"""

from __future__ import annotations

import os
import random
import signal
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import psutil

from pipeline.graph import Graph
from pipeline.hosts.deployment import BusOptions
from pipeline.placement import Hosts
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph
from pipeline.written import Scenario

FOLDER = Path(__file__).parents[2] / "scenarios"
SEED = 20221122
RUNS, STRIKES = 20, 50  # at least
LONGEST_S = 0.6  # wall time between strikes
WHILE_RECOVERING = 3  # strikes at most until the run has gone on; five on one host would be taken for a crash loop
STOPS = 0.2  # of strikes: SIGSTOP, as a process that hangs; each costs the second after which it is overdue
NURSERY = 0.05  # of strikes: the process that forks hosts, with which all of them die
# (scenario, simulated time, hosts): one process each, and two groups.
CASES = (
    ("pool_chain", "10 s", {}),
    ("bond_mass", "10 s", {}),
    ("pool_chain", "10 s", {"wall": "p", "hand": "q", "tether": "p", "markers": "q"}),
)
Row = dict[str, str | float]


@dataclass(frozen=True)
class Outcome:
    """Of one run: strikes by kind, whether the digest is the undisturbed run's, what was left behind, wall time."""

    strikes: Counter[str]
    is_equal: bool
    left_behind: int
    wall_s: float


def rows() -> list[Row]:
    """One row a case; the error is the number of runs that differ or leave something behind."""
    dice = random.Random(SEED)
    found: list[Outcome] = []
    while len(found) < RUNS or sum(outcome.strikes.total() for outcome in found) < STRIKES:
        found.append(disturbed(*CASES[len(found) % len(CASES)], dice))
    return [_row(case, found[i :: len(CASES)]) for i, case in enumerate(CASES)]


def _row(case: tuple[str, str, dict[str, str]], outcomes: list[Outcome]) -> Row:
    name, duration, hosts = case
    strikes = sum((outcome.strikes for outcome in outcomes), Counter[str]())
    return {
        "case": f"{name}, {duration}, {'two groups' if hosts else 'one process each'}",
        "method": f"random strikes, seed {SEED}",
        "error": float(sum(not outcome.is_equal for outcome in outcomes)),
        "error_unit": "runs whose digest differs",
        "reference": "the undisturbed local run",
        "runs": len(outcomes),
        **{kind: strikes[kind] for kind in ("kill", "stop", "nursery")},
        "left_behind": sum(outcome.left_behind for outcome in outcomes),
        "wall_s": sum(outcome.wall_s for outcome in outcomes),
    }


def disturbed(name: str, duration: str, hosts: dict[str, str], dice: random.Random) -> Outcome:
    """One run of a scenario under strikes, compared with the undisturbed local one."""
    scenario = replace(load_scenario(FOLDER / f"{name}.yaml", duration=duration), hosts=Hosts(hosts))
    graph = build_graph(scenario)
    with tempfile.TemporaryDirectory() as folder:
        local = run_scenario(scenario, graph, Path(folder) / "local.mcap", Options(), lambda _: None)
        began = time.monotonic()
        digest, strikes = strike(scenario, graph, Path(folder) / "struck.mcap", dice)
        wall_s = time.monotonic() - began
    return Outcome(strikes, digest == local.digest, left_behind(), wall_s)


def strike(scenario: Scenario, graph: Graph, path: Path, dice: random.Random) -> tuple[str, Counter[str]]:
    """Run over zenoh under strikes from another thread; the digest, and strikes by kind."""
    strikes, is_over, goes_on = Counter[str](), threading.Event(), threading.Event()
    thread = threading.Thread(target=lambda: _strike_until(is_over, goes_on, strikes, dice))

    def begin(_: float) -> None:
        goes_on.set()
        if thread.ident is None:
            thread.start()

    try:
        result = run_scenario(scenario, graph, path, Options(bus=BusOptions()), begin)
    finally:
        is_over.set()
        if thread.ident is not None:
            thread.join()
    return result.digest, strikes


def _strike_until(
    is_over: threading.Event, goes_on: threading.Event, strikes: Counter[str], dice: random.Random
) -> None:
    """Strike at random times, also while the run recovers, but not for ever."""
    in_a_row = 0
    while not is_over.wait(dice.uniform(0.0, LONGEST_S)):
        in_a_row = 0 if goes_on.is_set() else in_a_row + 1
        goes_on.clear()
        if in_a_row >= WHILE_RECOVERING:
            continue
        chance = dice.random()
        kind = "nursery" if chance < NURSERY else "stop" if chance < NURSERY + STOPS else "kill"
        struck = nurseries() if kind == "nursery" else hosts_of(nurseries())
        if struck and _send(dice.choice(struck), signal.SIGSTOP if kind == "stop" else signal.SIGKILL):
            strikes[kind] += 1


def _send(process: psutil.Process, number: int) -> bool:
    """Whether the process was still there."""
    try:
        os.kill(process.pid, number)
    except ProcessLookupError:
        return False
    return True


def nurseries() -> list[psutil.Process]:
    """The processes that fork hosts, children of this one."""
    return [child for child in psutil.Process().children() if "pipeline.hosts.nursery" in _words(child)]


def hosts_of(parents: list[psutil.Process]) -> list[psutil.Process]:
    """Their children."""
    return _tolerant(lambda: [child for parent in parents for child in parent.children()])


def _words(process: psutil.Process) -> list[str]:
    return _tolerant(process.cmdline)


def _tolerant(ask: Callable[[], list]) -> list:
    try:
        return ask()
    except psutil.NoSuchProcess:
        return []


def left_behind() -> int:
    """Processes below this one, ports listened at, and sockets of its runs."""
    me = psutil.Process()
    sockets = list(Path(tempfile.gettempdir()).glob(f"towline-bus-{me.pid}-*"))
    ports = [connection for connection in me.net_connections() if connection.status == psutil.CONN_LISTEN]
    return len(me.children(recursive=True)) + len(ports) + len(sockets)
