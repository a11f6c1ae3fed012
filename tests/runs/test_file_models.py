"""Components from files beside the scenario: the log holds their sources, and an edit is not taken for the original."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.replay import replay_component
from pipeline.rerun import graph_of, other_sources
from pipeline.resume import resume_run
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

COUNTER = Path(__file__).parents[1] / "orchestration" / "components" / "counter.py"


@pytest.fixture
def interrupted(tmp_path):
    """A folder with a model, a scenario of it, and the log of a run that was interrupted."""
    shutil.copy(COUNTER, tmp_path / "mine.py")
    (tmp_path / "s.yaml").write_text("duration: 600 s\nstep: 1 s\ncomponents: {a: {model: ./mine.py}}\n")
    scenario = load_scenario(tmp_path / "s.yaml")

    def interrupt(simulated_s: float) -> None:
        if simulated_s > 100.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_scenario(scenario, build_graph(scenario), tmp_path / "a.mcap", Options(slice_ticks=50), interrupt)
    return tmp_path


def test_edited_model_is_not_resumed(interrupted):
    model = interrupted / "mine.py"
    model.write_text(model.read_text().replace("x[0] += p", "x[0] += 10 * p"))
    log = open_log(interrupted / "a.mcap")
    with pytest.raises(LogError, match=r"mine.py changed since the log was made"):
        resume_run(log, *graph_of(log), interrupted / "b.mcap", Options(), lambda _: None)


def test_lost_model_is_taken_from_the_log(interrupted):
    scenario = load_scenario(interrupted / "s.yaml")
    whole = run_scenario(scenario, build_graph(scenario), interrupted / "whole.mcap", Options(), lambda _: None)
    (interrupted / "mine.py").unlink()
    log = open_log(interrupted / "a.mcap")
    assert other_sources(log) is None
    resumed = resume_run(log, *graph_of(log), interrupted / "b.mcap", Options(), lambda _: None)
    assert resumed.digest == whole.digest
    graph = graph_of(open_log(interrupted / "b.mcap"))[1]
    assert replay_component(open_log(interrupted / "whole.mcap"), graph, graph.nodes[0]).identical
