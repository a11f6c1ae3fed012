"""Camera and vision against what was drawn: true centres, the noise asked for, chi-square, the projection."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from components.camera.marked_line import component as camera
from components.camera.marked_line.model import MarkedLine
from components.camera.optics import Optics, project, ray, turn_of
from components.contract import SEED_LOW
from components.vision.markers import bump, calibration, order, published, reference, scales
from components.vision.markers import component as vision
from components.vision.markers.model import Markers

WIDTH, HEIGHT, PERIOD_NS = 480, 300, 35_000_000
# A tilted, turned, distorting camera 3 m before eight markers from the floor up.
VIEW = {
    "width": WIDTH, "height": HEIGHT, "position": (4.55, 3.0, 2.5), "heading": np.deg2rad(270.5),
    "pitch": np.deg2rad(-3.0), "roll": np.deg2rad(1.5), "focal_length": 5.6e-3, "pixel_size": 7.9e-6,
    "distortion": -0.05,
    "blur": 1.0, "length": 8.19, "segments": 60, "diameter": 0.0123, "markers": 8, "first": 4.0, "spacing": 0.2,
    "marker_diameter": 0.024, "wall": -1.2, "floor": 3.0, "lamp": (4.5, 3.2, 1.0), "attenuation": 0.1,
    "marks": ((4.5, -1.19, 2.3), (4.0, -1.19, 2.4), (5.4, -1.19, 2.6)), "mark_diameter": 0.04, "exposure": 1.3,
}  # fmt: skip
CLEAN = {"noise": 0.5}
NOISY = {"noise": 2.0, "shot": 0.05, "particles": 80, "texture": 0.1, "joint": 0.012}
SURVEYED = ((3.9, 3.0), (5.2, 3.0), (5.2, 2.4), (3.9, 2.4), (4.6, 2.6))
NEAR = 3.0  # pixels beyond which a mark is false


def line(t: float) -> np.ndarray:
    """Nodes (61, 3) of a line that lies on the floor and rises as a catenary of a changing horizontal force, NED."""
    a = 1.02 * (1.0 + 0.15 * np.sin(np.pi * t))
    s = np.linspace(0.0, 8.19, 61) - (8.19 - np.sqrt(9.0 + 6.0 * a))
    up = np.maximum(s, 0.0)
    north = 8.19 - np.sqrt(9.0 + 6.0 * a) + np.minimum(s, 0.0) + a * np.arcsinh(up / a)
    return np.column_stack([north, np.zeros(61), 3.0 - (np.hypot(a, up) - a)])


class Watched:
    """A camera and the vision behind it, stepped by hand; y and w full of NaN before each call."""

    def __init__(self, *, seed: int = 7, looking: dict | None = None, **changes):
        self.camera = MarkedLine(**VIEW | changes)
        optics = self.camera.optics()
        seen = {
            "reference_pixel": tuple(project(optics, n, 0.0, d)[:2] for n, d in SURVEYED),
            "mark_pixel": tuple(project(optics, *mark)[:2] for mark in self.camera.marks),
            "mark_radius": optics.f * 0.02 / 4.19,
        }
        same = {name: VIEW[name] for name in ("width", "height", "markers", "spacing", "marker_diameter", "diameter")}
        known = {"first_position": (4.0, 3.0), "reference_position": SURVEYED, "focal_length": optics.f, "blur": 1.0}
        self.vision = Markers(**same | known | seen | {"distortion": -0.05} | (looking or {}))
        self.seed, self.k, self.x = seed, 0, np.zeros(1)
        self.p = vision.COMPONENT.pack(self.vision)
        self.track = np.full(int(self.p[3 - 1]), np.nan)

    def image(self, **changes) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The next image, and of its markers the true position, pixel and visible share."""
        parameters = self.camera.model_copy(update=changes)
        p, pictures = camera.COMPONENT.pack(parameters, self.seed), {}
        y, function = np.full(6 * VIEW["markers"], np.nan), camera.step if self.k else camera.init
        nodes = line(self.k * PERIOD_NS * 1e-9).ravel()
        assert function(self.k * PERIOD_NS, PERIOD_NS, p, nodes, self.x, y, np.empty(0), {}, pictures) == 0
        self.k += 1
        return pictures["image"], y[:24].reshape(8, 3), y[24:40].reshape(8, 2), y[40:]

    def find(self, image: np.ndarray, *, first: bool = False) -> dict[str, np.ndarray]:
        """What the vision gives of an image."""
        y, function = np.full(int(self.p[4 - 1]), np.nan), vision.init if first else vision.step
        image = image.copy()
        image.flags.writeable = False
        assert function(0, PERIOD_NS, self.p, np.empty(0), self.track, y, np.empty(0), {"image": image}, {}) == 0
        assert np.isfinite(y).all()
        assert np.isfinite(self.track).all()
        found, k = {}, 0
        for port in vision.COMPONENT.outputs(self.vision):
            found[port.name] = y[k : k + port.size].reshape(port.shape)
            k += port.size
        return found


