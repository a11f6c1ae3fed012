"""The linear filters of a riser: filterpy, chi-square, and what Trigo et al. 2014 print."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from pydantic import ValidationError
from scipy.linalg import expm

from components.compiled import functions
from components.estimator import modal
from components.estimator.corrected.component import COMPONENT as CORRECTED
from components.estimator.published.component import COMPONENT as PUBLISHED
from components.tether.linkage.lagrangian import HEAD
from pipeline.estimation.consistency import autocorrelation, inside
from pipeline.estimation.own_truth import Twin, campaign
from pipeline.estimation.stepping import Stepper

H, L, NOISE = 0.036, 0.2, 1e-3
LINE = {
    "length": 1.0, "bars": 5, "mass_per_length": 0.338, "weight": 0.98, "flexural_rigidity": 0.05, "clamp": True,
    "gamma": 0.85, "normal_friction": 1.0, "spacing": L, "marker_noise": NOISE, "interval": H,
    "angles": (-0.02, -0.05, -0.08, -0.1, -0.13),
}  # fmt: skip
# Stiff enough that angles driven by random walks stay small, as the linear model has them.
FILTER = LINE | {"force_noise": 0.01, "start_angle": 0.05, "start_rate": 0.1, "start_force": 0.01}


def given(**more):
    return CORRECTED.parameters(**{**FILTER, **more})


def seen(nodes, valid=None):
    """Inputs of markers at (6, 2) north and down."""
    position = np.zeros((len(nodes), 3))
    position[:, [0, 2]] = nodes
    return np.concatenate([position.ravel(), np.ones(len(nodes)) if valid is None else valid])


def nodes_of(angles):
    t = L * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.vstack([np.zeros(2), np.cumsum(t, axis=0)])


@pytest.fixture(scope="module")
def runs():
    return campaign(CORRECTED, given(), H, 60, 100, missing=0.1)


def test_consistent(runs):
    """60 runs, a tenth of the markers missing: the average lies in its 95 % band at 95 % of times.

    100 independent times allow for 90 to 100 % (2 deviations); NEES is correlated over tens of steps: 85 to 100 %.
    """
    assert 0.9 <= inside(runs.nis, runs.freedom) <= 1.0
    assert 0.85 <= inside(runs.nees, runs.states) <= 1.0
    assert runs.nis.sum() / runs.freedom.sum() == pytest.approx(1.0, abs=0.03)  # 4 deviations of 24 000 squares
    assert runs.nees.mean() == pytest.approx(runs.states, rel=0.05)


def test_innovations_are_white(runs):
    found, deviation = autocorrelation(runs.innovations, 5)
    assert np.abs(found).max() < 4.0 * deviation


def test_it_is_filterpys_filter(unit):
    """filterpy's KalmanFilter with the same matrices, angles of chords and their covariance, to rounding."""
    p = given()
    m = modal.corrected(p, p.force_noise**2, H)
    truth = Twin(CORRECTED, p, H, 3)
    u = truth.inputs()
    own = unit("estimator.corrected", u, h=H, **FILTER)
    oracle = KalmanFilter(dim_x=15, dim_z=5)
    rows = np.zeros((5, 15))
    rows[:, :10:2] = modal.joints(5) @ m.modes
    oracle.F, oracle.H, oracle.Q = m.transition, rows, m.noise @ m.noise.T
    oracle.P = np.diag([0.05**2, 0.1**2] * 5 + [0.01**2] * 5)
    joints = np.diff(p.angles, prepend=0.0)
    oracle.x = np.zeros(15)
    oracle.x[:10:2], oracle.x[10:] = m.modes.T @ joints, m.modes.T @ (m.springs * joints)
    for k in range(40):
        if k:
            oracle.predict()
            truth.step()
            u = truth.filter.u.copy()
            own.step(u)
        chords = np.diff(u[:18].reshape(6, 3)[:, [0, 2]], axis=0)
        length = np.linalg.norm(chords, axis=1)
        normal = np.column_stack([-chords[:, 1], chords[:, 0]]) / length[:, None] ** 2
        shared = np.zeros((5, 12))
        for i in range(5):
            shared[i, 2 * i : 2 * i + 2], shared[i, 2 * i + 2 : 2 * i + 4] = -normal[i], normal[i]
        oracle.update(np.arctan2(chords[:, 1], chords[:, 0]), R=NOISE**2 * shared @ shared.T)
        root = own.x[15:240].reshape(15, 15)
        P = root @ root.T
        scale = np.sqrt(np.diag(oracle.P))
        assert np.abs((own.x[:15] - oracle.x) / scale).max() < 1e-7
        assert np.abs((P - oracle.P) / np.outer(scale, scale)).max() < 1e-7
        assert own["nis"] == pytest.approx(oracle.mahalanobis**2, rel=1e-6)


