"""How near a line's markers are to a catenary, frame by frame: alpha, e_P, e_C and C with their covariance.

Without noise alpha [rad] and C (relative) come out to 1e-9 or better, as far as float64 can hold the markers: at a
distance R from the origin a coordinate is rounded to R / 2^53, of deviation sigma = ulp(R) / sqrt(12). For n markers
evenly along a line of span l and sag s, parabola z = 4 s (x / l)^2, least squares know C to sigma sqrt(720 / n) / l^2,
with C = 8 s / l^2, and the normal's turn to sigma / sqrt(n var z), with var z = (4 s)^2 / 180: both 3.354 sigma /
(sqrt(n) s). Five deviations are 1e-9 at R = 1e6 m, where sigma is 3.4e-11 m, for s = 0.56 m / sqrt(n).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np

from pipeline.analysis import catenary_fit, plane
from pipeline.analysis.catenary_fit import Catenaries, fit_catenaries
from pipeline.analysis.continuity import Continuity, check_continuity
from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.plane import Planes, fit_planes
from pipeline.analysis.scatter import Scatter, hidden, scatter
from pipeline.analysis.uncertainty import Sensitivity, sensitivity


class Status(IntEnum):
    """Whether a frame could be fitted; REASONS says why not."""

    FITTED = 0
    TOO_FEW = 1
    COINCIDENT = 2
    STRAIGHT = 3
    NO_PLANE = 4
    HORIZONTAL = 5
    NO_CATENARY = 6
    NOT_CONVERGED = 7


REASONS = {
    Status.FITTED: "fitted",
    Status.TOO_FEW: "not identifiable: fewer than 4 markers are visible",
    Status.COINCIDENT: "not identifiable: the markers stand at fewer than 4 different places",
    Status.STRAIGHT: "not identifiable: the markers stand on a straight line, in which no plane is marked out",
    Status.NO_PLANE: "not identifiable: the line is straight within the scatter of its markers, no plane is marked out",
    Status.HORIZONTAL: "not identifiable: the plane is horizontal within the markers' scatter, nothing in it points up",
    Status.NO_CATENARY: "not identifiable: at fewer than 3 different x in their plane, within the markers' scatter",
    Status.NOT_CONVERGED: "the fit did not converge",
}
# By the statuses of the plane's and of the curve's kernels.
_OF_PLANE = np.empty(5, np.int64)
_OF_PLANE[[plane.FITTED, plane.TOO_FEW, plane.COINCIDENT]] = Status.FITTED, Status.TOO_FEW, Status.COINCIDENT
_OF_PLANE[[plane.STRAIGHT, plane.HORIZONTAL]] = Status.STRAIGHT, Status.HORIZONTAL
_OF_CURVE = np.empty(3, np.int64)
_OF_CURVE[catenary_fit.FITTED] = Status.FITTED
_OF_CURVE[[catenary_fit.NO_CATENARY, catenary_fit.NOT_CONVERGED]] = Status.NO_CATENARY, Status.NOT_CONVERGED
METHODS = ("fast", "nelder-mead")


@dataclass(frozen=True)
class Fits:
    """The fits of k frames of m markers; every number is NaN where status is not FITTED.

    C, x0 and z0 are NaN also where C is not identifiable: its standard deviation exceeds it.

    t_ns: (k,) [ns]. visible: (k,) markers seen. n: (k,) markers fitted. left_out: (k,) seen but not on the line.
    swapped: (k,) markers whose labels were exchanged. used: (k, m) bool. status: (k,) int, see Status.
    alpha: (k,) inclination of the plane to the vertical, 0 to pi/2 [rad]. psi: (k,) heading of x_p [rad].
    e_plane, e_catenary: (k,) RMS distances [m], e_P and e_C of Drupt et al. 2022, III.B. C: (k,) eq. 8 [1/m].
    x0, z0: (k,) the catenary's lowest point in F_p (x_p horizontal, z_p up the plane), from the centroid [m].
    centroid: (k, 3) of the markers used, NED [m]. normal: (k, 3) y_p in NED.
    covariance: (k, 5, 5) of (alpha, psi, x0, z0, C), first order, in their units.
    noise_gain: (k,) e_catenary that markers' noise of 1 m would give. marker_sigma: noise of a marker's coordinate [m],
    as given or found in the record. notes: what was mended, not checked or not identifiable.
    """

    t_ns: np.ndarray
    visible: np.ndarray
    n: np.ndarray
    left_out: np.ndarray
    swapped: np.ndarray
    used: np.ndarray
    status: np.ndarray
    alpha: np.ndarray
    psi: np.ndarray
    e_plane: np.ndarray
    e_catenary: np.ndarray
    C: np.ndarray
    x0: np.ndarray
    z0: np.ndarray
    centroid: np.ndarray
    normal: np.ndarray
    covariance: np.ndarray
    noise_gain: np.ndarray
    marker_sigma: float
    notes: tuple[str, ...] = ()

    @property
    def fitted(self) -> np.ndarray:
        """(k,) bool."""
        return self.status == Status.FITTED

    @property
    def sigma_alpha(self) -> np.ndarray:
        """(k,) standard deviation of alpha [rad]."""
        return np.sqrt(self.covariance[:, 0, 0])

    @property
    def sigma_C(self) -> np.ndarray:
        """(k,) standard deviation of C [1/m]."""
        return np.sqrt(self.covariance[:, 4, 4])

    def reasons(self) -> dict[str, int]:
        """Frames by reason, those fitted included."""
        return {
            REASONS[status]: int((self.status == status).sum()) for status in Status if (self.status == status).any()
        }


def fit_frames(frames: MarkerFrames, method: str = "fast", marker_sigma: float | None = None) -> Fits:
    """Fit plane and inclined catenary to every frame.

    method: "fast", or "nelder-mead" as published, a thousand times slower.
    marker_sigma: standard deviation of a marker's coordinates [m]; None: from the residuals.
    Raises ValueError if there is no such method.
    """
    if method not in METHODS:
        raise ValueError(f"method {method!r} is not known; use one of {', '.join(METHODS)}")
    continuity = check_continuity(frames)
    planes = fit_planes(frames.position, continuity.order)
    curves = fit_catenaries(planes.points, np.where(planes.status == 0, planes.n, 0))
    sensitive = sensitivity(planes, curves)
    noise = scatter(frames, planes, curves, sensitive.noise_gain, marker_sigma)
    status = _status(planes, curves, noise)
    if method == "nelder-mead":
        from pipeline.analysis.nelder_mead import search  # scipy.optimize takes a quarter of a second to import

        planes, curves = search(frames, continuity.order, planes, status == Status.FITTED)
        status = np.where(status == Status.FITTED, _OF_CURVE[curves.status], status)
        sensitive = sensitivity(planes, curves)
    covariance = sensitive.covariance(planes, curves, marker_sigma)
    fits = _gather(frames, continuity, planes, curves, sensitive, status, covariance)
    found = marker_sigma if marker_sigma is not None else noise.sigma
    return replace(fits, marker_sigma=found, notes=(*fits.notes, *([noise.note] if noise.note else [])))


def _status(planes: Planes, curves: Catenaries, noise: Scatter) -> np.ndarray:
    """(k,) of what noise may have made, the plane before what is in it, and of what is singular whatever the noise."""
    status = np.where(planes.status == 0, _OF_CURVE[curves.status], _OF_PLANE[planes.status])
    lost = hidden(planes, noise)
    status[lost.curve] = Status.NO_CATENARY
    status[lost.upright] = Status.HORIZONTAL
    status[lost.plane] = Status.NO_PLANE
    status[(planes.status == 0) & (curves.status == catenary_fit.NO_CATENARY)] = Status.NO_CATENARY
    return status


def _gather(
    frames: MarkerFrames,
    continuity: Continuity,
    planes: Planes,
    curves: Catenaries,
    sensitive: Sensitivity,
    status: np.ndarray,
    covariance: np.ndarray,
) -> Fits:
    k, m = frames.valid.shape
    fitted = status == Status.FITTED
    used = np.zeros((k, m + 1), bool)
    np.put_along_axis(used, continuity.order, True, axis=1)  # -1 falls on the last column
    has_C = fitted & ~(np.sqrt(np.maximum(covariance[:, 4, 4], 0.0)) > np.abs(curves.C))
    notes = list(frames.notes)
    if continuity.note:
        notes.append(continuity.note)
    if unknown := int((fitted & ~has_C).sum()):
        notes.append(f"C is not identifiable in {unknown} of the fitted frames: its standard deviation exceeds it")

    def known(values: np.ndarray, where: np.ndarray = fitted) -> np.ndarray:
        found = np.full_like(values, np.nan)
        found[where] = values[where]
        return found

    return Fits(
        t_ns=frames.t_ns,
        visible=frames.valid.sum(axis=1),
        n=planes.n,
        left_out=continuity.left_out,
        swapped=continuity.swapped,
        used=used[:, :m],
        status=status,
        alpha=known(np.abs(planes.inclination)),
        psi=known(planes.psi),
        e_plane=known(planes.e_plane),
        e_catenary=known(curves.e_catenary),
        C=known(curves.C, has_C),
        x0=known(curves.x0, has_C),
        z0=known(curves.z0, has_C),
        centroid=known(planes.centroid),
        normal=known(planes.normal),
        covariance=known(covariance),
        noise_gain=known(sensitive.noise_gain),
        marker_sigma=np.nan,
        notes=tuple(notes),
    )
