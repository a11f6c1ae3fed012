"""First-order covariance of what the fits give, from the markers' scatter about plane and curve.

A marker's noise is taken as isotropic with deviation sigma, given, or estimated from the frame itself: across the
plane from the distances to it (n - 3 degrees of freedom), in the plane from those to the curve.

The normal deviates by (d_x, d_z) along x_p and z_p. By the rotations of Drupt et al. 2022, eq. 6 and 7, the
inclination changes by d_z, the heading by d_x / cos(inclination), and x_p turns in the plane by tan(inclination) d_x
towards z_p, which moves the markers under the curve and so (x0, z0, C).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TypeVar

import numpy as np

from pipeline.analysis.catenary_fit import SERIES, Catenaries
from pipeline.analysis.plane import Planes

SINGULAR = 4 * 2.220446049250313e-16  # determinant of the correlations of a, beta and C: rounding
BATCH = 2048  # frames taken together, which bounds the memory taken


Table = TypeVar("Table", Planes, Catenaries)


def take(table: Table, rows: slice | np.ndarray) -> Table:
    """The same arrays for these frames only."""
    return type(table)(**{field.name: getattr(table, field.name)[rows] for field in fields(table)})


@dataclass(frozen=True)
class Sensitivity:
    """Of k fits. across, along: (k, 5, 5) covariance of (alpha, psi, x0, z0, C) that a marker's unit variance across
    and in the plane gives [1/m^2 times their units]. noise_gain: (k,) e_C that noise of 1 m gives. Where the curve's
    parameters cannot be told apart at all, `along` is infinite and noise_gain NaN."""

    across: np.ndarray
    along: np.ndarray
    noise_gain: np.ndarray

    def covariance(self, planes: Planes, curves: Catenaries, sigma: float | None) -> np.ndarray:
        """(k, 5, 5) for markers of deviation sigma [m]; None: of each frame's own, from its residuals."""
        if sigma is not None:
            return sigma**2 * (self.across + self.along)
        across = planes.e_plane**2 * planes.n / (planes.n - 3)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # noise_gain 0 or NaN: nothing is known
            along = np.nan_to_num((curves.e_catenary / self.noise_gain) ** 2, nan=np.inf)
            return across[:, None, None] * self.across + along[:, None, None] * self.along


def sensitivity(planes: Planes, curves: Catenaries) -> Sensitivity:
    """To first order; NaN where plane or curve is not fitted."""
    k = len(planes.n)
    found = Sensitivity(np.full((k, 5, 5), np.nan), np.full((k, 5, 5), np.nan), np.full(k, np.nan))
    fitted = np.flatnonzero((planes.status == 0) & (curves.status == 0))
    for start in range(0, len(fitted), BATCH):
        rows = fitted[start : start + BATCH]
        parts = _sensitivity(take(planes, rows), take(curves, rows))
        found.across[rows], found.along[rows], found.noise_gain[rows] = parts
    return found


