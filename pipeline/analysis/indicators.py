"""How near a line's markers are to a catenary, frame by frame: alpha, e_P, e_C and C with their covariance."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from pipeline.analysis import catenary_fit, plane
from pipeline.analysis.catenary_fit import Catenaries, fit_catenaries
from pipeline.analysis.continuity import Continuity, check_continuity
from pipeline.analysis.markers import MarkerFrames
from pipeline.analysis.plane import Planes, fit_planes
from pipeline.analysis.uncertainty import propagate, take


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
    Status.HORIZONTAL: "not identifiable: the plane is horizontal, nothing in it points up",
    Status.NO_CATENARY: "not identifiable: the markers stand at fewer than 3 different x in their plane",
    Status.NOT_CONVERGED: "the fit did not converge",
}
# By the statuses of the plane's and of the curve's kernels.
_OF_PLANE = np.empty(6, np.int64)
_OF_PLANE[[plane.FITTED, plane.TOO_FEW, plane.COINCIDENT]] = Status.FITTED, Status.TOO_FEW, Status.COINCIDENT
_OF_PLANE[[plane.STRAIGHT, plane.NO_PLANE, plane.HORIZONTAL]] = Status.STRAIGHT, Status.NO_PLANE, Status.HORIZONTAL
_OF_CURVE = np.empty(3, np.int64)
_OF_CURVE[catenary_fit.FITTED] = Status.FITTED
_OF_CURVE[[catenary_fit.NO_CATENARY, catenary_fit.NOT_CONVERGED]] = Status.NO_CATENARY, Status.NOT_CONVERGED
METHODS = ("fast", "nelder-mead")


@dataclass(frozen=True)
class Fits:
    """The fits of k frames of m markers; every number is NaN where status is not FITTED.

    t_ns: (k,) [ns]. visible: (k,) markers seen. n: (k,) markers fitted. left_out: (k,) seen but not on the line.
    swapped: (k,) markers whose labels were exchanged. used: (k, m) bool. status: (k,) int, see Status.
    alpha: (k,) inclination of the plane to the vertical, 0 to pi/2 [rad]. psi: (k,) heading of x_p [rad].
    e_plane, e_catenary: (k,) RMS distances [m], e_P and e_C of Drupt et al. 2022, III.B. C: (k,) eq. 8 [1/m].
    x0, z0: (k,) the catenary's lowest point in F_p (x_p horizontal, z_p up the plane), from the centroid [m].
    centroid: (k, 3) of the markers used, NED [m]. normal: (k, 3) y_p in NED.
    covariance: (k, 5, 5) of (alpha, psi, x0, z0, C), first order, in their units.
    noise_gain: (k,) e_catenary that markers' noise of 1 m would give. notes: what was mended or not checked.
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
    planes = fit_planes(frames.position, continuity.order, marker_sigma)
    if method == "nelder-mead":
        from pipeline.analysis.nelder_mead import search  # scipy.optimize takes a quarter of a second to import

        planes, curves = search(frames, continuity.order, planes)
    else:
        curves = fit_catenaries(planes.points, np.where(planes.status == 0, planes.n, 0))
    return _gather(frames, continuity, planes, curves, marker_sigma)


def _gather(
    frames: MarkerFrames, continuity: Continuity, planes: Planes, curves: Catenaries, marker_sigma: float | None
) -> Fits:
    k, m = frames.valid.shape
    status = np.where(planes.status == 0, _OF_CURVE[curves.status], _OF_PLANE[planes.status])
    fitted = np.flatnonzero(status == Status.FITTED)
    covariance, noise_gain = np.full((k, 5, 5), np.nan), np.full(k, np.nan)
    covariance[fitted], noise_gain[fitted] = propagate(take(planes, fitted), take(curves, fitted), marker_sigma)
    used = np.zeros((k, m + 1), bool)
    np.put_along_axis(used, continuity.order, True, axis=1)  # -1 falls on the last column

    def known(values: np.ndarray) -> np.ndarray:
        found = np.full_like(values, np.nan)
        found[fitted] = values[fitted]
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
        C=known(curves.C),
        x0=known(curves.x0),
        z0=known(curves.z0),
        centroid=known(planes.centroid),
        normal=known(planes.normal),
        covariance=covariance,
        noise_gain=noise_gain,
        notes=(*frames.notes, continuity.note) if continuity.note else frames.notes,
    )
