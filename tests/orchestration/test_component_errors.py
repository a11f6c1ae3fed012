"""Components of a user's own that are wrong: each is refused by name, in one line, before anything runs.

Authority: the contract (ports, sizes, plain functions that never raise and never allocate).
"""

from pathlib import Path

import pytest

from components import compiled
from components.contract import Component
from pipeline import catalogue, kernels
from pipeline.conductor import Conductor
from pipeline.errors import TowlineError
from pipeline.quantities import is_unit
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
MODEL = """\
import functools, math, sys
from components.compiled import kernel
from components.contract import Component, Parameters, Port, Sizes

class Nothing(Parameters):
    pass

@kernel
def half(value):
    return 0.5 * value

def init(t_ns, dt_ns, p, u, x, y, w):
    y[0] = half(1.0)
    return 0

def step(t_ns, dt_ns, p, u, x, y, w):
    y[0] = 1.0
    return 0

def inputs(_):
    return ()

def outputs(_):
    return (Port("n", "1"),)

def sizes(_):
    return Sizes(state=1)

COMPONENT = Component(
    name="own", parameters=Nothing, inputs=inputs, outputs=outputs, sizes=sizes, init=init, step=step
)
"""
SCENARIO = "duration: 4 s\nstep: 1 s\ncomponents: {own: {model: ./own.py}}\n"


@pytest.fixture
def refused(tmp_path, monkeypatch):
    """A function from an edit of the model above to the message it gets; it lays the graph out, and runs nothing."""
    monkeypatch.setattr(compiled, "clear_cache", lambda: None)  # other tests' kernels are in it

    def message(old: str, new: str, scenario: str = SCENARIO) -> str:
        assert old in MODEL
        (tmp_path / "own.py").write_text(MODEL.replace(old, new))
        with pytest.raises(TowlineError) as error:
            Conductor(build_graph(load_scenario_text(scenario, "s.yaml", tmp_path)))
        text = str(error.value).replace(str(tmp_path), "HERE")
        assert len(text.splitlines()) == 1
        return text

    return message


PORT = 'Port("n", "1")'
PORTS = {
    "negative": (
        'Port("n", "1", (-1,))',
        "output 'n' has the shape (-1,); expected a tuple of whole numbers, 0 or more",
    ),
    "fraction": (
        'Port("n", "1", (2.5,))',
        "output 'n' has the shape (2.5,); expected a tuple of whole numbers, 0 or more",
    ),
    "no tuple": ('Port("n", "1", 3)', "output 'n' has the shape 3; expected a tuple of whole numbers, 0 or more"),
    "twice": ('Port("n", "1"), Port("n", "m")', "output 'n' stands twice; expected one port of a name"),
    "port and bundle": (
        'Port("n", "1"), Port("n.m", "m")',
        "output 'n.m' stands beside 'n': a name is a port or a bundle, not both",
    ),
    "bundle and port": (
        'Port("n.m.o", "1"), Port("n.m", "m")',
        "output 'n.m' stands beside 'n.m.o': a name is a port or a bundle, not both",
    ),
    "unit": (
        'Port("n", "furlongs?")',
        "output 'n' is in 'furlongs?', which is not a known unit; expected one such as 'm/s', or '1' for none",
    ),
    "no unit": (
        'Port("n", "")',
        "output 'n' is in '', which is not a known unit; expected one such as 'm/s', or '1' for none",
    ),
} | {
    name: (
        f'Port("{name}", "1")',
        f"output '{name}' is no name; expected letters, digits and _, with a dot between a bundle and its member",
    )
    for name in ("", "a..b", ".a", "a.", "a b", "a/b", "1a")
}


@pytest.mark.parametrize(("new", "expected"), PORTS.values(), ids=PORTS)
def test_ports(refused, new, expected):
    assert refused(PORT, new) == f"s.yaml:3:14 components.own: {expected}"


def test_inputs_too(refused):
    message = refused("return ()", 'return [Port("a", "1", (-1,))]')
    assert message.startswith("s.yaml:3:14 components.own: input 'a' has the shape (-1,)")


@pytest.mark.parametrize("length", ["-1", "1.5"])
def test_sizes(refused, length):
    expected = f"its state takes {length} numbers; expected a whole number, 0 or more"
    assert refused("state=1", f"state={length}") == f"s.yaml:3:14 components.own: {expected}"


UNITS = ["1", "m", "m/s^2", "1/s", "N m", "N s/m", "kg/m", "rad/s", "N/(m/s)", "kN", "deg", "lumen", "knot"]


@pytest.mark.parametrize("unit", UNITS)
def test_units(unit):
    assert is_unit(unit)


@pytest.mark.parametrize("unit", ["", "furlongs?", "m/", "/s", "m s^x", "metrez", "2 m", "m^12^3"])
def test_no_units(unit):
    assert not is_unit(unit)


