"""The pool scenes' statistics: the README's table, and the fast fit against the published one on the scenes' frames.

Authority: Nelder-Mead as published; the README, to the digits it prints.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from components.tether.catenary.hang import hang
from pipeline.analysis.indicators import fit_frames
from pipeline.analysis.markers import marker_frames
from pipeline.analysis.published import published
from pipeline.analysis.recording import recordings
from pipeline.cli import main

README = Path(__file__).parents[2] / "README.md"
INDICATORS = ("alpha_deg", "e_plane_mm", "e_catenary_mm")
SCENES = ("pool_chain", "pool_rope")
SEARCHED = 60  # frames a scene: the published search takes 6 ms each; the bench `validity` takes all 21,000


def printed() -> dict[str, list[list[str]]]:
    """Cells of the README's table by the rows' names, the numbers in each; the published rows after their scenes."""
    found: dict[str, list[list[str]]] = {}
    scene = ""
    section = README.read_text().split("## Was the catenary valid?")[1].split("\n## ")[0]
    for line in section.splitlines():
        name, *cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if name in SCENES or name == "published":
            scene = name if name in SCENES else scene
            key = scene if name in SCENES else f"{scene} published"
            found[key] = [re.findall(r"\d+(?:\.\d+)?", cell) for cell in cells]
    return found


def agrees(text: str, value: float) -> bool:
    """Whether the value, rounded to the digits of the text, is the text."""
    return abs(value - float(text)) <= 0.5000001 * 10.0 ** -len(text.partition(".")[2])


@pytest.mark.parametrize("scene", SCENES)
def test_readme_table(capsys, pool_logs, scene):
    capsys.readouterr()
    assert main(["validity", str(pool_logs[scene]), "--json"]) == 0
    cable = json.loads(capsys.readouterr().out)["cables"]["markers"]
    *indicators, failing = printed()[scene]
    assert len(indicators) == 3
    for name, (median, mean) in zip(INDICATORS, indicators, strict=True):
        assert agrees(median, cable[name]["median"]), (name, median, cable[name]["median"])
        assert agrees(mean, cable[name]["mean"]), (name, mean, cable[name]["mean"])
    share = 100.0 * sum(span["frames"] for span in cable["fails"]) / cable["frames_used"]
    assert agrees(failing[-1], share)
    there = published(scene)
    assert there is not None
    for name, (median, mean) in zip(INDICATORS, printed()[f"{scene} published"][:3], strict=True):
        assert agrees(median, getattr(there, name).median)
        assert agrees(mean, getattr(there, name).mean)


@pytest.mark.parametrize("scene", SCENES)
def test_fast_is_never_worse_than_the_published_search(pool_logs, scene):
    """0.1 % more residual is allowed in one frame of 1000: in none of these."""
    frames = recordings(pool_logs[scene])[0].frames
    rows = np.linspace(0, len(frames.t_ns) - 1, SEARCHED).astype(int)
    some = replace(frames, t_ns=frames.t_ns[rows], position=frames.position[rows], valid=frames.valid[rows])
    fast, searched = (fit_frames(some, method, marker_sigma=4e-4) for method in ("fast", "nelder-mead"))
    both = fast.fitted & searched.fitted
    assert both.sum() > 0.9 * SEARCHED
    assert (fast.e_catenary[both] < 1.001 * searched.e_catenary[both]).all()


@pytest.mark.parametrize("scene", SCENES)
def test_all_frames_with_markers_enough_are_identifiable(pool_logs, scene):
    """What refuses straight lines must not refuse moving ones: their sag is a metre, their noise 0.4 mm."""
    recording = recordings(pool_logs[scene])[0]
    fits = fit_frames(recording.frames, marker_sigma=recording.origin.noise)
    assert fits.fitted[fits.n > 6].all(), fits.reasons()


def leaning_line(length, span, markers, spacing, power):
    """Markers on a static catenary under a small sideways load that grows as a power of the distance from end a.

    Linear statics: H y'' = -q ds/dx with H the horizontal tension, y = 0 at both ends. NED [m], end b at x = span.
    """
    line = hang(length, 1.0, span, 0.0, 1e9)
    C = 1.0 / line.H_N
    x = np.linspace(0.0, span, 20_001)
    z = (np.cosh(C * (x - span / 2)) - np.cosh(C * span / 2)) / C
    slope = np.cosh(C * (x - span / 2))  # ds/dx
    s = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(x) * (slope[1:] + slope[:-1]))])
    load = 0.01 * C * slope * (s / s[-1]) ** power
    for _ in range(2):
        load = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(x) * (load[1:] + load[:-1]))])
    y = load[-1] * x / span - load
    places = length - spacing * np.arange(markers)[::-1]
    return np.stack([np.interp(places, s, one) for one in (x, y, -z)], axis=1)


@pytest.mark.parametrize(
    ("scene", "line", "per_degree"),
    [("pool_chain", (3.5, 2.1, 12, 0.245), 1.18), ("pool_rope", (2.0, 1.2, 9, 0.2), 0.79)],
)
def test_leaning_goes_with_bending(pool_logs, scene, line, per_degree):
    """Drawn sideways at end b alone, drag goes with the square of the distance from end a: no plane holds the line.

    Statics give e_P for each degree of alpha, as the README says; the moving scene, whose turns bend it further, has up
    to twice that. A uniform load only leans the plane. Tolerance: the README's digits.
    """
    uniform, sheared = fit_frames(
        marker_frames(np.arange(2), np.stack([leaning_line(*line, p) for p in (0, 2)]))
    ).e_plane
    alpha = np.degrees(fit_frames(marker_frames(np.arange(1), leaning_line(*line, 2)[None])).alpha[0])
    assert uniform < 1e-3 * sheared
    assert 1e3 * sheared / alpha == pytest.approx(per_degree, abs=0.01)
    fits = fit_frames(recordings(pool_logs[scene])[0].frames, marker_sigma=4e-4)
    leans = fits.fitted & (fits.n > 6) & (fits.alpha > np.radians(1.0))
    found = np.median(1e3 * fits.e_plane[leans] / np.degrees(fits.alpha[leans]))
    assert per_degree < found < 2.1 * per_degree
