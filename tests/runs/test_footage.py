"""Films shown again: images come back as they were, the frame follows the time, and each fault is one clear line."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from pipeline.errors import StepError, WiringError
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario_text
from pipeline.wiring import build_graph

WIDTH, HEIGHT, COUNT = 64, 48, 6
TEXT = """
name: film
duration: {duration} ms
step: 20 ms
components:
  film:
    model: camera.footage
    parameters: {{film: {film}, width: {width}, height: 48, rate: 25 Hz, {more}}}
"""


def picture(k: int) -> np.ndarray:
    """A grey wedge that moves to the right."""
    return ((np.arange(WIDTH)[None, :] * 3 + np.arange(HEIGHT)[:, None] + 20 * k) % 256).astype(np.uint8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six images in a folder, and as a video without loss."""
    path = tmp_path_factory.mktemp("film")
    (path / "images").mkdir()
    video = cv2.VideoWriter(str(path / "film.avi"), cv2.VideoWriter_fourcc(*"FFV1"), 25.0, (WIDTH, HEIGHT))
    for k in range(COUNT):
        cv2.imwrite(str(path / "images" / f"{k:03d}.png"), picture(k))
        video.write(cv2.cvtColor(picture(k), cv2.COLOR_GRAY2BGR))
    video.release()
    return path


def shown(folder: Path, tmp_path: Path, film: str, duration: int = 200, width: int = WIDTH, more: str = "start: 0 s"):
    """The images of a run, and their numbers in the film. Raises StepError."""
    text = TEXT.format(duration=duration, film=film, width=width, more=more)
    scenario = load_scenario_text(text, "film.yaml", folder)
    run_scenario(scenario, build_graph(scenario), tmp_path / "film.mcap", Options(), lambda _: None)
    log = open_log(tmp_path / "film.mcap")
    return [image for _, image in log.images("film", "image")], log.port("film", "number")


@pytest.mark.parametrize(("film", "off"), [("images", 0), ("film.avi", 1)])
def test_the_frame_follows_the_time(folder, tmp_path, film, off):
    """25 images/s in steps of 20 ms: each twice. A folder is exact; FFV1 is too, but for the colours' rounding."""
    images, numbers = shown(folder, tmp_path, film)
    assert numbers.tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5]
    for image, k in zip(images, numbers, strict=True):
        assert np.abs(image.astype(int) - picture(int(k))).max() <= off


def test_a_film_may_begin_later_and_hold_its_last_image(folder, tmp_path):
    _, numbers = shown(folder, tmp_path, "film.avi", duration=160, more="start: 120 ms, at_end: hold")
    assert numbers.tolist() == [3, 3, 4, 4, 5, 5, 5, 5, 5]


@pytest.mark.parametrize(
    ("film", "more", "said"),
    [
        ("nothing.avi", {}, "there is no film .*nothing.avi: expected a folder of images or a video file"),
        ("text.avi", {}, "text.avi cannot be read as a video"),
        ("empty", {}, "empty holds no image"),
        ("broken", {}, "000.png cannot be read as an image"),
        ("images", {"width": 65}, "64 x 48 pixels; expected 65 x 48"),
        ("images", {"duration": 400}, "the film has ended: end the run before it"),
    ],
)
def test_faults_are_told_in_one_line(folder, tmp_path, capfd, film, more, said):
    (folder / "empty").mkdir(exist_ok=True)
    (folder / "broken").mkdir(exist_ok=True)
    for broken in ("text.avi", "broken/000.png"):
        (folder / broken).write_text("no film")
    with pytest.raises(StepError, match=said) as raised:
        shown(folder, tmp_path, film, **more)
    assert "\n" not in str(raised.value)
    assert capfd.readouterr() == ("", "")


def test_a_film_of_another_size_than_the_vision_expects_is_refused(folder):
    vision = """
  vision:
    model: vision.markers
    parameters:
      {width: 128, height: 48, markers: 3, spacing: 0.2 m, marker_diameter: 20 mm, diameter: 10 mm,
       first_position: [0 m, 1 m], reference_position: [[0 m, 1 m], [1 m, 1 m], [0 m, 0 m]],
       reference_pixel: [[1 pixel, 40 pixel], [60 pixel, 40 pixel], [1 pixel, 1 pixel]]}
    inputs: {image: film.image}
"""
    text = TEXT.format(duration=100, film="images", width=WIDTH, more="start: 0 s") + vision
    with pytest.raises(WiringError, match="64 x 48") as raised:
        build_graph(load_scenario_text(text, "film.yaml", folder))
    assert "128 x 48" in str(raised.value)
    assert "\n" not in str(raised.value)