RAISING = {
    "raise": ("    y[0] = 1.0", "    if y[0] > 0.0:\n        raise ValueError\n    y[0] = 1.0", "step at line 18"),
    "assert": ("    y[0] = 1.0", "    assert x[0] == 0.0\n    y[0] = 1.0", "step at line 17"),
    "in a kernel": ("    return 0.5 * value", "    assert value\n    return 0.5 * value", "half at line 10"),
    "in a kernel of a kernel": (
        "@kernel\ndef half(value):\n",
        "@kernel\ndef inner(value):\n    assert value\n\n@kernel\ndef half(value):\n    inner(value)\n",
        "inner at line 10",
    ),
    "in a function inside": (
        "    y[0] = 1.0",
        "    def check(value):\n        assert value\n    check(1.0)\n    y[0] = 1.0",
        "step at line 18",
    ),
}


@pytest.mark.parametrize(("old", "new", "where"), RAISING.values(), ids=RAISING)
def test_a_kernel_that_raises(refused, old, new, where):
    """Compiled, it would print a traceback and go on as if it had returned 0."""
    remedy = "return a positive status and explain it in status_text"
    expected = f"'./own.py': {where} of own.py raises, and a compiled kernel cannot raise; {remedy}"
    assert refused(old, new) == f"s.yaml:3:27 components.own.model: {expected}"


def test_python_may_raise(tmp_path):
    text = MODEL.replace("    y[0] = 1.0", "    assert y[0]\n    y[0] = 1.0").replace(
        "step=step", "step=step, compiled=False"
    )
    (tmp_path / "own.py").write_text(text)
    assert build_graph(load_scenario_text(SCENARIO, "s.yaml", tmp_path)).ticks == 4


@pytest.mark.parametrize("model", catalogue.models())
def test_no_component_of_this_repository_raises(model):
    """find() refuses one that does."""
    _, component = catalogue.find(model, Path())
    assert isinstance(component, Component)
    assert kernels.fault(component) == ""


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("step=step", "step=functools.partial(step)", "step is a partial; expected a plain function, made by def"),
        ("step=step", "step=half", "step is a CompiledKernel; expected a plain function, made by def"),
        (
            "def step(t_ns, dt_ns,",
            "def step(t_ns,",
            "step does not take the arguments of a component; expected def step(",
        ),
        ("step=step", "step=None, compiled=False", "step is a NoneType; expected a function"),
        ("name=", "name=3 or ", "has a COMPONENT whose name is no text or whose parameters are no Parameters class"),
        ("=Nothing", "=dict", "has a COMPONENT whose name is no text or whose parameters are no Parameters class"),
        ("def half", "sys.exit(3)\ndef half", "cannot be loaded: SyntaxError: invalid syntax"),
        ("def init", "sys.exit(3)\ndef init", "cannot be loaded: SystemExit: 3"),
    ],
)
def test_functions_and_files(refused, old, new, expected):
    message = refused(old, new)
    assert message.startswith("s.yaml:3:27 components.own.model: ")
    assert expected in message


STEP = "    y[0] = 1.0"
UNCOMPILED = {
    "unknown name": ("y[0] = foo(x)", "NameError: name 'foo' is not defined"),
    "unknown attribute": ("y[0] = math.sine(x[0])", "module 'math' has no attribute 'sine'"),
    "allocates": ("y[:] = x + 1.0", "it allocates memory, which a kernel may not (No implementation of function"),
    "text": ("y[0] = 'a'", "found for signature: setitem(array(float64, 1d, C)"),
    "class": ("class A: pass", "Use of unsupported opcode (LOAD_BUILD_CLASS) found"),
    "no number": ("return 'a'", "No conversion from Literal[str](a) to int64"),
}


@pytest.mark.parametrize(("statement", "expected"), UNCOMPILED.values(), ids=UNCOMPILED)
def test_a_kernel_that_does_not_compile(refused, statement, expected):
    message = refused(STEP, f"    {statement}")
    assert message.startswith("own (HERE/own.py) cannot be compiled: ")
    assert expected in message
    assert message.endswith(" (--debug shows all)")


BOTH = "    y[0] = half(1.0)\n    return 0\n\ndef step(t_ns, dt_ns, p, u, x, y, w):\n    y[0] = 1.0\n"


@pytest.mark.parametrize(
    ("init", "step", "where"),
    [("y[0]", "y[1]", "step at line 17"), ("x[1]", "y[0]", "init at line 13"), ("y[0]", "x[t_ns]", "step at line 17")],
)
def test_a_kernel_that_goes_beyond_its_vectors(refused, init, step, where):
    """Compiled, it would write into other components' memory, without a word."""
    message = refused(BOTH, BOTH.replace("y[0] = 1.0", f"{step} = 1.0").replace("y[0] = half(1.0)", f"{init} = 0.5"))
    assert message.startswith(f"own (HERE/own.py): {where} of own.py goes beyond a vector")


def test_a_kernel_that_does_not_compile_tells_its_line(refused):
    assert ", line 10 of own.py (--debug" in refused("return 0.5 * value", "return value.nothing")


@pytest.mark.parametrize("path", sorted(SCENARIOS.glob("*.yaml")), ids=lambda path: path.stem)
def test_scenarios_of_this_repository_for_two_seconds(path):
    """Their components' ports, units and kernels pass, and none's period is longer than a short run."""
    assert build_graph(load_scenario(path, (), "2 s")).ticks > 0