def film(watched: Watched, count: int) -> tuple[np.ndarray, ...]:
    """Of so many images valid (k, m), errors (k, m, 2) [pixel], their NEES, errors in the plane [m], visible shares."""
    rows = []
    for k in range(count):
        image, position, pixel, visible = watched.image()
        found = watched.find(image, first=k == 0)
        valid = found["valid"] > 0
        error = np.where(valid[:, None], found["pixel"] - pixel, 0.0)
        covariance = np.where(valid[:, None, None], found["pixel_covariance"], np.eye(2))
        nees = np.einsum("ij,ijk,ik->i", error, np.linalg.inv(covariance), error)
        away = np.where(valid, np.linalg.norm(found["position"] - position, axis=1), 0.0)
        rows.append((valid, error, nees, away, visible))
    return tuple(np.array(column) for column in zip(*rows, strict=True))


@pytest.fixture(scope="module")
def noisy():
    return film(Watched(**NOISY), 30)


def test_a_pixels_ray_leads_back_to_it():
    """Two formulations of one projection; Newton's method leaves rounding."""
    optics = Optics(1.0, 2.0, 3.0, turn_of(4.7, -0.1, 0.2), 900.0, 319.5, 199.5, -0.1)
    for u, v in ((0.0, 0.0), (639.0, 50.0), (300.0, 399.0)):
        n, e, d = ray(optics, u, v)
        assert project(optics, 1.0 + 3.0 * n, 2.0 + 3.0 * e, 3.0 + 3.0 * d) == pytest.approx((u, v, 3.0), abs=1e-9)


def test_camera_axes():
    """A camera that looks west has north to its right, and down is down; 1 m at 4 m is f / 4."""
    optics = Optics(0.0, 4.0, 0.0, turn_of(1.5 * np.pi, 0.0, 0.0), 800.0, 100.0, 50.0, 0.0)
    assert project(optics, 1.0, 0.0, 0.5) == pytest.approx((300.0, 150.0, 4.0))


def test_a_rendered_disc_has_its_centroid_where_it_is_said_to_be():
    """First moment of an area-sampled disc; rounding to grey levels is 0.01 pixel of it at 100 levels of contrast."""
    watched = Watched(line_level=0.0, wall_level=0.0, floor_level=0.0, marks=(), distortion=0.0, diameter=1e-4)
    image, _, pixel, _ = watched.image()
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    for a, b in pixel:
        near = np.hypot(u - a, v - b) < 12.0
        weight = image[near].astype(float)
        middle = (weight @ u[near] / weight.sum(), weight @ v[near] / weight.sum())
        assert middle == pytest.approx((a, b), abs=0.02)


