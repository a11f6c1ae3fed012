"""What the pool scenes' indicators owe to noise, hand, water and resolution: one thing changed at a time.

Medians over the reliable frames, markers without noise or drop-out where not said otherwise.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import yaml

from pipeline.analysis.published import published
from pipeline.analysis.recording import recordings
from pipeline.analysis.validity import Cable, Tolerance, judge
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"
HAND = SCENARIOS / "parameters" / "pool_hand.yaml"
LEANING_DEG = 1.0  # frames in which alpha says something about e_P: the tremor alone leans the rope by 0.2 deg
SEGMENTS = {"pool_chain": 50, "pool_rope": 40}
DRAG = {"pool_chain": 1.0, "pool_rope": 1.2}
# The same moves in the vertical plane through the ends; two axes that become one are taken as the other one.
IN_PLANE = (
    ("north-east-down", "north-down"),
    ("sweep north-east", "sweep north"),
    ("east-down", "north-down"),
    ("north-east", "north-down"),
    (" east", " north"),
)

Row = dict[str, str | float]


def _in_plane() -> str:
    moves = yaml.safe_load(HAND.read_text())["moves"]
    for across, along in IN_PLANE:
        moves = [move.replace(across, along) for move in moves]
    return f"hand.moves={moves}"


def _variants(name: str) -> dict[str, tuple[str, ...]]:
    """Settings by what they stand for."""
    clean = ("markers.noise=0 m", "markers.lost_time=0 s")
    still, fine = "hand.tremor=0 m", 2 * SEGMENTS[name]
    durations = [2.0 * value for value in yaml.safe_load(HAND.read_text())["durations"]["values"]]
    half = ("hand.slow=0.15 m/s", "hand.fast=0.5 m/s", f"hand.durations={{values: {durations}, unit: s}}")
    return {
        "as it is, noise 0.4 mm": (),
        "noise 1 mm": ("markers.noise=1 mm",),
        "no noise": clean,
        "no tremor": (*clean, still),
        "no moves across": (*clean, _in_plane()),
        "half the speeds": (*clean, *half),
        "half the speeds, no tremor": (*clean, *half, still),
        "half the drag": (*clean, f"tether.normal_drag={0.5 * DRAG[name]}"),
        "no added mass": (*clean, "tether.normal_added_mass=0"),
        "twice the segments": (*clean, f"tether.segments={fine}", f"markers.segments={fine}"),
        "half the step": clean,
    }


def _judged(name: str, variant: str, settings: tuple[str, ...], folder: Path) -> Cable:
    path = SCENARIOS / f"{name}.yaml"
    text = path.read_text()
    if variant == "half the step":
        text = text.replace("step: 20 ms", "step: 10 ms")
    record_s = float(yaml.safe_load(text)["duration"].split()[0])
    duration = f"{2.0 * record_s} s" if variant.startswith("half the speeds") else None
    scenario = load_scenario_text(text, path.name, path.parent, settings, duration)
    out = folder / "run.mcap"
    run_scenario(scenario, build_graph(scenario), out, Options(overwrite=True, scene=False), lambda _: None)
    return judge(recordings(out)[0], "fast", Tolerance(0.01, True))


def rows() -> list[Row]:
    """One row a scene and variant."""
    table = []
    with tempfile.TemporaryDirectory() as folder:
        for name in SEGMENTS:
            there = published(name)
            assert there is not None
            for variant, settings in _variants(name).items():
                cable = _judged(name, variant, settings, Path(folder))
                table.append(_row(name, variant, cable, there.e_plane_mm.median))
    return table


def _row(name: str, variant: str, cable: Cable, reference: float) -> Row:
    s, fits = cable.statistics, cable.fits
    assert s.alpha_deg is not None
    assert s.e_plane_mm is not None
    assert s.e_catenary_mm is not None
    alpha = np.degrees(fits.alpha)
    leaning = alpha > LEANING_DEG
    bend = float(np.median(1e3 * fits.e_plane[leaning] / alpha[leaning])) if leaning.any() else "never leans"
    return {
        "case": name,
        "method": variant,
        "error": s.e_plane_mm.median / reference,
        "error_unit": "median of e_P over the published one",
        "alpha_deg": s.alpha_deg.median,
        "e_P_mm": s.e_plane_mm.median,
        "e_C_mm": s.e_catenary_mm.median,
        "e_P_mm_per_deg": bend,
        "reference": "Drupt et al. 2022, Tables II and III",
    }
