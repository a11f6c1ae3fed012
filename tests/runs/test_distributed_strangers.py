"""What comes in a host's name without being its answer changes nothing: each kind of it before every true reply.

Without seals, as on the socket of this machine; for sealed messages see test_distributed_security.py. Authority: the
local run's digest.
"""

from __future__ import annotations

from collections import deque
from pathlib import Path

import pytest

from pipeline.bus.local import LocalBus
from pipeline.bus.messages import DONE, READY, REFUSED, STATE, STOPPED, pack, unpack
from pipeline.distributed import Distributed
from pipeline.hosts.deployment import InProcess
from pipeline.placement import Hosts, placement_of
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
TICKS = 100
INPUT_BYTES = 8  # of either component
TEXT = """
duration: 1 s
step: 10 ms
components:
  a: {model: motion.van_der_pol, inputs: {neighbour: {from: b.position, delay: true}}}
  b: {model: motion.van_der_pol, inputs: {neighbour: a.position}}
"""


def with_other_numbers(message):
    return message._replace(numbers=bytes(len(message.numbers)))


FORGED = {
    "of another run": lambda true: pack(with_other_numbers(true)._replace(run=true.run ^ 1)),
    "of an incarnation that is no more": lambda true: pack(
        with_other_numbers(true)._replace(incarnation=true.incarnation - 1)
    ),
    "of an incarnation to come": lambda true: pack(with_other_numbers(true)._replace(incarnation=true.incarnation + 1)),
    "of the next step": lambda true: pack(with_other_numbers(true)._replace(sequence=true.sequence + 1)),
    "of the step before": lambda true: pack(with_other_numbers(true)._replace(sequence=max(0, true.sequence - 1) or 7)),
    "of another section": lambda true: pack(with_other_numbers(true)._replace(section=true.section ^ 1)),
    "of no section": lambda true: pack(with_other_numbers(true)._replace(section=99)),
    "a number too many": lambda true: pack(true._replace(numbers=bytes(len(true.numbers) + 8))),
    "no numbers": lambda true: pack(true._replace(numbers=b"")),
    "a state announced and not there": lambda true: pack(true._replace(flags=true.flags ^ STATE)),
    "a stop of no component": lambda true: pack(
        true._replace(flags=true.flags | STOPPED, status=1, failed=9, numbers=bytes(len(true.numbers) + INPUT_BYTES))
    ),
    "a refusal without a reason": lambda true: pack(true._replace(kind=REFUSED, text=b"[]")),
    "readiness without facts": lambda true: pack(true._replace(kind=READY, text=b'{"facts": 7, "reasons": []}')),
    "a kind that is none": lambda true: pack(with_other_numbers(true)._replace(kind=77)),
    "cut": lambda true: pack(true)[:-1],
    "longer": lambda true: pack(true) + b"x",
    "garbage": lambda _: b"x" * 100,
}


class Disturbed(LocalBus):
    """A bus on which somebody else is faster than the host."""

    def __init__(self, forge):
        super().__init__()
        self._forge, self.forged = forge, 0

    def send(self, address, data):
        before = len(self._replies[address])
        super().send(address, data)
        for true in list(self._replies[address])[before:]:
            message = unpack(true)
            if message.kind == DONE:
                self._replies[address] = deque([*list(self._replies[address])[:before], self._forge(message), true])
                self.forged += 1


@pytest.mark.parametrize("what", FORGED)
def test_counted_and_ignored(what, tmp_path, monkeypatch):
    scenario = load_scenario_text(TEXT, "two.yaml", ROOT / "scenarios")
    graph = build_graph(scenario)
    local = run_scenario(scenario, graph, tmp_path / "local.mcap", Options(), lambda _: None)
    bus = Disturbed(FORGED[what])
    deployment = InProcess()
    deployment.open = lambda run: setattr(deployment, "_bus", bus) or bus
    conductor = Distributed(graph, placement_of(graph, Hosts(), {}), deployment)
    monkeypatch.setattr("pipeline.run.conductor_of", lambda *_: conductor)
    result = run_scenario(scenario, graph, tmp_path / "a.mcap", Options(), lambda _: None)
    assert result.digest == local.digest
    assert bus.forged == 2 * (TICKS + 1)
    assert sum(counts["refused"] for counts in result.hosts.values()) == bus.forged
    assert sum(counts["restarts"] for counts in result.hosts.values()) == 0
