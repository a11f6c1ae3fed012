"""What scatter hides is refused: straight, vertical and level lines give no number, however their markers scatter.

Authority: the lines' own construction. Each record has 2000 frames; the rule allows one record in a hundred a number,
and its bounds are on the safe side, so that none of the few dozen records here may have one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.analysis.bias import by_drop_out, by_noise
from pipeline.analysis.grid import grid
from pipeline.analysis.indicators import REASONS, Status, fit_frames
from pipeline.analysis.markers import marker_frames
from pipeline.analysis.statistics import FLOORS, fails, reliable, statistics

FRAMES = 2000
T_NS = 20_000_000 * np.arange(FRAMES)
PLACES = np.linspace(0.0, 2.695, 12)


def fits_of(position, **options):
    return fit_frames(marker_frames(T_NS[: len(position)], position), **options)


def turning(markers=12):
    """A straight line that turns about its end: (2000, m, 3)."""
    t = np.linspace(0.0, 3.0, FRAMES)
    direction = np.stack([np.cos(t), np.sin(t), 0.5 * np.sin(0.7 * t)], axis=1)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return np.array([0.3, 0.1, 0.7]) + PLACES[:markers, None] * direction[:, None]


def still(markers=12):
    return np.repeat(turning(markers)[700:701], FRAMES, axis=0)


def vertical(markers=12):
    return np.zeros((FRAMES, 1, 1)) + PLACES[:markers, None] * np.array([0.0, 0.0, 1.0])


def normal(shape, random):
    return random.standard_normal(shape)


def bursts(shape, random):
    """Five times noisier in every tenth second."""
    return np.where(np.arange(FRAMES) // 50 % 10 == 0, 5.0, 1.0)[:, None, None] * random.standard_normal(shape)


def stray(shape, random):
    """One marker in 50 frames 30 sigma off."""
    noise = random.standard_normal(shape)
    noise[::50, shape[1] // 2] += [0.0, 25.0, 17.0]
    return noise


def smoothed(shape, random):
    """As a tracker that averages over ten frames gives them."""
    noise = np.cumsum(random.standard_normal((shape[0] + 10, *shape[1:])), axis=0)
    return (noise[10:] - noise[:-10]) / np.sqrt(10.0)


SCATTER = {
    "isotropic": normal,
    "worst upwards": lambda shape, random: random.standard_normal(shape) * [1.0, 1.0, 4.0],
    "one direction only": lambda shape, random: random.standard_normal(shape) * [0.01, 0.01, 1.0],
    "heavy tails": lambda shape, random: random.standard_t(3, shape),
    "bursts": bursts,
    "a stray marker": stray,
    "smoothed by the tracker": smoothed,
    "markers stuck on askew": lambda shape, random: 3.0 * random.standard_normal((1, *shape[1:])) + np.zeros(shape),
}


@pytest.mark.parametrize("line_of", [turning, still, vertical])
@pytest.mark.parametrize("markers", [7, 12])
@pytest.mark.parametrize("name", SCATTER)
def test_a_straight_line_gives_no_number(name, markers, line_of):
    random = np.random.default_rng([1, markers])
    shapes = line_of(markers)
    shapes = shapes + 1e-3 * SCATTER[name](shapes.shape, random)
    for sigma in (None, 1e-3):
        fits = fits_of(shapes, marker_sigma=sigma)
        assert fits.reasons() == {REASONS[Status.NO_PLANE]: FRAMES}
        assert np.isnan(fits.alpha).all()
        table = statistics(fits)
        assert table.alpha_deg is table.e_plane_mm is table.e_catenary_mm is None
        # A marker 60 sigma off, as heavy tails have it once in a record, is left out.
        assert table.frames_enough >= FRAMES - 1
        assert table.missing.startswith(f"no statistics: only 0 of {table.frames_enough} frames with 7 markers or more")


@pytest.mark.parametrize("noise", [0.0, 3e-4])
@pytest.mark.parametrize("spacing", [1e-2, 1e-3, 0.0254 / 16, 5e-4, 1e-4])
@pytest.mark.parametrize("line_of", [turning, still, vertical])
def test_rounding_to_a_grid_marks_out_no_plane(line_of, spacing, noise):
    shapes = line_of()
    shapes = shapes + noise * np.random.default_rng(2).standard_normal(shapes.shape)
    fits = fits_of(np.rint(shapes / spacing) * spacing)
    assert not fits.fitted.any(), fits.reasons()


def test_any_grid_is_found():
    """Sixteenths of an inch and others, of an axis that begins anywhere; none where nothing was rounded."""
    sixteenth, random = 0.0254 / 16, np.random.default_rng(12)
    for spacing in (sixteenth, 1e-3, 5e-4, 2.5e-7):
        x = spacing * random.integers(-2000, 2000, (50, 4, 3)) + [0.3, 1e-7, 12.0]
        assert grid(marker_frames(T_NS[:50], x)) == pytest.approx(spacing, rel=1e-9)
    assert grid(marker_frames(T_NS[:50], random.standard_normal((50, 4, 3)))) == 0.0
    records = np.rint(random.standard_normal((100, 1, 1, 3)) * PLACES[:4, None] / sixteenth) * sixteenth
    assert not any(fits_of(np.repeat(one, 100, axis=0)).fitted.any() for one in records)


def test_single_precision_marks_out_no_plane():
    assert not fits_of(turning().astype(np.float32)).fitted.any()


@pytest.mark.parametrize(("frames", "markers"), [(1, 12), (1, 7), (1, 4), (5, 7)])
def test_short_records_give_a_number_once_in_a_hundred(frames, markers):
    """400 records of straight lines: 4 +- 2 by the rule's chance of 0.01, were its bounds exact; 10 is three more."""
    random = np.random.default_rng(3)
    shapes = PLACES[:markers, None] * np.array([0.8, 0.5, 0.3]) + np.zeros((400, frames, 1, 1))
    shapes = shapes + 1e-3 * random.standard_normal((*shapes.shape[:3], 3))
    assert sum(fits_of(one).fitted.any() for one in shapes) <= 10


