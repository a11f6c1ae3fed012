"""Broken scenarios and the message each gets: the YAML, the top level, components and parameters.

Authority: the issue's list of errors; the form `file:line:col path: what is wrong, what would be right`.
"""

from pathlib import Path

import pytest

HERE = Path(__file__).parent
MODELS = sorted(
    f"{path.parts[-3]}.{path.parts[-2]}" for path in (HERE.parents[1] / "components").glob("*/*/component.py")
)
HEAD = "duration: 1 s\nstep: 20 ms\n"
GOOD = (HERE / "good.yaml").read_text()
END = ""  # in place of what to replace: append

# name: (what is replaced in GOOD, by what, the message with line:column)
EDITS = {
    "two documents": (END, "---\na: 1\n", "13:1 a second document; expected one document in a file"),
    "python tag": (
        "3 m}",
        "!!python/name:os.system 3 m}",
        "7:26 the tag !!python/name:os.system is not supported; write the plain value",
    ),
    "duplicate key": (
        "step: 20 ms\n",
        "step: 20 ms\nstep: 10 ms\n",
        "3:1 duplicate key 'step', first on line 2; keep one",
    ),
    "duplicate component": (
        END,
        "  src: {model: ./components/source.py}\n",
        "13:3 duplicate key 'src', first on line 4; keep one",
    ),
    "merge key": (
        "{model: ./components/source.py}",
        "{<<: {a: 1}, model: ./components/source.py}",
        "4:9 merge keys are not supported; write the keys out",
    ),
    "alias to itself": ("duration: 1 s", "duration: &d [*d]", "1:15 *d contains itself"),
    "undefined alias": ("duration: 1 s", "duration: *d", "1:11 *d is not defined above"),
    "unknown key": (
        "step: 20 ms",
        "step: 20 ms\ncomponent: 3",
        "3:1 component: unknown key; did you mean 'components'?",
    ),
    "no duration": (
        "duration: 1 s\n",
        "",
        "1:1 the key 'duration' is missing; expected simulated time, such as '10 s'",
    ),
    "bare duration": ("1 s", "10", "1:11 duration: 10 has no unit; expected a quantity in s, such as '10 s'"),
    "zero duration": ("1 s", "0 s", "1:11 duration: '0 s' is not above zero; expected e.g. '20 ms'"),
    "negative duration": ("1 s", "-1 s", "1:11 duration: '-1 s' is not above zero; expected e.g. '20 ms'"),
    "infinite duration": ("1 s", ".inf", "1:11 duration: 'inf' is not finite; expected a finite number"),
    "nan duration": ("1 s", ".nan", "1:11 duration: 'nan' is not finite; expected a finite number"),
    "inf s": ("1 s", "inf s", "1:11 duration: 'inf s' is not finite; expected a quantity in s, such as '1 s'"),
    "huge duration": ("1 s", "1e99 s", "1:11 duration: '1e99 s' is too long; times reach to 292 years"),
    "duration off step": (
        "1 s",
        "1.01 s",
        "1:11 duration: 1.01 s is not a multiple of the step of 20 ms; nearest is 1.02 s",
    ),
    "negative start": (
        "step: 20 ms",
        "step: 20 ms\nstart: -5 s",
        "3:8 start: '-5 s' is before zero; expected e.g. '0 s'",
    ),
    "end beyond 64 bits": (  # 2**63 ns are 9223372036.85 s
        "step: 20 ms",
        "step: 20 ms\nstart: 9223372036 s",
        "1:11 duration: 1 s from the start at 9223372036 s is too long; times reach to 292 years",
    ),
    "name with a path": (
        "step: 20 ms",
        "step: 20 ms\nname: ../../etc/x",
        "3:7 name: '../../etc/x' cannot name a log; expected up to 64 letters, digits, spaces, _, - and ., "
        "not beginning with a dot",
    ),
    "hidden name": (
        "step: 20 ms",
        "step: 20 ms\nname: .x",
        "3:7 name: '.x' cannot name a log; expected up to 64 letters, digits, spaces, _, - and ., "
        "not beginning with a dot",
    ),
    "name of two lines": (
        "step: 20 ms",
        'step: 20 ms\nname: "a\\t"',
        "3:7 name: 'a\t' cannot name a log; expected up to 64 letters, digits, spaces, _, - and ., "
        "not beginning with a dot",
    ),
    "empty name": (
        "step: 20 ms",
        "step: 20 ms\nname: ''",
        "3:7 name: '' cannot name a log; expected up to 64 letters, digits, spaces, _, - and ., "
        "not beginning with a dot",
    ),
    "long name": (
        "step: 20 ms",
        f"step: 20 ms\nname: {'x' * 65}",
        f"3:7 name: '{'x' * 39}... cannot name a log; expected up to 64 letters, digits, spaces, _, - and ., "
        "not beginning with a dot",
    ),
    "length for duration": (
        "1 s",
        "1 m",
        "1:11 duration: '1 m': 'm' does not convert to 's'; expected a quantity in s, such as '1 s'",
    ),
    "unknown unit": (
        "1 s",
        "1 sekunde",
        "1:11 duration: '1 sekunde': 'sekunde' is not a known unit; expected a quantity in s, such as '1 s'",
    ),
    "zero step": ("20 ms", "0 ms", "2:7 step: '0 ms' is not above zero; expected e.g. '20 ms'"),
    "fraction of ns": (
        "20 ms",
        "0.5 ns",
        "2:7 step: '0.5 ns' is not a whole number of nanoseconds; expected e.g. 0 ns",
    ),
    "text seed": ("step: 20 ms", "step: 20 ms\nseed: abc", "3:7 seed: 'abc' where a whole number is expected"),
    "float seed": ("step: 20 ms", "step: 20 ms\nseed: 1.5", "3:7 seed: 1.5 where a whole number is expected"),
    "bool seed": ("step: 20 ms", "step: 20 ms\nseed: true", "3:7 seed: true where a whole number is expected"),
    "negative seed": ("step: 20 ms", "step: 20 ms\nseed: -1", "3:7 seed: -1 is out of range; must be at least 0"),
    "unknown bus": (
        "step: 20 ms",
        "step: 20 ms\nbus: can",
        "3:6 bus: 'can' is not possible; expected 'local' or 'zenoh'",
    ),
    "scene": (
        "step: 20 ms",
        "step: 20 ms\nscene: 25",
        "3:8 scene: 25 has no unit; expected a time or a rate, such as '20 ms' or '50 Hz'",
    ),
    "list name": ("step: 20 ms", "step: 20 ms\nname: [a]", "3:7 name: a list where text is expected"),
    "name": (
        "  snk:\n",
        "  Snk 1:\n",
        "5:3 components.Snk 1: not a name; expected small letters, digits and _, beginning with a letter",
    ),
    "no model": (
        "model: ./components/source.py",
        "period: 20 ms",
        "4:8 components.src: the key 'model' is missing; expected a model such as motion.hand or ./my_component.py"
        ", or fmu: a file",
    ),
    "unknown model": (
        "./components/source.py",
        "motion.hnd",
        "4:16 components.src.model: unknown model 'motion.hnd'; did you mean 'motion.hand'?",
    ),
    "unknown model 2": (
        "./components/source.py",
        "spaceship",
        f"4:16 components.src.model: unknown model 'spaceship'; expected one of {', '.join(MODELS[:12])}, ...",
    ),
    "missing model file": (
        "./components/source.py",
        "./nowhere.py",
        "4:16 components.src.model: no such file './nowhere.py' in HERE; expected a Python file with a COMPONENT",
    ),
    "unknown component key": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, imputs: {}}",
        "4:40 components.src.imputs: unknown key; did you mean 'inputs'?",
    ),
    "period": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, period: 30 ms}",
        "4:48 components.src.period: 30 ms is not a multiple of the step, 20 ms; nearest is 40 ms",
    ),
    "period smaller": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, period: 10 ms}",
        "4:48 components.src.period: 10 ms is not a multiple of the step, 20 ms; nearest is 20 ms",
    ),
    "period longer than the run": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, period: 10 s}",
        "4:48 components.src.period: its period of 10 s is longer than the run of 1 s: it would never step",
    ),
    "record": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, record: sometimes}",
        "4:48 components.src.record: 'sometimes' is no record rate; expected 'every 5' (own steps), "
        "'every 100 ms' or false",
    ),
    "record period": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, period: 40 ms, record: every 60 ms}",
        "4:63 components.src.record: 60 ms is not a multiple of the component's period, 40 ms; nearest is 80 ms",
    ),
    "record zero": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, record: every 0}",
        "4:48 components.src.record: 'every 0' is not above zero; expected false to record nothing",
    ),
    "unknown parameter": (
        "length: 3 m",
        "lenght: 3 m",
        "7:18 components.snk.parameters.lenght: unknown parameter; did you mean 'length'?",
    ),
    "missing parameter": (
        "{length: 3 m}",
        "{}",
        "7:5 components.snk.parameters.length: missing parameter (no default); expected a value in m",
    ),
    "bare parameter": (
        "length: 3 m",
        "length: 3",
        "7:26 components.snk.parameters.length: 3 has no unit; expected a quantity in m, such as '3 m'",
    ),
    "wrong unit": (
        "length: 3 m",
        "length: 3 kg",
        "7:26 components.snk.parameters.length: '3 kg': 'kg' does not convert to 'm'; expected a "
        "quantity in m, such as '1 m'",
    ),
    "text parameter": (
        "length: 3 m",
        "length: long",
        "7:26 components.snk.parameters.length: 'long' is not a number; expected a quantity in m, such as '1 m'",
    ),
    "bool parameter": (
        "length: 3 m",
        "length: true",
        "7:26 components.snk.parameters.length: true is not a number; expected a quantity in m, such as '1 m'",
    ),
    "null parameter": (
        "length: 3 m",
        "length: null",
        "7:26 components.snk.parameters.length: null where a number is expected",
    ),
    "list parameter": (
        "length: 3 m",
        "length: [3 m]",
        "7:26 components.snk.parameters.length: a list where a number is expected",
    ),
    "mapping parameter": (
        "length: 3 m",
        "length: {a: 3 m}",
        "7:26 components.snk.parameters.length: a mapping where a number in m is expected (or {values: "
        "[...], unit: m})",
    ),
    "out of range": (
        "length: 3 m",
        "length: -3 m",
        "7:26 components.snk.parameters.length: -3 m is out of range; must be above 0 m",
    ),
    "overflow": (
        "length: 3 m",
        "length: 1e400 m",
        "7:26 components.snk.parameters.length: '1e400 m' is not finite; expected a finite number",
    ),
    "nan parameter": (
        "length: 3 m",
        "length: .nan",
        "7:26 components.snk.parameters.length: 'nan' is not finite; expected a finite number",
    ),
    "choice": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {kind: swining}}",
        "4:59 components.src.parameters.kind: 'swining' is not possible; expected 'steady' or 'swinging'",
    ),
    "bool count": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {nodes: true}}",
        "4:60 components.src.parameters.nodes: true where a whole number is expected",
    ),
    "text count": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {nodes: '4'}}",
        "4:60 components.src.parameters.nodes: '4' where a whole number is expected",
    ),
    "fraction count": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {nodes: 2.5}}",
        "4:60 components.src.parameters.nodes: 2.5 where a whole number is expected",
    ),
    "zero count": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {nodes: 0}}",
        "4:60 components.src.parameters.nodes: 0 is out of range; must be at least 1",
    ),
    "off": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {smooth: off}}",
        "4:61 components.src.parameters.smooth: 'off' where true or false is expected",
    ),
    "list item": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {weights: [1 kg, 2 m]}}",
        "4:69 components.src.parameters.weights[1]: '2 m': 'm' does not convert to 'kg'; expected a "
        "quantity in kg, such as '1 kg'",
    ),
    "parameter file": (
        "{length: 3 m}",
        "{file: nowhere.yaml}",
        "7:24 components.snk.parameters.file: nowhere.yaml: no such file",
    ),
    "parameter file mistyped": (
        "{length: 3 m}",
        "{flie: nowhere.yaml}",
        "7:18 components.snk.parameters.flie: unknown parameter; did you mean 'file'?",
    ),
    "csv": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {table: {csv: nowhere.csv}}}",
        "4:60 components.src.parameters.table: nowhere.csv: no such file",
    ),
    "csv spec": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {table: {csv: 3}}}",
        "4:60 components.src.parameters.table: expected {csv: file.csv, columns: [time, x, y, z]}",
    ),
    "parameters text": ("{length: 3 m}", "none", "7:17 components.snk.parameters: 'none' where a mapping is expected"),
    "no unit of angle": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {ratio: 30 deg}}",
        "4:60 components.src.parameters.ratio: '30 deg': 'deg' does not convert to '1'; expected a number",
    ),
    "far too many numbers": (
        "{model: ./components/source.py}",
        "{model: ./components/source.py, parameters: {nodes: 1000000000000}}",
        "4:3 components.src: test.source cannot be set up with these parameters: it takes 3000000000018 "
        "numbers; expected at most 10000000",
    ),
}

