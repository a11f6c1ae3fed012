"""How far noise and drop-out move the indicators: by formula to first order, and by Monte Carlo.

Markers' noise adds to the squares of e_P and e_C, so both have a floor that no line comes below; alpha is an absolute
value, so the noise of a vertical plane's inclination does not average out; C is moved by the noise of x on a curve.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import erf, pi, sqrt

import numpy as np

from pipeline.analysis.indicators import Fits, fit_frames
from pipeline.analysis.markers import MarkerFrames


@dataclass(frozen=True)
class Expected:
    """Of k frames, first order. floor_plane, floor_catenary: (k,) e_P and e_C of a true catenary's noisy markers [m].

    e_plane, e_catenary: (k,) what was measured without the noise's part [m]; zero where noise explains all.
    alpha_bias: (k,) mean of the measured alpha minus alpha, were alpha the true inclination [rad].
    """

    floor_plane: np.ndarray
    floor_catenary: np.ndarray
    e_plane: np.ndarray
    e_catenary: np.ndarray
    alpha_bias: np.ndarray


def floors(fits: Fits, marker_sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """e_P and e_C (k,) that noise of marker_sigma [m] alone would give, as `expected` says [m]."""
    floor_plane = marker_sigma * np.sqrt((fits.n - 3) / np.where(fits.fitted, fits.n, np.nan))
    return floor_plane, marker_sigma * fits.noise_gain


def expected(fits: Fits, marker_sigma: float) -> Expected:
    """What noise of marker_sigma [m] in each coordinate does to the indicators.

    A plane takes 3 of n degrees of freedom: floor sigma sqrt((n - 3) / n). A curve takes 3, and noise along x counts
    by the slope: floor sigma sqrt(trace((1 - H) W) / n), see uncertainty. alpha: mean of the folded normal law.
    """
    floor_plane, floor_catenary = floors(fits, marker_sigma)
    return Expected(
        floor_plane,
        floor_catenary,
        _without(fits.e_plane, floor_plane),
        _without(fits.e_catenary, floor_catenary),
        folded_mean(fits.alpha, fits.sigma_alpha) - fits.alpha,
    )


def _without(measured: np.ndarray, floor: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(measured**2 - floor**2, 0.0))


def folded_mean(mean: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Mean of |x| for a normal x of this mean and deviation, arrays alike: sigma sqrt(2 / pi) about zero."""
    ratio = np.divide(mean, sigma, out=np.full_like(mean, np.inf), where=sigma > 0.0)
    within = np.array([erf(r / sqrt(2.0)) for r in np.ravel(ratio)]).reshape(np.shape(ratio))
    return sigma * np.sqrt(2.0 / pi) * np.exp(-0.5 * ratio**2) + mean * within


@dataclass(frozen=True)
class Difference:
    """Mean of measured minus true, and the standard deviation about it."""

    mean: float
    std: float


@dataclass(frozen=True)
class Bias:
    """Of the indicators over `frames` fits, with n markers used (0: any number). SI units and radians."""

    n: int
    frames: int
    alpha: Difference
    e_plane: Difference
    e_catenary: Difference
    C: Difference


def compare(truth: Fits, measured: Fits, choose: np.ndarray | None = None, n: int = 0) -> Bias:
    """Differences frame by frame, over those that both fitted. choose: (k,) bool, default all."""
    both = truth.fitted & measured.fitted & (True if choose is None else choose)
    found = {}
    for name in ("alpha", "e_plane", "e_catenary", "C"):
        difference = getattr(measured, name)[both] - getattr(truth, name)[both]
        difference = difference[np.isfinite(difference)]  # C of a fitted frame may be unknown
        found[name] = Difference(float(difference.mean()), float(difference.std())) if len(difference) else NOTHING
    return Bias(n, int(both.sum()), **found)


NOTHING = Difference(float("nan"), float("nan"))


def compare_by_markers(truth: Fits, measured: Fits) -> list[Bias]:
    """The bias by the number of markers used: what drop-out does."""
    return [compare(truth, measured, measured.n == n, int(n)) for n in np.unique(measured.n[measured.fitted])]


@dataclass(frozen=True)
class Shifts:
    """Mean of measured minus true over `frames` frames: alpha in degrees, e_P and e_C in mm."""

    frames: int
    alpha_deg: float
    e_plane_mm: float
    e_catenary_mm: float


WHOLE = 300  # frames taken for the bias by drop-out: its mean is then known to 6 % of how it varies from frame to frame


def by_noise(fits: Fits, choose: np.ndarray) -> Shifts:
    """What the markers' noise adds to the chosen fits (k,), to first order."""
    true = expected(fits, fits.marker_sigma)
    return Shifts(
        int(choose.sum()),
        float(np.degrees(true.alpha_bias[choose].mean())),
        1e3 * float((fits.e_plane - true.e_plane)[choose].mean()),
        1e3 * float((fits.e_catenary - true.e_catenary)[choose].mean()),
    )


def by_drop_out(frames: MarkerFrames, fits: Fits, least_markers: int, seed: int = 0) -> Shifts | None:
    """What hiding as large a share of the markers as the record lost does to frames that show all of them.

    Of frames with least_markers left. None where nothing was lost, or no frame shows all.
    """
    m = frames.markers
    whole = np.flatnonzero(fits.fitted & (fits.n == m))
    lost = 1.0 - frames.valid.mean() if frames.valid.size else 0.0
    if lost <= 0.0 or not len(whole):
        return None
    rows = whole[np.linspace(0, len(whole) - 1, min(WHOLE, len(whole))).astype(int)]
    chosen = replace(frames, t_ns=frames.t_ns[rows], position=frames.position[rows], valid=frames.valid[rows])
    seen = np.random.default_rng(seed).random((len(rows), m)) >= lost
    hidden = replace(chosen, position=np.where(seen[:, :, None], chosen.position, 0.0), valid=seen)
    truth, measured = (fit_frames(some, marker_sigma=fits.marker_sigma) for some in (chosen, hidden))
    bias = compare(truth, measured, measured.n >= least_markers)
    if not bias.frames:
        return None
    numbers = (np.degrees(bias.alpha.mean), 1e3 * bias.e_plane.mean, 1e3 * bias.e_catenary.mean)
    return Shifts(bias.frames, *map(float, numbers))


def simulate(truth: MarkerFrames, marker_sigma: float, drop_out: float, draws: int, seed: int) -> tuple[Fits, Fits]:
    """Fits of the true frames, and of the same with noise and drop-out; both (draws * k), to be compared.

    truth: markers without noise. marker_sigma: of each coordinate [m]. drop_out: each marker's chance to be unseen.
    """
    random = np.random.default_rng(seed)
    k, m = truth.valid.shape
    shape = (draws, k, m)
    noise = marker_sigma * random.standard_normal((*shape, 3))
    seen = truth.valid & (random.random(shape) >= drop_out)
    measured = replace(
        truth,
        t_ns=np.arange(draws * k),
        position=(truth.position + noise).reshape(-1, m, 3),
        valid=seen.reshape(-1, m),
    )
    return _repeat(fit_frames(truth), draws), fit_frames(measured, marker_sigma=marker_sigma)


def _repeat(fits: Fits, draws: int) -> Fits:
    """The same frames, draws times over."""
    names = [field.name for field in fields(fits) if field.name not in ("notes", "marker_sigma")]
    return replace(fits, **{name: np.concatenate([getattr(fits, name)] * draws) for name in names})
