"""The estimator of the tether in the main scene, against the log's own tether.

Authority: the dynamic line of tether.cable, which the estimator does not know, in a current that it is told wrongly.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.analysis.estimates import tether_estimates
from pipeline.analysis.markers import lines
from pipeline.analysis.page import line_estimate, tensions
from pipeline.analysis.page.signals import Signals
from pipeline.analysis.page.tab import heading
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario
from pipeline.wiring import build_graph

SCENE = Path(__file__).parents[2] / "scenarios" / "dp_rov_tether.yaml"


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """`seen(component, port)` at the estimator's steps from 30 s on, by when the USBL has given ten positions."""
    scenario, out = load_scenario(SCENE, duration="150 s"), tmp_path_factory.mktemp("rov") / "rov.mcap"
    run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
    log = open_log(out)
    steps = log.times("estimator")[log.times("estimator") >= 30_000_000_000]

    def at(component, port):
        return log.port(component, port)[np.searchsorted(log.times(component), steps)]

    at.log = log
    return at


def test_it_is_not_judged_as_a_line_of_its_own(seen):
    assert lines(seen.log) == ["tether"]


def rms(values):
    return np.sqrt((values**2).mean(axis=0))


def test_shape(seen):
    """Within 2 % of the line's length; its lag behind the ROV is the most of that."""
    off = seen("estimator", "nodes") - seen("tether", "nodes")[:, ::2]
    assert rms(np.linalg.norm(off, axis=2).ravel()) <= 0.02 * 187.0
    assert (seen("estimator", "held") == 0.0).all()


def test_end_tensions(seen):
    """Both within 6 N, at swings of 14 N; as sure as the filter says, to the factor that 240 correlated steps allow."""
    true = np.maximum(seen("tether", "tension")[:, [0, -1]], 0.0)
    off, rest = seen("estimator", "tension") - true, seen("estimator", "mean_tension") - true
    assert (rms(off) <= [2.5, 6.5]).all()
    assert (rms(off) <= 0.6 * rms(rest)).all()
    sure = rms(off / seen("estimator", "deviation.tension"))
    assert ((sure > 0.6) & (sure < 1.6)).all()


def test_end_b(seen):
    """A fix of the USBL scatters by 0.6 m each way and is off by the slow errors of its angles, compass and GNSS."""
    off = seen("estimator", "end_b.position") - seen("rov", "hook.position")
    assert rms(np.linalg.norm(off, axis=1)) <= 1.5
    assert (rms(off / seen("estimator", "deviation.end_b")) <= 1.5).all()


def test_page_shows_it_beside_the_simulated_line(seen):
    """What the page says is what the other tests here find: places at equal shares of the length, within the stretch
    and the arc's rounding at nodes (0.1 m); tensions as the line gives them to its holders."""
    signals = Signals(seen.log)
    (found,) = tether_estimates(signals)
    late = found.t >= 30.0
    off = np.linalg.norm(seen("estimator", "nodes") - seen("tether", "nodes")[:, ::2], axis=2)
    assert found.off[late] == pytest.approx(off, abs=0.1)
    true = np.linalg.norm(seen("tether", "force_a"), axis=1)
    assert found.true_tension[late, 0] == pytest.approx(true, rel=1e-12)
    charts = {item.title: item for item in line_estimate.tab(signals).items if not isinstance(item, str)}
    for end in "ab":
        names = [series.name for series in charts[f"Tension at end {end}"].series]
        assert names == ["estimated", "+2σ", "−2σ", "simulated"]
    assert sum(title.startswith("NIS of the") for title in charts) == 2
    assert not [item for item in tensions.tab(signals).items if item == heading("estimator")]
