"""The summary of a run whose component has ports without numbers, and one called nodes that is no line.

Authority: the contract, in which a count may be zero.
"""

from io import StringIO

import pytest
from rich.console import Console

from pipeline.commands.summary import print_summary
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

MODEL = """\
from components.contract import Component, Parameters, Port

class Nothing(Parameters):
    pass

def step(t_ns, dt_ns, p, u, x, y, w):
    for i in range(len(y)):
        y[i] = i
    return 0

COMPONENT = Component(
    name="empty", parameters=Nothing, outputs=lambda _: (PORTS,), init=step, step=step, compiled=False
)
"""


@pytest.mark.parametrize(
    ("ports", "shown"),
    [
        ('Port("none", "m", (0, 3), "NED"), Port("one", "N")', ["one"]),
        ('Port("nodes", "m", (2,), "NED"), Port("none", "1", (0,))', ["nodes"]),
        ('Port("none", "1", (0,))', []),
    ],
)
def test_summary(tmp_path, ports, shown):
    (tmp_path / "model.py").write_text(MODEL.replace("PORTS", ports))
    text = "duration: 4 s\nstep: 1 s\ncomponents: {a: {model: ./model.py}}\n"
    scenario = load_scenario_text(text, "test.yaml", tmp_path)
    result = run_scenario(scenario, build_graph(scenario), tmp_path / "a.mcap", Options(), lambda _: None)
    console = Console(record=True, width=120, file=StringIO())
    print_summary(console, result)
    printed = console.export_text()
    assert [name for name in ("none", "one", "nodes") if f" {name} " in printed] == shown
    assert "4 component steps" in printed