def test_noise_is_what_was_asked_for_and_repeats():
    dark = {"exposure": 0.0, "turbidity": 0.0, "haze": 0.0}
    haze = {"turbidity": 50.0, "haze": 100.0, "exposure": 1.0, "noise": 2.0, "shot": 0.05}
    first, second = Watched(), Watched()
    one, two = first.image(**haze)[0], first.image(**haze)[0]
    # 144 000 pixels: the mean within 4 sigma / 380; the variance, with 1/12 of rounding, within 4 sqrt(2) / 380 of it.
    assert one.mean() == pytest.approx(100.0, abs=4.0 * 3.0 / 380.0)
    assert one.var() == pytest.approx(4.0 + 0.05 * 100.0 + 1.0 / 12.0, rel=4.0 * 1.42 / 380.0)
    assert abs(np.corrcoef(one.ravel(), two.ravel())[0, 1]) < 4.0 / 380.0
    assert np.array_equal(one, second.image(**haze)[0])
    assert not np.array_equal(one, Watched(seed=8).image(**haze)[0])
    assert not first.image(**dark)[0].any()


def test_what_an_obstacle_hides_is_told():
    """A housing that covers marker 3 and half of the view of none other."""
    _, _, pixel, visible = Watched().image()
    assert visible == pytest.approx(np.ones(8))
    n, e, d = ray(MarkedLine(**VIEW).optics(), *pixel[3])
    s = (0.3 - 3.0) / e
    north, down = 4.55 + s * n, 2.5 + s * d
    box = ((north - 0.02, north + 0.02, down - 0.02, down + 0.02, 0.3),)
    assert Watched(obstacles=box).image()[3] == pytest.approx(np.array([1, 1, 1, 0, 1, 1, 1, 1]), abs=1e-9)
    half = ((north, north + 0.1, down - 0.1, down + 0.1, 0.3),)
    # The edge through the middle, drawn to a thousandth of a pixel, of a disc of 6 pixels.
    assert Watched(obstacles=half).image()[3][3] == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"wall": 1.0}, "must be between"),
        ({"floor": 2.0}, "below the floor"),
        ({"heading": 0.0}, "turn the camera"),
        ({"markers": 40}, "fewer markers"),
    ],
)
def test_scenes_that_cannot_be_are_refused(wrong, said):
    with pytest.raises(ValidationError, match=said):
        MarkedLine(**VIEW | wrong)


def test_clean_images_give_a_tenth_of_a_pixel():
    valid, error, _, away, _ = film(Watched(**CLEAN), 10)
    assert valid.all()
    assert np.median(np.linalg.norm(error, axis=2)) < 0.1
    assert np.linalg.norm(error, axis=2).max() < 0.1
    assert np.median(away) < 1e-4  # a tenth of a pixel of 4 mm / 1000


def test_noisy_images_give_half_a_pixel_and_no_false_marks(noisy):
    valid, error, _, _, visible = noisy
    size = np.linalg.norm(error, axis=2)
    assert np.median(size[valid]) < 0.5
    assert valid[visible > 0.999].mean() >= 0.99
    assert not (size[valid] > NEAR).any()


def test_stated_covariances_are_those_of_the_errors(noisy):
    """Chi-square of two degrees of freedom, whose mean is 2 and 95 % of which are below 5.99.

    Texture is the same in each image, so that some 240 finds are not as many draws: bounds of a factor of two.
    """
    valid, _, nees, _, _ = noisy
    assert 1.0 < nees[valid].mean() < 4.0
    assert np.mean(nees[valid] < 5.99) > 0.85


def test_all_markers_lost_and_known_again():
    """Two seconds without light, while the line goes through a whole period and a bit, and the others are not taken."""
    watched = Watched(**CLEAN)
    for k in range(5):
        found = watched.find(watched.image()[0], first=k == 0)
    dark = np.zeros((HEIGHT, WIDTH), np.uint8)
    for _ in range(60):
        watched.k += 1
        assert not watched.find(dark)["valid"].any()
    image, _, pixel, _ = watched.image()
    found = watched.find(image)
    assert found["valid"].all()
    assert np.linalg.norm(found["pixel"] - pixel, axis=1).max() < NEAR


def painted(image: np.ndarray, u: float, v: float, radius: float, level: int) -> np.ndarray:
    """The image with a disc."""
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    cover = np.clip(radius + 0.5 - np.hypot(columns - u, rows - v), 0.0, 1.0)
    return np.round(image + cover * (level - image.astype(float))).astype(np.uint8)


