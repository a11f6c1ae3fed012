"""Markers of a line found in the images of a camera: parameters, ports and sizes."""

from __future__ import annotations

from math import hypot, sqrt
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from components.contract import ImagePort, Parameters, Port, Sizes, Term, choice, quantity
from components.vision.markers import calibration, finding, reference, scales
from components.vision.markers.identity import ROOM

Pair = tuple[float, float]
METHODS = ("published", "best")
PIXEL_BLUR = 1.0 / sqrt(12.0)  # standard deviation of a pixel's own width
BYTES = 6  # of an image that a number of the state holds, exactly


class Markers(Parameters):
    """Round bright markers, equally spaced along a line that moves in a plane of constant east.

    `best` takes the calibration from surveyed points of that plane; `published`, Trigo et al. 2014, from the markers'
    spacing and the pixels of some of them, and its first image as the reference of the background.
    """

    width: Annotated[int, Field(ge=32)] = choice("columns of the image", 1280)
    height: Annotated[int, Field(ge=32)] = choice("rows of the image", 800)
    method: Literal["published", "best"] = choice("published (Trigo et al. 2014, section 2) or best", "best")
    markers: Annotated[int, Field(ge=2, le=ROOM[0])] = choice("number of markers")
    spacing: float = quantity("m", "distance of two markers along the line", gt=0)
    marker_diameter: float = quantity("m", "of the markers", gt=0)
    diameter: float = quantity("m", "of the line", gt=0)
    plane: float = quantity("m", "east of the plane in which the line moves", 0.0)
    first_position: Pair = quantity("m", "north and down of marker 0 at the start, best one that lies still")
    first_tolerance: float = quantity("m", "standard deviation of that", 0.03, gt=0)

    reference_pixel: tuple[Pair, ...] = quantity("pixel", "column and row of surveyed points, three at least", ())
    reference_position: tuple[Pair, ...] = quantity("m", "north and down of these, in the motion plane", ())
    reference_deviation: float = quantity("pixel", "standard deviation of their pixels", 0.2, ge=0)
    focal_length: float = quantity("pixel", "in water; where the lens distorts, else of no effect", 1000.0, gt=0)
    distortion: float = quantity("1", "k of r_d = r (1 + k r^2), r in focal lengths", 0.0, gt=-0.3, lt=0.3)
    mark_pixel: tuple[Pair, ...] = quantity(
        "pixel", "round marks fixed in the tank, where they were at calibration", ()
    )
    mark_radius: float = quantity("pixel", "of these in the image", 6.0, gt=1)
    bump_limit: float = quantity("pixel", "how far these may be found from there", 40.0, gt=0)

    agility: float = quantity("m/s^2", "acceleration of a marker that is to be followed", 2.0, gt=0)
    wander: float | None = quantity(
        "m", "how far an unseen marker gets, one sigma; by default 0.4 spacings", None, gt=0
    )
    blur: float = quantity("pixel", "standard deviation of the lens's blur", 1.2, ge=0, le=20)
    contrast: float = quantity("1", "least of a marker over its background [grey levels]", 25.0, gt=0)
    model_error: float = quantity("pixel", "standard deviation of a centre beside the fit's own", 0.01, ge=0)

    chain_pixel: tuple[Pair, ...] = quantity(
        "pixel", "published: markers 0, 1, ... as read in its first image, two at least lying on the floor", ()
    )
    centroid_deviation: float = quantity("pixel", "published: standard deviation of a centroid", 0.5, gt=0)

    @model_validator(mode="after")
    def _is_calibrated(self) -> Markers:
        if len(self.reference_pixel) != len(self.reference_position):
            raise ValueError(
                f"{len(self.reference_pixel)} reference pixels for {len(self.reference_position)} reference positions"
            )
        if self.method == "published":
            self.affinity()
        elif len(self.reference_pixel) < 3:
            raise ValueError(
                f"{len(self.reference_pixel)} reference points; the scales of a plane need three, its tilt four"
            )
        else:
            self.homography()
        return self

    @model_validator(mode="after")
    def _are_seen(self) -> Markers:
        for name in ("reference_pixel", "mark_pixel", "chain_pixel"):
            for u, v in getattr(self, name):
                if not (0.0 <= u <= self.width - 1 and 0.0 <= v <= self.height - 1):
                    raise ValueError(f"{name} ({u:g}, {v:g}) is not in an image of {self.width} x {self.height}")
        return self

    def lens(self) -> calibration.Lens:
        """Its distortion, about the middle of the image."""
        return calibration.Lens(self.focal_length, 0.5 * (self.width - 1), 0.5 * (self.height - 1), self.distortion)

    def homography(self) -> np.ndarray:
        """(9,) from undistorted pixels to north and down. Raises ValueError if the reference points tell none."""
        pixels = calibration.undistorted(self.lens(), calibration.STILL, np.array(self.reference_pixel))
        return reference.homography(self.lens(), pixels, np.array(self.reference_position), self.reference_deviation)

    def affinity(self) -> scales.Affinity:
        """Of method published. Raises ValueError if less than two markers are given."""
        return scales.calibrate(np.array(self.chain_pixel).reshape(-1, 2), self.spacing)

    def vector(self) -> np.ndarray:
        """Method, sizes, then what task_of() or affinity_of() reads; scale deviations first."""
        head = [METHODS.index(self.method), self.width, self.height, self.markers, self.plane, *self.first_position]
        if self.method == "published":
            spread = calibration.scale_deviation(np.array(self.chain_pixel), self.reference_deviation)
            return np.array([*head, *spread, *self.affinity(), self.centroid_deviation])
        spread = calibration.scale_deviation(np.array(self.reference_pixel), self.reference_deviation)
        numbers = [*self.lens(), *self.homography(), self.mark_radius, self.bump_limit, self.spacing]
        numbers += [0.5 * self.marker_diameter, 0.5 * self.diameter, self.first_tolerance, self.agility]
        numbers += [self.wander or 0.4 * self.spacing, hypot(self.blur, PIXEL_BLUR), self.contrast, self.model_error]
        return np.array([*head, *spread, *numbers, *np.ravel(self.mark_pixel)])