TEXTS = {
    "empty": ("", "1:1 empty; expected a scenario"),
    "comment only": ("# nothing\n", "1:1 empty; expected a scenario"),
    "binary": ("duration: 1 s\n\x00\x01", "2:1 a control character; expected a YAML text file"),
    "not a mapping": ("- 1\n- 2\n", "1:1 expected a mapping with duration, step and components"),
    "scalar": ("hello", "1:1 expected a mapping with duration, step and components"),
    "unclosed": (
        HEAD + ("components: {a: [1\n"),
        "4:1 not YAML: while parsing a flow sequence did not find expected ',' or ']'",
    ),
    "tab": (
        HEAD + ("components:\n\ta: 1\n"),
        "4:1 not YAML: while scanning for the next token found character that cannot start any token",
    ),
    "laughs": (
        "a: &a [x,x,x,x,x,x,x,x,x,x]\n"
        "b: &b [*a,*a,*a,*a,*a,*a,*a,*a,*a,*a]\n"
        "c: &c [*b,*b,*b,*b,*b,*b,*b,*b,*b,*b]\n"
        "d: &d [*c,*c,*c,*c,*c,*c,*c,*c,*c,*c]\n"
        "e: &e [*d,*d,*d,*d,*d,*d,*d,*d,*d,*d]\n"
        "f: [*e,*e]\n"
        "",
        "5:29 aliases expand to more than 100000 values",
    ),
    "deep": (
        "a: [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
        "1:67 nested deeper than 64 levels",
    ),
    "no components": (HEAD + "", "1:1 the key 'components' is missing; expected a mapping of names to components"),
    "components empty": (HEAD + ("components: {}\n"), "3:13 components: empty"),
    "components list": (HEAD + ("components: [1]\n"), "3:13 components: a list where a mapping is expected"),
    "component text": (
        HEAD + ("components:\n  src: source\n"),
        "4:8 components.src: 'source' where a mapping is expected",
    ),
}


@pytest.mark.parametrize(("old", "new", "expected"), EDITS.values(), ids=EDITS)
def test_edit(message, old, new, expected):
    assert old in GOOD
    assert message(GOOD.replace(old, new) if old else GOOD + new) == expected


@pytest.mark.parametrize(("text", "expected"), TEXTS.values(), ids=TEXTS)
def test_text(message, text, expected):
    assert message(text) == expected
