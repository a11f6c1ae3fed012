"""A component that stops the run, in each way it can: component, time, cause and inputs are named, the log is whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.conductor import Conductor
from pipeline.errors import StepError
from pipeline.graph import Graph
from pipeline.hosts.python import RAISED
from pipeline.log.reader import open_log
from pipeline.loop_tables import NON_FINITE
from pipeline.run import RESULT, Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

MODELS = Path(__file__).parent / "components"
COUNT_TO = (
    "components: {{a: {{model: ./counter.py}}, b: {{model: ./relay.py, parameters: {{{}}}, inputs: {{in: a.n}}}}}}"
)


def run(graph: Graph) -> Conductor:
    conductor = Conductor(graph)
    conductor.initialise()
    for _ in conductor.run(graph.ticks):
        pass
    return conductor


def test_status(graph):
    with pytest.raises(StepError) as caught:
        run(graph(COUNT_TO.format("stop_at: 4")))
    expected = "b stopped the run at t = 4 s: it saw the number it was told to stop at (inputs: in = 4 1)"
    assert str(caught.value) == expected


def test_status_at_init(graph):
    with pytest.raises(StepError, match="b stopped the run at t = 0 s: it saw the number"):
        run(graph(COUNT_TO.format("stop_at: 0")))


def test_non_finite_output(graph):
    with pytest.raises(StepError, match=r"b stopped the run at t = 3 s: its output out\[1\] is not finite \(inputs"):
        run(
            graph(
                "components: {a: {model: ./counter.py}, c: {model: ./counter.py},"
                " b: {model: ./relay.py, parameters: {width: 2, poison_at: 3}, inputs: {'in[0]': a.n, 'in[1]': c.n}}}"
            )
        )


def test_python_exception(graph):
    def broken(t_ns, dt_ns, p, u, x, y, w):
        raise ZeroDivisionError("a mistake in a component")

    built = graph(COUNT_TO.format(""))
    b = replace(built.nodes[1], component=replace(built.nodes[1].component, compiled=False, step=broken))
    with pytest.raises(
        StepError, match=r"b stopped the run at t = 1 s: its Python code raised ZeroDivisionError: a mis"
    ):
        run(replace(built, nodes=(built.nodes[0], b)))


@pytest.mark.parametrize(("raised", "said"), [(ValueError("one\ntwo"), "ValueError: one"), (OSError(), "OSError")])
def test_python_exception_is_one_line(graph, raised, said):
    def broken(t_ns, dt_ns, p, u, x, y, w):
        raise raised

    built = graph(COUNT_TO.format(""))
    b = replace(built.nodes[1], component=replace(built.nodes[1].component, compiled=False, step=broken))
    with pytest.raises(StepError) as caught:
        run(replace(built, nodes=(built.nodes[0], b)))
    expected = f"b stopped the run at t = 1 s: its Python code raised {said} (inputs: in = 1 1)"
    assert str(caught.value) == expected


@pytest.mark.parametrize("status", [NON_FINITE, RAISED])
def test_statuses_that_mean_something_to_the_loop(graph, status):
    """A component's own status is told as such, though the loop marks its findings by the same numbers."""

    def stops(t_ns, dt_ns, p, u, x, y, w):
        y[0] = u[0]
        return status

    built = graph(COUNT_TO.format(""))
    b = replace(built.nodes[1], component=replace(built.nodes[1].component, compiled=False, init=stops))
    with pytest.raises(StepError, match=f"b stopped the run at t = 0 s: status {status}, which it does not explain"):
        run(replace(built, nodes=(built.nodes[0], b)))


def test_keyboard_interrupt_in_a_python_component_is_one(graph):
    def interrupted(t_ns, dt_ns, p, u, x, y, w):
        raise KeyboardInterrupt

    built = graph(COUNT_TO.format(""))
    b = replace(built.nodes[1], component=replace(built.nodes[1].component, compiled=False, step=interrupted))
    with pytest.raises(KeyboardInterrupt):
        run(replace(built, nodes=(built.nodes[0], b)))


def test_log_holds_everything_up_to_the_stop(tmp_path):
    text = "duration: 60 s\nstep: 1 s\n" + COUNT_TO.format("stop_at: 40")
    scenario = load_scenario_text(text, "test.yaml", MODELS)
    with pytest.raises(StepError):
        run_scenario(scenario, build_graph(scenario), tmp_path / "stopped.mcap", Options(), lambda _: None)
    log = open_log(tmp_path / "stopped.mcap")
    assert log.complete
    assert log.values("b")[:, 0].tolist() == list(range(40))
    assert "b stopped the run at t = 40 s" in log.metadata(RESULT)["ending"]