def test_model_is_the_slope_of_lagranges_equations():
    # The nonlinear chain's M at the straight line, in the joints' angles.
    p = given()
    A = p.chain()[HEAD : HEAD + 25].reshape(5, 5)
    T = modal.joints(5)
    assert modal.inertia(p) == pytest.approx(T.T @ A @ T)
    ratios = np.linalg.eigvals(np.linalg.solve(modal.printed_inertia(p), modal.inertia(p)))
    # PAPERS.md: 0.5 to 10.5.
    assert sorted(ratios.real)[0] == pytest.approx(0.52, abs=0.01)
    assert sorted(ratios.real)[-1] == pytest.approx(10.5, abs=0.05)
    # (13) as printed has 2 m l^2 less in its first element, with which M is indefinite.
    printed = modal.printed_inertia(p)
    printed[0, 0] -= 2.0 * p.mass_per_length * L**3
    assert np.linalg.eigvalsh(printed)[0] < 0.0 < np.linalg.eigvalsh(modal.printed_inertia(p))[0]


PRINTED = LINE | {"mass_per_length": 0.2190, "weight": 0.1001, "flexural_rigidity": 1.337e-6}
FIRST = np.array([-0.0183, 0.0276, 0.0085, 0.0262, 0.0633])  # of the joints, up: section 4


def test_noise_of_a_step_with_much_drag():
    """The integral of e^As Q e^A's by Gauss-Legendre, of a bar whose rate decays by e^-1000 in a step."""
    line = given(bars=1, length=L, markers=2, angles=(), flexural_rigidity=0.0, normal_friction=2e4)
    _, A = modal.rates(modal.inertia(line), modal.damping(line), np.zeros((1, 1)))
    assert -A[1, 1] * H > 1000.0
    model = modal.corrected(line, 1e-4, H)
    # Over what decays at once, and over the rest.
    expected = 0.0
    for a, b in ((0.0, 0.01 * H), (0.01 * H, H)):
        places, weights = np.polynomial.legendre.leggauss(40)
        for s, w in zip(a + 0.5 * (b - a) * (places + 1.0), 0.5 * (b - a) * weights, strict=True):
            column = expm(A * s)[:, 2:]
            expected = expected + w * 1e-4 * column @ column.T
    scale = np.sqrt(np.diag(expected))
    error = (model.noise @ model.noise.T - expected) / np.outer(scale, scale)
    assert np.abs(error).max() < 1e-6  # of the quadrature and rounding


def test_first_forces_are_those_printed(unit):
    """Section 4, with F = 0.5 N: F l s_i alone, the weight of (13)-(16) is not in them; given to 1e-4."""
    angles = -np.cumsum(FIRST)
    riser = unit(
        "estimator.published", seen(nodes_of(angles), np.zeros(6)), h=H, **{**PRINTED, "angles": tuple(angles)}
    )
    assert -riser.x[10:15] == pytest.approx([0.0376, 0.025, 0.0153, 0.0063, 0.0], abs=1e-4)
    assert riser["end_tension"] == pytest.approx(0.5, abs=1e-9)


def test_what_published_leaves_out_is_said_to_be_off_and_has_no_effect(unit):
    plain = {name: value for name, value in LINE.items() if name != "normal_friction"}
    u = seen(nodes_of(np.array([-0.03, -0.04, -0.07, -0.12, -0.1])))
    cov = np.tile([1e-4, 0.0, 0.0, 4e-4], 6)
    more = {"normal_friction": 50.0, "chain_noise": 0.01, "takes_covariance": True}
    without = unit("estimator.published", u, h=H, **plain)
    told = unit("estimator.published", np.concatenate([u, cov]), h=H, **plain, **more)
    for _ in range(5):
        without.step(u)
        told.step(np.concatenate([u, cov]))
    assert (told.x == without.x).all()
    terms = {term.name: term.on for term in PUBLISHED.terms(PUBLISHED.parameters(**plain, **more))}
    assert terms == {
        "springs": True,
        "spring at the pivot": True,
        "damping": False,
        "covariance from outside": False,
        "markers beside the chain": False,
    }