def test_a_hidden_marker_is_missing_and_a_disc_beside_it_is_not_taken_for_it():
    watched = Watched(**CLEAN)
    for k in range(4):
        watched.find(watched.image()[0], first=k == 0)
    for _ in range(10):
        image, _, pixel, _ = watched.image()
        ground = int(np.median(image))
        hidden = painted(image, *pixel[5], 14.0, ground)
        wrong = painted(hidden, pixel[5, 0] + 40.0, pixel[5, 1] + 35.0, 6.0, 200)
        found = watched.find(wrong)
        assert found["valid"].tolist() == [1, 1, 1, 1, 1, 0, 1, 1]
        assert np.linalg.norm(found["pixel"] - pixel, axis=1)[found["valid"] > 0].max() < NEAR
        assert not found["position"][5].any()


def test_identities_begin_right_with_the_first_marker_hidden():
    watched = Watched(**CLEAN)
    image, _, pixel, _ = watched.image()
    found = watched.find(painted(image, *pixel[0], 14.0, int(np.median(image))), first=True)
    assert found["valid"].tolist() == [0, 1, 1, 1, 1, 1, 1, 1]
    assert np.linalg.norm(found["pixel"] - pixel, axis=1)[1:].max() < NEAR


def test_a_shifted_camera_is_followed_by_the_marks_in_the_tank():
    """Turned by (9, -5) pixels; the wall with the marks is 1.4 times as far as the line, which a turn does not see."""
    watched = Watched(**CLEAN)
    f = watched.camera.optics().f
    watched.find(watched.image()[0], first=True)
    for _ in range(3):
        image, position, pixel, _ = watched.image(heading=VIEW["heading"] - 9.0 / f, pitch=VIEW["pitch"] - 5.0 / f)
        found = watched.find(image)
        assert found["valid"].all()
        assert np.linalg.norm(found["pixel"] - pixel, axis=1).max() < 0.1
        assert found["shift"] == pytest.approx([9.0, -5.0], abs=0.3)  # the camera's roll turns these by 1.5 deg
        # A tenth of a pixel of line and of marks, 3 mm / 10 each.
        assert np.linalg.norm(found["position"] - position, axis=1).max() < 6e-4


@pytest.mark.parametrize("level", [0, 128, 255])
def test_images_without_anything_give_nothing(level):
    watched = Watched()
    for k in range(2):
        assert not watched.find(np.full((HEIGHT, WIDTH), level, np.uint8), first=k == 0)["valid"].any()


def test_images_of_noise_alone_give_nothing():
    watched, rng = Watched(), np.random.default_rng(1)
    for k in range(3):
        image = rng.integers(0, 256, (HEIGHT, WIDTH)).astype(np.uint8)
        assert not watched.find(image, first=k == 0)["valid"].any()


def test_light_that_saturates_the_markers_leaves_them_where_they_are():
    watched = Watched(**CLEAN, looking={"contrast": 15.0})
    image, _, pixel, _ = watched.image(exposure=2.0)
    assert (image == 255).sum() > 8 * 30
    found = watched.find(image, first=True)
    assert found["valid"].all()
    assert np.linalg.norm(found["pixel"] - pixel, axis=1).max() < 0.2


def test_what_does_not_move_is_seen_by_best_and_not_by_published():
    """The paper subtracts the reference image, and the line with it."""
    best, paper = Watched(**CLEAN), Watched(**CLEAN, looking={"method": "published", "chain_pixel": CHAIN})
    image = best.image()[0]
    for k in range(3):
        assert best.find(image, first=k == 0)["valid"].all()
        assert not paper.find(image, first=k == 0)["valid"].any()


CHAIN = ((100.0, 250.0), (150.0, 250.0), (200.0, 250.0), (240.0, 220.0))


