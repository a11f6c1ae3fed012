"""A towed line brought to a shape by its two ends: by the paper's law, and by planning ahead.

The scenarios of figures 8 and 9 of Bhattacharya et al. 2011, run whole.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
# Scenario, method, what of its text is left out, when its shapes are to be reached [s].
CASES = (
    ("boom_u_v_square", "law", "", (199.0, 399.0, 599.0)),
    ("boom_circle", "law", "      horizon: 40 s\n", (100.0,)),
    ("boom_circle", "plan", "", (100.0,)),
)
NEAR = 1.02  # of the last error: from then on nothing is gained
Row = dict[str, str | float]


def _row(name: str, method: str, without: str, due: tuple[float, ...], folder: Path) -> Row:
    text = (SCENARIOS / f"{name}.yaml").read_text()
    assert without in text
    scenario = load_scenario_text(text.replace(without, ""), f"{name}.yaml", SCENARIOS)
    out = folder / f"{name}_{method}.mcap"
    result = run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
    log = open_log(out)
    t, error = log.times("boats") * 1e-9, log.port("boats", "error.largest")
    last = max(float(np.interp(when, t, error)) for when in due)
    row: Row = {"case": name, "method": method, "error": last, "error_unit": "rad, largest of all segments at the end"}
    if len(due) == 1:
        row["reached_s"] = float(t[np.argmax(error <= NEAR * last)])
    return {**row, "real_time_factor": result.real_time_factor, "reference": "the shape asked for"}


def rows() -> list[Row]:
    """One row a scenario and method."""
    with tempfile.TemporaryDirectory() as folder:
        return [_row(*case, Path(folder)) for case in CASES]
