"""Catenaries without noise are found again; what cannot be known is refused with its reason.

Authority: eq. 2 and 6-8 of Drupt et al. 2022, evaluated in extended precision and rounded to float64 once.
Tolerance: 1e-9 as the issue asks. Far from the origin the rounding of the coordinates themselves (uniform, of
deviation eps |x| / sqrt(12) at most) decides: the fit's own first-order covariance for markers with that noise says
what can be known, and errors must stay below five of its deviations.
"""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.analysis.indicators import REASONS, Status, fit_frames
from pipeline.analysis.markers import marker_frames

EPS = np.finfo(float).eps
CASES = 150
FAR = (1e6, -7e5, 3e5)


def fits_of(position, **options):
    """Of one frame (m, 3) or several (k, m, 3)."""
    position = position if np.ndim(position) == 3 else position[None]
    return fit_frames(marker_frames(np.arange(len(position)), position), **options)


def draw(markers, seed):
    """C L, chord, inclination and heading over the whole range asked, the corners first."""
    random = np.random.default_rng([markers, seed])
    reach = 10.0 ** random.uniform(-2.0, np.log10(50.0), CASES)
    chord = np.radians(random.uniform(0.0, 85.0, CASES)) * random.choice([0.0, 1.0, 1.0], CASES)
    alpha = np.radians(random.uniform(0.0, 89.0, CASES)) * random.choice([-1.0, 1.0, 0.0], CASES)
    reach[:16], chord[:8], alpha[:4] = 0.01, np.radians(85.0), np.radians(89.0)
    reach[16:32], chord[16:24], alpha[16:20] = 50.0, np.radians(85.0), np.radians(89.0)
    return reach, chord, alpha, random.uniform(-np.pi, np.pi, CASES)


def fit_cases(line, markers, length, origin, seed, marker_sigma=None, sign=1.0):
    """C, alpha and psi of the cases drawn, and their fits."""
    reach, chord, alpha, psi = draw(markers, seed)
    shapes = [line(sign * reach[i] / length, length, chord[i], markers, alpha[i], psi[i], origin) for i in range(CASES)]
    fits = fits_of(np.stack(shapes), marker_sigma=marker_sigma)
    return sign * reach / length, np.abs(alpha), psi, fits


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["heavy", "buoyant"])
@pytest.mark.parametrize("markers", [4, 5, 7, 12, 60, 500])
def test_recovers_c_and_alpha(line, markers, sign):
    C, alpha, psi, fits = fit_cases(line, markers, 3.5, (0.0, 0.0, 0.0), 1, sign=sign)
    assert fits.fitted.all(), fits.reasons()
    assert np.abs(fits.C / C - 1.0).max() < 1e-9
    assert np.abs(fits.alpha - alpha).max() < 1e-9
    assert np.abs(np.angle(np.exp(1j * (fits.psi - psi)))).max() < 1e-9
    # Residuals are rounding: some units of the last place of the coordinates.
    assert max(fits.e_plane.max(), fits.e_catenary.max()) < 1e3 * EPS * 3.5


@pytest.mark.parametrize("markers", [4, 12, 500])
@pytest.mark.parametrize("length", [3.5, 2000.0])
def test_far_from_the_origin_only_rounding_is_lost(line, markers, length):
    rounding = EPS * max(map(abs, FAR)) / np.sqrt(12.0)
    C, alpha, _, fits = fit_cases(line, markers, length, FAR, 2, marker_sigma=rounding)
    assert fits.fitted.all(), fits.reasons()
    assert (np.abs(fits.C / C - 1.0) < np.maximum(1e-9, 5.0 * fits.sigma_C / np.abs(C))).all()
    # The angle of a plane at 0 deg cannot come out negative: its absolute value is taken.
    assert (np.abs(fits.alpha - alpha) < np.maximum(1e-9, 5.0 * fits.sigma_alpha)).all()


def test_a_well_shaped_line_far_away_keeps_1e_9(line):
    """2 km of line, sag a fifth: the bound of the docstring is 1e-12, so the issue's 1e-9 holds at 1e6 m."""
    for markers in (4, 12, 500):
        fits = fits_of(line(1.0 / 1000.0, 2000.0, np.radians(30.0), markers, np.radians(20.0), 1.0, FAR))
        assert abs(fits.C[0] * 1000.0 - 1.0) < 1e-9
        assert abs(fits.alpha[0] - np.radians(20.0)) < 1e-9


# Rounding of coordinates near 1e6 m: an ulp of 1.16e-10 m over sqrt(12).
ROUNDED = np.spacing(1e6) / np.sqrt(12.0)