def test_published_steps_find_moving_markers_to_a_pixel():
    watched = Watched(**CLEAN, looking={"method": "published", "chain_pixel": CHAIN})
    watched.find(watched.image()[0], first=True)
    watched.k = 12
    image, _, pixel, _ = watched.image()
    found = watched.find(image)
    away = np.linalg.norm(found["pixel"][found["valid"] > 0][:, None] - pixel[None], axis=2).min(axis=1)
    assert found["valid"].sum() >= 3
    assert np.median(away) < 1.5


def test_golays_skeleton_of_a_ring_is_closed_and_of_thin_lines_themselves():
    """A ring keeps its hole and has neither ends nor forks; a T one pixel wide has three ends and a fork."""
    v, u = np.mgrid[:41, :41]
    radius = np.hypot(v - 20, u - 20)
    thin = published.skeleton(np.where((radius > 8.0) & (radius < 13.0), 255, 0).astype(np.uint8))
    ends, forks = published.ends_and_forks(thin)
    assert not ends.any()
    assert not forks.any()
    assert 2.0 * np.pi * 8.0 < (thin > 0).sum() < 2.0 * np.pi * 13.0
    letter = np.zeros((21, 21), np.uint8)
    letter[5, 3:18] = letter[5:18, 10] = 255
    assert np.array_equal(published.skeleton(letter), letter)
    ends, forks = published.ends_and_forks(letter)
    assert sorted(zip(*np.nonzero(ends), strict=True)) == [(5, 3), (5, 17), (17, 10)]
    assert list(zip(*np.nonzero(forks), strict=True)) == [(5, 10)]


def test_vertical_scale_of_the_paper_holds_for_the_true_angle_only():
    """Trigo et al. 2014, (3): a segment of 0.2 m at 40 deg seen at 2 and 2.5 mm/pixel."""
    true, s_x, s_y = np.deg2rad(40.0), 2e-3, 2.5e-3
    du, dv = 0.2 * np.cos(true) / s_x, 0.2 * np.sin(true) / s_y
    s_theta, seen = 0.2 / np.hypot(du, dv), np.arctan2(dv, du)
    assert scales.vertical_scale(s_x, s_theta, true) == pytest.approx(s_y, rel=1e-12)
    assert np.sqrt((s_theta**2 - (s_x * np.cos(seen)) ** 2) / np.sin(seen) ** 2) == pytest.approx(s_y, rel=1e-12)
    assert abs(scales.vertical_scale(s_x, s_theta, seen) / s_y - 1.0) > 0.1


def test_affinity_by_the_markers_spacing():
    """(1), (2): a floor at 3 deg and 4 pixels a centimetre, three markers lying and a fourth at 60 deg above them."""
    turned, raised = np.deg2rad(3.0), np.deg2rad(3.0 - 60.0)
    along, up = np.array([np.cos(turned), np.sin(turned)]), np.array([np.cos(raised), np.sin(raised)])
    pixels = np.array([100.0, 400.0]) + 80.0 * np.array([0 * along, along, 2 * along, 2 * along + up])
    affinity = scales.calibrate(pixels, 0.2)
    assert affinity.angle == pytest.approx(turned)
    assert affinity.s_x == pytest.approx(0.0025)
    assert affinity.s_y == pytest.approx(0.0025)
    plane = scales.to_plane(affinity, pixels, np.array([3.0, 2.0]))
    assert plane[3] == pytest.approx([3.0 + 0.4 + 0.2 * np.cos(np.pi / 3), 2.0 - 0.2 * np.sin(np.pi / 3)])
    with pytest.raises(ValueError, match="chain_pixel tells 1 markers; expected those of two at least"):
        scales.calibrate(pixels[:1], 0.2)


def test_homography_is_the_pinholes_image_of_the_plane():
    """Exact where the distortion is known, whatever the tilt; tolerance: rounding of eight unknowns."""
    watched = Watched(roll=0.1, pitch=-0.06)
    lens, h = watched.vision.lens(), watched.vision.homography()
    truth = np.array([[4.2, 2.9], [5.1, 2.5], [4.6, 2.8]])
    pixels = np.array([project(watched.camera.optics(), n, 0.0, d)[:2] for n, d in truth])
    assert calibration.to_plane(lens, calibration.STILL, h, pixels) == pytest.approx(truth, abs=1e-9)
    with pytest.raises(ValidationError, match="on a line"):
        Watched(looking={"reference_pixel": ((1.0, 1.0), (2.0, 2.0), (3.0, 3.0)), "reference_position": SURVEYED[:3]})


