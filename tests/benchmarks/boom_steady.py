"""The trials of Bhattacharya et al. 2011, section V: all of them towed, and what points of a rope tell of its drag.

Each of the 16 pairs runs as scenarios/boom_steady.yaml with 20 and with 40 segments; the reference is the catenary of
their eq. 9, and the force that it asks of a boat. The figure redraws 7a and 7b; in the place of the paper's pictures
stand those of scenarios/boom_views.yaml, whose rope has quadratic drag across only.
"""

from __future__ import annotations

import tempfile
import time
from math import log2
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.analysis.coverage import exact
from pipeline.analysis.coverage.drag import ACROSS, EQUAL
from pipeline.analysis.coverage.steady import shape
from pipeline.analysis.drag.fit import FAMILIES, Judgement, Problem, judge
from pipeline.analysis.drag.pictures import Errors, Pictures
from pipeline.analysis.drag.recorded import Asked, pictures
from pipeline.conductor import Conductor
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

ROOT = Path(__file__).parents[2]
SCENARIOS, FIGURE = ROOT / "scenarios", ROOT / "docs" / "boom_shapes.svg"
LENGTH, FRICTION = 18.288, 0.05  # of scenarios/parameters/boom_rope.yaml [m, N s/m^2]
# Separations [m] and speeds [m/s] of the trials.
TRIALS = {4: (0.8, 1.0, 1.4), 6: (0.6, 0.9, 1.2), 8: (0.6, 0.7, 0.8, 0.9, 1.0), 10: (0.5, 0.7, 0.8), 12: (0.5, 0.75)}
COLOURS = ("#12608a", "#3c8d53", "#d1495b", "#e0912f", "#5b6770")
STYLE = {"font.size": 9, "axes.grid": True, "grid.color": "#e4e4e4", "svg.fonttype": "none", "svg.hashsalt": "towline",
         "axes.spines.top": False, "axes.spines.right": False}  # fmt: skip
Row = dict[str, str | float]


def towed(D: float, v: float, segments: int) -> tuple[np.ndarray, np.ndarray, float]:
    """After 60 s: nodes (n + 1, 2) across and along from end a, force on it (2) likewise [N]; times real time."""
    text = (SCENARIOS / "boom_steady.yaml").read_text()
    for old, new in (("8 m, 0 m]", f"{D} m, 0 m]"), ("[1, 0.8, 0, 0]", f"[1, {v}, 0, 0]"),
                     ("segments: 40", f"segments: {segments}")):  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    conductor = Conductor(build_graph(load_scenario_text(text, "boom_steady.yaml", SCENARIOS)))
    conductor.initialise()
    ticks, began = conductor.graph.ticks, time.perf_counter()
    for _ in conductor.run(ticks):
        pass
    wall = time.perf_counter() - began
    y = conductor.memory.tables.board[18:]
    nodes, at = y[: 3 * (segments + 1)].reshape(-1, 3), 4 * segments + 3
    return (nodes - nodes[0])[:, [1, 0]], y[at : at + 2][::-1].copy(), 60.0 / wall


def catenary(D: float, segments: int) -> np.ndarray:
    """The exact nodes, across and along from end a."""
    a = 0.5 * D / exact.u_at(EQUAL, D / LENGTH)
    s = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, segments + 1)
    nodes = np.column_stack([a * np.arcsinh(s / a), np.hypot(a, s)])
    return nodes - nodes[0]


def trial(D: float, v: float) -> tuple[Row, np.ndarray]:
    """The row of a pair, and its nodes with 20 segments."""
    misses, shapes, force, factor = [], [], np.zeros(2), 0.0
    for segments in (20, 40):
        nodes, force, factor = towed(D, v, segments)
        misses.append(np.linalg.norm(nodes - catenary(D, segments), axis=1).max() / LENGTH)
        shapes.append(nodes)
    pull = FRICTION * v * LENGTH * exact.tow(EQUAL, exact.u_at(EQUAL, D / LENGTH)).force
    row: Row = {
        "case": f"D = {D} m, v = {v} m/s",
        "method": "boom_steady",
        "error": misses[1],
        "error_20": misses[0],
        "error_unit": "largest distance over the length, 40 segments (error_20: 20)",
        "order": log2(misses[0] / misses[1]),
        "force_error": abs(float(np.linalg.norm(force)) / pull - 1.0),
        "real_time_factor": factor,
        "reference": "catenary, eq. 9",
    }
    return row, shapes[0]


