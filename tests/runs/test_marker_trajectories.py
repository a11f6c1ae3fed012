"""Markers off their trajectory and exchanged labels, in a record that swings and loses markers.

Authority: the same record before it was spoilt. 0.4 mm of noise at 50 Hz, as the pool scenes.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer

from pipeline.analysis.continuity import check_continuity
from pipeline.analysis.foreign import from_mcap
from pipeline.analysis.line_order import in_line_order
from pipeline.analysis.markers import MarkerFrames, marker_frames
from pipeline.analysis.origin import Origin
from pipeline.analysis.reading import Reading
from pipeline.analysis.recording import Recording
from pipeline.analysis.validity import Tolerance, judge
from pipeline.errors import LogError

FRAMES, MARKERS = 400, 12
ARC = 0.245 * np.arange(MARKERS)
T_NS = 20_000_000 * np.arange(FRAMES)
T = T_NS / 1e9
SWAPS = {
    "a pair": [0, 1, 2, 6, 4, 5, 3, 7, 8, 9, 10, 11],
    "two pairs": [0, 2, 1, 3, 4, 5, 7, 6, 8, 9, 10, 11],
    "a cycle of three": [1, 2, 0, 3, 4, 5, 6, 7, 8, 9, 10, 11],
}


@pytest.fixture(scope="module")
def position(line) -> np.ndarray:
    """A chain that swings by 0.3 rad at 1 Hz, its end by 0.1 m at 2 Hz: (400, 12, 3)."""
    swing, end = 0.3 * np.sin(2 * np.pi * T), 0.1 * np.sin(4 * np.pi * T)
    frames = [line(0.9, ARC[-1], 0.3, MARKERS, a, 0.2 * a, (0.0, e, 0.0)) for a, e in zip(swing, end, strict=True)]
    return np.stack(frames) + 4e-4 * np.random.default_rng(0).standard_normal((FRAMES, MARKERS, 3))


@pytest.fixture(params=[None, ARC], ids=["spacing unknown", "spacing known"])
def arc(request) -> np.ndarray | None:
    return request.param


def used(frames: MarkerFrames) -> np.ndarray:
    """(k, m) bool, which positions of the record are used."""
    order = check_continuity(frames).order
    found = np.zeros((len(order), order.shape[1] + 1), bool)
    np.put_along_axis(found, order, True, axis=1)
    return found[:, :-1]


def test_nothing_is_lost_of_a_clean_record(position, arc):
    """Nor where markers are lost in bursts, nor at a fifth of the rate."""
    seen = np.ones((FRAMES, MARKERS), bool)
    rng = np.random.default_rng(1)
    for start, marker in zip(rng.integers(0, FRAMES, 60), rng.integers(0, MARKERS, 60), strict=True):
        seen[start : start + rng.integers(1, 30), marker] = False
    for step in (1, 5):
        frames = marker_frames(T_NS[::step], position[::step], seen[::step], arc)
        found = check_continuity(frames)
        assert found.left_out.sum() == found.swapped.sum() == 0
        assert found.note == ""
        assert (used(frames) == frames.valid).all()


@pytest.mark.parametrize("step", [3, 10, 25, 50, 100])
def test_no_motion_is_taken_for_a_jump_at_any_rate(line, arc, step):
    """100 s of a chain whose end goes 0.25 m to and fro at 0.9 Hz and snaps at 2.3 Hz, at 17 to 0.5 Hz."""
    t = 0.02 * np.arange(5000)
    end = 0.25 * np.sin(5.7 * t) + 0.05 * np.sign(np.sin(14.5 * t))
    still = line(0.9, ARC[-1], 0.3, MARKERS, 0.2, 0.0, (0.0, 0.0, 0.0))
    share = (ARC / ARC[-1])[None, :, None]
    moved = still + share * end[:, None, None] * np.array([0.3, 1.0, 0.5])
    noise = 4e-4 * np.random.default_rng(4).standard_normal(moved.shape)
    found = check_continuity(marker_frames((1e9 * t[::step]).astype(int), (moved + noise)[::step], arc=arc))
    assert found.left_out.sum() == found.swapped.sum() == 0


@pytest.mark.parametrize("offset", [0.1, 0.15])
@pytest.mark.parametrize("frames", [1, 4])
def test_moderate_outliers_are_found(position, arc, offset, frames):
    """For one frame or for four, in any direction: each one, and nothing else, while the chain swings with 11 m/s^2.

    Its second difference is then 4.4 mm, so that the limit is about 4 (4.4 + 4.4 + 6) mm = 60 mm, and 80 mm at the
    turning points.
    """
    spoilt, bad = position.copy(), np.zeros((FRAMES, MARKERS), bool)
    rng = np.random.default_rng(2)
    for start in range(10, FRAMES - 10, 20):
        marker, way = rng.integers(0, MARKERS), rng.standard_normal(3)
        bad[start : start + frames, marker] = True
        spoilt[start : start + frames, marker] += offset * way / np.linalg.norm(way)
    assert (used(marker_frames(T_NS, spoilt, arc=arc)) == ~bad).all()


@pytest.mark.parametrize("swap", SWAPS)
@pytest.mark.parametrize("which", [slice(4, None, 4), slice(100, 250)], ids=["every fourth frame", "3 s"])
def test_exchanged_labels_are_given_back(position, arc, swap, which):
    spoilt, labels = position.copy(), np.tile(np.arange(MARKERS), (FRAMES, 1))
    spoilt[which], labels[which] = spoilt[which][:, SWAPS[swap]], SWAPS[swap]
    found = check_continuity(marker_frames(T_NS, spoilt, arc=arc))
    assert (np.take_along_axis(labels, found.order, axis=1) == np.arange(MARKERS)).all()
    assert (found.swapped == (labels != np.arange(MARKERS)).sum(axis=1)).all()
    assert "given back their exchanged labels" in found.note


def test_outliers_and_exchanged_labels_do_not_lengthen_the_line(position):
    """A tracker's -9999 in most frames, two labels exchanged in a quarter of them: the tolerance is a share of the
    length, and must not grow with it. The clean record's length, whose median varies by a part of the noise."""
    spoilt = position.copy()
    spoilt[np.arange(0, FRAMES, 2), np.arange(0, FRAMES, 2) % MARKERS] = -9999.0
    spoilt[1::8, [3, 5]] = -9999.0
    spoilt[300:] = position[300:, SWAPS["a pair"]]
    path = Path("markers.csv")
    clean, found = (
        judge(Recording(path, "chain", marker_frames(T_NS, x), Origin()), "fast", Tolerance(0.01, True))
        for x in (position, spoilt)
    )
    assert found.length == pytest.approx(clean.length, abs=4e-4)


