"""A run tells how far its models were inside or outside their validity range, resumed or not; and what is modelled."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pipeline.cli import main
from pipeline.log.reader import open_log
from pipeline.rerun import graph_of
from pipeline.resume import resume_run
from pipeline.run import Options, Run, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

MODELS = Path(__file__).parents[1] / "orchestration" / "components"
# Recorded every 100 steps only: the figures must come from all of them.
SCENARIO = """
duration: 2000 s
step: 1 s
components:
  line: {model: ./ranged.py, record: every 100}
"""
# By the model: 0.1 a second, so steps 11..2000 of the 2001 rows are outside; float64 sums of 0.1 k are products here.
EXPECTED = {"line": {"largest": 200.0, "outside_share": 1990 / 2001, "strain": 200.0, "slope": 100.0}}


def graph_and_scenario():
    scenario = load_scenario_text(SCENARIO, "test.yaml", MODELS)
    return scenario, build_graph(scenario)


def test_over_all_steps(tmp_path):
    result = run_scenario(*graph_and_scenario(), tmp_path / "a.mcap", Options(), lambda _: None)
    assert result.validity == EXPECTED


def test_resumed_run_has_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr("pipeline.run.FLUSH_S", 0.0)  # a snapshot at each block end
    path = tmp_path / "a.mcap"
    run = Run(*graph_and_scenario(), path, Options())
    run.start()
    run.go(1500, lambda _: None)
    run.__exit__(RuntimeError, RuntimeError(), None)  # the log is left unfinished
    with open_log(path) as log:
        result = resume_run(log, *graph_of(log), tmp_path / "b.mcap", Options(), lambda _: None)
    assert result.validity == EXPECTED


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text(SCENARIO.replace("./ranged.py", str(MODELS / "ranged.py")))
    return path


def test_summary_says_so(file, tmp_path, capsys):
    assert main(["run", str(file), "--out", str(tmp_path / "a.mcap"), "--explain"]) == 0
    said = capsys.readouterr().err
    assert "line: outside its validity range in 99.5 % of its steps (largest 200 of the limit: strain)" in said
    assert "drag is 0" in said


def test_explain_as_json(file, capsys):
    assert main(["check", str(file), "--explain", "--json", "--set", "line.drag=2"]) == 0
    terms = json.loads(capsys.readouterr().out)["terms"]
    assert terms == {"line": [{"name": "drag", "on": True, "why": "drag is 2"}]}
