"""The markers of one image by method `best`: spots, fitted discs, the camera's turn, identities, covariances."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from components.vision.markers import bump, calibration, disc, identity, spots, tracks

TURN, TRACKS = slice(0, 3), 3  # in x: the camera's turn since calibration, then a record for each marker
RELATIVE_LEAST = 0.35  # of the median contrast that as many spots as there are markers and marks have
# A fit is no marker's where the radius is off by more, the residuals reach more of the contrast, or the disc's contrast
# is not as many times the line's.
CHAIN_ERROR = 0.5  # of a spot for the lengths of links [pixel]
SIZE_OFF, MISFIT, ABOVE_LINE = 0.3, 0.1, 1.3


class Task(NamedTuple):
    """What is looked for, and how.

    lens, homography: calibration. marks: (j, 2) pixels of the marks fixed in the tank at calibration, mark_radius
    [pixel]; bump_limit: how far they may have moved [pixel]. markers: their number, spacing along the line [m],
    marker_radius [m]; radius: of the line [m]. first: (2,) north and down of marker 0 at first, tolerance: of that, its
    standard deviation [m]. agility: acceleration to be followed [m/s^2]; wander: of an unseen marker [m]. blur: of an
    edge, its standard deviation [pixel]; contrast: least of a marker [grey level]; model_error: standard deviation of a
    centre beside the fit's own [pixel].
    """

    lens: calibration.Lens
    homography: np.ndarray
    marks: np.ndarray
    mark_radius: float
    bump_limit: float
    markers: int
    spacing: float
    marker_radius: float
    radius: float
    first: np.ndarray
    tolerance: float
    agility: float
    wander: float
    blur: float
    contrast: float
    model_error: float


class Found(NamedTuple):
    """Of the markers: pixel (m, 2), pixel_covariance (m, 2, 2) [pixel^2], plane (m, 2) north and down [m], covariance.

    covariance: (m, 2, 2) [m^2]; valid: (m,) bool; zeros where it is False. shift: (2,) of the camera [pixel].
    """

    pixel: np.ndarray
    pixel_covariance: np.ndarray
    plane: np.ndarray
    covariance: np.ndarray
    valid: np.ndarray
    shift: np.ndarray


def nothing(markers: int) -> Found:
    """No marker found."""
    two, square = (markers, 2), (markers, 2, 2)
    return Found(np.zeros(two), np.zeros(square), np.zeros(two), np.zeros(square), np.zeros(markers, bool), np.zeros(2))


def state_size(markers: int) -> int:
    """Numbers of x."""
    return TRACKS + tracks.TRACK * markers


def begin(x: np.ndarray) -> None:
    """Nothing was seen yet."""
    x[TURN] = 0.0
    tracks.forget(x[TRACKS:].reshape(-1, tracks.TRACK))


def scales_at(task: Task, turned: calibration.Turned, pixels: np.ndarray) -> np.ndarray:
    """(k,) metres of the motion plane that a pixel shows at pixels (k, 2)."""
    derivatives = calibration.plane_derivatives(task.lens, turned, task.homography, pixels)
    return np.sqrt(np.abs(np.linalg.det(derivatives)))


def middle_scale(task: Task, image: np.ndarray) -> float:
    """The same in the middle of the image at calibration."""
    height, width = image.shape
    return float(scales_at(task, calibration.STILL, np.array([[0.5 * width, 0.5 * height]]))[0])


def spots_of(task: Task, image: np.ndarray) -> np.ndarray:
    """(k, 3) spots of the image, the strongest first, with as much contrast as a marker may have."""
    by = spots.reduction(task.marker_radius / middle_scale(task, image))
    shape = image.shape[0] // by, image.shape[1] // by
    found, sums = np.empty((identity.ROOM[0], spots.SPOT)), np.empty((shape[0] + 1, shape[1] + 1), np.int64)
    count = spots.find_spots(image, by, 0.5 * task.contrast, sums, np.empty(shape, np.float32), found)
    wanted = task.markers + len(task.marks)
    least = RELATIVE_LEAST * found[wanted // 2, spots.CONTRAST] if count > wanted // 2 else 0.0
    return found[:count][found[:count, spots.CONTRAST] >= least]


def is_marker(task: Task, fit: disc.Fit, radius: float) -> bool:
    """Whether a fit is that of a marker seen whole."""
    return bool(
        fit.found
        and fit.contrast >= task.contrast
        and abs(fit.radius / radius - 1.0) < SIZE_OFF
        and fit.misfit < MISFIT * fit.contrast
        and fit.contrast > ABOVE_LINE * fit.line
    )


def shift_of(task: Task, turned: calibration.Turned) -> np.ndarray:
    """(2,) how far the middle of the image turned [pixel]."""
    ahead = calibration.rotation(turned)[:, 2]
    return calibration.seen_at(task.lens, ahead[None])[0] - (task.lens.cu, task.lens.cv)


def turned_camera(task: Task, image: np.ndarray, found: np.ndarray, last: np.ndarray) -> calibration.Turned:
    """The camera's turn by the marks fixed in the tank; the last one where they do not tell."""
    before = calibration.Turned(*map(float, last))
    if not len(task.marks):
        return before
    shift, alike = bump.find_shift(found[:, :2], task.marks, shift_of(task, before), task.bump_limit)
    if 2 * alike <= len(task.marks) and np.hypot(*(shift - shift_of(task, before))) > bump.AGREE:
        return before
    there, seen, used = task.marks + shift, np.zeros_like(task.marks), np.zeros(len(task.marks), bool)
    shape, scratch = disc.Shape(task.mark_radius, 0.5 * task.mark_radius, task.blur), np.empty(disc.ROOM)
    for j, (u, v) in enumerate(there):
        fit = disc.fit_disc(image, shape, u, v, scratch)
        seen[j] = fit.u, fit.v
        used[j] = fit.found and fit.contrast >= task.contrast and fit.misfit < MISFIT * fit.contrast
    used &= np.linalg.norm(seen - there, axis=1) < bump.AGREE
    if not used.any():
        return before
    before, after = (calibration.rays(task.lens, pixels[used]) for pixels in (task.marks, seen))
    return bump.turn_between(before, after)