def test_first_angles_balance_at_another_tension():
    """The printed first shape, in (13)-(16) at rest, asks for 6 N with g in p_s, 0.6 N without; not for 23.9 N."""
    weights = modal.weights(given(flexural_rigidity=0.0, weight=0.1001 * 9.80665))[:4]
    levers = [L * sum((j - i) * FIRST[j] for j in range(i + 1, 5)) for i in range(4)]
    tension = weights / np.array(levers)
    assert tension == pytest.approx([6.3, 6.0, 5.5, 5.7], abs=0.06)


def test_covariance_as_printed_flies_off():
    """(30) without Phi about P: the closed loop is unstable, which the status says."""
    p = PUBLISHED.pack(PUBLISHED.parameters(**PRINTED, moves_covariance=False))
    u, x, y, w = (np.zeros(int(n)) for n in p[1:5])
    u[:] = seen(nodes_of(np.array(PRINTED["angles"])))
    init, step = functions(PUBLISHED)
    assert init(0, 36_000_000, p, u, x, y, w) == 0
    assert 2 in [step(36_000_000 * k, 36_000_000, p, u, x, y, w) for k in range(1, 100)]
    assert "(30)" in PUBLISHED.status_text[2]


def test_missing_markers_and_none_at_all(unit):
    rng = np.random.default_rng(0)
    angles = np.array(LINE["angles"])
    riser = unit("estimator.corrected", seen(nodes_of(angles)), h=H, **FILTER)
    for _ in range(30):
        riser.step(seen(nodes_of(angles) + NOISE * rng.standard_normal((6, 2))))
    one_off = np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])
    riser.step(seen(nodes_of(angles), one_off))
    assert riser["freedom"] == 4
    assert riser["used"].tolist() == one_off.tolist()
    before = riser["deviation.angle"]
    for _ in range(20):
        riser.step(np.zeros(24))
    assert riser["freedom"] == 0
    assert riser["nis"] == 0.0
    assert (riser["deviation.angle"] > 2.0 * before).all()


def test_a_wrong_identity_is_refused(unit):
    rng = np.random.default_rng(1)
    angles = np.array(LINE["angles"])
    riser = unit("estimator.corrected", seen(nodes_of(angles)), h=H, **FILTER)
    for _ in range(30):
        riser.step(seen(nodes_of(angles) + NOISE * rng.standard_normal((6, 2))))
    swapped = nodes_of(angles)[[0, 1, 3, 2, 4, 5]]
    riser.step(seen(swapped))
    assert riser["used"].tolist() == [1.0, 1.0, -1.0, -1.0, 1.0, 1.0]
    assert np.abs(riser["angle"] - angles).max() < 0.03
    # A camera that is turned by 20 degrees is in all of them: nothing is refused, the NIS says it.
    turned = nodes_of(angles) @ np.array([[np.cos(0.35), np.sin(0.35)], [-np.sin(0.35), np.cos(0.35)]])
    riser.step(seen(turned))
    assert (riser["used"] == 1.0).all()
    assert riser["nis"] > 100.0


def test_a_marker_refused_for_half_a_second_is_believed(unit):
    # After the 14 frames of believed_after: an estimate that is itself wrong does not refuse what is right for ever.
    angles = np.array(LINE["angles"])
    riser = unit("estimator.corrected", seen(nodes_of(angles)), h=H, **FILTER)
    for _ in range(30):
        riser.step(seen(nodes_of(angles)))
    moved = nodes_of(angles)
    moved[0] += 0.05
    used = [riser.step(seen(moved))["used"][0] for _ in range(15)]
    assert used == [-1.0] * 14 + [1.0]