@pytest.mark.parametrize(
    ("pixels", "said"),
    [
        (((9.0, 9.0), (9.0, 9.0), (9.0, 9.0)), "on a line"),
        (((9.0, 280.0), (200.0, 280.0), (400.0, 280.0), (9.0, 20.0)), "all reference points but one"),
        (((9.0, 280.0), (400.0, 20.0), (400.0, 280.0), (9.0, 20.0)), "same order"),
    ],
)
def test_calibrations_that_tell_no_plane_are_refused(pixels, said):
    level = ((3.9, 3.0), (4.5, 3.0), (5.2, 3.0), (3.9, 2.4))
    plane = level if "but one" in said else SURVEYED[: len(pixels)]
    with pytest.raises(ValueError, match=said):
        calibration.homography(np.array(pixels), np.array(plane))


@pytest.mark.parametrize(("tilt", "focal"), [(3.0, 709.0), (15.0, 709.0), (15.0, 900.0)])
def test_one_mistyped_reference_point_of_five_is_named(tilt, focal):
    """Each point in turn with a digit of its pixel or 20 cm of its position wrong: it is named first, and by how much.

    Four points fit any homography; the wrong one among them shows by the camera's square pixels, also where the focal
    length is a quarter off. Others may be named too, where they would explain it within twice the gate.
    """
    optics = Optics(
        4.55, 3.0, 2.6, turn_of(np.deg2rad(270.0 + tilt), np.deg2rad(-tilt), 0.03), 709.0, 239.5, 149.5, 0.0
    )
    lens, plane = calibration.Lens(focal, 239.5, 149.5, 0.0), np.array(SURVEYED)
    rng = np.random.default_rng(5)
    pixels = np.array([project(optics, n, 0.0, d)[:2] for n, d in plane]) + 0.2 * rng.standard_normal((5, 2))
    assert reference.homography(lens, pixels, plane, 0.2) == pytest.approx(calibration.homography(pixels, plane))
    named = 0
    for i in range(5):
        typed, placed = pixels.copy(), plane.copy()
        typed[i, i % 2] += 40.0
        placed[i, 1 - i % 2] += 0.2
        for wrong, size in (((typed, plane), 40.0), ((pixels, placed), 0.2 * 709.0 / 3.0)):
            with pytest.raises(ValueError, match=r"misses the others by") as raised:
                reference.homography(lens, *wrong, 0.2)
            text = str(raised.value)
            first, away = re.match(r"reference point (\d) misses the others by ([\d.]+) pixels", text).groups()
            assert f"reference point {i + 1} " in text
            if int(first) == i + 1:
                named += 1
                # Its own error, and what the others' noise and the perspective make of it.
                assert float(away) == pytest.approx(size, rel=0.5)
    assert named >= 9


def test_reference_points_of_which_two_are_wrong():
    """Six points tell that one alone does not explain it; four tell nothing, and one pixel is within the gate."""
    watched = Watched()
    lens, points = watched.vision.lens(), (*SURVEYED, (5.0, 2.8), (4.2, 2.8))
    seen = np.array([project(watched.camera.optics(), n, 0.0, d)[:2] for n, d in points])
    pixels = calibration.undistorted(lens, calibration.STILL, seen)
    pixels[1, 0] += 1.0
    reference.homography(lens, pixels, np.array(points), 0.2)
    pixels[1, 0] += 30.0
    with pytest.raises(ValueError, match=r"^reference point 2 misses the others by 31\.?\d* pixels: correct"):
        reference.homography(lens, pixels, np.array(points), 0.2)
    pixels[4, 1] -= 25.0
    with pytest.raises(
        ValueError, match=r"the 7 reference points miss each other, whichever is left out: two or more err, or the lens"
    ):
        reference.homography(lens, pixels, np.array(points), 0.2)
    reference.homography(lens, pixels[:4], np.array(points[:4]), 0.2)


