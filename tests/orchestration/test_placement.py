"""`hosts:`, `machines:` and `overdue:` of a scenario: where components go, and what each mistake is told.

Authority: the issue's words; the form `file:line:col path: what is wrong, what would be right`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.placement import placement_of
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

FOLDER = Path(__file__).parents[2] / "scenarios"
TEXT = """duration: 1 s
step: 10 ms
bus: zenoh
hosts: {HOSTS}
machines: {MACHINES}
components:
  anchor: {model: motion.fixed, parameters: {position: [0 m, 0 m, 1 m]}}
  ball:
    model: vessel.mass
    overdue: 2 s
    parameters: {mass: 2 kg, weight: [0 N, 0 N, 15 N], position: [0 m, 0 m, 3 m]}
  chain:
    model: tether.cable
    parameters: {file: FOLDER/parameters/pool_chain.yaml, length: 2 m, segments: 20}
    inputs: {end_a: anchor.motion}
bonds:
  hook: {body: ball.hook, line: chain.end_b}
"""


def text(hosts: str = "", machines: str = "") -> str:
    return TEXT.replace("HOSTS", hosts).replace("MACHINES", machines).replace("FOLDER", str(FOLDER))


WRONG = {
    "unknown component": (
        "anker: p",
        "",
        "4:9 hosts.anker: unknown component 'anker'; expected one of anchor, ball, chain",
    ),
    "no name": (
        "anchor: 'A b'",
        "",
        "4:17 hosts.anchor: 'A b' is not a name; expected small letters, digits and _, beginning with a letter",
    ),
    "bonded apart": (
        "ball: p, chain: q",
        "",
        "4:25 hosts.chain: bond 'hook' ties chain to ball, which is on 'p'; put both on one host",
    ),
    "machine without components": (
        "ball: p",
        "r: {}",
        "5:12 machines.r: no component is on it; expected one of p; place one with hosts:",
    ),
    "unknown key": ("ball: p", "p: {limt: 3 s}", "5:16 machines.p.limt: unknown key; did you mean 'limit'?"),
    "no unit": (
        "ball: p",
        "p: {limit: 3}",
        "5:23 machines.p.limit: 3 has no unit; expected a quantity in s, such as '3 s'",
    ),
    "no time": ("ball: p", "p: {limit: 0 s}", "5:23 machines.p.limit: '0 s' is not above zero; expected e.g. '20 ms'"),
    "no mapping": ("ball: p", "p: 3 s", "5:15 machines.p: '3 s' where a mapping is expected"),
}


@pytest.mark.parametrize("case", WRONG)
def test_told_with_its_place(case, message):
    hosts, machines, expected = WRONG[case]
    assert message(text(hosts, machines)) == expected


def placed(hosts: str = "", machines: str = ""):
    scenario = load_scenario_text(text(hosts, machines), "s.yaml", FOLDER)
    again = load_scenario_text(scenario.resolved_text(), "log", FOLDER)
    assert (again.hosts.hosts, again.hosts.machines) == (scenario.hosts.hosts, scenario.hosts.machines)
    overdue_s = {one.name: one.overdue_ns / 1e9 for one in again.instances if one.overdue_ns}
    return placement_of(build_graph(again), again.hosts, overdue_s)


def test_a_process_each_but_for_what_is_bonded():
    placement = placed()
    assert placement.hosts == ("anchor", "ball", "ball")
    assert placement.overdue_s == (1.0, 2.0, 1.0)
    assert placement.limits_s == {}


def test_what_is_bonded_follows_the_one_that_is_placed():
    placement = placed("chain: crane, anchor: quay", "crane: {limit: 1 min}, quay: {}")
    assert placement.hosts == ("quay", "crane", "crane")
    assert placement.limits_s == {"crane": 60.0, "quay": 30.0}
