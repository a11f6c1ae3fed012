"""Broken scenarios and the message each gets: bonds and events.

Authority: the issue's list of errors; the form `file:line:col path: what is wrong, what would be right`.
"""

from pathlib import Path

import pytest

HERE = Path(__file__).parent
HEAD = "duration: 1 s\nstep: 20 ms\n"
GOOD = (HERE / "good.yaml").read_text()
END = ""  # in place of what to replace: append

# name: (what is replaced in GOOD, by what, the message with line:column)
EDITS = {
    "event off grid": (
        END,
        "events:\n  - {at: 0.555 s, set: {snk.share: 0.5}}\n",
        "14:10 events[0].at: 555 ms does not begin a step of 20 ms; nearest is 560 ms",
    ),
    "event after end": (
        END,
        "events:\n  - {at: 1 s, set: {snk.share: 0.5}}\n",
        "14:10 events[0].at: 1 s is not before the end of the run, 1 s",
    ),
    "event before start": (
        END,
        "events:\n  - {at: -1 s, set: {snk.share: 0.5}}\n",
        "14:10 events[0].at: -1 s is before the start of the run, 0 s",
    ),
    "event fixed": (
        END,
        "events:\n  - {at: 0.5 s, set: {snk.length: 2 m}}\n",
        "14:23 events[0].set.snk.length: 'snk.length' is fixed during a run; expected a tunable one: share",
    ),
    "event unknown parameter": (
        END,
        "events:\n  - {at: 0.5 s, set: {snk.shrae: 2}}\n",
        "14:23 events[0].set.snk.shrae: 'snk.shrae' is no parameter; did you mean 'share'?",
    ),
    "event range": (
        END,
        "events:\n  - {at: 0.5 s, set: {snk.share: 2}}\n",
        "14:34 events[0].set.snk.share: 2 is out of range; must be at most 1",
    ),
    "event verb": (
        END,
        "events:\n  - {at: 0.5 s, cut: tether}\n",
        "14:17 events[0].cut: unknown key; expected one of at, set, add, until",
    ),
    "event nothing": (
        END,
        "events:\n  - {at: 0.5 s}\n",
        "14:5 events[0]: nothing happens; expected set: {component.parameter: value} or add: {component.port: value}",
    ),
    "event no at": (
        END,
        "events:\n  - {set: {snk.share: 1}}\n",
        "14:5 events[0]: the key 'at' is missing; expected a simulated time such as '10 s'",
    ),
    "event component": (
        END,
        "events:\n  - {at: 0.5 s, set: {sink.share: 1}}\n",
        "14:23 events[0].set.sink.share: unknown component 'sink'; did you mean 'snk'?",
    ),
    "event add unit": (
        END,
        "events:\n  - {at: 0.5 s, add: {src.pull: 5 m}}\n",
        "14:33 events[0].add.src.pull: '5 m': 'm' does not convert to 'N'; expected a quantity in N, such as '1 N'",
    ),
    "event add shape": (
        END,
        "events:\n  - {at: 0.5 s, add: {src.force: 5 N}}\n",
        "14:34 events[0].add.src.force: a single number; expected a list of 3 in N",
    ),
    "event add bundle": (
        END,
        "events:\n  - {at: 0.5 s, add: {src.motion: 5 N}}\n",
        "14:23 events[0].add.src.motion: src.motion is a bundle; expected one of its ports: position, "
        "velocity, acceleration",
    ),
    "event until": (
        END,
        "events:\n  - {at: 0.5 s, add: {src.pull: 5 N}, until: 0.5 s}\n",
        "14:46 events[0].until: 500 ms is not after 'at'; expected a later time",
    ),
    "event until set": (
        END,
        "events:\n  - {at: 0.5 s, set: {snk.share: 0.5}, until: 0.6 s}\n",
        "14:47 events[0].until: ends nothing; it goes with add",
    ),
    "events mapping": (END, "events: {a: 1}\n", "13:9 events: a mapping where a list is expected"),
    "bonds list": (END, "bonds: [a]\n", "13:8 bonds: a list where a mapping is expected"),
}

