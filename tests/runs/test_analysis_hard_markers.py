"""Markers as they come: unseen, not finite, exchanged, far off, repeated and unsorted in time.

Authority: the same record before it was spoilt.
"""

from __future__ import annotations

import numpy as np
import pytest

from components.contract import Port
from pipeline.analysis.indicators import fit_frames
from pipeline.analysis.markers import from_log, marker_channels, marker_frames
from pipeline.errors import LogError
from pipeline.log.reader import open_log
from pipeline.log.recorder import ChannelSpec, Recorder, pack_rows

FRAMES = 20
T_NS = 20_000_000 * np.arange(FRAMES)
ARC = 0.245 * np.arange(12)


@pytest.fixture(scope="module")
def position(line):
    """A chain that swings: (20, 12, 3)."""
    return np.stack([line(0.8 + 0.05 * i, 2.695, 0.4, 12, 0.02 * i, 0.1 * i) for i in range(FRAMES)])


@pytest.fixture(params=[None, ARC], ids=["spacing unknown", "spacing known"])
def arc(request):
    return request.param


def test_a_marker_far_off_is_left_out_and_counted(position, arc):
    spoilt = position.copy()
    spoilt[3, 5] += [0.0, 3.0, 1.0]
    spoilt[8, 0] += [0.0, 1.0, 0.0]
    spoilt[8, 11] += [-400.0, 1.0, 0.0]
    fits = fit_frames(marker_frames(T_NS, spoilt, arc=arc))
    assert fits.left_out.tolist() == [1 if i == 3 else 2 if i == 8 else 0 for i in range(FRAMES)]
    assert np.flatnonzero(~fits.used[3]).tolist() == [5]
    assert np.flatnonzero(~fits.used[8]).tolist() == [0, 11]
    assert fits.visible[3] == 12
    assert fits.n[3] == 11
    # The others are a catenary without noise.
    assert fits.e_catenary.max() < 1e-12


def test_exchanged_markers_are_exchanged_back(position, arc):
    spoilt = position.copy()
    spoilt[4, [2, 9]] = spoilt[4, [9, 2]]
    spoilt[6, [5, 6]] = spoilt[6, [6, 5]]
    fits = fit_frames(marker_frames(T_NS, spoilt, arc=arc))
    assert fits.swapped.tolist() == [2 if i in (4, 6) else 0 for i in range(FRAMES)]
    assert (fits.n == 12).all()
    clean = fit_frames(marker_frames(T_NS, position, arc=arc))
    np.testing.assert_allclose(fits.C, clean.C, rtol=1e-12)


def test_too_few_frames_to_know_the_spacing_say_so(position):
    fits = fit_frames(marker_frames(T_NS[:3], position[:3]))
    assert fits.notes == ("markers far off were not looked for: fewer than 5 frames and no spacing given",)
    assert fit_frames(marker_frames(T_NS[:3], position[:3], arc=ARC)).notes == ()


def test_not_finite_is_not_seen(position):
    spoilt = position.copy()
    spoilt[2, 4, 1] = np.nan
    spoilt[2, 7] = np.inf
    frames = marker_frames(T_NS, spoilt, arc=ARC)
    assert frames.notes == ("2 positions were not finite: taken as not visible",)
    fits = fit_frames(frames)
    assert fits.n[2] == fits.visible[2] == 10
    assert fits.fitted.all()
    assert fits.e_catenary.max() < 1e-12


def test_unsorted_and_repeated_times(position):
    order = np.random.default_rng(0).permutation(FRAMES)
    twice = np.concatenate([order, order[:4]])
    frames = marker_frames(T_NS[twice], position[twice])
    assert (frames.t_ns == T_NS).all()
    assert (frames.position == position).all()
    assert [note.split(":")[1] for note in frames.notes] == [" frames sorted by time", " the first of each was kept"]
    assert frames.notes[1].startswith("4 frames")


def test_what_does_not_fit_together_is_refused(position):
    with pytest.raises(LogError, match=r"here: markers need positions of shape \(k, m, 3\)"):
        marker_frames(T_NS, position[0], source="here")
    with pytest.raises(LogError, match=r"visibility has shape \(20, 3\)"):
        marker_frames(T_NS, position, np.ones((FRAMES, 3)))
    for arc in (ARC[::-1], ARC[:5]):
        with pytest.raises(LogError, match="12 increasing lengths"):
            marker_frames(T_NS, position, arc=arc)


@pytest.mark.parametrize("method", ["fast", "nelder-mead"])
@pytest.mark.parametrize("shape", [(0, 12, 3), (3, 0, 3), (3, 1, 3), (6, 3, 3)])
def test_no_frames_or_hardly_a_marker(shape, method):
    fits = fit_frames(marker_frames(np.arange(shape[0]), np.zeros(shape), arc=np.arange(shape[1])), method)
    assert not fits.fitted.any()
    assert sum(fits.reasons().values()) == shape[0]


def test_the_input_is_not_changed(position):
    mine, seen = position.copy(), np.ones((FRAMES, 12), bool)
    seen[:, 3] = False
    fit_frames(marker_frames(T_NS, mine, seen))
    assert (mine == position).all()


def test_from_a_log(position, tmp_path):
    """A tracker's ports, a line's nodes, and a channel with neither."""
    seen = np.random.default_rng(1).random((FRAMES, 12)) > 0.2
    tracked = np.where(seen[:, :, None], position, 0.0)
    channels = {
        "tracker": ((Port("position", "m", (12, 3), "NED"), Port("valid", "1", (12,))), (tracked, seen)),
        "line": ((Port("nodes", "m", (12, 3), "NED"), Port("sag", "m")), (position, position[:, 0, :1])),
        "hand": ((Port("position", "m", (3,), "NED"),), (position[:, 0],)),
    }
    specs = [ChannelSpec(name, ports) for name, (ports, _) in channels.items()]
    with Recorder(tmp_path / "log.mcap", specs) as recorder:
        for i, (_, arrays) in enumerate(channels.values()):
            recorder.rows(i, pack_rows(T_NS, np.concatenate([a.reshape(FRAMES, -1) for a in arrays], axis=1)))
    with open_log(tmp_path / "log.mcap") as log:
        assert marker_channels(log) == ["tracker"]
        frames, nodes = from_log(log, "tracker", ARC), from_log(log, "line")
        with pytest.raises(LogError, match="channel hand has no markers: it needs the ports position"):
            from_log(log, "hand")
    assert (frames.t_ns == T_NS).all()
    assert (frames.position == tracked).all()
    assert (frames.valid == seen).all()
    assert (nodes.position == position).all()
    assert nodes.valid.all()


def test_a_largest_float_is_not_visible():
    """What tools write for a lost marker besides NaN; squared it would overflow."""
    position = np.zeros((2, 4, 3)) + np.arange(4.0)[:, None]
    position[0, 1], position[1, 2, 0] = np.finfo(np.float32).max, -np.finfo(np.float64).max
    frames = marker_frames(np.arange(2), position)
    assert (~frames.valid).nonzero()[0].tolist() == [0, 1]
    assert frames.notes == ("2 positions were not finite: taken as not visible",)