def test_markers_of_one_calibration_row_or_pixel():
    # In one row nothing is known of the vertical scale: deviation 1, not infinite.
    row = np.array([[10.0, 10.0], [40.0, 10.0], [70.0, 10.0]])
    assert calibration.scale_deviation(row, 0.2).tolist() == pytest.approx([0.2 / np.sqrt(1800.0), 1.0])
    with pytest.raises(ValueError, match="at one pixel"):
        scales.calibrate(row[[0, 1, 1]], 0.2)


def test_scale_deviations_are_those_of_calibrations_repeated():
    """Affinities through five points read with 0.2 pixel of noise, 4000 times: deviations to 5 %, four of their own."""
    rng, pixels = (
        np.random.default_rng(3),
        np.array([[40.0, 280.0], [440.0, 270.0], [450.0, 30.0], [30.0, 20.0], [240, 150]]),
    )
    plane = np.column_stack([pixels, np.ones(5)]) @ np.array([[2e-3, 0.0], [0.0, 2e-3], [1.0, 1.0]])
    noisy = pixels + 0.2 * rng.standard_normal((4000, 5, 2))
    found = []
    for one in noisy:
        solved = np.linalg.lstsq(np.column_stack([plane - plane.mean(axis=0), np.ones(5)]), one, rcond=None)[0]
        found.append((solved[0, 0] * 2e-3, solved[1, 1] * 2e-3))
    expected = calibration.scale_deviation(pixels, 0.2)
    assert np.std(found, axis=0) == pytest.approx(expected, rel=0.05)


def test_marks_agree_on_a_shift_and_others_do_not_count():
    marks = np.array([[50.0, 40.0], [400.0, 60.0], [300.0, 250.0]])
    spots = np.vstack([marks + np.array([[6.5, -2.5], [5.5, -3.5], [6.0, -3.0]]), [[60.0, 60.0], [390.0, 40.0]]])
    shift, alike = bump.find_shift(spots, marks, np.zeros(2), 30.0)
    assert alike == 3
    assert shift == pytest.approx([6.0, -3.0], abs=1.0)


def test_a_cameras_turn_comes_back_from_what_it_sees():
    """Rodrigues' rotation against the least squares that undo it; a single mark tells no turn about itself."""
    lens, turn = calibration.Lens(900.0, 239.5, 149.5, -0.1), calibration.Turned(0.02, -0.03, 0.05)
    marks = np.array([[50.0, 40.0], [400.0, 60.0], [300.0, 250.0]])
    before = calibration.rays(lens, marks)
    seen = calibration.seen_at(lens, before @ calibration.rotation(turn).T)
    assert list(bump.turn_between(before, calibration.rays(lens, seen))) == pytest.approx(list(turn), abs=1e-9)
    ideal = calibration.undistorted(lens, turn, seen)
    assert ideal == pytest.approx(calibration.undistorted(lens, calibration.STILL, marks), abs=1e-7)
    alone = bump.turn_between(before[:1], calibration.rays(lens, seen[:1]))
    assert calibration.undistorted(lens, alone, seen[:1]) == pytest.approx(ideal[:1], abs=1e-6)


def test_the_state_holds_an_image_exactly():
    image = np.random.default_rng(5).integers(0, 256, (37, 51)).astype(np.uint8)
    x = np.empty(-(-image.size // 6))
    order.keep_reference(image, x)
    assert np.array_equal(order.reference_of(x, image.shape), image)


def test_seeds_of_instances_differ():
    """The component's key is in p; images of two cameras with other keys differ in their noise alone."""
    p = [camera.COMPONENT.pack(MarkedLine(**VIEW), seed) for seed in (1, 2)]
    assert [q[SEED_LOW] for q in p] == [1, 2]
    assert all(np.array_equal(a[SEED_LOW + 1 :], b[SEED_LOW + 1 :]) for a, b in pairwise(p))
