"""Broken scenarios and the message each gets: wires and cycles.

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
    "unknown component": (
        "src.force",
        "scr.force",
        "10:14 components.snk.inputs.force: unknown component 'scr'; did you mean 'src'?",
    ),
    "unknown output": (
        "src.force",
        "src.froce",
        "10:14 components.snk.inputs.force: src has no output 'froce'; did you mean 'force'?",
    ),
    "unknown input": (
        "      force: src.force",
        "      froce: src.force",
        "10:7 components.snk.inputs.froce: snk has no input 'froce'; did you mean 'force'?",
    ),
    "no signal": (
        "src.force",
        "Src",
        "10:14 components.snk.inputs.force: 'Src' is no signal; expected component.port, "
        "component.port[3] or a constant",
    ),
    "no port": (
        "src.force",
        "src",
        "10:14 components.snk.inputs.force: src is a bundle; expected one of its ports: motion.position, "
        "motion.velocity, motion.acceleration, nodes, heading, thrust, force, pull, torque",
    ),
    "shape": (
        "src.force",
        "src.pull",
        "10:14 components.snk.inputs.force: src.pull is a single number; snk.force expects a list of 3",
    ),
    "shape 2": (
        "src.nodes[:2, :2]",
        "src.nodes",
        "12:15 components.snk.inputs.matrix: src.nodes is a list of 4 x 3; snk.matrix expects a list of 2 x 2",
    ),
    "unit": (
        "src.pull",
        "src.heading",
        "11:13 components.snk.inputs.pull: src.heading is in rad; snk.pull expects N (or a gain in N/rad)",
    ),
    "unit torque": (
        "src.pull",
        "src.torque",
        "11:13 components.snk.inputs.pull: src.torque is in N m; snk.pull expects N (or a gain in N/(N m))",
    ),
    "frame": (
        "src.force",
        "src.thrust",
        "10:14 components.snk.inputs.force: src.thrust is in the body frame; snk.force expects NED",
    ),
    "unwired": (
        "      pull: src.pull\n",
        "",
        "8:5 components.snk.inputs: 'pull' is not wired; expected a single number in N, from a signal or constant",
    ),
    "partly wired": (
        "force: src.force",
        "force[0]: src.pull",
        "8:5 components.snk.inputs: 2 of 3 in 'force' are not wired; expected a list of 3 in N, from a "
        "signal or constant",
    ),
    "overlap": (
        "      force: src.force",
        "      end.position: src.nodes[0]\n      force: src.force",
        "10:7 components.snk.inputs.end.position: two wires into snk.end.position, which "
        "components.snk.inputs.end feeds already; keep one, or sum them",
    ),
    "overlap slice": (
        "      force: src.force",
        "      force[1]: src.pull\n      force: src.force",
        "11:7 components.snk.inputs.force: two wires into snk.force, which "
        "components.snk.inputs.force[1] feeds already; keep one, or sum them",
    ),
    "slice range": (
        "src.nodes[:2, :2]",
        "src.nodes[3:5, :2]",
        "12:15 components.snk.inputs.matrix: src.nodes[3:5, :2]: '3:5' is out of range; there are 4, 0 to 3",
    ),
    "slice index": (
        "src.pull",
        "src.force[3]",
        "11:13 components.snk.inputs.pull: src.force[3]: 3 is out of range; there are 3, 0 to 2",
    ),
    "slice dims": (
        "src.pull",
        "src.force[1, 1]",
        "11:13 components.snk.inputs.pull: src.force[1, 1]: 2 indices; expected at most 1",
    ),
    "slice text": (
        "src.pull",
        "src.force[x]",
        "11:13 components.snk.inputs.pull: src.force[x]: 'x' is no index; expected 3, 1:4 or :",
    ),
    "slice bundle": (
        "src.motion",
        "src.motion[0]",
        "9:12 components.snk.inputs.end: 'motion' is a bundle of position, velocity, acceleration; slice one of these",
    ),
    "bundle to port": (
        "src.pull",
        "src.motion",
        "11:13 components.snk.inputs.pull: src.motion is a bundle; expected one of its ports: position, "
        "velocity, acceleration",
    ),
    "port to bundle": (
        "src.motion",
        "src.force",
        "9:12 components.snk.inputs.end: src.force is one port; expected a bundle of position, velocity, acceleration",
    ),
    "constant unit": (
        "src.pull",
        "3 m",
        "11:13 components.snk.inputs.pull: '3 m': 'm' does not convert to 'N'; expected a quantity in N, such as '1 N'",
    ),
    "constant bare": (
        "src.pull",
        "3",
        "11:13 components.snk.inputs.pull: 3 has no unit; expected a quantity in N, such as '3 N'",
    ),
    "constant shape": (
        "src.force",
        "[1 N, 2 N]",
        "10:14 components.snk.inputs.force: a list of 2; expected a list of 3 in N",
    ),
    "constant ragged": (
        "src.nodes[:2, :2]",
        "[[1 m, 2 m], [3 m]]",
        "12:15 components.snk.inputs.matrix: lists of different lengths; expected a list of 2 x 2",
    ),
    "constant bundle": (
        "src.motion",
        "3 m",
        "9:12 components.snk.inputs.end: a constant for a bundle; expected a signal, or constants for "
        "its ports: position, velocity, acceleration",
    ),
    "wire key": (
        "src.pull",
        "{from: src.pull, gian: 2}",
        "11:30 components.snk.inputs.pull.gian: unknown key; did you mean 'gain'?",
    ),
    "wire no from": (
        "src.pull",
        "{gain: 2}",
        "11:13 components.snk.inputs.pull: the key 'from' is missing; expected a signal such as hand.motion",
    ),
    "delay text": (
        "src.pull",
        "{from: src.pull, delay: yes}",
        "11:37 components.snk.inputs.pull.delay: 'yes' where true or false is expected",
    ),
    "initial without delay": (
        "src.pull",
        "{from: src.pull, initial: 3}",
        "11:39 components.snk.inputs.pull.initial: initial without delay: true; a direct wire has no use for it",
    ),
    "initial shape": (
        "src.force",
        "{from: src.force, delay: true, initial: 0}",
        "10:54 components.snk.inputs.force.initial: a single number; expected a list of 3 in N",
    ),
    "initial unit": (
        "src.pull",
        "{from: src.pull, delay: true, initial: 3 m}",
        "11:52 components.snk.inputs.pull.initial: '3 m': 'm' does not convert to 'N'; expected a "
        "quantity in N, such as '1 N'",
    ),
    "initial of bundle": (
        "src.motion",
        "{from: src.motion, delay: true, initial: 3}",
        "9:12 components.snk.inputs.end: offset and initial go to single ports; wire the members of the "
        "bundle one by one",
    ),
    "gain bare": (
        "src.pull",
        "{from: src.heading, gain: 2}",
        "11:39 components.snk.inputs.pull.gain: 2 has no unit; expected a quantity in N/rad, such as '2 N/rad'",
    ),
    "gain list": (
        "src.pull",
        "{from: src.pull, gain: [1, 2]}",
        "11:36 components.snk.inputs.pull.gain: a list of 2; expected a single number",
    ),
    "offset unit": (
        "src.pull",
        "{from: src.pull, offset: 2 m}",
        "11:38 components.snk.inputs.pull.offset: '2 m': 'm' does not convert to 'N'; expected a "
        "quantity in N, such as '1 N'",
    ),
    "empty sum": ("src.pull", "{sum: []}", "11:19 components.snk.inputs.pull.sum: empty"),
    "sum key": (
        "src.pull",
        "{sum: [src.pull], gain: 2}",
        "11:31 components.snk.inputs.pull.gain: unknown key; expected one of sum",
    ),
    "null wire": (
        "src.pull",
        "",
        "11:12 components.snk.inputs.pull: nothing is wired; expected a signal such as hand.motion, or a constant",
    ),
    "gain unit": (
        "src.pull",
        "{from: src.heading, gain: 2 m/rad}",
        "11:39 components.snk.inputs.pull.gain: '2 m/rad': 'm/rad' does not convert to 'N/rad'; expected "
        "a quantity in N/rad, such as '1 N/rad'",
    ),
}

TEXTS = {
    "no inputs": (
        HEAD
        + (
            "components:\n"
            "  src: {model: ./components/source.py}\n"
            "  snk: {model: ./components/sink.py, parameters: {length: 1 m}}\n"
            ""
        ),
        "5:3 components.snk.inputs: 'force' is not wired; expected a list of 3 in N, from a signal or "
        "constant\n"
        "5:3 components.snk.inputs: 'pull' is not wired; expected a single number in N, from a signal or "
        "constant\n"
        "5:3 components.snk.inputs: 'matrix' is not wired; expected a list of 2 x 2 in m, from a signal "
        "or constant\n"
        "5:3 components.snk.inputs: 'end' is not wired; expected a bundle of position, velocity, "
        "acceleration",
    ),
    "bundle misses": (
        HEAD
        + (
            "components:\n"
            "  snk: {model: ./components/sink.py, parameters: {length: 1 m}, inputs: {end: ball.law, force: "
            "[0 N, 0 N, 0 N], pull: 0 N, matrix: [[0 m, 0 m], [0 m, 0 m]]}}\n"
            "  ball: {model: ./components/source.py}\n"
            ""
        ),
        "4:79 components.snk.inputs.end: ball has no output 'law'; expected one of motion.position, "
        "motion, motion.velocity, motion.acceleration, nodes, heading, thrust, force, pull, torque",
    ),
    "self wire": (
        HEAD
        + ("components:\n  a: {model: ./components/tracer.py, parameters: {inputs: 1}, inputs: {in_0: a.out_0}}\n"),
        "4:78 components.a.inputs.in_0: a cycle of direct wires, a -> a; delay one of them, such as "
        "{from: a.out_0, delay: true} here",
    ),
    "cycle": (
        HEAD
        + (
            "components:\n"
            "  a: {model: ./components/tracer.py, parameters: {inputs: 1}, inputs: {in_0: c.out_0}}\n"
            "  b: {model: ./components/tracer.py, parameters: {inputs: 1}, inputs: {in_0: a.out_0}}\n"
            "  c: {model: ./components/tracer.py, parameters: {inputs: 1}, inputs: {in_0: b.out_0}}\n"
            ""
        ),
        "4:78 components.a.inputs.in_0: a cycle of direct wires, a -> b -> c -> a; delay one of them, "
        "such as {from: c.out_0, delay: true} here",
    ),
}


@pytest.mark.parametrize(("old", "new", "expected"), EDITS.values(), ids=EDITS)
def test_edit(message, old, new, expected):
    assert old in GOOD
    assert message(GOOD.replace(old, new) if old else GOOD + new) == expected


@pytest.mark.parametrize(("text", "expected"), TEXTS.values(), ids=TEXTS)
def test_text(message, text, expected):
    assert message(text) == expected
