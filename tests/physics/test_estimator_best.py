"""The chain filter against truth of its own model, in hard cases, and with few sensors of other kinds."""

import numpy as np
import pytest

from components.estimator.best.component import COMPONENT as BEST
from components.tether.linkage.component import COMPONENT as LINKAGE
from pipeline.estimation.consistency import autocorrelation, inside
from pipeline.estimation.own_truth import Twin, campaign
from pipeline.estimation.stepping import Stepper

H = 0.036
RISER = {
    "length": 1.0, "bars": 5, "mass_per_length": 0.338, "weight": 0.98, "flexural_rigidity": 1.3e-5,
    "drag_diameter": 0.0123, "fluid_density": 1000.0, "spacing": 0.2, "marker_noise": 2e-3, "end_force": (1.5, -0.9),
    "end_force_spread": 0.3, "end_force_time": 2.0, "moment_noise": 3e-3,
    "angles": tuple(np.linspace(-0.1, -0.6, 5)), "start_angle": 0.1, "start_rate": 0.3,
}  # fmt: skip


def given(**more):
    return BEST.parameters(**{**RISER, **more})


def twin(seed=0, missing=0.0, **more):
    return Twin(BEST, given(**more), H, seed, missing)


@pytest.fixture(scope="module")
def runs():
    return campaign(BEST, given(), H, 50, 80, missing=0.1)


def test_consistent(runs):
    """50 runs, a tenth of the markers missing: the average lies in its 95 % band at 95 % of times.

    80 independent times allow for 90 to 100 % (2 deviations); NEES is correlated over tens of steps: 85 to 100 %.
    """
    assert 0.9 <= inside(runs.nis, runs.freedom) <= 1.0
    assert 0.85 <= inside(runs.nees, runs.states) <= 1.0
    assert runs.nis.sum() / runs.freedom.sum() == pytest.approx(1.0, abs=0.03)  # 4 deviations of 43 000 squares
    assert runs.nees.mean() == pytest.approx(runs.states, rel=0.05)
    # The tension within what the filter says of it (its own spread being 0.3 N each way).
    assert np.sqrt(((runs.tension - runs.true_tension) ** 2).mean()) < 0.2


def test_innovations_are_white(runs):
    found, deviation = autocorrelation(runs.innovations, 5)
    assert np.abs(found).max() < 4.0 * deviation


@pytest.mark.parametrize(
    "more",
    [
        {"pivot": "moving"},
        {
            "markers": 1,
            "first": 0.55,
            "end_position_noise": 5e-3,
            "end_tension_noise": 0.05,
            "tilts": (0.1, 0.9),
            "gyros": (0.1, 0.5),
        },
        {"takes_covariance": True, "bars": 2, "angles": (-0.2, -0.5), "spacing": 0.25, "markers": 4, "first": 0.1},
        {"takes_covariance": True, "pivot": "moving", "marker_noise": 1e-4, "chain_noise": 2e-3},
    ],
    ids=("moving pivot", "few sensors of five kinds", "two bars", "markers beside the chain"),
)
def test_consistent_with_other_sensors(more):
    # Mean NEES over 30 runs: 3 deviations, the runs' own times taken as one.
    found = campaign(BEST, given(**more), H, 30, 25)
    N = found.states
    assert found.nis.sum() / found.freedom.sum() == pytest.approx(1.0, abs=0.12)
    assert found.nees.mean() == pytest.approx(N, abs=3.0 * np.sqrt(2.0 * N / 30))


def test_an_inertial_unit_on_each_bar_halves_the_error_of_the_rates():
    """12 runs with and without. Mean square over the told variance: 3 deviations, a run's times taken as one."""
    places, error, told = (0.1, 0.3, 0.5, 0.7, 0.9), {}, {}
    for name, more in {"without": {}, "with": {"gyros": places, "tilts": places, "gyro_noise": 0.02}}.items():
        squares = []
        for seed in range(12):
            one = twin(seed, **more)
            for _ in range(25):
                one.step()
                squares.append([one.filter["rate"] - one.truth[5:10], one.filter["deviation.rate"]])
        squares = np.array(squares)
        error[name] = np.sqrt((squares[:, 0] ** 2).mean())
        told[name] = ((squares[:, 0] / squares[:, 1]) ** 2).mean()
    assert error["with"] < 0.5 * error["without"]
    assert error["with"] < 0.02  # of one gyro alone
    assert list(told.values()) == pytest.approx([1.0, 1.0], abs=3.0 * np.sqrt(2.0 / 60))


