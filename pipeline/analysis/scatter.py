"""What the markers' scatter leaves unknown: the noise of a record, and the frames whose shape may be noise alone.

Three bounds of the noise, each holding something else besides: the third differences in time of each marker, which also
hold its jerk, the fourth differences from marker to marker, which also hold the line's bends, and the distances from
the plane and from a curve in it, which also hold waves. The least is taken, in its worst direction, so that scatter
need not be isotropic; and no less than was given. Where the rate does not resolve the motion none of them is the noise:
then what was given counts, or a note says so. A frame noisier than its record counts as noisy as it is. Coordinates
rounded to a grid may be half of its spacing off, all of them in step, which is added.

A shape is refused where straight lines with so much noise would have it once in CHANCE of all *records*: the chance is
shared out among the frames. And no shape may hang on one marker alone, which may be a stray one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipeline.analysis.catenary_fit import Catenaries
from pipeline.analysis.grid import grid
from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.plane import Planes

CHANCE = 0.01  # that a record of straight lines gives any number at all
ALTERNATING = np.array([-1.0, 3.0, -3.0, 1.0])  # third difference; white noise gives it 20 times its variance
ALONG = np.array([1.0, -4.0, 6.0, -4.0, 1.0])  # fourth difference, from marker to marker
# Fourth differences that overlap share noise: of so many windows one is new, the sum of their squared correlations.
OVERLAP = float((np.correlate(ALONG, ALONG, "full") ** 2).sum() / (ALONG @ ALONG) ** 2)
# Of the estimate in time, when every second frame is left out. Noise alone leaves it as it is, jerk makes it 8 times:
# doubled, a twentieth of the variance is jerk's.
SETTLED = 2.0
NOTICED = 1e-3  # of the distance of neighbours: less noise than that hides nothing that is asked
SOME_FRAMES = 2000  # evenly over the record, for its fourth differences
MANY_WINDOWS = 100  # over the record, for a median that chance hardly lowers
EVEN = 0.1  # of the usual interval: frames that far from evenly spaced have no third difference
# A record whose median frame leaves its straight line by less than this many of its own distances from the fit shows
# no curve: what is steady in time (markers stuck on askew, positions smoothed by their tracker) counts as noise too.
SHOWS_CURVE = 3.0
# Of the distance of neighbouring markers: third differences in time beyond that are motion from frame to frame.
NO_NOISE = 0.1
MANY = 1e6  # degrees of freedom of a variance that is as good as known


@dataclass(frozen=True)
class Scatter:
    """Of k frames. sigma: noise of a marker's coordinate over the record [m]; frame: (k,) the same of each frame [m].

    grid: spacing of the coordinates' values [m], 0 if none was found. freedom: degrees of freedom behind sigma.
    note: that sigma is only a bound; "" where it is the noise.
    """

    sigma: float
    frame: np.ndarray
    grid: float
    freedom: float
    note: str = ""

    def least(self, freedom: np.ndarray | float, markers: np.ndarray, tests: int) -> np.ndarray:
        """(k,) root of a sum of squares of so many degrees of freedom that noise exceeds in CHANCE / tests [m].

        Half of the chance is for the sum to be great: chi square of d degrees of freedom exceeds d + 2 sqrt(d t) + 2 t
        with probability exp(-t) at most (Laurent and Massart 2000, Ann. Statist. 28, 1302-1338, eq. 4.3). The other
        half is for sigma to be found too small.
        """
        t = np.log(2.0 * tests / CHANCE)
        worst = np.sqrt((freedom + 2.0 * np.sqrt(freedom * t) + 2.0 * t) / _found_too_small(t, self.freedom))
        return self.frame * worst + self.grid * np.sqrt(0.25 * 3.0 * markers)


def _found_too_small(t: float, freedom: float) -> float:
    """Share of its mean that a chi square stays below with probability exp(-t) at most: x with x e^(1 - x) = e^(-2t/d).

    Chernoff's bound; for many degrees of freedom d it is 1 - 2 sqrt(t / d).
    """
    low, high = 0.0, 1.0
    while high - low > 1e-9 * high:
        x = 0.5 * (low + high)
        if np.log(x) + 1.0 - x > -2.0 * t / freedom:
            high = x
        else:
            low = x
    return high


def scatter(
    frames: MarkerFrames, planes: Planes, curves: Catenaries, noise_gain: np.ndarray, given: float | None
) -> Scatter:
    """The scatter of a record, see above. noise_gain: (k,) of uncertainty. given: deviation of a coordinate [m]."""
    about_fit = _about_fit(planes, curves, noise_gain)
    in_time, of_record = _in_time(frames)
    fitted = np.isfinite(about_fit)
    usual = float(np.median(about_fit[fitted])) if fitted.any() else 0.0
    width = planes.width[fitted] / np.sqrt(np.maximum(planes.n[fitted] - 2, 1))
    shows_curve = not fitted.any() or float(np.median(width)) > SHOWS_CURVE * usual
    along = _along_line(frames)
    found = min(of_record, usual, along) if shows_curve else usual
    own = np.minimum(about_fit, in_time)
    is_bound = shows_curve and not _resolved(frames, of_record, along)
    if given and is_bound:  # nothing contradicts what was given
        found, own = given, np.full_like(own, given)
    elif is_bound:
        own = np.minimum(own, along)
    sigma = max(found, given or 0.0)
    frame = np.maximum(sigma, np.where(np.isfinite(own), own, 0.0))
    freedom = MANY if given else float(min(MANY, max(1, (planes.n[fitted] - 3).sum())))
    note = _bound_note(sigma) if is_bound and not given and sigma > NOTICED * _spacing(frames) else ""
    return Scatter(sigma, frame, grid(frames), freedom, note)


def _bound_note(sigma: float) -> str:
    return (
        "the markers' noise cannot be told from their motion at this rate: it counts as the most it can be, "
        f"{1e3 * sigma:.2g} mm; give it with --noise"
    )


def _resolved(frames: MarkerFrames, of_record: float, along: float) -> bool:
    """Whether what third differences in time find is noise: it does not grow with the interval, nor exceeds `along`."""
    if not np.isfinite(of_record) or of_record > along:
        return False
    half = replace(frames, t_ns=frames.t_ns[::2], position=frames.position[::2], valid=frames.valid[::2])
    return _in_time(half)[1] <= SETTLED * of_record


def _about_fit(planes: Planes, curves: Catenaries, noise_gain: np.ndarray) -> np.ndarray:
    """(k,) distance from the plane, or in it from the catenary or from marker to marker, whichever is less [m].

    By their degrees of freedom; inf where no plane was found.
    """
    across = planes.e_plane * np.sqrt(planes.n / np.maximum(planes.n - 3.0, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        from_catenary = np.where(curves.status == 0, curves.e_catenary / noise_gain, np.inf)
    greater = np.maximum(across, np.fmin(from_catenary, _roughness(planes)))
    return np.where(planes.status == 0, greater, np.inf)


def _roughness(planes: Planes) -> np.ndarray:
    """(k,) noise by third differences from marker to marker, across the line in its plane [m]: also holds its bends."""
    x, z = planes.points[:, :, 0], planes.points[:, :, 1]
    used = np.arange(x.shape[1]) < planes.n[:, None]
    xx, xz, zz = ((a * b * used).sum(axis=1) for a, b in ((x, x), (x, z), (z, z)))
    turn = 0.5 * np.arctan2(2.0 * xz, xx - zz)[:, None]
    across = z * np.cos(turn) - x * np.sin(turn)
    if across.shape[1] < len(ALTERNATING):
        return np.full(len(x), np.inf)
    windows = across.shape[1] - len(ALTERNATING) + 1
    difference = sum(c * across[:, i : i + windows] for i, c in enumerate(ALTERNATING))
    inside = used[:, len(ALTERNATING) - 1 :]
    square = (difference**2 * inside).sum(axis=1)
    return np.sqrt(square / (ALTERNATING @ ALTERNATING * np.maximum(inside.sum(axis=1), 1)))


def _in_time(frames: MarkerFrames) -> tuple[np.ndarray, float]:
    """Noise by third differences in time, in its worst direction: (k,) of each frame, and of the record [m].

    inf where there is none, and for the record if it is motion. The record's covariance is the median of the frames',
    element by element, over the median of a chi square: its mean times (1 - 2/(9 d))^3 (Wilson and Hilferty 1931,
    Proc. Nat. Acad. Sci. 17, 684-688).
    """
    k, m = frames.valid.shape
    found = np.full(k, np.inf)
    if k < len(ALTERNATING) or m == 0:
        return found, np.inf
    windows = k - len(ALTERNATING) + 1
    rows = [slice(i, i + windows) for i in range(len(ALTERNATING))]
    seen = np.logical_and.reduce([frames.valid[row] for row in rows])
    steps = np.diff(frames.t_ns)
    usual = np.median(steps)
    even = np.logical_and.reduce([np.abs(steps[i : i + windows] - usual) <= EVEN * usual for i in range(3)])
    difference = sum(c * frames.position[row] for c, row in zip(ALTERNATING, rows, strict=True))
    difference = np.where(seen[:, :, None], difference, 0.0)
    count = seen.sum(axis=1)
    good = np.flatnonzero(even & (count > 0))
    if not len(good):
        return found, np.inf
    moments = np.einsum("kma,kmb->kab", difference[good], difference[good])
    moments /= (ALTERNATING @ ALTERNATING * count[good])[:, None, None]
    most = NO_NOISE * _spacing(frames)
    largest = np.sqrt(np.maximum(np.linalg.eigvalsh(moments)[:, -1], 0.0))
    found[good + 1] = np.minimum(largest, most)
    found[0], found[windows + 1 :] = found[1], found[windows]
    usual_moments = np.median(moments, axis=0) / (1.0 - 2.0 / (9.0 * np.median(count[good]))) ** 3
    of_record = float(np.sqrt(max(np.linalg.eigvalsh(usual_moments)[-1], 0.0)))
    return found, of_record if of_record <= most else np.inf


def _along_line(frames: MarkerFrames) -> float:
    """Noise of the record by fourth differences from marker to marker, in its worst direction [m]: also holds bends.

    As in _in_time; inf where too few neighbours are seen together.
    """
    windows = frames.markers - len(ALONG) + 1
    if windows < 1:
        return np.inf
    columns = [slice(i, i + windows) for i in range(len(ALONG))]
    some = slice(None, None, 1 + len(frames.t_ns) // SOME_FRAMES)
    position, valid = frames.position[some], frames.valid[some]
    seen = np.logical_and.reduce([valid[:, column] for column in columns])
    count = seen.sum(axis=1)
    good = np.flatnonzero(count)
    if count.sum() < MANY_WINDOWS:
        return np.inf
    difference = sum(c * position[:, column] for c, column in zip(ALONG, columns, strict=True))
    difference = np.where(seen[:, :, None], difference, 0.0)[good]
    moments = np.einsum("kma,kmb->kab", difference, difference) / (ALONG @ ALONG * count[good])[:, None, None]
    freedom = max(1.0, float(np.median(count[good])) / OVERLAP)
    usual_moments = np.median(moments, axis=0) / (1.0 - 2.0 / (9.0 * freedom)) ** 3
    return float(np.sqrt(max(np.linalg.eigvalsh(usual_moments)[-1], 0.0)))


def _spacing(frames: MarkerFrames) -> float:
    """Median distance of neighbouring markers that are both seen [m]; inf if there are none."""
    both = frames.valid[:, 1:] & frames.valid[:, :-1]
    if not both.any():
        return np.inf
    steps = np.diff(frames.position, axis=1)
    return float(np.sqrt(np.median((steps * steps).sum(axis=2)[both])))


@dataclass(frozen=True)
class Hidden:
    """(k,) bool each: what cannot be told from noise. plane: that the line is not straight. upright: that its plane is
    not horizontal. curve: that its markers stand at different x in the plane."""

    plane: np.ndarray
    upright: np.ndarray
    curve: np.ndarray


def hidden(planes: Planes, noise: Scatter) -> Hidden:
    """What noise may have made, of frames in which a plane was found.

    A straight line's markers leave it in two directions, by no less than in the plane found. The normal is known to
    sigma / width in each direction, its horizontal part is the cosine of the inclination. Of x there is one direction.
    """
    found = planes.status == 0
    n, tests = planes.n, max(1, int(found.sum()))
    used = np.arange(planes.points.shape[1]) < n[:, None]
    extent = np.sqrt((planes.points[:, :, 0] ** 2 * used).sum(axis=1))
    across = planes.width * np.abs(np.cos(planes.inclination))
    return Hidden(
        plane=found & (planes.firm <= noise.least(2.0 * np.maximum(n - 2, 1), n, tests)),
        upright=found & (across <= noise.least(2.0, n, tests)),
        curve=found & (extent <= noise.least(1.0 * np.maximum(n - 1, 1), n, tests)),
    )
