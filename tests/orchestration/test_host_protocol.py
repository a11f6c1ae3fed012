"""What a host answers, message by message, without a network. Authority: the protocol as written in serving.py."""

from __future__ import annotations

import json
import math
import struct

import pytest

from pipeline.bus.messages import (
    ASSIGN,
    DONE,
    END,
    INITIALISE,
    OUT_OF_ORDER,
    READY,
    REFUSED,
    RESTORE,
    STATE,
    STEP,
    WANT_STATE,
    Message,
    MessageError,
    pack,
    unpack,
)
from pipeline.hosts import facts
from pipeline.hosts.assignment import to_json
from pipeline.hosts.serving import Serving
from pipeline.sections import cut

RUN, INCARNATION = 0xFEDC_BA98_7654_3210, 3
TEXT = """
components:
  a: {model: ./tracer.py, parameters: {start: 10}}
  b: {model: ./tracer.py, parameters: {inputs: 1}, inputs: {in_0: a.out_0}}
"""
SECOND_NS = 1_000_000_000


def one(value: float) -> bytes:
    return struct.pack("<d", value)


def message(kind: int, sequence: int = 0, value: float | None = None, **changes) -> Message:
    made = Message(kind, RUN, INCARNATION, section=1, sequence=sequence, t_ns=sequence * SECOND_NS)
    return made._replace(numbers=b"" if value is None else one(value), **changes)


def assignment(graph, **changes) -> Message:
    """Section 1, which is b, to host B."""
    sections = to_json(section for section in cut(graph(TEXT), ["A", "B"]) if section.host == "B")
    wanted = {"facts": dict(facts.own()), "limit_s": 30.0, "sections": sections} | changes
    return Message(ASSIGN, RUN, INCARNATION, text=json.dumps(wanted).encode())


def answer(host: Serving, asked: Message) -> Message | None:
    data = host.answer(pack(asked))
    return None if data is None else unpack(data)


@pytest.fixture
def host(graph) -> Serving:
    """A host that has been assigned b and has initialised it."""
    host = Serving("B")
    assert answer(host, assignment(graph)).kind == READY
    assert answer(host, message(INITIALISE, 0, 5.0)).values.tolist() == [5.0]
    return host


def test_steps_in_sequence(host):
    for sequence in (1, 2):
        reply = answer(host, message(STEP, sequence, 7.0, flags=WANT_STATE))
        assert (reply.kind, reply.sequence, reply.flags) == (DONE, sequence, STATE)
        assert reply.values.tolist() == [7.0 + sequence, sequence]  # output, then state


def test_last_request_is_answered_from_the_cache(host):
    first = host.answer(pack(message(STEP, 1, 7.0)))
    assert host.answer(pack(message(STEP, 1, 7.0))) == first
    assert answer(host, message(STEP, 2, 7.0)).values.tolist() == [9.0]


@pytest.mark.parametrize("sequence", [0, 3, 2**30])
def test_others_are_refused(host, sequence):
    answer(host, message(STEP, 1, 7.0))
    refused = answer(host, message(STEP, sequence, 7.0))
    assert (refused.kind, refused.sequence, refused.ignored) == (OUT_OF_ORDER, 1, 1)
    assert answer(host, message(STEP, 2, 7.0)).values.tolist() == [9.0]


def test_restored_to_any_sequence(host):
    """Signals, state, then settings: parameters with their header, offsets, switches."""
    p = host._sections[1].runner._memory.parameters[:-1].tobytes()
    numbers = one(0.0) + one(41.0) + p + one(0.0) + one(0.0)
    host.answer(pack(message(RESTORE, 41)._replace(numbers=numbers)))
    assert answer(host, message(STEP, 42, 0.5)).values.tolist() == [42.5]


WRONG = {
    "another run": message(STEP, 1, 7.0, run=RUN + 1),
    "an incarnation that is no more": message(STEP, 1, 7.0, incarnation=INCARNATION - 1),
    "an incarnation to come": message(STEP, 1, 7.0, incarnation=INCARNATION + 1),
    "a section of another host": message(STEP, 1, 7.0, section=0),
    "a number too few": message(STEP, 1),
    "a number too many": message(STEP, 1)._replace(numbers=one(1.0) + one(2.0)),
    "settings announced and not there": message(STEP, 1, 7.0, flags=1),
    "a kind that is none": message(99, 1, 7.0),
    "the end of another run": message(END, run=RUN + 1),
    "a snapshot of another length": message(RESTORE, 7, 1.0),
}