def test_a_gyro_that_is_missing_wrong_or_not_finite(unit):
    # Behind 6 markers (24 numbers): rates, then whether they are there.
    riser = unit("estimator.best", np.zeros(28), h=H, **RISER, gyros=(0.1, 0.9))
    u = np.concatenate([np.zeros(24), [0.1, np.nan, 1.0, 1.0]])
    for told, used in (((0.1, np.nan, 1, 1), (1, 0)), ((0.1, 0.3, 1, 0), (1, 0)), ((0.1, 1e3, 1, 1), (1, -1))):
        u[24:] = told
        riser.step(u)
        assert riser["used"].tolist() == [0.0] * 6 + list(used)
        assert riser["freedom"] == 1
    assert riser["contradiction"] == 1
    with pytest.raises(ValueError, match="gyros are at"):
        given(gyros=(1.1,))


def test_slope_of_a_step_is_exact():
    # Central differences of the very step: 1e-8 by their rounding.
    filter_ = twin(pivot="moving").filter
    state = filter_.state + np.random.default_rng(1).normal(size=filter_.states) * 0.3
    _, phi, _ = filter_.moved(state)
    for j in range(filter_.states):
        apart = 1e-6 * np.eye(filter_.states)[j]
        column = (filter_.moved(state + apart)[0] - filter_.moved(state - apart)[0]) / 2e-6
        assert column == pytest.approx(phi[:, j], abs=1e-8)


def test_a_step_is_the_linkages(unit):
    """Two formulations: the explicit chain by the midpoint rule, the linkage by BDF2 in O(n), free to swing.

    Quadratic drag is by Gauss's two points here and exact there: 2e-3 rad after a swing of half a second.
    """
    angles, h = tuple(np.linspace(0.3, 1.0, 5)), 0.002
    force = np.array([0.4, 0.0, 0.2])
    pulled = {"angles": angles, "end_force": (0.4, 0.2), "end_force_spread": 1e-9, "flexural_rigidity": 0.0}
    filter_ = Stepper(BEST, given(**pulled), h)
    filter_.begin(np.zeros(24))
    state = filter_.state
    u = np.concatenate([np.zeros(9), force])
    chain = unit(
        "tether.linkage", u, h=h, length=1.0, segments=5, plane="vertical", weight=0.98, mass_per_length=0.338,
        drag_diameter=0.0123, fluid_density=1000.0, end_b="pulled", start="given", angles=angles,
    )  # fmt: skip
    # The linkage begins with the rates that drag alone allows: so does the other.
    x = chain.x.reshape(6, -1)
    t = np.column_stack([np.cos(angles), np.sin(angles)])
    turn = np.diff(x[:, 4:6], axis=0)
    state[5:10] = (t[:, 0] * turn[:, 1] - t[:, 1] * turn[:, 0]) / 0.2
    for _ in range(250):
        state = filter_.moved(state)[0]
        chain.step(u)
    assert chain["angle"] == pytest.approx(state[:5], abs=2e-3)
    assert np.abs(state[:5] - angles).max() > 0.2
    assert LINKAGE.name == "tether.linkage"


def test_tension_along_the_line_balances(unit):
    # At rest, where each bar lies along the force on its middle: end's force and the weight below, resolved along it.
    rest = np.arctan2(-1.1 + 0.98 * 0.2 * (np.arange(4, -1, -1) + 0.5), 1.0)
    given_here = {**RISER, "angles": tuple(rest), "end_force": (1.0, -1.1), "flexural_rigidity": 0.0}
    riser = unit("estimator.best", np.zeros(24), h=H, **given_here)
    f = np.column_stack([np.full(6, 1.0), -1.1 + 0.98 * 0.2 * (5 - np.arange(6))])
    t = np.column_stack([np.cos(rest), np.sin(rest)])
    assert riser["tension"] == pytest.approx(0.5 * ((f[:-1] + f[1:]) * t).sum(axis=1), rel=1e-12)
    assert riser["end_tension"] == pytest.approx(np.hypot(1.0, 1.1))
    # Without a marker its deviation is that of the end's force.
    assert riser["deviation.end_tension"] == pytest.approx(0.3, rel=0.02)


