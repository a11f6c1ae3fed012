"""The marker tracker against the curve it samples, the normal distribution, and the two-state Markov chain's theory."""

from math import exp

import numpy as np
import pytest
from scipy import stats

from components.compiled import functions
from components.markers.tracker.component import COMPONENT
from components.markers.tracker.model import Tracker

init, step = functions(COMPONENT)
CHAIN = {"length": 3.5, "segments": 50, "markers": 12, "spacing": 0.245}  # Drupt et al. 2022, Table I
ROPE = {"length": 2.0, "segments": 40, "markers": 9, "spacing": 0.2}
PERIOD = 0.02
SEED = 0x0123456789ABCDEF


def catenary(s, c):
    """Points (k, 3) of an upright catenary of parameter c [1/m] at arc lengths s from its lowest point, NED."""
    return np.stack([np.arcsinh(c * s) / c, np.full_like(s, 0.3), -np.sqrt(1.0 + (c * s) ** 2) / c], axis=-1)


def straight(tracker):
    """Nodes of a straight line north from the origin: exact for any interpolation."""
    nodes = np.zeros((tracker.segments + 1, 3))
    nodes[:, 0] = np.linspace(0.0, tracker.length, tracker.segments + 1)
    return nodes


def frames(tracker, nodes, count, seed=SEED, period=PERIOD, rest=None):
    """Positions (count, m, 3), flags (count, m) and states; y and w are NaN before every call, or `rest`."""
    p, sizes, h = COMPONENT.pack(tracker, seed), COMPONENT.sizes(tracker), round(period * 1e9)
    m = tracker.markers
    x, w, y = np.zeros(sizes.state), np.empty(sizes.workspace), np.empty(4 * m)
    seen, states = np.empty((count, 4 * m)), np.empty((count, len(x)))
    for k in range(count):
        y[:] = w[:] = np.nan if rest is None else rest
        assert (step if k else init)(k * h, h, p, nodes.ravel(), x, y, w) == 0
        seen[k], states[k] = y, x
    return seen[:, : 3 * m].reshape(count, m, 3), seen[:, 3 * m :], states


@pytest.mark.parametrize(("cable", "span"), [(CHAIN, 2.695), (ROPE, 1.6)])
def test_markers_span_what_the_paper_says_up_to_the_mobile_end(cable, span):
    """Drupt et al. 2022, Table I: 11 x 245 mm and 8 x 200 mm; tolerance: roundings of 3.5 m."""
    tracker = Tracker(**cable)
    north = frames(tracker, straight(tracker), 1)[0][0, :, 0]
    np.testing.assert_allclose(np.diff(north), cable["spacing"], atol=1e-14)
    assert north[-1] - north[0] == pytest.approx(span, abs=1e-14)
    assert north[-1] == pytest.approx(cable["length"], abs=1e-14)


def test_offset_moves_all_markers_from_the_end():
    tracker = Tracker(**CHAIN, offset=0.1)
    assert frames(tracker, straight(tracker), 1)[0][0, -1, 0] == pytest.approx(3.4, abs=1e-14)


def test_markers_lie_on_the_curve_between_the_nodes():
    """Against the catenary itself. Tolerance: h^4 |q''''|/24, |q''''| <= 4 C^3: 32 micrometres; a chord misses 1 mm."""
    c, tracker = 2.0, Tracker(**CHAIN, offset=0.013)
    s = np.linspace(-1.0, 2.5, tracker.segments + 1)
    position = frames(tracker, catenary(s, c), 1)[0][0]
    exact = catenary(2.5 - 0.013 - 0.245 * np.arange(11, -1, -1), c)
    h = tracker.length / tracker.segments
    assert np.linalg.norm(position - exact, axis=1).max() < 4 * c**3 * h**4 / 24


def test_noise_is_normal_white_and_isotropic():
    """Kolmogorov-Smirnov at 1e-3 (the numbers never change); correlations within four standard deviations of zero."""
    tracker = Tracker(**ROPE, noise=4e-4)
    nodes = straight(tracker)
    exact = frames(Tracker(**ROPE), nodes, 1)[0][0]
    z = (frames(tracker, nodes, 4000)[0] - exact) / 4e-4
    assert stats.kstest(z.ravel(), "norm").pvalue > 1e-3
    series = z.reshape(4000, -1)
    mutual = np.corrcoef(series.T)[np.triu_indices(series.shape[1], 1)]
    following = np.mean(series[1:] * series[:-1], axis=0)
    assert max(abs(mutual).max(), abs(following).max()) < 4.0 / np.sqrt(4000)


