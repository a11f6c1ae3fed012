"""Every scene on other processes over zenoh has the local run's bits: its digest, without tolerance."""

from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from pipeline.diff import diff_logs
from pipeline.hosts.deployment import BusOptions
from pipeline.hosts.launch import Nursery
from pipeline.log.reader import open_log
from pipeline.placement import Hosts
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENARIOS = {path.stem: path for path in sorted((Path(__file__).parents[2] / "scenarios").glob("*.yaml"))}
# 200 to 800 ticks, events included; others 5 s.
RISERS = ("riser_blind", "riser_tank", "riser_unforced")
UNTIL = {"bond_mass": "8 s", "van_der_pol": "0.3 s"} | dict.fromkeys(RISERS, "1.05 s")
# Scenes of more components share two processes: the start of each process is what takes the test's time. One does both.
MANY, MAIN = 8, "dp_rov_tether"


class OneNursery(Nursery):
    """One for many runs, each of which would start its own, which imports numba for a second."""

    def close(self) -> None:
        """Leave it to the fixture."""

    def pids(self) -> set[int]:
        return {self._process.pid} if self._process else set()


@pytest.fixture(scope="module")
def nursery():
    one = OneNursery()
    one.open()
    yield one
    Nursery.close(one)


def two_groups(scenario) -> Hosts:
    """Components dealt to two hosts in turn, what is bonded together to one."""
    bonded = {reference.component for tie in scenario.ties for reference in (tie.body, tie.line)}
    free = [one.name for one in scenario.instances if one.name not in bonded]
    return Hosts({name: "p" for name in bonded} | {name: "qp"[i % 2] for i, name in enumerate(free)})


def run(scenario, path, bus=None):
    return run_scenario(scenario, build_graph(scenario), path, Options(bus=bus), lambda _: None)


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario(name, tmp_path, nursery, monkeypatch):
    """Local, two groups, and a process each."""
    monkeypatch.setattr("pipeline.hosts.deployment.Nursery", lambda: nursery)
    monkeypatch.setattr(nursery, "open", lambda: None)
    scenario = load_scenario(SCENARIOS[name], duration=UNTIL.get(name, "5 s"))
    local = run(scenario, tmp_path / "local.mcap")
    each = [Hosts()] if name == MAIN or len(scenario.instances) <= MANY else []
    for hosts in (two_groups(scenario), *each):
        path = tmp_path / f"{len(hosts.hosts)}.mcap"
        result = run(replace(scenario, hosts=hosts), path, BusOptions())
        assert (result.digest, result.channels, result.bonds) == (local.digest, local.channels, local.bonds)
        assert all(not any(counts.values()) for counts in result.hosts.values())
        assert diff_logs(open_log(path), open_log(local.log)).identical
        assert {child.pid for child in psutil.Process().children(recursive=True)} == nursery.pids()
        assert not [c for c in psutil.Process().net_connections() if c.status == "LISTEN"]