def test_all_markers_lost():
    one = twin(2)
    for _ in range(60):
        one.step()
    sure = one.filter["deviation.angle"]
    one.missing = 1.0
    for _ in range(56):
        one.step()
    # It says how little it knows: within 4 of its deviations, which have grown.
    assert (one.filter["deviation.angle"] > 2.0 * sure).all()
    assert (np.abs(one.filter["angle"] - one.angles) < 4.0 * one.filter["deviation.angle"]).all()
    assert one.filter["freedom"] == 0
    one.missing = 0.0
    for _ in range(15):
        one.step()
    assert one.filter["deviation.angle"] == pytest.approx(sure, rel=0.2)


def test_a_wrong_identity_is_refused_and_a_shifted_camera_is_not():
    one = twin(3)
    for _ in range(40):
        one.step()
    u = one.inputs()
    swapped = u.copy()
    swapped[6:9], swapped[9:12] = u[9:12], u[6:9]
    one.filter.step(swapped)
    assert one.filter["used"].tolist() == [1.0, 1.0, -1.0, -1.0, 1.0, 1.0]
    shifted = one.inputs()
    shifted[:18:3] += 0.1
    one.filter.step(shifted)
    assert (one.filter["used"] == 1.0).all()
    assert one.filter["nis"] > 1000.0


@pytest.mark.parametrize("pivot", ["fixed", "moving"])
@pytest.mark.parametrize("from_the_start", [True, False])
def test_markers_that_stay_where_the_line_does_not_reach_are_never_believed(pivot, from_the_start):
    # Two neighbours taken for each other, and one a kilometre off, for far longer than believed_after.
    one = Twin(BEST, given(pivot=pivot), H, 3)
    filter_ = Stepper(BEST, one.line, H)

    def wrong(u):
        u = u.copy()
        u[6:9], u[9:12] = u[9:12].copy(), u[6:9].copy()
        u[15] += 1000.0
        return u

    filter_.begin(wrong(one.filter.u) if from_the_start else one.filter.u)
    for _ in range(40):
        one.step()
        filter_.step(wrong(one.filter.u))
    # Of six that contradict each other three are left: nothing tells which are right.
    assert filter_["used"].tolist() == [-1.0] * 6
    one = Twin(BEST, given(pivot=pivot), H, 3)
    filter_.begin(one.filter.u)
    for _ in range(40):
        one.step()
        u = one.filter.u.copy()
        u[6:9], u[9:12] = one.filter.u[9:12], one.filter.u[6:9]
        filter_.step(u)
    assert filter_["used"].tolist() == [1.0, 1.0, -1.0, -1.0, 1.0, 1.0]
    assert (np.abs(filter_["angle"] - one.angles) < 4.0 * filter_["deviation.angle"]).all()


def test_a_shape_that_jumps_is_taken_up_anew():
    # Another line than the one that was followed: told by the NIS. The end's marker, which a
    # folded last bar contradicts, is refused for the 14 frames that it may be, then believed.
    one, other = twin(3), twin(4, angles=(1.4, 1.6, 1.8, 1.9, 2.0), end_force=(-0.5, 0.5))
    for _ in range(30):
        one.step()
        other.step()
    one.filter.step(other.inputs())
    assert one.filter["nis"] > 1000.0
    for _ in range(20):
        other.step()
        one.filter.step(other.filter.u)
    assert (one.filter["used"] == 1.0).all()
    assert np.abs(one.filter["angle"] - other.angles).max() < 0.1


def test_first_angles_wrong_by_30_degrees():
    # With a deviation that tells of it, and with one that does not: 0.03 rad, a seventeenth.
    for deviation, steps in ((0.5, 3), (0.03, 60)):
        one = twin(4, start_angle=0.05)
        wrong = given(angles=tuple(np.array(RISER["angles"]) + np.radians(30.0)), start_angle=deviation)
        filter_ = Stepper(BEST, wrong, H).begin(one.inputs())
        for _ in range(steps):
            one.step()
            filter_.step(one.filter.u)
        error = np.abs(filter_["angle"] - one.angles)
        assert error.max() < 0.05


