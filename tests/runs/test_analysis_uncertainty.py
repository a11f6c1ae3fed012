"""The covariance of the fitted parameters and the indicators' bias under noise, against Monte Carlo.

Authority: 4000 draws of the markers' noise on one known line.
Tolerance: a standard deviation from 4000 draws is itself known to 1.1 %; 5 % is 4.5 of its deviations, and leaves room
for what first order leaves out at sag over noise of 500 and more. Means are known to sigma / 63; 4.5 of that allowed.
"""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.analysis.bias import compare, compare_by_markers, expected, folded_mean, simulate
from pipeline.analysis.indicators import fit_frames
from pipeline.analysis.markers import marker_frames

DRAWS = 4000
SIGMA = 5e-4
ROOT = np.sqrt(DRAWS)
SPACING = 0.245
# C, chord [deg], markers, inclination [deg]
LINES = {
    "slack": (1.5, 0.0, 12, 10.0),
    "sloped": (1.0, 40.0, 9, 30.0),
    "tight": (0.4, 20.0, 12, 5.0),
    "leaning": (1.0, 30.0, 7, 70.0),
}


def one_frame(line, name):
    C, chord, markers, alpha = LINES[name]
    shape = line(C, SPACING * (markers - 1), np.radians(chord), markers, np.radians(alpha), 0.7, (2.0, -1.0, 0.5))
    return marker_frames(np.zeros(1), shape[None], arc=SPACING * np.arange(markers))


@pytest.mark.parametrize("name", LINES)
def test_covariance(line, name):
    truth, fits = simulate(one_frame(line, name), SIGMA, 0.0, DRAWS, 1)
    assert fits.fitted.all()
    x_p = np.array([np.cos(truth.psi[0]), np.sin(truth.psi[0]), 0.0])
    z_p = np.cross(truth.normal[0], x_p)
    z_p *= -np.sign(z_p[2])
    # x0, z0 are measured from the centroid of the noisy markers: measure both from the true one.
    moved = fits.centroid - truth.centroid
    found = np.stack([fits.alpha, fits.psi, fits.x0 + moved @ x_p, fits.z0 + moved @ z_p, fits.C], axis=1)
    predicted = truth_covariance(line, name)
    deviation = np.sqrt(np.diag(predicted))
    assert found.std(axis=0) == pytest.approx(deviation, rel=0.05)
    correlation = predicted / np.outer(deviation, deviation)
    assert np.abs(np.corrcoef(found.T) - correlation).max() < 4.5 / ROOT + 0.01


def truth_covariance(line, name):
    return fit_frames(one_frame(line, name), marker_sigma=SIGMA).covariance[0]


@pytest.mark.parametrize("name", LINES)
def test_covariance_from_the_residuals_alone(line, name):
    """Without a given sigma the variance is estimated from each frame; its mean is the true one (n - 3 chi square)."""
    frames = one_frame(line, name)
    random = np.random.default_rng(2)
    noisy = frames.position + SIGMA * random.standard_normal((DRAWS, *frames.position.shape[1:]))
    fits = fit_frames(marker_frames(np.arange(DRAWS), noisy, arc=frames.arc))
    spread = 4.5 * np.sqrt(2.0 / (frames.markers - 3)) / ROOT
    mean = np.diagonal(fits.covariance, axis1=1, axis2=2).mean(axis=0)
    assert mean == pytest.approx(np.diag(truth_covariance(line, name)), rel=spread + 0.02)


@pytest.mark.parametrize("name", LINES)
def test_floors_of_e_p_and_e_c(line, name):
    truth, fits = simulate(one_frame(line, name), SIGMA, 0.0, DRAWS, 3)
    formula = expected(truth, SIGMA)
    n = truth.n[0]
    assert formula.floor_plane[0] == pytest.approx(SIGMA * np.sqrt((n - 3) / n), rel=1e-12)
    # Root mean squares of chi distributed values: known to 1 / sqrt(2 (n - 3) draws), 0.6 % at worst.
    assert np.sqrt((fits.e_plane**2).mean()) == pytest.approx(formula.floor_plane[0], rel=0.03)
    assert np.sqrt((fits.e_catenary**2).mean()) == pytest.approx(formula.floor_catenary[0], rel=0.03)


def test_the_noise_is_taken_off_again(line):
    """A true e_C of 10 mm is found again below noise of 5 mm: its mean square, to 5 %."""
    frames = one_frame(line, "slack")
    wave = 0.014 * np.cos(np.linspace(0.0, 4.0 * np.pi, 12))
    position = frames.position + wave[:, None] * np.array([0.0, 0.0, 1.0])
    bent = marker_frames(np.zeros(1), position, arc=2.0 * frames.arc)
    truth, fits = simulate(bent, 5e-3, 0.0, DRAWS, 4)
    corrected = np.sqrt((fits.e_catenary**2).mean() - (expected(truth, 5e-3).floor_catenary[0]) ** 2)
    assert corrected == pytest.approx(truth.e_catenary[0], rel=0.05)


@pytest.mark.parametrize("alpha", [0.0, 1e-3, 0.1])
def test_bias_of_alpha(line, alpha):
    """Near a vertical plane the absolute value does not average out: a folded normal distribution."""
    shape = line(1.5, 2.695, 0.3, 12, alpha, 0.7)
    frames = marker_frames(np.zeros(1), shape[None], arc=SPACING * np.arange(12))
    truth, fits = simulate(frames, SIGMA, 0.0, DRAWS, 5)
    sigma = fit_frames(frames, marker_sigma=SIGMA).sigma_alpha[0]
    bias = compare(truth, fits)
    assert bias.alpha.mean == pytest.approx(folded_mean(np.array(alpha), sigma) - alpha, abs=4.5 * sigma / ROOT)
    if alpha == 0.0:
        assert bias.alpha.mean == pytest.approx(sigma * np.sqrt(2.0 / np.pi), rel=0.05)


def test_bias_of_c_is_small_against_its_deviation(line):
    for name in LINES:
        bias = compare(*simulate(one_frame(line, name), SIGMA, 0.0, DRAWS, 6))
        assert abs(bias.C.mean) < 0.1 * bias.C.std


def test_drop_out_lowers_the_errors_and_raises_the_scatter(line):
    """Fewer markers follow more closely: the floor of e_P falls as sqrt((n - 3) / n), that of C's knowledge rises."""
    truth, fits = simulate(one_frame(line, "slack"), SIGMA, 0.3, DRAWS, 7)
    rows = [row for row in compare_by_markers(truth, fits) if row.frames > 300]
    assert len(rows) >= 4
    for row in rows:
        mean_square = row.e_plane.mean**2 + row.e_plane.std**2
        allowed = 4.5 * np.sqrt(2.0 / ((row.n - 3) * row.frames))
        assert mean_square == pytest.approx(SIGMA**2 * (row.n - 3) / row.n, rel=allowed + 0.02)
    assert np.all(np.diff([row.C.std for row in rows]) < 0.0)
    assert sum(row.frames for row in compare_by_markers(truth, fits)) == fits.fitted.sum()
