"""The hand: smooth, band-limited, the same at any time however it is reached; against scipy's splines."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import BSpline

from components.compiled import functions
from components.motion.fixed.component import COMPONENT as FIXED
from components.motion.hand.component import COMPONENT, FIRST
from components.motion.hand.model import HALVED, Hand
from components.motion.hand.programme import meant

MOVES = {
    "rest": 1.0,
    "slow sweep north": 13.0,
    "fast sweep north-east-down": 8.0,
    "fast reversal east-down": 5.0,
    "slow circle north-east": 6.0,
    "fast eight east-down": 5.0,
    "fast sweep down": 4.0,
}
SECOND = 10**9
_, step = functions(COMPONENT)


def hand(**parameters):
    return Hand(**{"moves": tuple(MOVES), "durations": tuple(MOVES.values()), **parameters})


def motion(parameters, times_ns, seed=1):
    """Position, velocity, acceleration, each (len(times), 3); whatever is not written would be NaN."""
    p = COMPONENT.pack(parameters, seed)
    y = np.full((len(times_ns), 9), np.nan)
    for row, t_ns in zip(y, times_ns, strict=True):
        w = np.full(COMPONENT.sizes(parameters).workspace, np.nan)
        assert step(int(t_ns), 10**7, p, np.empty(0), np.empty(0), row, w) == 0
    return y[:, :3], y[:, 3:6], y[:, 6:]


def around_all_joins(parameters, until_ns):
    """Each knot of the spline, where its polynomials join, and an instant between each two."""
    knots = np.arange(1, until_ns // parameters.knot_ns) * parameters.knot_ns
    return np.concatenate([knots, knots + parameters.knot_ns // 3])


def assert_derivatives_belong(at, times_ns):
    """Fourth-order central differences at 2 ms: their error is d^4/30 times the fifth derivative of the path.

    Here it is below 1e4 m/s^5 (10 m/s^2 changing within h = 0.13 s, three times): 1e-8 for the velocity, 50 times that
    for the acceleration, whose fifth derivative is taken over a jump at each knot.
    """
    d = 2 * 10**6
    outer, inner = [], []
    for sign in (-1, 1):
        outer.append(at(times_ns + sign * 2 * d))
        inner.append(at(times_ns + sign * d))
    here = at(times_ns)
    for k, tolerance in ((0, 1e-8), (1, 1e-5)):
        slope = (8.0 * (inner[1][k] - inner[0][k]) - (outer[1][k] - outer[0][k])) / (12.0 * d * 1e-9)
        np.testing.assert_allclose(slope, here[k + 1], atol=tolerance)


def test_velocity_and_acceleration_are_the_derivatives_across_all_joins():
    parameters = hand(tremor=0.003)
    assert_derivatives_belong(lambda t: motion(parameters, t), around_all_joins(parameters, 43 * SECOND))


def test_starts_at_rest_in_the_centre():
    position, velocity, acceleration = motion(hand(centre=(1.0, -2.0, 3.0), tremor=0.01), [0])
    np.testing.assert_array_equal(position, [[1.0, -2.0, 3.0]])
    np.testing.assert_array_equal([velocity, acceleration], 0.0)


def test_against_scipy_spline_after_an_hour():
    # The same spline by scipy, from control points whose times are exact integers: nothing accumulates in an hour.
    # Tolerance: roundings of 0.5 m, and of 10 m/s^2.
    parameters = hand()
    p, h = COMPONENT.pack(parameters), parameters.knot_ns
    period = sum(round(d * SECOND) for d in parameters.durations)
    for start in (0, 3600 * SECOND):
        times = start + np.arange(1, 2 * SECOND, 12_345_678)
        first = start // h - 5
        numbers = [first + k for k in range(2 * SECOND // h + 8)]
        points = [meant(p, FIRST, len(MOVES), (j * h) % period) if j > 0 else (0.0, 0.0, 0.0) for j in numbers]
        # Control point j of the spline is centred three knots late, at (j + 3) h: its support begins at j h.
        spline = BSpline(np.arange(len(numbers) + 6), np.array(points), 5)
        at = [(int(t) - first * h) / h for t in times]
        position, velocity, acceleration = motion(parameters, times)
        np.testing.assert_allclose(position, spline(at), atol=1e-14)
        np.testing.assert_allclose(velocity, spline(at, 1) * 1e9 / h, atol=1e-12)
        np.testing.assert_allclose(acceleration, spline(at, 2) * (1e9 / h) ** 2, atol=1e-11)


def test_same_bits_after_an_hour_of_whole_periods():
    # Period and knots both divide an hour: 0.1 s knots, 40 s of moves, 3600 s.
    parameters = hand(bandwidth=HALVED / 0.1, durations=(1.0, 13.0, 8.0, 5.0, 6.0, 3.0, 4.0), fast=1.3, reach=0.4)
    assert (parameters.knot_ns, sum(parameters.durations)) == (10**8, 40.0)
    times = 41 * SECOND + np.arange(0, 40 * SECOND, 33_333_333)
    np.testing.assert_array_equal(motion(parameters, times), motion(parameters, times + 3600 * SECOND))


def test_same_bits_in_any_order_and_another_seed_differs():
    parameters = hand(tremor=0.003)
    times = np.arange(0, 50 * SECOND, 77_777_777)
    forward = motion(parameters, times)
    backward = motion(parameters, times[::-1])
    np.testing.assert_array_equal(forward, [part[::-1] for part in backward])
    assert np.abs(forward[0] - motion(parameters, times, seed=2)[0]).max() > 1e-3


def test_stays_within_reach_and_speed():
    # A B-spline lies in the convex hull of its control points, its velocity in that of theirs over a knot.
    parameters = hand()
    position, velocity, _ = motion(parameters, np.arange(0, 42 * SECOND, 10**7))
    assert 0.4 < np.linalg.norm(position, axis=1).max() <= 0.5
    assert 0.8 < np.linalg.norm(velocity, axis=1).max() <= 1.0 + 1e-12


@pytest.mark.parametrize(("move", "axes"), [("sweep", 1), ("reversal", 1), ("circle", 2), ("eight", 2)])
def test_moves_keep_to_their_axes_and_reach_both_speeds(move, axes):
    # With a wide band (50 Hz) the hand does what it means to: its highest speed is the one asked, to 1 %.
    for pace, speed in (("slow", 0.3), ("fast", 1.0)):
        name = f"{pace} {move} " + "-".join(("east", "down")[:axes])
        parameters = hand(moves=(name,), durations=(20.0,), reach=0.5, bandwidth=50.0)
        position, velocity, _ = motion(parameters, np.arange(0, 20 * SECOND, 10**7))
        moved = np.ptp(position, axis=0)
        assert moved[0] == 0.0
        assert moved[1] == pytest.approx(0.5 if move == "circle" else 1.0, rel=0.01)
        assert (moved[2] > 0.1) == (axes == 2)
        assert np.linalg.norm(velocity, axis=1).max() == pytest.approx(speed, rel=0.01)


def test_reversal_is_abrupt_but_within_the_band():
    # From +1 to -1 m/s: the spline's acceleration peaks at up to 2 v (2/3)/h where the corner falls on a control point.
    parameters = hand(moves=("fast reversal north",), durations=(8.0,))
    _, velocity, acceleration = motion(parameters, np.arange(0, 8 * SECOND, 10**6))
    bound = 2.0 * (2.0 / 3.0) / (parameters.knot_ns * 1e-9)
    assert 0.7 * bound < np.abs(acceleration[:, 0]).max() <= bound * (1.0 + 1e-12)
    assert np.ptp(velocity[:, 0]) == pytest.approx(2.0, rel=1e-9)


def test_spectrum_ends_at_the_band():
    # Twice the bandwidth passes with (sin(pi x)/(pi x))^6 = 0.05, x = 2 HALVED: less than 0.25 % of the energy that the
    # moves have there, which is itself a small share of the whole.
    parameters = hand(bandwidth=2.0)
    _, velocity, _ = motion(parameters, np.arange(0, 84 * SECOND, 2 * 10**7))
    power = (np.abs(np.fft.rfft(velocity * np.hanning(len(velocity))[:, None], axis=0)) ** 2).sum(axis=1)
    f = np.fft.rfftfreq(len(velocity), 0.02)
    assert power[f > 4.0].sum() < 2.5e-3 * power.sum()
    assert power[f > 8.0].sum() < 1e-4 * power.sum()


def test_tremor_has_its_rms_and_its_band():
    # 300 s hold 2300 independent control points and 3 axes: 1/sqrt(2 * 6900) = 1 % of statistical error, times 4.
    # White noise through the filter leaves the integral of (sin(pi x)/(pi x))^12 above x = 2 HALVED there.
    parameters = hand(moves=("rest",), durations=(1.0,), tremor=0.004)
    position, _, _ = motion(parameters, np.arange(SECOND, 301 * SECOND, 2 * 10**7))
    assert np.sqrt((position**2).mean()) == pytest.approx(0.004, rel=0.04)
    power = (np.abs(np.fft.rfft(position * np.hanning(len(position))[:, None], axis=0)) ** 2).sum(axis=1)
    above = quad(lambda x: np.sinc(x) ** 12, 2 * HALVED, 3.0)[0] / quad(lambda x: np.sinc(x) ** 12, 0.0, 3.0)[0]
    assert power[np.fft.rfftfreq(len(position), 0.02) > 4.0].sum() < 2.0 * above * power.sum()


# --- the table ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def rows():
    times = np.array([0.5, 0.9, 1.4, 1.5, 2.2, 3.0, 3.3, 4.1])
    return tuple((t, np.sin(t), 0.1 * t**2, np.cos(3.0 * t)) for t in times.tolist())


def test_table_passes_through_its_rows_smoothly(rows):
    parameters = Hand(table=rows, centre=(1.0, 2.0, 3.0))
    times = np.array([round(row[0] * SECOND) for row in rows])
    position, _, _ = motion(parameters, times)
    np.testing.assert_allclose(position - [1.0, 2.0, 3.0], np.array(rows)[:, 1:], atol=4e-15)  # roundings of 4 m
    inner = times[1:-1]  # at its ends the track is smooth to acceleration alone, too little for the differences
    joins = np.concatenate([inner, inner - 1, inner + 1, inner + 10**8])
    assert_derivatives_belong(lambda t: motion(parameters, t), joins)


def test_table_rests_before_and_after(rows):
    # At rest to acceleration at both ends; the last polynomial's own end is rounded through powers of its 0.8 s.
    position, velocity, acceleration = motion(Hand(table=rows), [0, 499_999_999, 4_100_000_001, 100 * SECOND])
    np.testing.assert_allclose(position, np.array(rows)[[0, 0, -1, -1], 1:], atol=1e-14)
    np.testing.assert_array_equal([velocity, acceleration], 0.0)
    _, velocity, acceleration = motion(Hand(table=rows), [500_000_000, 4_100_000_000])
    np.testing.assert_allclose([velocity, acceleration], 0.0, atol=1e-11)


def test_two_rows_are_one_stroke_of_least_jerk():
    # Flash and Hogan 1985: 10 s^3 - 15 s^4 + 6 s^5 is the only quintic at rest at both ends.
    s = np.linspace(0.0, 1.0, 11)
    position, _, _ = motion(Hand(table=((0.0, 0.0, 0.0, 0.0), (2.0, 1.0, 0.0, -3.0))), np.round(2e9 * s).astype(int))
    stroke = 10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5
    np.testing.assert_allclose(position, stroke[:, None] * [1.0, 0.0, -3.0], atol=1e-14)


# --- refusals ----------------------------------------------------------------------------------------------------

ROW = (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({}, "either moves with durations, or a table"),
        ({"moves": ("rest",), "durations": (1.0,), "table": (ROW, (1.0, 0.0, 0.0, 0.0))}, "either moves"),
        ({"moves": ("rest",)}, "1 moves, but 0 durations"),
        ({"moves": ("rest",), "durations": (0.0,)}, "durations.0 is 0 s"),
        ({"moves": ("rest", "jump"), "durations": (1.0, 1.0)}, "moves.1 'jump': expected 'rest' or"),
        ({"moves": ("quick sweep north",), "durations": (9.0,)}, "expected 'rest' or"),
        ({"moves": ("fast sweep up",), "durations": (9.0,)}, "its axes are 'up'"),
        ({"moves": ("fast sweep north-north",), "durations": (9.0,)}, "three different ones"),
        ({"moves": ("fast circle north",), "durations": (9.0,)}, "expected two different ones"),
        (
            {"moves": ("slow sweep north",), "durations": (12.0,)},
            "12 s are too short for it: once at 0.3 m/s takes 12.5 s",
        ),
        ({"table": (ROW,)}, "table has 1 rows"),
        ({"table": (ROW, (1.0, 0.0, 0.0))}, "table.1 has 3 numbers"),
        ({"table": (ROW, (0.0, 1.0, 0.0, 0.0))}, "table.1: time 0 s"),
        ({"table": ((-1.0, 0.0, 0.0, 0.0), ROW)}, "table.0: time -1 s"),
        ({"table": (ROW, (1.0, float("nan"), 0.0, 0.0))}, "finite"),
    ],
)
def test_wrong_programmes_and_tables_are_refused(parameters, text):
    with pytest.raises(ValueError, match=text):
        Hand(**parameters)


def test_fixed_point_does_not_move():
    p = FIXED.pack(FIXED.parameters(position=(1.0, -2.0, 3.0)))
    y = np.full(9, np.nan)
    assert functions(FIXED)[1](5, 5, p, np.empty(0), np.empty(0), y, np.empty(0)) == 0
    np.testing.assert_array_equal(y, [1.0, -2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