@pytest.mark.parametrize("tilt_deg", [0.0, 0.02])
def test_a_level_plane_gives_no_number(line, tilt_deg):
    """An arc 0.3 m deep; noise of 0.4 mm tilts its plane by 0.025 deg, so that 0.02 deg are no tilt."""
    shape = line(1.0, alpha=np.radians(90.0 - tilt_deg), psi=0.3)
    noise = 4e-4 * np.random.default_rng(4).standard_normal((FRAMES, 12, 3))
    fits = fits_of(shape + noise)
    assert fits.reasons() == {REASONS[Status.HORIZONTAL]: FRAMES}


def test_a_plane_that_is_not_level_is_known(line):
    """At 1 deg from the level, 40 sigma; tolerance: the mean of 2000 frames at 0.025 deg each, five times over."""
    shape = line(1.0, alpha=np.radians(89.0), psi=0.3)
    fits = fits_of(shape + 4e-4 * np.random.default_rng(5).standard_normal((FRAMES, 12, 3)))
    assert fits.fitted.all(), fits.reasons()
    assert np.degrees(fits.alpha.mean()) == pytest.approx(89.0, abs=5 * 0.025 / np.sqrt(FRAMES))


@pytest.mark.parametrize("aniso", [(1.0, 1.0, 1.0), (1.0, 1.0, 3.0)])
def test_what_stands_out_of_the_noise_is_fitted(line, aniso):
    """A sag of 20 mm in noise of 0.4 mm (1.2 mm upwards): no frame is given away."""
    shape = line(8 * 0.02 / 2.695**2, alpha=0.3, psi=0.4)
    fits = fits_of(shape + 4e-4 * np.array(aniso) * np.random.default_rng(6).standard_normal((FRAMES, 12, 3)))
    assert fits.fitted.all(), fits.reasons()


def test_a_wave_is_no_noise(line):
    """Waves of 50 mm on the line, running along it: far beyond any catenary, and to be judged so."""
    phase = np.linspace(0.0, 60.0, FRAMES)[:, None] + np.linspace(0.0, 7.0, 12)
    shapes = line(1.0) + 0.05 * np.sin(phase)[:, :, None] * np.array([0.0, 0.0, 1.0])
    fits = fits_of(shapes + 4e-4 * np.random.default_rng(7).standard_normal(shapes.shape))
    assert fits.fitted.all(), fits.reasons()
    # The largest of three variances from 2000 frames of 12 markers: a little more than the noise, not the waves.
    assert 3.95e-4 < fits.marker_sigma < 4.2e-4
    assert fails(fits, 0.01).all()


def test_noise_at_a_rate_that_does_not_resolve_the_motion(line):
    """A chain swinging at 1.1 Hz seen at 2 Hz, 20 mm of waves: in time all is jumps. What noise is given counts; else
    a note says that it is a bound, which fourth differences from marker to marker keep below the waves."""
    t = 0.5 * np.arange(FRAMES)
    phase = 2.0 * t[:, None] + np.linspace(0.0, 7.0, 12)
    shapes = np.stack([line(1.0, alpha=0.4 * np.sin(6.9 * one)) for one in t])
    shapes += 0.02 * np.sin(phase)[:, :, None] * np.array([0.0, 0.0, 1.0])
    frames = marker_frames(
        (1e9 * t).astype(int), shapes + 4e-4 * np.random.default_rng(13).standard_normal(shapes.shape)
    )
    found, given = fit_frames(frames), fit_frames(frames, marker_sigma=4e-4)
    assert found.fitted.all()
    assert 4e-4 < found.marker_sigma < 5e-3
    assert any("cannot be told from their motion at this rate" in note for note in found.notes)
    assert given.marker_sigma == 4e-4
    assert given.fitted.all()
    assert not any("--noise" in note for note in given.notes)