def test_known_arcs_stand_against_a_polluted_record(position):
    """A marker 0.4 m off in every frame, and one that is the origin in every frame: these are left out, no others."""
    spoilt = position.copy()
    spoilt[:, 5] += [0.0, 0.4, 0.0]
    spoilt[:, 10] = 0.0
    found = used(marker_frames(T_NS, spoilt, arc=ARC))
    assert (found == ~np.isin(np.arange(MARKERS), [5, 10])).all()


def json_mcap(path, messages) -> None:
    with open(path, "wb") as file:
        writer = Writer(file)
        writer.start(profile="other")
        channel = writer.register_channel("/m", "json", writer.register_schema("s", "jsonschema", b"{}"))
        for i, message in enumerate(messages):
            data = message if isinstance(message, bytes) else json.dumps(message).encode()
            writer.add_message(channel, 10_000_000 * i, data, 10_000_000 * i)
        writer.finish()


POINTS = [[0.1 * i, 0.0, 0.01 * i * i] for i in range(5)]
GOOD = {"points": POINTS}


@pytest.mark.parametrize(
    ("messages", "reading", "text"),
    [
        ([GOOD, {"status": "lost"}], Reading(), "channel /m: message at 0.01 s has no points; it has status"),
        ([GOOD, {"points": [1] * 5}], Reading(), "points[0] is '1', not a point x, y, z"),
        ([GOOD, {"points": [[1, 2]] * 5}], Reading(), "points[0] is '[1, 2]', not a point x, y, z"),
        ([GOOD, {"points": {"x": 1}}], Reading(), "points is "),
        ([GOOD, [1]], Reading(), "message at 0.01 s has no points; it has a list as a whole"),
        ([GOOD, b"{"], Reading(), "message at 0.01 s: not json s: Expecting property name"),
        ([GOOD, b"[" * 100_000], Reading(), "message at 0.01 s: not json s: "),
        ([{"cov": POINTS[:3], **GOOD}], Reading(), "has several lists of points: cov, points; choose one with --field"),
        ([GOOD], Reading(field="a.b"), "no channel has a list of points a.b; it has /m"),
        ([GOOD], Reading("/m", "a.b"), "holds no list of points a.b; it has points"),
        ([{"points": [{"x": True, "y": 1, "z": 2}] * 5}], Reading(), "x, y, z that are numbers; it has /m"),
        ([GOOD, {"points": [["a", 1, 2]] * 5}], Reading(), """points[0] is '["a", 1, 2]', not a point x, y, z"""),
        ([], Reading("/m"), "channel /m has no messages"),
    ],
)
def test_strange_messages_are_refused_by_name(tmp_path, messages, reading, text):
    json_mcap(tmp_path / "a.mcap", messages)
    with pytest.raises(LogError) as refusal:
        from_mcap(tmp_path / "a.mcap", reading)
    assert text in str(refusal.value)
    assert str(tmp_path) in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_tracker_that_begins_with_nothing(tmp_path):
    json_mcap(tmp_path / "a.mcap", [{"points": []}, {"points": []}, GOOD, {"points": []}, GOOD])
    frames = from_mcap(tmp_path / "a.mcap", Reading(up="-z"))["/m"]
    assert frames.valid.tolist() == [[seen] * 5 for seen in (False, False, True, False, True)]