TEXTS = {
    "bond body": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: bal.hook, line: line.end_b}\n"
            ""
        ),
        "7:13 bonds.b.body: unknown component 'bal'; did you mean 'ball'?",
    ),
    "bond end": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook, line: line.end_c}\n"
            ""
        ),
        "7:30 bonds.b.line: 'line' has no line end 'end_c'; did you mean 'end_b'?",
    ),
    "bond twice": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook, end_b: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook, line: line.end_b}\n"
            ""
        ),
        "7:6 bonds.b: two wires into line.end_b.position, which components.line.inputs.end_b feeds "
        "already; keep one, or sum them",
    ),
    "two bonds on one body's end": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py}\n"
            "bonds:\n"
            "  a: {body: ball.hook, line: line.end_a}\n"
            "  b: {body: ball.hook, line: line.end_b}\n"
            ""
        ),
        "8:13 bonds.b.body: bonds 'a' and 'b' both tie 'ball.hook'; a body's end takes one bond",
    ),
    "two bonds on one line's end": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  other: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  a: {body: ball.hook, line: line.end_b}\n"
            "  b: {body: other.hook, line: line.end_b}\n"
            ""
        ),
        "9:31 bonds.b.line: bonds 'a' and 'b' both tie 'line.end_b'; a line's end takes one bond",
    ),
    "bond with a slice": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: 'ball.hook[0]', line: line.end_b}\n"
            ""
        ),
        "7:13 bonds.b.body: 'ball.hook[0]' is a slice; expected an end such as ball.hook",
    ),
    "bond switched off": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, parameters: {bond_b: false}, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook, line: line.end_b}\n"
            ""
        ),
        "5:62 components.line.parameters.bond_b: false, but bond 'b' turns it on; leave it out, or leave out the bond",
    ),
    "bond without tolerance": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook, line: line.end_b, tolerance: 0 N}\n"
            ""
        ),
        "7:53 bonds.b.tolerance: '0 N' is not above zero; expected e.g. '1 mN'",
    ),
    "bond periods": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py, period: 40 ms}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook, line: line.end_b}\n"
            ""
        ),
        "7:6 bonds.b: 'ball' and 'line' have different periods; a bond needs equal ones",
    ),
    "bond rounds": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook, line: line.end_b, rounds: 0, tolerance: 1 m}\n"
            ""
        ),
        "7:50 bonds.b.rounds: 0 is out of range; must be at least 1\n"
        "7:64 bonds.b.tolerance: '1 m': 'm' does not convert to 'N'; expected a quantity in N, such as "
        "'1 N'",
    ),
    "bond misses line": (
        HEAD
        + (
            "components:\n"
            "  ball: {model: ./components/ball.py}\n"
            "  line: {model: ./components/string.py, inputs: {end_a: ball.hook}}\n"
            "bonds:\n"
            "  b: {body: ball.hook}\n"
            ""
        ),
        "7:6 bonds.b: the key 'line' is missing; expected a line's end such as tether.end_b",
    ),
    "event adds a term": (
        HEAD
        + (
            "components:\n"
            "  hook: {model: motion.fixed, parameters: {position: [0 m, 0 m, 0 m]}}\n"
            "  line:\n"
            "    model: tether.cable\n"
            "    parameters: {length: 3 m, mass_per_length: 1 kg/m, volume_per_length: 0 m^2, drag_diameter: 1 cm,"
            " end_b: free}\n"
            "    inputs: {end_a: hook.motion}\n"
            "events:\n"
            "  - {at: 0.5 s, set: {line.bending_stiffness: 1 N*m^2}}\n"
            "  - {at: 0.6 s, set: {line.breaking_load: 1 kN}}\n"
        ),
        "10:23 events[0].set.line.bending_stiffness: 'line.bending_stiffness' turns a term of tether.cable on or off "
        "that has a place of its own in it, which is fixed during a run; begin with a very small value instead of "
        "none, or end with it",
    ),
}


@pytest.mark.parametrize(("old", "new", "expected"), EDITS.values(), ids=EDITS)
def test_edit(message, old, new, expected):
    assert old in GOOD
    assert message(GOOD.replace(old, new) if old else GOOD + new) == expected


@pytest.mark.parametrize(("text", "expected"), TEXTS.values(), ids=TEXTS)
def test_text(message, text, expected):
    assert message(text) == expected
