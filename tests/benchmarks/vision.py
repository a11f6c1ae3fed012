"""Markers found in rendered images of the model riser: errors, detections and false marks beside the speed.

1280 x 800 pixels, 28.6 images/s, ten seconds of the scenario riser_tank. `clean`: no particles, noise half a grey
level, nothing before the line; `default`: the scenario's scene; `hard`: three times the noise, four times the particles
and these thrice as bright, haze, the camera bumped by (12, -7) pixels after 3 s, and no light from 5 to 6 s. Times are
the processor's, of one thread.

Detections are of markers that the image shows whole. A false mark is a valid one that is not within 3 pixels of its own
marker (`best`), or of any marker (`published`, whose numbers go wrong; how often is told apart).
"""

from __future__ import annotations

import tempfile
import time
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from components.camera.marked_line import model as camera_model
from components.camera.marked_line.rendering import Seen, paint, render
from components.vision.markers import model as vision_model
from components.vision.markers.component import look
from components.vision.markers.finding import Found
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIO = Path(__file__).parents[2] / "scenarios" / "riser_tank.yaml"
PERIOD_S, STEP_S, IMAGES, SEED = 0.035, 0.005, 286, (1.0, 2.0)
NEAR = 3.0  # pixels within which a found marker is the true one
BINNING = 2  # of the scenario's camera
BUMP, BUMPED_S, DARK_S = (12.0, -7.0), 3.0, (5.0, 6.0)
QUIET = {"particles": 0, "noise": 0.5, "shot": 0.0, "obstacles": (), "texture": 0.0, "joint": 0.0}
HARD = {"particles": 1000, "particle_level": 300.0, "noise": 6.0, "shot": 0.15, "turbidity": 0.3}
CASES = {"clean": QUIET, "default": {}, "hard": HARD}
Row = dict[str, str | float]


class Judged(NamedTuple):
    """Of a film: errors (k,) [pixel] and normalised squared errors (k,) of true finds; detected: share of the whole

    markers; false, misnamed: of the finds; time that finding and rendering an image take [s].
    """

    error: np.ndarray
    nees: np.ndarray
    detected: float
    false: float
    misnamed: float
    found_s: float
    rendered_s: float


@cache
def shapes() -> np.ndarray:
    """The riser's nodes in the scenario, (IMAGES, n+1, 3) [m]."""
    text = SCENARIO.read_text()
    scenario = load_scenario_text(text[: text.index("  camera:\n")], "riser.yaml", SCENARIO.parent)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "riser.mcap"
        run_scenario(scenario, build_graph(scenario), path, Options(), lambda _: None)
        return open_log(path).port("riser", "nodes")[:: round(PERIOD_S / STEP_S)][:IMAGES]


@cache
def both() -> tuple[camera_model.MarkedLine, vision_model.Markers]:
    """Parameters of camera and vision, with the pixels that the scenario's camera bins."""
    nodes = {node.name: node.parameters for node in build_graph(load_scenario(SCENARIO)).nodes}
    camera, vision = nodes["camera"], nodes["vision"]
    wide = {"width": BINNING * camera.width, "height": BINNING * camera.height, "blur": BINNING * camera.blur}
    camera = camera.model_copy(update={**wide, "pixel_size": camera.pixel_size / BINNING})
    # The middle of a pixel is half a pixel from its edge, before and after.
    points = {
        name: tuple(tuple(BINNING * (a + 0.5) - 0.5 for a in pair) for pair in getattr(vision, name))
        for name in ("reference_pixel", "mark_pixel")
    }
    lengths = {name: BINNING * getattr(vision, name) for name in ("focal_length", "mark_radius")}
    return camera, vision.model_copy(update={**wide, **points, **lengths})


def published(vision: vision_model.Markers, seen: Seen) -> vision_model.Markers:
    """The paper's method, calibrated by the markers of its first image as a patient reader would."""
    read = tuple((round(float(u), 1), round(float(v), 1)) for u, v in seen.pixel)
    return vision.model_copy(update={"method": "published", "chain_pixel": read})