def test_ids_tell_which_marker_a_point_is(tmp_path, position):
    """Points shuffled in every message, one of them not listed: as if they stood in order."""
    random = np.random.default_rng(5)
    orders = [random.permutation(MARKERS)[: MARKERS - i % 2] for i in range(50)]
    messages = [
        {"points": [{"id": int(j), **dict(zip("xyz", x[j].tolist(), strict=True))} for j in order]}
        for x, order in zip(position, orders, strict=False)
    ]
    json_mcap(tmp_path / "a.mcap", messages)
    frames = from_mcap(tmp_path / "a.mcap", Reading(up="-z"))["/m"]
    assert [np.flatnonzero(seen).tolist() for seen in frames.valid] == [sorted(order) for order in orders]
    assert (frames.position == np.where(frames.valid[:, :, None], position[:50], 0.0)).all()


@pytest.mark.parametrize("change", ["throughout", "each frame", "two", "none"])
def test_numbers_that_do_not_follow_the_line(position, change):
    random = np.random.default_rng(6)
    order = random.permutation(MARKERS)
    shuffled = {
        "throughout": position[:, order],
        "each frame": np.stack([x[random.permutation(MARKERS)] for x in position]),
        "two": position[:, [0, 1, 2, 4, 3, *range(5, MARKERS)]],
        "none": position,
    }
    seen = random.random((FRAMES, MARKERS)) > 0.05
    frames = marker_frames(T_NS, shuffled[change], seen, source="here")
    if change in ("two", "none"):
        notes = in_line_order(frames).notes
        assert ["as if some were exchanged" in note for note in notes] == ([True] if change == "two" else [])
        return
    with pytest.raises(LogError, match="here: the markers' numbers do not follow the line") as refusal:
        in_line_order(frames)
    assert ("changes from frame to frame" in str(refusal.value)) == (change == "each frame")


def test_the_field_asked_for_is_taken(tmp_path):
    json_mcap(tmp_path / "a.mcap", [{"cov": POINTS[:3], "rigid": GOOD}] * 3)
    frames = from_mcap(tmp_path / "a.mcap", Reading(field="rigid.points", up="-z"))["/m"]
    assert (frames.position == np.array(POINTS)).all()