def test_all_markers_lost_for_two_seconds():
    one = Twin(CORRECTED, given(), H, 2)
    for _ in range(60):
        one.step()
    sure = one.filter["deviation.angle"]
    one.missing = 1.0
    for _ in range(56):
        one.step()
        # It says how little it knows: within 4 of its deviations, which have grown.
        assert (np.abs(one.filter["angle"] - one.angles) < 4.0 * one.filter["deviation.angle"]).all()
    assert (one.filter["deviation.angle"] > 3.0 * sure).all()
    assert one.filter["freedom"] == 0
    one.missing = 0.0
    for _ in range(15):
        one.step()
    assert one.filter["deviation.angle"] == pytest.approx(sure, rel=0.2)
    assert one.filter["contradiction"] == one.filter["beginnings"] == 0


def test_no_motion(unit):
    # The same frame for a minute: nothing turns, and the angles are those seen, but for the springs' pull on them.
    angles = np.array(LINE["angles"])
    riser = unit("estimator.corrected", seen(nodes_of(angles)), h=H, **FILTER)
    for _ in range(1700):
        riser.step(seen(nodes_of(angles)))
    assert riser["angle"] == pytest.approx(angles, abs=1e-6)
    assert np.abs(riser["rate"]).max() < 1e-6
    assert riser["nis"] < 1e-6


def test_a_tension_through_zero_is_as_sure_as_it_says():
    """(13)-(17) with the true state. Where the levers vanish it says so, by a deviation of any size."""
    error = []
    for seed in range(3):
        one = Twin(CORRECTED, given(), H, seed)
        for _ in range(200):
            one.step()
            m, angles = one.filter.model, one.angles
            lever = L * np.array([(angles[-1] - angles[i:]).sum() for i in range(5)])
            true = (m.modes @ one.truth[10:] - m.weights) @ lever / (lever @ lever)
            error.append([true, one.filter["end_tension"] - true, one.filter["deviation.end_tension"]])
    true, error, deviation = np.array(error).T
    assert (np.diff(np.sign(true)) != 0.0).sum() > 10
    # 600 correlated times; where the levers nearly vanish a deviation to first order is too small: 5 % of them.
    assert (np.abs(error) < 2.0 * deviation).mean() > 0.9
    assert (np.abs(error) < 4.0 * deviation).mean() > 0.97


@pytest.mark.parametrize("bars", [1, 2, 15, 40])
def test_few_and_many_bars(bars):
    # The joints' first angles add up along the line. NEES and NIS of some thousand numbers, correlated over ten steps.
    first = 0.05 / np.sqrt(bars)
    line = given(
        bars=bars, markers=bars + 1, spacing=1.0 / bars, angles=tuple(np.linspace(-0.02, -0.13, bars)),
        start_angle=first, start_rate=2.0 * first,
    )  # fmt: skip
    nees, nis = [], []
    for seed in range(8 if bars < 10 else 1):
        one = Twin(CORRECTED, line, H, seed)
        for _ in range(25):
            one.step()
            error = np.linalg.solve(one.filter.root, one.filter.state - one.truth)
            nees.append(error @ error / one.filter.states)
            nis.append(one.filter["nis"] / one.filter["freedom"])
    assert np.mean(nees) == pytest.approx(1.0, abs=0.3)
    assert np.mean(nis) == pytest.approx(1.0, abs=0.25)
    assert one.filter["contradiction"] == 0


def test_a_micrometre_and_forty_thousand_steps():
    # A million are in the benchmark line_estimation.
    one = Twin(CORRECTED, given(marker_noise=1e-6), H, 7)
    u = [one.inputs()]
    for _ in range(40):
        one.step()
        u.append(one.filter.u.copy())
    f = one.filter
    for k in range(40_000):
        f.u[:] = u[k % len(u)]
        assert f._step(0, f.h_ns, f.p, f.u, f.x, f.y, f.w) == 0
    root = f.root
    P = root @ root.T
    scale = np.sqrt(np.diag(P))
    assert (P == P.T).all()
    assert np.linalg.eigvalsh(P / np.outer(scale, scale))[0] > 1e-4  # 1e-3 after a million
    assert np.isfinite(f.y).all()


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"spacing": 0.1}, "not at the ends of bars"),
        ({"markers": 7}, "along a line of 1 m"),
        ({"angles": (0.0, 0.1)}, "give one for each"),
    ],
    ids=str,
)
def test_refused(wrong, text):
    with pytest.raises(ValidationError, match=text):
        given(**wrong)


def test_another_period_is_refused():
    with pytest.raises(ValueError, match="make them equal"):
        Stepper(CORRECTED, given(), 0.04).begin(np.zeros(24))