def seen(folder: Path) -> tuple[Pictures, Pictures]:
    """The steady pictures of boom_views, without and with the pulls."""
    scenario = load_scenario_text((SCENARIOS / "boom_views.yaml").read_text(), "boom_views.yaml", SCENARIOS)
    out = folder / "views.mcap"
    run_scenario(scenario, build_graph(scenario), out, Options(scene=False), lambda _: None)
    with open_log(out) as log:
        plain, _ = pictures(log, Asked())
        pulled, _ = pictures(log, Asked(pulls=("boom.force_a", "boom.force_b")))
    return plain, pulled


def identified(found: Judgement, what: str, wall: float) -> list[Row]:
    """A row for each law."""
    least = found.fits[0].chi2
    return [
        {
            "case": f"drag from {what}",
            "method": one.family.name,
            "c_V/c_S": f"{one.ratio:.4f} ({one.low:.4f} to {one.high:.4f})",
            "chi2_above_best": one.chi2 - least,
            "verdict": "allowed" if one.family.name in found.equal else "excluded",
            "error_unit": "chi-square over its freedom",
            "error": one.chi2 / one.freedom,
            "wall_s": wall,
            "reference": "quadratic, across only (the simulated rope)",
        }
        for one in found.fits
    ]


def draw(shapes: dict[float, np.ndarray], views: Pictures, path: Path) -> None:
    """Figures 7a and 7b, and chi-square over the ratio."""
    with rc_context(STYLE):
        figure = Figure(figsize=(10.5, 3.4), layout="constrained")
        steady, points, ratio = figure.subplots(1, 3)
        for (D, nodes), colour in zip(shapes.items(), COLOURS, strict=True):
            exact_nodes = catenary(D, 400)
            steady.plot(*(exact_nodes - (0.5 * D, 0.0)).T, color=colour, label=f"D = {D} m")
            steady.plot(*(nodes - (0.5 * D, 0.0)).T, "o", color=colour, markersize=2.5)
        steady.set(title="20 segments on catenaries", xlabel="across [m]", ylabel="along the tow [m]", aspect="equal",
                   xlim=(-7.0, 7.0), ylim=(-9.5, 4.0))  # fmt: skip
        steady.legend(fontsize=8, frameon=False, loc="upper center", ncol=2)
        _draw_points(points, views)
        problem, ratios = Problem(views, Errors()), np.linspace(0.0, 1.0, 26)
        for family, colour in zip(FAMILIES, COLOURS, strict=False):
            chi2 = [problem.chi2(family.law(float(one)))[0] / problem.counted for one in ratios]
            ratio.semilogy(ratios, chi2, "--" if family.ratio else "-", color=colour, label=family.name)
        ratio.set(title="what the points tell", xlabel="$c_V/c_S$", ylabel="χ² over the number of points",
                  ylim=(0.8, 300.0))  # fmt: skip
        ratio.legend(fontsize=8, frameon=False, loc="upper center")
        figure.savefig(path, metadata={"Date": None})


def _draw_points(axes: Axes, views: Pictures) -> None:
    """The first steady picture's points and two laws between its ends."""
    ends, points = views.placed(np.zeros(6))
    middle = ends[0].mean(axis=0)
    D = float(np.ptp(ends[0, :, 0]))
    visible = np.isfinite(views.deviation[0])
    for law, colour, label in (
        (ACROSS, "#4bb3c8", "linear, $c_V = 0$"),
        (EQUAL, COLOURS[0], "$c_V = c_S$, and two more"),
    ):
        line = LENGTH * shape(law, D / LENGTH, 201)
        axes.plot(line[:, 0], line[:, 1] - line[0, 1], color=colour, label=label)
    axes.plot(*(points[0][visible] - middle).T, ".", color=COLOURS[2], markersize=3, label="seen from the boats")
    axes.set(title=f"points of a rope, D = {D:.0f} m", xlabel="across [m]", aspect="equal", xlim=(-7.0, 7.0),
             ylim=(-9.5, 4.0))  # fmt: skip
    axes.legend(fontsize=8, frameon=False, loc="upper center")


def rows() -> list[Row]:
    """All 16 pairs, then the law of drag; the figure is drawn anew."""
    table: list[Row] = []
    shapes: dict[float, np.ndarray] = {}
    for D, speeds in TRIALS.items():
        for v in speeds:
            row, shapes[D] = trial(D, v)
            table.append(row)
    with tempfile.TemporaryDirectory() as folder:
        plain, pulled = seen(Path(folder))
    for views, what in ((plain, "points"), (pulled, "points and pulls of 2 %")):
        began = time.perf_counter()
        found = judge(views, Errors())
        table += identified(found, f"{int(np.isfinite(views.deviation).sum())} {what}", time.perf_counter() - began)
    draw(shapes, plain, FIGURE)
    return table