@pytest.mark.parametrize("period", [0.005, 0.02, 0.3])
def test_drop_outs_are_the_markov_chain_at_any_rate(period):
    """Share lost, and both transitions between frames, against Kolmogorov's equation; within four standard deviations.

    The transition probabilities from a state are binomial. The share's variance is that of a mean of correlated flags:
    s (1 - s) / n times (1 + r)/(1 - r), with the correlation r = exp(-h/a - h/b) of following frames.
    """
    visible, lost = 0.8, 0.3
    tracker = Tracker(**ROPE, visible_time=visible, lost_time=lost)
    gone = frames(tracker, straight(tracker), 6000, period=period)[1] == 0.0
    share, r = lost / (visible + lost), exp(-period / visible - period / lost)
    deviation = np.sqrt(share * (1 - share) / gone.size * (1 + r) / (1 - r))
    assert abs(gone.mean() - share) < 4 * deviation
    for before, expected in ((False, share * (1 - r)), (True, share + (1 - share) * r)):
        trials = gone[1:][gone[:-1] == before]
        assert abs(trials.mean() - expected) < 4 * np.sqrt(expected * (1 - expected) / trials.size)


def test_bursts_last_as_long_as_stated():
    """At a frame rate fast against both times, runs of lost frames last lost_time on the mean.

    Geometric runs of mean 1 / P(found again); within four standard deviations of the mean (its own size over root n).
    """
    lost, period = 0.2, 0.002
    tracker = Tracker(**ROPE, visible_time=0.4, lost_time=lost)
    gone = frames(tracker, straight(tracker), 30_000, period=period)[1] == 0.0
    lengths = []
    for flags in gone.T:
        edges = np.flatnonzero(np.diff(flags.astype(int)))
        runs = np.diff(edges)
        lengths += list(runs[0 if flags[edges[0] + 1] else 1 :: 2])
    mean = np.mean(lengths) * period
    again = (0.4 / 0.6) * (1 - exp(-period / 0.4 - period / lost))
    assert abs(mean - period / again) < 4 * mean / np.sqrt(len(lengths))
    assert mean == pytest.approx(lost, rel=0.1)


def test_first_frame_is_stationary():
    """Over seeds: the share lost in the first frame is the stationary one; four binomial standard deviations."""
    tracker = Tracker(**ROPE, visible_time=1.0, lost_time=0.5)
    nodes = straight(tracker)
    gone = np.array([frames(tracker, nodes, 1, seed=seed)[1][0] == 0.0 for seed in range(2000)])
    assert abs(gone.mean() - 1 / 3) < 4 * np.sqrt(2 / 9 / gone.size)


def test_lost_markers_are_zero_and_others_whole():
    tracker = Tracker(**CHAIN, noise=1e-3, visible_time=0.1, lost_time=0.1)
    position, valid, _ = frames(tracker, straight(tracker) + 5.0, 200)
    assert set(np.unique(valid)) == {0.0, 1.0}
    assert np.array_equal((position == 0.0).all(axis=2), valid == 0.0)
    assert (position[valid == 1.0] > 4.0).all()


def test_all_are_seen_without_drop_out():
    assert frames(Tracker(**CHAIN), straight(Tracker(**CHAIN)), 100)[1].all()


def test_same_bits_from_any_memory_and_only_from_the_same_seed():
    tracker = Tracker(**CHAIN, noise=1e-3, visible_time=0.1, lost_time=0.1)
    nodes = straight(tracker)
    first, again, other = (
        frames(tracker, nodes, 50, seed, rest=rest) for seed, rest in ((SEED, np.nan), (SEED, 7.0), (SEED + 1, np.nan))
    )
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, again, strict=True))
    assert not np.array_equal(first[1], other[1])


def test_goes_on_from_its_state_alone():
    """x is the whole state: frames 30 to 49 again from x after frame 29."""
    tracker = Tracker(**CHAIN, noise=1e-3, visible_time=0.1, lost_time=0.1)
    nodes, p, h = straight(tracker), COMPONENT.pack(tracker, SEED), round(PERIOD * 1e9)
    position, _, states = frames(tracker, nodes, 50)
    x, y, w = states[29].copy(), np.empty(48), np.empty(0)
    for k in range(30, 50):
        assert step(k * h, h, p, nodes.ravel(), x, y, w) == 0
        assert y[:36].tobytes() == position[k].tobytes()


def test_too_many_markers_are_refused():
    with pytest.raises(ValueError, match=r"the first of 16 markers would be 3\.675 m from end b of a line of 3\.5 m"):
        Tracker(**{**CHAIN, "markers": 16})
