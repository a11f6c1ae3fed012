"""Random bytes, random text and mutated scenarios: a scenario or a TowlineError, never anything else, and soon."""

import contextlib
import json
import random
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import TowlineError
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

HERE = Path(__file__).parent
GOOD = """\
name: everything
description: one of each
duration: 1 s
step: 20 ms
seed: 7
start: 0 s
bus: local
scene: 25 Hz
components:
  src: &src
    model: ./components/source.py
    period: 40 ms
    parameters: {level: 30 cm, heading: 30 deg, weights: [1 kg, 20 g], kind: swinging, table: [[0, 1], [1, 2.5]]}
    record: every 80 ms
  snk:
    model: ./components/sink.py
    parameters: {length: 3.5 m}
    inputs:
      end: src.motion
      force: {sum: [src.force, {from: src.force, gain: -0.5, delay: true, initial: [1, 2, 3]}]}
      pull: {from: src.heading, gain: 2 N/rad, offset: 1 kN}
      matrix: {from: "src.nodes[1:3, :2]"}
    record: every 5
  ball: {model: ./components/ball.py}
  line: {model: ./components/string.py, inputs: {end_a: src.motion}}
  trace:
    model: ./components/tracer.py
    parameters: {inputs: 1, outputs: 2}
    inputs: {in_0: {from: trace.out_1, delay: true}}
bonds:
  hook: {body: ball.hook, line: line.end_b, tolerance: 1 mN, rounds: 4}
events:
  - {at: 0.5 s, set: {src.level: 2 m}}
  - {at: 0.2 s, add: {"src.nodes[1]": [1 m, 2 m, 3 m], src.pull: 5 N}, until: 0.4 s}
"""
PIECES = [
    *(
        "",
        " ",
        "\n",
        ":",
        "- ",
        "{",
        "}",
        "[",
        "]",
        ",",
        "'",
        '"',
        "&src ",
        "*src",
        "!!int ",
        "<<: *src",
        "#",
        "|\n",
        "\t",
    ),
    *("\x00", "\ufeff", "é", "?", "%", "---\n", "null", "true", ".nan", "-.inf", "1e999", "-1", "0", "9" * 30, "1 kg"),
    *("0 s", "1e-12 s", "[]", "{}", "src", "src.motion", "src.nodes[9]", "snk.pull", "sum", "from", "delay: true"),
    *(
        "every 0",
        "components",
        "parameters",
        "inputs",
        "./components/ball.py",
        "motion.hand",
        "/dev/zero",
        "..",
        "[1, [2]]",
    ),
]
DEADLINE = 5000  # ms a load; measured: 20 ms, and 0.5 s for the first one, which wakes pint


def load(text: str) -> None:
    """A graph or a TowlineError; anything else fails the test."""
    with contextlib.suppress(TowlineError):
        build_graph(load_scenario_text(text, "fuzz.yaml", HERE))


def test_the_unbroken_one_is_fine():
    assert len(build_graph(load_scenario_text(GOOD, "good.yaml", HERE)).nodes) == 5


@settings(max_examples=200, deadline=DEADLINE)
@given(st.binary(max_size=400))
def test_random_bytes(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "random.yaml"
    path.write_bytes(data)
    with contextlib.suppress(TowlineError):
        build_graph(load_scenario(path))


@settings(max_examples=200, deadline=DEADLINE)
@given(st.text(max_size=300))
def test_random_text(text):
    load(text)


@settings(max_examples=300, deadline=DEADLINE)
@given(
    st.lists(st.tuples(st.integers(0, len(GOOD)), st.integers(0, 12), st.sampled_from(PIECES)), min_size=1, max_size=4)
)
def test_mutated_text(edits):
    """Some characters cut out and something else put in."""
    text = GOOD
    for place, cut, piece in edits:
        text = text[:place] + piece + text[place + cut :]
    load(text)


@settings(max_examples=200, deadline=DEADLINE)
@given(st.integers(0, 2**32), st.integers(1, 5))
def test_shuffled_words(seed, swaps):
    """Words change places: keys become values, units become names."""
    rng = random.Random(seed)
    words = GOOD.split(" ")
    for _ in range(swaps):
        i, j = rng.randrange(len(words)), rng.randrange(len(words))
        words[i], words[j] = words[j], words[i]
    load(" ".join(words))


VALUES = st.recursive(
    st.sampled_from([None, True, -1, 0, 2.5, 1e300, "1 m", "src.pull", "every 2", "", "2 s", "x" * 500]),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["from", "sum", "values", "unit"]), inner)
    ),
    max_leaves=6,
)


@settings(max_examples=300, deadline=DEADLINE)
@given(st.sampled_from([word for word in GOOD.split() if not word.endswith(":")]), VALUES)
def test_replaced_values(word, value):
    """A word becomes a value of any kind (JSON is YAML)."""
    load(GOOD.replace(word, json.dumps(value), 1))