def test_no_motion_and_a_tension_through_zero():
    # A line hanging straight down from its pivot whose end is held by a force that goes through zero.
    down = {"angles": (1.5, 1.5, 1.5, 1.5, 1.5), "end_force": (0.0, 0.0), "end_force_spread": 0.2}
    one = twin(5, **down, moment_noise=1e-6, end_force_time=0.5)
    error = []
    for _ in range(150):
        one.step()
        error.append((one.filter.state[10:12] - one.truth[10:12]) / np.sqrt((one.filter.root[10:12] ** 2).sum(axis=1)))
    assert np.sqrt(np.mean(np.square(error))) == pytest.approx(1.0, abs=0.35)
    # Nothing moves: at its equilibrium, the same frame again and again, the estimate stays there.
    rest = np.arctan2(-0.9 + 0.98 * 0.2 * (np.arange(4, -1, -1) + 0.5), 1.5)
    still = twin(5, angles=tuple(rest), flexural_rigidity=0.0, marker_noise=1e-9)
    still.truth[:10] = np.concatenate([rest, np.zeros(5)])
    same = still.inputs()
    filter_ = Stepper(BEST, given(angles=tuple(rest), flexural_rigidity=0.0), H).begin(same)
    for _ in range(200):
        filter_.step(same)
    assert np.abs(filter_["rate"]).max() < 1e-5
    assert filter_["angle"] == pytest.approx(rest, abs=1e-6)
    assert filter_["nis"] < 1e-6


@pytest.mark.parametrize("bars", [2, 40])
def test_few_and_many_bars(bars):
    # Markers 0.2 m apart on bars of 25 mm: what lies between them is known by the model only.
    # A white force per length gives moments that go with the square of a bar's length.
    angles, noise = tuple(np.linspace(-0.1, -0.6, bars)), 1e-3 * (5.0 / bars) ** 2
    one = Twin(BEST, given(bars=bars, angles=angles, moment_noise=noise, start_angle=0.02), H, 6)
    for _ in range(10 if bars == 40 else 100):
        one.step()
    error = np.abs(one.filter["nodes"][:, [0, 2]] - one.at(np.linspace(0.0, 1.0, bars + 1)))
    assert (error <= 5.0 * one.filter["deviation.nodes"] + 1e-12).all()
    assert one.filter["iterations"] < 5


def test_tiny_noise_and_many_steps():
    # A million steps are in the benchmark line_estimation; here 5000, with markers known to a tenth of a micrometre.
    one = twin(7, marker_noise=1e-7, moment_noise=1e-3)
    u = [one.inputs()]
    for _ in range(40):
        one.step()
        u.append(one.filter.u.copy())
    for k in range(5000):
        one.filter.step(u[k % len(u)])
    P = one.filter.root @ one.filter.root.T
    scale = np.sqrt(np.diag(P))
    assert (P == P.T).all()
    assert np.linalg.eigvalsh(P / np.outer(scale, scale))[0] > 0.0


def test_a_given_covariance_is_the_parameters(unit):
    one = twin(8)
    u = [one.inputs() for _ in range(3)]
    cov = np.tile(RISER["marker_noise"] ** 2 * np.eye(2).ravel(), 6)
    plain = unit("estimator.best", u[0], h=H, **RISER)
    told = unit("estimator.best", np.concatenate([u[0], cov]), h=H, **RISER, takes_covariance=True)
    # Three parts of the variance by the chain, one by the input.
    chain = {"takes_covariance": True, "chain_noise": np.sqrt(0.75) * RISER["marker_noise"]}
    both = unit("estimator.best", np.concatenate([u[0], 0.25 * cov]), h=H, **RISER, **chain)
    for values in u[1:]:
        plain.step(values)
        told.step(np.concatenate([values, cov]))
        both.step(np.concatenate([values, 0.25 * cov]))
    assert told["angle"] == pytest.approx(plain["angle"], rel=1e-14)
    assert both["angle"] == pytest.approx(plain["angle"], rel=1e-12)
    assert both["deviation.angle"] == pytest.approx(plain["deviation.angle"], rel=1e-12)
