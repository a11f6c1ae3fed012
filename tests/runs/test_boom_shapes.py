"""Two boats give a rope its shape, by the scenarios of figures 8 and 9 of Bhattacharya et al. 2011."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def run(name, folder, *edits):
    text = (SCENARIOS / f"{name}.yaml").read_text()
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    scenario, out = load_scenario_text(text, f"{name}.yaml", SCENARIOS), folder / "run.mcap"
    run_scenario(scenario, build_graph(scenario), out, Options(overwrite=True), lambda _: None)
    return open_log(out)


def test_u_v_and_square(tmp_path):
    """Each to 1e-6 rad before the next, the rope's ends where the boats are, and the square closed."""
    log = run("boom_u_v_square", tmp_path)
    error = log.port("boats", "error.largest")
    assert error[[995, 1995, 2995]].max() < 1e-6
    assert log.port("boom", "miss").max() < 1e-8
    nodes = log.port("boom", "nodes")
    assert np.linalg.norm(nodes[-1, 0] - nodes[-1, -1]) < 1e-4


def test_circle_by_law_and_by_plan(tmp_path):
    """The plan ends nearer to the circle than the law, and sooner."""
    by_plan = run("boom_circle", tmp_path).port("boats", "error.largest")
    by_law = run("boom_circle", tmp_path, ("      horizon: 40 s\n", "")).port("boats", "error.largest")
    assert by_law[-1] < 0.06
    assert by_plan[-1] < 0.75 * by_law[-1]
    assert by_plan[100] < 0.1 * by_law[100]