@pytest.mark.parametrize("what", WRONG)
def test_strange_messages_are_counted_and_ignored(host, what):
    assert answer(host, WRONG[what]) is None
    assert not host.ended
    reply = answer(host, message(STEP, 1, 7.0))
    assert (reply.values.tolist(), reply.ignored) == ([8.0], 1)


@pytest.mark.parametrize("cut_at", [0, 3, 30, -1])
def test_mangled_bytes_are_counted_and_ignored(host, cut_at):
    data = pack(message(STEP, 1, 7.0))
    for mangled in (data[:cut_at], data + b"x", b"\0" * len(data), b""):
        assert host.answer(mangled) is None
        with pytest.raises(MessageError):
            unpack(mangled)
    assert answer(host, message(STEP, 1, 7.0)).ignored == 4


def test_message_survives_the_way():
    there = Message(STEP, RUN, 7, 3, 2**63, -(2**63), 3, -(2**31), 5, 70_000, one(math.pi), "über".encode())
    back = unpack(pack(there))
    assert back._replace(numbers=bytes(back.numbers)) == there._replace(ignored=65535)


def test_another_run_does_not_get_a_host_that_is_at_work(host, graph):
    assert answer(host, assignment(graph)._replace(run=RUN + 1)) is None
    assert answer(host, message(STEP, 1, 7.0)).kind == DONE


def reasons(graph, changes: dict) -> str:
    refused = answer(Serving("crane"), assignment(graph, **changes))
    assert refused.kind == REFUSED
    return "; ".join(json.loads(refused.text)["reasons"])


@pytest.mark.parametrize("key", facts.MUST_AGREE)
def test_another_make_is_refused_with_both_sides(graph, key):
    other = {**facts.own(), key: "0.0.1"}
    assert reasons(graph, {"facts": other}) == f"{key}: 0.0.1 at the conductor, {facts.own()[key]} at crane"


def test_sources_edited_since_its_start_are_refused(graph, monkeypatch):
    """It has imported some of them before, and would import others only now."""

    def edited() -> str:
        raise AssertionError

    edited.__wrapped__ = lambda: "feed" * 16
    monkeypatch.setattr(facts.cache, "source_hash", edited)
    then = facts.own()["sources"]
    assert reasons(graph, {}) == f"sources: {then} when crane was started, feedfeedfeedfeed now; start it again"


def test_other_ports_are_refused_with_both_sides(graph):
    sections = json.loads(assignment(graph).text)["sections"]
    sections[0]["nodes"][0]["outputs"] = [["out_0", "1", [3], ""]]
    said = reasons(graph, {"sections": sections})
    assert "has other outputs here: out_0 [1], and at the conductor out_0 [3] [1]" in said
    assert said.startswith("crane: b: ")


def test_a_file_that_is_not_here_or_differs_is_refused(graph, tmp_path):
    for path, expected in (
        (tmp_path / "tracer.py", "code does not travel over the bus"),
        (None, "differs from the conductor's"),
    ):
        sections = json.loads(assignment(graph).text)["sections"]
        node = sections[0]["nodes"][0]
        node["file_hash"] = "0" * 64
        node["model"] = str(path or node["model"])
        assert expected in reasons(graph, {"sections": sections})


@pytest.mark.parametrize("changes", [{"sections": 7}, {"facts": 7}, {"sections": [{}]}, {"limit_s": None}])
def test_an_assignment_that_is_none_is_refused(graph, changes):
    assert "crane cannot read its assignment" in reasons(graph, changes)


def test_another_libm_is_warned_of():
    here = dict(facts.own())
    assert facts.warning(here, here, "crane") is None
    said = facts.warning({**here, facts.LIBM: "0"}, here, "crane")
    assert said.startswith("crane: its libm or NumPy rounds otherwise (0 at the conductor")
    assert facts.libm_probe() == here[facts.LIBM]