def test_statistics_need_half_of_the_frames(line):
    """Curved in a share of the frames and else straight: the figures are those of the curved ones, or none."""
    random = np.random.default_rng(8)
    noise = 4e-4 * random.standard_normal((FRAMES, 12, 3))
    for curved, has in ((0.02, False), (0.45, False), (0.55, True)):
        shows = (np.arange(FRAMES) < curved * FRAMES)[:, None, None]
        fits = fits_of(np.where(shows, line(1.0), still()) + noise)
        table = statistics(fits)
        assert (table.alpha_deg is not None) == has
        assert (table.missing == "") == has
        assert table.frames_used == round(curved * FRAMES)
        assert table.frames_enough == FRAMES


def test_the_catenary_fails_only_beyond_the_noise(line):
    """A true catenary in noise of 5 mm, tolerance 4 mm, below its floor: it does not fail; bent by 40 mm it does."""
    noise = 5e-3 * np.random.default_rng(9).standard_normal((FRAMES, 12, 3))
    fits = fits_of(line(1.0) + noise, marker_sigma=5e-3)
    assert (fits.e_catenary > 4e-3).mean() > 0.8
    assert fails(fits, 4e-3).sum() == 0
    bent = line(1.0) + 0.04 * np.sin(np.linspace(0.0, 9.0, 12))[:, None] * np.array([0.0, 0.0, 1.0])
    fits = fits_of(bent + noise, marker_sigma=5e-3)
    floor = 5e-3 * fits.noise_gain
    assert (fails(fits, 4e-3) == (fits.e_catenary > 4e-3 + FLOORS * floor)).all()
    assert fails(fits, 4e-3).mean() > 0.99


def test_c_is_not_identifiable_beyond_its_deviation(line):
    """An S, whose best catenary has C near zero: plane and distances are known, C and the lowest point are not."""
    shape = PLACES[:, None] * np.array([0.9, 0.0, 0.3]) + np.zeros((FRAMES, 1, 1))
    shape = shape + 0.05 * np.sin(2.0 * np.pi * PLACES / PLACES[-1])[:, None] * np.array([0.0, 0.0, 1.0])
    fits = fits_of(shape + 4e-4 * np.random.default_rng(10).standard_normal(shape.shape))
    assert fits.fitted.all()
    known = np.isfinite(fits.C)
    assert (known == (fits.sigma_C <= np.abs(fits.C))).all() or np.isnan(fits.C[~known]).all()
    assert (~known).sum() > 0
    assert np.isnan(fits.x0[~known]).all()
    assert np.isnan(fits.z0[~known]).all()
    assert np.isfinite(fits.e_catenary).all()
    assert any(f"C is not identifiable in {(~known).sum()} of the fitted frames" in note for note in fits.notes)


def test_bias_by_noise_and_by_drop_out(line):
    """Against the same frames without noise, and with all markers. Tolerance: 5 deviations of the means compared."""
    random = np.random.default_rng(11)
    clean = np.stack([line(0.8 + 0.3 * np.sin(0.01 * i), alpha=0.3 * np.sin(0.02 * i)) for i in range(FRAMES)])
    phase = 0.05 * np.arange(FRAMES)[:, None] + np.linspace(0.0, 7.0, 12)
    clean += 2e-3 * np.sin(phase)[:, :, None] * np.array([0.0, 1.0, 1.0])
    noisy = clean + 4e-4 * random.standard_normal(clean.shape)
    truth, fits = fits_of(clean, marker_sigma=4e-4), fits_of(noisy, marker_sigma=4e-4)
    shifts = by_noise(fits, reliable(fits))
    for name, shift in (("e_plane", shifts.e_plane_mm), ("e_catenary", shifts.e_catenary_mm)):
        difference = 1e3 * (getattr(fits, name) - getattr(truth, name))
        # The correction leaves a part of the order of (floor / e)^3: a tenth of the shift.
        assert shift == pytest.approx(difference.mean(), abs=5 * difference.std() / np.sqrt(FRAMES) + 0.1 * shift)
    frames = marker_frames(T_NS, noisy, random.random((FRAMES, 12)) > 0.09)
    lossy = fit_frames(frames, marker_sigma=4e-4)
    dropped = by_drop_out(frames, lossy, 7)
    assert dropped is not None
    whole = reliable(lossy)
    for name, shift in (("e_plane", dropped.e_plane_mm), ("e_catenary", dropped.e_catenary_mm)):
        difference = 1e3 * (getattr(lossy, name) - getattr(fits, name))[whole]
        assert shift < 0.0
        assert shift == pytest.approx(difference.mean(), abs=5 * difference.std() / np.sqrt(300))
    assert by_drop_out(replace(frames, valid=np.ones_like(frames.valid)), fits, 7) is None
