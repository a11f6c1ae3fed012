"""Films shown again: images come back as they were, the frame follows the time, and each fault is one clear line."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from components.camera.footage.faults import FilmError, MissingImage
from components.camera.footage.folder import Folder
from components.camera.footage.video import Video
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
        ("broken", {}, "image 0, .*000.png, cannot be read as an image: copy it again, or set missing to black"),
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


FRAMES = 60
SNOW = [np.random.default_rng(k).integers(0, 256, (HEIGHT, WIDTH)).astype(np.uint8) for k in range(FRAMES)]


def number_of(image: np.ndarray) -> int:
    """Which of the frames of snow an image is."""
    return int(np.argmin([np.abs(image.astype(int) - snow).mean() for snow in SNOW]))


@pytest.fixture(scope="module")
def snow(tmp_path_factory):
    """Films of snow, each frame of some 3 kB, in a container without times and in one with them."""
    path = tmp_path_factory.mktemp("snow")
    for suffix in ("avi", "mkv"):
        video = cv2.VideoWriter(str(path / f"film.{suffix}"), cv2.VideoWriter_fourcc(*"FFV1"), 25.0, (WIDTH, HEIGHT))
        for image in SNOW:
            video.write(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
        video.release()
    return path


def damaged(path: Path, damage) -> Path:
    """A copy whose bytes went through damage()."""
    copy = path.with_name(f"{damage.__name__}{path.suffix}")
    copy.write_bytes(damage(path.read_bytes()))
    return copy


def cut(data: bytes) -> bytes:
    return data[: len(data) * 6 // 10]


def without_middle(data: bytes) -> bytes:
    return data[: len(data) // 2] + data[len(data) * 6 // 10 :]


def overwritten(data: bytes) -> bytes:
    at, size = len(data) // 2, len(data) // 10
    return data[:at] + np.random.default_rng(1).bytes(size) + data[at + size :]


@pytest.mark.parametrize(("damage", "last"), [(cut, 35), (without_middle, 59), (overwritten, 59)])
def test_frames_of_a_damaged_video_stay_where_they_were(snow, damage, last):
    """By the times that the container keeps: what is there is itself, what is not is missing, whatever comes first."""
    video = Video(damaged(snow / "film.mkv", damage))
    assert video.count == FRAMES
    shown, lost = {}, []
    for k in range(FRAMES):
        try:
            shown[k] = number_of(video.frame(k))
        except MissingImage:
            lost.append(k)
    # FFmpeg's decoder fills up the one frame into whose bytes the damage begins, and does not tell.
    assert all(found == k for k, found in shown.items() if k != lost[0] - 1)
    assert 6 <= len(lost) <= 31  # a tenth of 60, up to where the container is found into again, or the last 40 %
    assert max(shown) in (last - 1, last)
    assert number_of(video.frame(3)) == 3


@pytest.mark.parametrize("damage", [cut, without_middle, overwritten])
def test_a_damaged_avi_is_refused(snow, damage):
    with pytest.raises(
        FilmError, match=r"holds \d+ of the 60 frames that its header tells, .* copy it again"
    ) as raised:
        Video(damaged(snow / "film.avi", damage))
    assert "\n" not in str(raised.value)


def test_a_missing_image_stops_the_run_or_is_black(snow, tmp_path):
    """Cut off from frame 35 or 36 on, which are due at 1.4 and 1.44 s; shown from 1.2 s on."""
    film = damaged(snow / "film.mkv", cut)
    with pytest.raises(
        StepError, match=r"frame 3[56] of .*cut\.mkv (is missing|cannot be decoded) \(.* of 60 frames lost"
    ):
        shown(film.parent, tmp_path, film.name, duration=400, more="start: 1.2 s")
    (tmp_path / "film.mcap").unlink(missing_ok=True)
    images, numbers = shown(film.parent, tmp_path, film.name, duration=400, more="start: 1.2 s, missing: black")
    valid = open_log(tmp_path / "film.mcap").port("film", "valid")
    assert numbers[::2].tolist() == list(range(30, 41))
    assert {int(k) for k in numbers[valid == 0.0]} in (set(range(35, 41)), set(range(36, 41)))
    assert all(image.any() == there for image, there in zip(images, valid > 0.0, strict=True))


def pictures(folder: Path, *names: str) -> Path:
    folder.mkdir()
    for name in names:
        cv2.imwrite(str(folder / name), picture(int("0" + "".join(filter(str.isdigit, Path(name).stem)))))
    return folder


def test_a_hole_in_a_folders_numbers_stays_one(tmp_path):
    """Numbers count, not the order of the names; every second image of a film is a film."""
    folder = Folder(pictures(tmp_path / "hole", "im_8.png", "im_9.png", "im_10.png", "im_12.png"))
    assert folder.count == 5
    for k in (0, 1, 2, 4):
        assert np.array_equal(folder.frame(k), picture(8 + k))
    with pytest.raises(
        MissingImage, match=r"image 3 of .*hole, number 11, is missing [(]1 of 5 lost; .* im_8.png[)]: put it back"
    ):
        folder.frame(3)
    assert Folder(pictures(tmp_path / "second", "02.png", "04.png", "06.png", "10.png")).count == 5
    assert Folder(pictures(tmp_path / "one", "7.png")).count == 1
    assert Folder(pictures(tmp_path / "named", "a.png", "b.png", "c2.png")).count == 3


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("im_1.png", "im_2.png", "dark_3.png"), r"dark_3\.png is not numbered as im_1\.png and 1 others are: move it"),
        (("im_1.png", "im_01.png", "im_2.png"), r"im_0?1\.png and im_0?1\.png have one number: move one"),
    ],
)
def test_folders_whose_numbers_are_in_doubt_are_refused(tmp_path, names, said):
    with pytest.raises(FilmError, match=said):
        Folder(pictures(tmp_path / "doubt", *names))


@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_an_image_that_was_cut_short_is_missing(tmp_path, suffix):
    """A decoder would fill up the rest of it."""
    folder = pictures(tmp_path / "cut", f"1.{suffix}", f"2.{suffix}")
    file = folder / f"2.{suffix}"
    file.write_bytes(file.read_bytes()[:-70])
    film = Folder(folder)
    assert film.frame(0).shape == (HEIGHT, WIDTH)
    with pytest.raises(MissingImage, match=rf"image 1, .*2\.{suffix}, cannot be read as an image: copy it again"):
        film.frame(1)
