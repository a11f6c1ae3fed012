"""The fast fit against the published one, its speed, and the statistics of Tables II and III.

Authority: the two Nelder-Mead searches of Drupt et al. 2022, III.A, on lines bent by waves along them and out of
their plane; NumPy for the statistics.
"""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from pipeline.analysis.indicators import fit_frames
from pipeline.analysis.markers import marker_frames
from pipeline.analysis.statistics import failing_spans, statistics

FRAMES = 72


def moving_line(line, frames=FRAMES, drop_out=0.1):
    """Noisy lines of the chain's markers, waves of up to 0.1 m on them, some markers unseen."""
    random = np.random.default_rng(5)
    place = np.linspace(0.0, 1.0, 12)
    shapes = np.stack(
        [
            line(
                10.0 ** random.uniform(-0.5, 0.5),
                2.695,
                random.uniform(0.0, 1.0),
                12,
                random.uniform(0.0, 1.2),
                random.uniform(-3, 3),
            )
            for _ in range(frames)
        ]
    )
    wave = np.sin(place[None] * random.uniform(3.0, 12.0, (frames, 1)) + random.uniform(0.0, 6.0, (frames, 1)))
    shapes += random.uniform(0.0, 0.1, (frames, 1, 1)) * wave[:, :, None] * random.standard_normal((frames, 1, 3))
    shapes += 5e-4 * random.standard_normal(shapes.shape)
    seen = random.random((frames, 12)) >= drop_out
    # No arcs: the waves stretch the lines.
    return marker_frames(20_000_000 * np.arange(frames), shapes, seen)


def test_never_worse_than_the_published_search(line):
    """The issue allows 0.1 % more residual in one frame of 1000. Planes agree to the search's tolerance of 1e-9."""
    frames = moving_line(line)
    fast, published = fit_frames(frames, marker_sigma=5e-4), fit_frames(frames, "nelder-mead", marker_sigma=5e-4)
    both = fast.fitted & published.fitted
    assert both.sum() > 57
    assert (fast.e_catenary[both] < 1.001 * published.e_catenary[both]).all()
    assert np.abs(fast.e_plane - published.e_plane)[both].max() < 1e-8
    assert np.abs(fast.alpha - published.alpha)[both].max() < 1e-6
    agree = both & (published.e_catenary < 1.001 * fast.e_catenary)
    assert agree.sum() > 54
    assert fast.C[agree] == pytest.approx(published.C[agree], rel=1e-2)


def test_speed(line):
    """At least 50,000 frames of 12 markers a second and core (processor time; the best of five, others run too)."""
    frames = moving_line(line, 200)
    many = marker_frames(np.arange(8000), np.tile(frames.position, (40, 1, 1)), np.tile(frames.valid, (40, 1)))
    fit_frames(frames)
    times = []
    for _ in range(5):
        began = process_time()
        fit_frames(many)
        times.append(process_time() - began)
    assert 8000 / min(times) > 50_000


def test_unknown_method(line):
    with pytest.raises(ValueError, match="'gauss' is not known; use one of fast, nelder-mead"):
        fit_frames(moving_line(line, 1), "gauss")


def test_statistics_over_frames_with_more_than_6_markers(line):
    fits = fit_frames(moving_line(line, 300, 0.4))
    use = fits.fitted & (fits.n > 6)
    assert 0 < use.sum() < fits.fitted.sum()
    table = statistics(fits)
    assert (table.frames, table.frames_used) == (300, use.sum())
    values = 1e3 * fits.e_catenary[use]
    found = table.e_catenary_mm
    assert (found.mean, found.min, found.max, found.median, found.std) == (
        pytest.approx(values.mean()),
        values.min(),
        values.max(),
        pytest.approx(np.median(values)),
        pytest.approx(values.std()),
    )
    assert table.alpha_deg.max == pytest.approx(np.degrees(fits.alpha[use].max()))
    assert table.e_plane_mm.median == pytest.approx(1e3 * np.median(fits.e_plane[use]))


def test_statistics_of_nothing(line):
    table = statistics(fit_frames(moving_line(line, 5, 1.0)))
    assert (table.alpha_deg, table.frames, table.frames_used) == (None, 5, 0)


def test_failing_spans(line):
    """Bent in frames 3-5 and 9-10; frame 4 is unseen and does not break the first span."""
    straight = line(1.0)
    bent = straight + 0.1 * np.sin(np.linspace(0.0, 9.0, 12))[:, None] * np.array([0.0, 0.0, 1.0])
    position = np.stack([bent if i in (3, 4, 5, 9, 10) else straight for i in range(12)])
    seen = np.ones((12, 12), bool)
    seen[4] = False
    fits = fit_frames(marker_frames(10 * np.arange(12), position, seen), marker_sigma=1e-3)
    spans = failing_spans(fits, 0.01)
    assert [(span.start_ns, span.end_ns, span.frames) for span in spans] == [(30, 50, 2), (90, 100, 2)]
    assert spans[0].worst == fits.e_catenary[3] > 0.03
    assert failing_spans(fits, 1.0) == []


def test_a_gap_in_the_record_ends_a_span(line):
    """Frames 0.01 s apart, all bent, with ten seconds missing in their midst: two spans, not one over the gap."""
    bent = line(1.0) + 0.1 * np.sin(np.linspace(0.0, 9.0, 12))[:, None] * np.array([0.0, 0.0, 1.0])
    t_ns = 10_000_000 * np.concatenate([np.arange(20), 1000 + np.arange(30)])
    fits = fit_frames(marker_frames(t_ns, np.stack([bent] * 50), np.ones((50, 12), bool)), marker_sigma=1e-3)
    assert [span.frames for span in failing_spans(fits, 0.01)] == [20, 30]