METHOD, WIDTH, HEIGHT, MARKERS, PLANE, FIRST, SCALES, REST = 0, 1, 2, 3, 4, 5, 7, 9


def task_of(q: np.ndarray) -> finding.Task:
    """What method best looks for, from the parameters' vector."""
    rest = q[REST:].tolist()
    lens, homography, marks = calibration.Lens(*rest[:4]), np.array(rest[4:13]), np.array(rest[24:]).reshape(-1, 2)
    mark_radius, bump_limit, spacing, marker_radius, radius, tolerance, agility, wander, blur = rest[13:22]
    return finding.Task(
        lens,
        homography,
        marks,
        mark_radius,
        bump_limit,
        int(q[MARKERS]),
        spacing,
        marker_radius,
        radius,
        q[FIRST : FIRST + 2].copy(),
        tolerance,
        agility,
        wander,
        blur,
        *rest[22:24],
    )


def affinity_of(q: np.ndarray) -> tuple[scales.Affinity, float]:
    """Of method published, and its centroids' standard deviation [pixel]."""
    *affinity, deviation = q[REST:].tolist()
    return scales.Affinity(*affinity), deviation


def inputs(vision: Markers) -> tuple[Port, ...]:
    """The image."""
    return (ImagePort("image", shape=(vision.height, vision.width)),)


def outputs(vision: Markers) -> tuple[Port, ...]:
    """The markers in the image that came with the step; zeros where not valid.

    covariance is that of a marker's own errors. Beside it all markers share the errors of the scales: a relative one of
    north and one of down, of deviation scale_deviation, about the middle of the points of calibration.
    """
    m = vision.markers
    return (
        Port("pixel", "pixel", (m, 2), "", "column and row of the markers' centres"),
        Port("pixel_covariance", "pixel^2", (m, 2, 2), "", "of these"),
        Port("position", "m", (m, 3), "NED", "of the markers; east is the motion plane's"),
        Port("valid", "1", (m,), "", "1 where the marker is seen, else 0"),
        Port("covariance", "m^2", (m, 2, 2), "NED", "of north and down, without what all markers share"),
        Port("scale_deviation", "1", (2,), "", "of the scales along north and down, which all markers share"),
        Port("shift", "pixel", (2,), "", "of the image since calibration, by the marks fixed in the tank"),
    )


def sizes(vision: Markers) -> Sizes:
    """The tracks, or the reference image."""
    if vision.method == "published":
        return Sizes(state=-(-vision.width * vision.height // BYTES))
    return Sizes(state=finding.state_size(vision.markers))


def terms(vision: Markers) -> tuple[Term, ...]:
    """What of the method is on."""
    marks, best = len(vision.mark_pixel), vision.method == "best"
    return (
        Term("tilt", best and len(vision.reference_pixel) > 3, f"{len(vision.reference_pixel)} reference points"),
        Term("distortion", best and vision.distortion != 0.0, f"distortion {vision.distortion:g}"),
        Term("following a shifted camera", best and marks > 0, f"{marks} marks fixed in the tank"),
    )