def largest_errors(line, sag, markers):
    """Of C relative and of alpha [rad], over 300 lines with this sag 1e6 m from the origin along each axis."""
    random = np.random.default_rng(12)
    C = 8.0 * sag / 2.695**2
    alpha, psi = random.uniform(0.1, 1.2, 300), random.uniform(-3.0, 3.0, 300)
    shapes = [
        line(C, 2.695, 0.0, markers, a, p, 1e6 + random.uniform(-1e3, -10.0, 3))
        for a, p in zip(alpha, psi, strict=True)
    ]
    fits = fits_of(np.stack(shapes), marker_sigma=ROUNDED)
    assert fits.fitted.all(), fits.reasons()
    return np.abs(fits.C / C - 1.0).max(), np.abs(fits.alpha - alpha).max()


@pytest.mark.parametrize("markers", [12, 60])
def test_at_the_bound_of_float64(line, markers):
    """1e-9 at 1e6 m needs the sag that the docstring of indicators derives; right there it is met, below it is not."""
    sag = 5.0 * 3.354 * ROUNDED / np.sqrt(markers) / 1e-9
    assert max(largest_errors(line, sag, markers)) < 1e-9
    assert min(largest_errors(line, 0.2 * sag, markers)) > 1e-9


def test_lowest_point(line):
    """P_0 in world coordinates: where eq. 2 puts it. Tolerance: 1e-12 of a line of 2.7 m, some hundred roundings."""
    shape = line(1.5, 2.695, np.radians(20.0), 12, np.radians(35.0), 0.7, (3.0, -2.0, 1.0))
    fits = fits_of(shape)
    x_p = np.array([np.cos(0.7), np.sin(0.7), 0.0])
    z_p = np.cross(fits.normal[0], x_p)
    z_p = z_p if z_p[2] < 0.0 else -z_p
    lowest = fits.centroid[0] + fits.x0[0] * x_p + fits.z0[0] * z_p
    along, up = (shape - lowest) @ x_p, (shape - lowest) @ z_p
    assert np.abs(up - (np.cosh(1.5 * along) - 1.0) / 1.5).max() < 1e-12
    assert np.abs((shape - lowest) @ fits.normal[0]).max() < 1e-12


def straight(direction, markers=12, origin=(0.3, 0.1, 0.7)):
    direction = np.array(direction) / np.linalg.norm(direction)
    return np.array(origin) + np.linspace(0.0, 2.695, markers)[:, None] * direction


SQUARE = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]])
SHAPES = {
    "straight": (straight([0.3, 0.5, 0.2]), Status.STRAIGHT),
    "straight along an axis": (straight([1.0, 0.0, 0.0]), Status.STRAIGHT),
    "straight, 4 markers": (straight([0.1, -0.9, 0.3], 4), Status.STRAIGHT),
    "straight, 500 markers": (straight([0.1, -0.9, 0.3], 500), Status.STRAIGHT),
    "straight, 1e6 m away": (straight([0.3, 0.5, 0.2], 12, FAR), Status.STRAIGHT),
    "vertical": (straight([0.0, 0.0, 1.0]), Status.STRAIGHT),
    "vertical, 1e6 m away": (straight([0.0, 0.0, 1.0], 12, FAR), Status.STRAIGHT),
    "coincident": (np.full((12, 3), 0.3), Status.COINCIDENT),
    "three places": (
        np.repeat(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.4], [2.0, 0.0, 0.0]]), 4, axis=0),
        Status.COINCIDENT,
    ),
    "three markers": (SQUARE[:3], Status.TOO_FEW),
    "no markers": (np.zeros((0, 3)), Status.TOO_FEW),
    "two abscissas": (SQUARE, Status.NO_CATENARY),
    "horizontal plane": (SQUARE[:, [0, 2, 1]] * [1.0, 2.0, 1.0], Status.HORIZONTAL),
}


@pytest.mark.parametrize("method", ["fast", "nelder-mead"])
@pytest.mark.parametrize("name", SHAPES)
def test_not_identifiable(name, method):
    shape, status = SHAPES[name]
    fits = fits_of(shape, method=method)
    assert fits.reasons() == {REASONS[status]: 1}
    assert REASONS[status].startswith("not identifiable: ")
    for name in ("alpha", "psi", "e_plane", "e_catenary", "C", "x0", "z0", "normal", "covariance", "centroid"):
        assert np.isnan(getattr(fits, name)).all(), name


def test_a_curve_out_of_any_plane_is_no_straight_line(line):
    """A frame far wider than the markers' scatter is fitted however thick it is: its alpha counts in the statistics."""
    random = np.random.default_rng(4)
    calm = line(1.0) + 5e-4 * random.standard_normal((50, 12, 3))
    helix = line(1.0) + np.stack([np.zeros(12), 0.2 * np.sin(np.linspace(0.0, 6.0, 12)), np.zeros(12)], axis=1)
    fits = fits_of(np.concatenate([calm, helix[None]]))
    assert fits.fitted.all()
    assert fits.e_plane[-1] > 0.05