def fitted(task: Task, image: np.ndarray, found: np.ndarray, turned: calibration.Turned) -> list[disc.Fit]:
    """Fits of all spots that are markers seen whole and not marks of the tank."""
    fits, scratch = [], np.empty(disc.ROOM)
    there = calibration.seen_at(task.lens, calibration.rays(task.lens, task.marks) @ calibration.rotation(turned).T)
    for (u, v), scale in zip(found[:, :2], scales_at(task, turned, found[:, :2]), strict=True):
        if len(there) and np.linalg.norm(there - (u, v), axis=1).min() < task.mark_radius:
            continue
        radius = task.marker_radius / scale
        fit = disc.fit_disc(image, disc.Shape(radius, task.radius / scale, task.blur), u, v, scratch)
        if is_marker(task, fit, radius):
            fits.append(fit)
    return fits


def identify(task: Task, plane: np.ndarray, error: float, expected: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """(m,) which of the spots (k, 2) [m] each marker is, -1 where it is not seen; error: of the spots [m]."""
    taken, single = np.empty(task.markers, np.int64), np.empty(task.markers, np.int64)
    links, chains = identity.empty_links(), identity.empty_chains(task.markers)
    identity.assign(plane, len(plane), task.spacing, error, expected, deviation, links, chains, single, taken)
    for k in range(len(plane)):
        twice = np.flatnonzero(taken == k)
        if len(twice) > 1:
            away = np.linalg.norm(expected[twice] - plane[k], axis=1) / deviation[twice]
            taken[np.delete(twice, np.argmin(away))] = -1
    return taken


def find(task: Task, image: np.ndarray, x: np.ndarray, h: float) -> Found:
    """The markers of an image (H, W) uint8, h [s] after the last one (0: the first); x goes on to this image."""
    found = spots_of(task, image)
    turned = turned_camera(task, image, found, x[TURN])
    x[TURN] = turned
    fits = fitted(task, image, found, turned)
    centres = np.array([(fit.u, fit.v) for fit in fits]).reshape(-1, 2)
    plane = calibration.to_plane(task.lens, turned, task.homography, centres)
    track = x[TRACKS:].reshape(-1, tracks.TRACK)
    expected = tracks.expect(track, h, task.agility, task.wander, task.first, task.tolerance)
    taken = identify(task, plane, CHAIN_ERROR * middle_scale(task, image), *expected)
    result = nothing(task.markers)
    result.shift[:] = shift_of(task, turned)
    seen = taken >= 0
    at = taken[seen]
    result.pixel[seen], result.plane[seen], result.valid[seen] = centres[at], plane[at], True
    own = np.array([((fit.uu, fit.uv), (fit.uv, fit.vv)) for fit in fits]).reshape(-1, 2, 2)
    own += task.model_error**2 * np.eye(2)
    metric = calibration.plane_derivatives(task.lens, turned, task.homography, centres[at])
    result.pixel_covariance[seen] = own[at]
    result.covariance[seen] = metric @ own[at] @ metric.transpose(0, 2, 1)
    tracks.go_on(track, result.plane, seen, h)
    return result