def at(camera: camera_model.MarkedLine, case: str, t: float) -> camera_model.MarkedLine:
    """The camera at t [s]."""
    if case != "hard":
        return camera
    f = camera.optics().f
    changed = {}
    if t >= BUMPED_S:
        changed = {"heading": camera.heading - BUMP[0] / f, "pitch": camera.pitch + BUMP[1] / f}
    if DARK_S[0] <= t < DARK_S[1]:
        changed["exposure"] = 0.0
    return camera.model_copy(update=changed)


def whole(seen: Seen, size: tuple[int, int], border: float) -> np.ndarray:
    """(m,) which markers the image shows whole, this far from its border [pixel]."""
    inside = ((seen.pixel > border) & (seen.pixel < np.array(size) - 1.0 - border)).all(axis=1)
    return inside & (seen.visible > 0.999)


def judge(case: str, method: str) -> Judged:
    """Find the markers of a film and compare with the truth."""
    camera, vision = both()
    camera = camera.model_copy(update=CASES[case])
    error, nees, counts = [], [], np.zeros(5)  # counts: whole, of these found, found, false, misnamed
    walls: list[tuple[float, float]] = []
    scene, q, x, radius = b"", np.empty(0), np.empty(0), camera.optics().f * 0.5 * camera.marker_diameter / 4.0
    for k, nodes in enumerate(shapes()):
        t = k * PERIOD_S
        numbers = at(camera, case, t).vector()
        if numbers[camera_model.SENSOR :].tobytes() != scene:
            scene = numbers[camera_model.SENSOR :].tobytes()
            setting = camera_model.setting_of(numbers, SEED)
            still = paint(setting)
        began = time.process_time()
        seen = render(setting, still, *camera_model.sensor_of(numbers), nodes, t, k)
        if k == 0:
            vision = published(vision, seen) if method == "published" else vision
            q, x = vision.vector(), np.empty(vision_model.sizes(vision).state)
        rendered = time.process_time()
        found = look(PERIOD_S if k else 0.0, q, x, seen.image)
        walls.append((time.process_time() - rendered, rendered - began))
        dark = case == "hard" and DARK_S[0] <= t < DARK_S[1]
        is_whole = whole(seen, setting.size, 3.0 * radius) & (not dark)
        counts += compare(seen, found, is_whole, method, error, nees)
    total, detected, finds, false, misnamed = counts
    found_s, rendered_s = np.median(np.array(walls)[3:], axis=0)  # the first ones load their machine code
    shares = detected / total, false / max(finds, 1.0), misnamed / max(finds, 1.0)
    return Judged(np.array(error), np.array(nees), *shares, float(found_s), float(rendered_s))


def compare(
    seen: Seen, found: Found, is_whole: np.ndarray, method: str, error: list[float], nees: list[float]
) -> np.ndarray:
    """Counts of an image, and errors added to the lists; `published` is compared with the nearest marker."""
    away = np.linalg.norm(found.pixel[:, None] - seen.pixel[None], axis=2)
    own = away.argmin(axis=1) if method == "published" else np.arange(len(away))
    miss = away[np.arange(len(away)), own]
    right = found.valid & (miss < NEAR)
    named = right & (own == np.arange(len(own)))
    for i in np.flatnonzero(right):
        e = found.pixel[i] - seen.pixel[own[i]]
        error.append(float(miss[i]))
        nees.append(float(e @ np.linalg.solve(found.pixel_covariance[i], e)))
    hit = np.isin(np.flatnonzero(is_whole), own[right]).sum()
    return np.array([is_whole.sum(), hit, found.valid.sum(), (found.valid & ~right).sum(), (right & ~named).sum()])


def rows() -> list[Row]:
    """Both methods in the three cases."""
    table: list[Row] = []
    for case in CASES:
        for method in vision_model.METHODS:
            judged = judge(case, method)
            table.append(
                {
                    "case": case,
                    "method": method,
                    "error": float(np.median(judged.error)),
                    "error_95": float(np.quantile(judged.error, 0.95)),
                    "error_unit": "pixel",
                    "nees": float(np.mean(judged.nees)),
                    "detected": judged.detected,
                    "false": judged.false,
                    "wrong number": judged.misnamed,
                    "us": 1e6 * judged.found_s,
                    "images/s": 1.0 / judged.found_s,
                    "rendered/s": 1.0 / judged.rendered_s,
                    "reference": "the rendered markers' true centres",
                }
            )
    return table