def _sensitivity(planes: Planes, curves: Catenaries) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n = planes.n
    jacobian, slope = _jacobian(planes, curves)
    # Columns scaled to length 1 first: x0 and C of a near-straight line differ by many orders of magnitude.
    scale = np.sqrt(np.einsum("kij,kij->kj", jacobian, jacobian))
    scale[~((scale > 0.0) & np.isfinite(scale))] = np.inf
    jacobian /= scale[:, None]
    normal = np.einsum("kip,kiq->kpq", jacobian, jacobian)
    singular = ~(np.linalg.det(normal) > SINGULAR)
    normal[singular], jacobian[singular], slope[singular] = np.eye(3), 0.0, 0.0
    influence = np.linalg.inv(normal) @ jacobian.transpose(0, 2, 1)
    # A marker's noise (dx, dz) changes its residual by dz - z' dx, of variance sigma^2 w; the squares of the
    # residuals expect sigma^2 trace((1 - H) W) with the hat matrix H.
    used = np.arange(planes.points.shape[1]) < n[:, None]
    weight = np.where(used, 1.0 + slope**2, 0.0)
    hat = np.einsum("kip,kpi->ki", jacobian, influence)
    freedom = ((1.0 - hat) * weight).sum(axis=1)
    curve = np.einsum("kpi,ki,kqi->kpq", influence, weight, influence)
    lever = planes.points[:, :, 0] + slope * planes.points[:, :, 1]
    turning = -np.einsum("kpi,ki->kp", influence, np.where(used, lever, 0.0))
    to_lowest = _to_lowest_point(curves) / scale[:, None]
    along = np.zeros((len(n), 5, 5))
    along[:, 2:, 2:] = to_lowest @ curve @ to_lowest.transpose(0, 2, 1)
    turning = np.einsum("kpq,kq->kp", to_lowest, turning)
    noise_gain = np.sqrt(np.maximum(freedom, 0.0) / n)
    along[singular, 2:, 2:], noise_gain[singular] = np.inf, np.nan
    return _with_plane(planes, turning), along, noise_gain


def _jacobian(planes: Planes, curves: Catenaries) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (k, m, 3) of z by (a, beta, C) and the slope z' (k, m); zero where there is no marker.

    As in catenary_fit, but in metres and for all frames together: it is wanted once, at the end.
    """
    used = np.arange(planes.points.shape[1]) < planes.n[:, None]
    u = np.where(used, planes.points[:, :, 0] - curves.middle[:, None], 0.0)
    S, K, C = np.sinh(curves.beta)[:, None], np.cosh(curves.beta)[:, None], curves.C[:, None]
    y = C * u
    s, q = np.sinh(0.5 * y), y * y
    sinh, cosh_1 = 2.0 * s * np.sqrt(1.0 + s * s), 2.0 * s * s
    A, B = sinh / C, cosh_1 / C
    series = u * u * y * (1.0 / 3.0 + q * (1.0 / 30.0 + q * (1.0 / 840.0 + q / 45360.0)))
    A_C = np.where(np.abs(y) < SERIES, series, (u * (1.0 + cosh_1) - A) / C)
    B_C = (u * sinh - B) / C
    columns = np.stack([np.ones_like(u), K * A + S * B, S * A_C + K * B_C], axis=2)
    return np.where(used[:, :, None], columns, 0.0), np.where(used, S * (1.0 + cosh_1) + K * sinh, 0.0)


def _to_lowest_point(curves: Catenaries) -> np.ndarray:
    """Derivatives of (x0, z0, C) by (a, beta, C): (k, 3, 3)."""
    to = np.zeros((len(curves.C), 3, 3))
    to[:, 0, 1], to[:, 0, 2] = -1.0 / curves.C, curves.beta / curves.C**2
    to[:, 1, 0], to[:, 1, 1] = 1.0, -np.sinh(curves.beta) / curves.C
    to[:, 1, 2] = 2.0 * np.sinh(0.5 * curves.beta) ** 2 / curves.C**2
    to[:, 2, 2] = 1.0
    return to


def _with_plane(planes: Planes, turning: np.ndarray) -> np.ndarray:
    """Covariance (k, 5, 5) of (alpha, psi, x0, z0, C) by the normal's deviation, for a unit variance of the markers."""
    cosine, tangent = np.cos(planes.inclination), np.tan(planes.inclination)
    by_normal = np.zeros((len(planes.n), 5, 2))  # d_x, d_z
    by_normal[:, 0, 1] = np.where(planes.inclination < 0.0, -1.0, 1.0)
    by_normal[:, 1, 0] = 1.0 / cosine  # psi is clockwise seen from above, the turn of eq. 6 is not
    by_normal[:, 2:, 0] = turning * tangent[:, None]
    normal = planes.tilt[:, [[0, 1], [1, 2]]]
    return by_normal @ normal @ by_normal.transpose(0, 2, 1)
