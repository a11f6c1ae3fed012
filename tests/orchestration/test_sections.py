"""Sections of a schedule, drawn: what runs back to back on each host. Authority: the wires as drawn."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.sections import cut


def chain(*edges: str, delayed: tuple[str, ...] = (), alone: list[str] | None = None) -> str:
    """A scenario of tracers with one input each: `a>b` feeds b from a."""
    feeds = {edge[2]: edge[0] for edge in (*edges, *delayed)}
    names = sorted({name for edge in (*edges, *delayed) for name in edge.split(">")} | set(alone or ()))
    lines = ["components:"]
    for name in names:
        source = feeds.get(name)
        lines.append(f"  {name}:")
        lines.append("    model: ./tracer.py")
        if source:
            lines.append("    parameters: {inputs: 1}")
            late = f"{{from: {source}.out_0, delay: true}}" if f"{source}>{name}" in delayed else f"{source}.out_0"
            lines.append(f"    inputs: {{in_0: {late}}}")
    return "\n".join(lines)


def drawn(graph, hosts: dict[str, str]) -> list[str]:
    names = [node.name for node in graph.nodes]
    sections = cut(graph, [hosts[name] for name in names])
    return [f"{s.stage} {s.host}: {' '.join(names[i] for i in s.nodes)}" for s in sections]


CASES = {
    # A: a   c      a section of A, one of B, another of A
    # B:   b
    "there and back": (("a>b", "b>c"), {"a": "A", "b": "B", "c": "A"}, ["0 A: a", "1 B: b", "2 A: c"]),
    # A: a-b
    # B:     c-d
    "two and two": (("a>b", "b>c", "c>d"), {"a": "A", "b": "A", "c": "B", "d": "B"}, ["0 A: a b", "1 B: c d"]),
    # A: (a) c      nobody waits for a, so it runs with c
    # B:  b
    "put off": (("b>c",), {"a": "A", "b": "B", "c": "A"}, ["0 B: b", "1 A: a c"]),
    # A: a   c      d waits for a, so a cannot be put off to c
    # B: b d
    "not put off": (("b>c", "a>d"), {"a": "A", "b": "B", "c": "A", "d": "B"}, ["0 A: a", "0 B: b", "1 A: c", "1 B: d"]),
    # A: a
    # B: b          side by side
    "side by side": ((), {"a": "A", "b": "B"}, ["0 A: a", "0 B: b"]),
}


@pytest.mark.parametrize("case", CASES)
def test_sections_as_drawn(case, graph):
    edges, hosts, expected = CASES[case]
    text = chain(*edges, alone=[name for name in hosts if name not in "".join(edges)])
    assert drawn(graph(text), hosts) == expected


def test_delayed_wires_do_not_part(graph):
    """A ring closed by a delayed wire: each host has one section."""
    text = chain("a>b", "b>c", delayed=("c>a",))
    assert drawn(graph(text), {"a": "A", "b": "A", "c": "B"}) == ["0 A: a b", "1 B: c"]


def test_what_comes_from_outside_is_sent_once(graph):
    """Two inputs that read one signal of another host take one number in the request."""
    text = "components:\n  a: {model: ./tracer.py, parameters: {outputs: 3}}\n"
    text += "  b: {model: ./tracer.py, parameters: {inputs: 2}, inputs: {in_0: 'a.out_1', in_1: 'a.out_1'}}\n"
    section = cut(graph(text), ["A", "B"])[1]
    assert np.array_equal(section.outside, [1])
    assert section.graph.board == section.signals + 1
