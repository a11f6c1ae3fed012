"""The end's speed and acceleration at any rate, against a circle, whose are constant; durations, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from components.contract import Port, motion_ports
from pipeline.analysis.durations import durations
from pipeline.analysis.ends import Ends, ends_of_log, ends_of_markers
from pipeline.analysis.markers import marker_frames
from pipeline.analysis.origin import Origin

RADIUS, OMEGA = 0.5, 2.0  # m, rad/s: 1 m/s and 2 m/s^2
SPEED, ACCELERATION = RADIUS * OMEGA, RADIUS * OMEGA**2


def times(rate: float, jitter: float = 0.0) -> np.ndarray:
    """Ten seconds [ns], unevenly sampled by a part of the interval."""
    t = np.arange(0.0, 10.0, 1.0 / rate)
    return ((t + jitter / rate * np.random.default_rng(0).uniform(-1.0, 1.0, len(t))) * 1e9).astype(np.int64)


def circle(t_ns: np.ndarray) -> np.ndarray:
    angle = OMEGA * t_ns / 1e9
    return RADIUS * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)


def markers(t_ns: np.ndarray):
    """Five markers from the centre to the circle."""
    return marker_frames(t_ns, np.linspace(0.0, 1.0, 5)[:, None] * circle(t_ns)[:, None, :])


def assert_circle(ends: Ends, step: float) -> None:
    """Central differences over `step` to either side are small by (omega step)^2 / 6 and / 12."""
    angle = OMEGA * step
    for values, exact, error in ((ends.speed, SPEED, angle**2 / 6), (ends.acceleration, ACCELERATION, angle**2 / 12)):
        inside = values[np.isfinite(values)]
        assert len(inside) > 0.9 * len(ends.t) - 6
        assert inside == pytest.approx(exact, rel=1.01 * error + 1e-6)


@pytest.mark.parametrize(("rate", "step"), [(5.0, 0.2), (10.0, 0.1), (19.0, 1 / 19), (20.0, 0.05), (50.0, 0.06)])
def test_markers_at_any_rate(rate, step):
    ends = ends_of_markers(markers(times(rate)))
    assert_circle(ends, step)
    assert ends.distance == pytest.approx(RADIUS, abs=1e-12)
    assert f"over {step:.3g} s to either side" in ends.source


def test_markers_unevenly_in_time():
    """A parabola through three places: second order in the speed; in the acceleration unequal steps cost one."""
    ends = ends_of_markers(markers(times(50.0, 0.4)))
    assert ends.speed[np.isfinite(ends.speed)] == pytest.approx(SPEED, rel=0.01)
    assert ends.acceleration[np.isfinite(ends.acceleration)] == pytest.approx(ACCELERATION, rel=0.03)


def test_nothing_is_told_across_a_long_drop_out():
    t_ns = times(50.0)
    frames = markers(t_ns)
    frames.valid[100:200, -1] = False
    ends = ends_of_markers(frames)
    assert_circle(ends, 0.06)
    assert np.isnan(ends.acceleration[[98, 99, 100, 101]]).all()  # the three at either edge have nothing near
    assert not np.isin(t_ns[100:200] / 1e9, ends.t).any()


@pytest.mark.parametrize("count", [0, 1, 2])
def test_too_few_frames_tell_nothing(count):
    ends = ends_of_markers(markers(times(10.0)[:count]))
    assert np.isnan(ends.acceleration).all()
    assert len(ends.t) == count


class Recorded:
    """What ends_of_log reads of a log: channels, times, ports."""

    def __init__(self, **channels: tuple[np.ndarray, dict[str, np.ndarray]]):
        self._channels = channels
        self.channels = {
            name: SimpleNamespace(ports=[Port(port, "m", values.shape[1:]) for port, values in ports.items()])
            for name, (_, ports) in channels.items()
        }

    def times(self, name: str) -> np.ndarray:
        return self._channels[name][0]

    def port(self, name: str, port: str) -> np.ndarray:
        return self._channels[name][1][port]


@pytest.mark.parametrize(
    ("kept", "step", "said"),
    [(3, 0.0, "hand, as recorded;"), (2, 0.1, "its differences"), (1, 0.1, "positions of hand"), (0, 0.02, "tether")],
)
def test_log_gives_what_it_recorded(kept, step, said):
    """The end at 10 Hz beside the line at 50 Hz: as recorded where it was, else by differences of what there is."""
    t_ns, line_ns = times(10.0), times(50.0)
    place, turned = circle(t_ns), circle(t_ns + round(0.5 * np.pi / OMEGA * 1e9))
    motion = dict(
        zip((p.name for p in motion_ports("motion")), (place, OMEGA * turned, -(OMEGA**2) * place), strict=True)
    )
    ports = {name: motion[name] for name in list(motion)[:kept]}
    nodes = np.linspace(0.0, 1.0, 5)[:, None] * circle(line_ns)[:, None, :]
    log = Recorded(hand=(t_ns, ports), tether=(line_ns, {"nodes": nodes}))
    where = Origin(line="tether", motion=("hand", "motion"))
    ends = ends_of_log(log, where, markers(line_ns))  # pyright: ignore[reportArgumentType]
    inside = slice(2, -2)
    # np.gradient of the velocity: (omega step)^2 / 6; of places, as above.
    assert ends.speed[inside] == pytest.approx(SPEED, rel=1.01 * (OMEGA * step) ** 2 / 6 + 1e-7)
    assert ends.acceleration[inside] == pytest.approx(ACCELERATION, rel=1.01 * (OMEGA * step) ** 2 / 6 + 1e-6)
    assert ends.distance == pytest.approx(RADIUS, abs=1e-12)
    assert len(ends.t_distance) == len(line_ns)
    assert said in ends.source


def fits(t_s: list[float], e_catenary: list[float], n: list[int], marker_sigma: float = 0.0) -> SimpleNamespace:
    values = np.array(e_catenary)
    return SimpleNamespace(
        t_ns=(np.array(t_s) * 1e9).astype(np.int64),
        e_catenary=values,
        n=np.array(n),
        fitted=np.isfinite(values),
        marker_sigma=marker_sigma,
        noise_gain=np.ones(len(values)),
    )


def test_durations_of_uneven_frames():
    """Frames at 0, 1, 2, 4 s stand for 0.5, 1, 1.5 and 1 s: holding, failing, unknown (5 markers), failing."""
    found = durations(fits([0, 1, 2, 4], [0.1, 3.0, 3.0, 3.0], [8, 8, 5, 8]), 1.0)  # type: ignore
    assert (found.holding, found.failing, found.unknown) == pytest.approx((0.5, 2.0, 1.5), abs=1e-9)


def test_what_noise_may_explain_neither_holds_nor_fails():
    """Tolerance 1, noise 0.5: within 1 it holds, above 1 + FLOORS 0.5 = 2 it fails, between them it is not known."""
    found = durations(fits([0, 1, 2, 3], [0.9, 1.5, 1.5, 2.1], [8] * 4, 0.5), 1.0)  # type: ignore
    assert (found.holding, found.failing, found.unknown) == pytest.approx((0.5, 0.5, 2.0), abs=1e-9)


def test_a_gap_is_not_known():
    """Of 20 s without a frame, half a usual second belongs to either side."""
    found = durations(fits([0, 1, 2, 3, 23, 24], [3.0] * 6, [8] * 6), 1.0)  # type: ignore
    assert (found.holding, found.failing, found.unknown) == pytest.approx((0.0, 5.0, 19.0), abs=1e-9)


def test_a_single_frame_lasts_no_time():
    assert durations(fits([0], [3.0], [8]), 1.0).record == 0.0  # type: ignore
