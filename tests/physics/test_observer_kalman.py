"""The Kalman filter against truth of its own model, a plain filter in numpy, and the chi-square distribution."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import chi2

SHIP = {
    "surge_mass": 6.7644e6, "sway_mass": 1.1341e7, "sway_yaw_mass": -3.4016e7, "yaw_inertia": 4.4524e9,
    "surge_damping": 7.7071e4, "sway_damping": 2.5468e5, "sway_yaw_damping": -2.0342e6, "yaw_sway_damping": -6.7258e5,
    "yaw_damping": 3.8501e8,
}  # fmt: skip
NOISE, COMPASS, HEADING = 0.3, 0.002, 0.6
FILTER = {
    "heading_noise": COMPASS, "disturbance_force": 3e4, "disturbance_moment": 6e5, "slow_force": 1.5e5,
    "slow_moment": 3e6, "wave_motion": 0.3, "wave_turn": 0.006, "wave_period": 8.0,
}  # fmt: skip
H, EVERY = 0.1, 10  # step [s]; steps from one position to the next
TAU = np.array([4e4, -2e4, 3e5])
INVERSE = np.linalg.inv([[6.7644e6, 0, 0], [0, 1.1341e7, -3.4016e7], [0, -3.4016e7, 4.4524e9]])
D = np.array([[7.7071e4, 0, 0], [0, 2.5468e5, -2.0342e6], [0, -6.7258e5, 3.8501e8]])


def model(psi, h):
    """F (15, 15), Q (15, 15) and the load's effect (15, 3) about a heading [rad], by Van Loan 1978.

    States as the filter's: position and heading, velocity, slow load, for each axis the wave's integral and the wave.
    """
    turn = np.array([[cos(psi), -sin(psi), 0], [sin(psi), cos(psi), 0], [0, 0, 1]])
    a, q, b = np.zeros((15, 15)), np.zeros((15, 15)), np.zeros((15, 3))
    a[0:3, 3:6], a[3:6, 3:6], a[3:6, 6:9], a[6:9, 6:9] = turn, -INVERSE @ D, INVERSE @ turn.T, -np.eye(3) / 1000.0
    b[3:6] = INVERSE
    q[3:6, 3:6] = INVERSE @ np.diag([3e4, 3e4, 6e5]) ** 2 @ INVERSE.T
    q[6:9, 6:9] = np.diag([1.5e5, 1.5e5, 3e6]) ** 2 * 2.0 / 1000.0
    omega, zeta = 2.0 * pi / 8.0, 0.1
    for k, sigma in enumerate((0.3, 0.3, 0.006)):
        i = 9 + 2 * k
        a[i, i + 1], a[i + 1, i], a[i + 1, i + 1] = 1.0, -(omega**2), -2.0 * zeta * omega
        q[i + 1, i + 1] = 4.0 * zeta * omega * sigma**2
    loan = expm(h * np.block([[-a, q], [np.zeros((15, 15)), a.T]]))
    f = loan[15:, 15:].T
    response = expm(h * np.block([[a, b], [np.zeros((3, 18))]]))[:15, 15:]
    return f, f @ loan[:15, 15:], response


def measured(axis):
    row = np.zeros(15)
    row[axis] = row[9 + 2 * axis + 1] = 1.0
    return row


def start(unit, z):
    """A filter at its first measurement, 0 m apart from it; `z`: north, east, heading."""
    references = ({"kind": "gnss", "noise": NOISE},)
    return unit("observer.kalman", inputs(z, 0.0, 0.0), H, references=references, **SHIP, **FILTER)


def inputs(z, t, t_fix):
    return [z[0], z[1], 0.0, 1.0, t_fix, z[2], 1.0, t, *TAU]


class Truth:
    """A vessel that obeys the filter's model at any heading, drawn from the filter's first uncertainty."""

    def __init__(self, rng, spread):
        self.rng = rng
        self.x = rng.multivariate_normal(np.zeros(15), spread)
        self.x[2] += HEADING
        self.f, q, _ = model(HEADING, H)
        self.drive = np.linalg.cholesky(q + 1e-30 * np.eye(15))

    def rates(self, x):
        """Of position, velocity and slow load: M nu' + D nu = tau + R' b, without noise."""
        c, s = cos(x[2]), sin(x[2])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.concatenate([turn @ x[3:6], INVERSE @ (TAU + turn.T @ x[6:9] - D @ x[3:6]), -x[6:9] / 1000.0])

    def step(self):
        low, waves = self.x[:9], self.f[9:, 9:] @ self.x[9:]
        low = low + H * self.rates(low + 0.5 * H * self.rates(low))
        self.x = np.concatenate([low, waves]) + self.drive @ self.rng.standard_normal(15)

    def seen(self):
        z = np.array([measured(axis) @ self.x for axis in range(3)])
        return z + self.rng.standard_normal(3) * [NOISE, NOISE, COMPASS]


def covariance(filter_):
    return filter_.x[15 : 15 + 225].reshape(15, 15)


@pytest.fixture(scope="module")
def runs(unit):
    """Of 40 runs of 120 s: NIS of positions and headings, and NEES, each (runs, samples), after 30 s."""
    first = covariance(start(unit, np.array([0.0, 0.0, HEADING])))
    found = {"position": [], "heading": [], "nees": []}
    for seed in range(40):
        rng = np.random.default_rng(seed)
        truth = Truth(rng, first)
        observer = start(unit, np.array([0.0, 0.0, HEADING]))
        rows = {name: [] for name in found}
        z = truth.seen()
        for k in range(1, 1200):
            truth.step()
            fresh = truth.seen()
            z = fresh if k % EVERY == 0 else np.array([z[0], z[1], fresh[2]])
            t = k * H
            observer.step(inputs(z, t, k // EVERY * EVERY * H))
            if k < 300:
                continue
            rows["heading"].append(observer["nis.compass"].item())
            if k % EVERY == 0:
                rows["position"].append(observer["nis.references"][0])
                error = observer.x[:15] - truth.x
                rows["nees"].append(error @ np.linalg.solve(covariance(observer), error))
        for name, values in rows.items():
            found[name].append(values)
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize(("name", "freedom"), [("position", 2), ("heading", 1), ("nees", 15)])
def test_consistent(runs, name, freedom):
    """The average over the runs lies in its pointwise 95 % band at 95 % of times (Bar-Shalom et al. 2001, section 5.4).

    Neighbouring times are correlated, for NEES over tens of seconds: 88 to 100 % are allowed for.
    """
    values = runs[name]
    count = len(values)
    low, high = chi2.ppf([0.025, 0.975], freedom * count) / count
    mean = values.mean(axis=0)
    assert 0.88 <= ((low <= mean) & (mean <= high)).mean() <= 1.0
    assert mean.mean() == pytest.approx(freedom, rel=0.06)


def test_it_is_a_plain_kalman_filter(unit):
    """numpy's F P F' + Q, exact in the step, and the gain P H' S^-1; theirs are of second order in it."""
    rng = np.random.default_rng(3)
    observer = start(unit, np.array([0.0, 0.0, HEADING]))
    x, p = observer.x[:15].copy(), covariance(observer).copy()
    for k in range(1, 90):
        z = np.array([*rng.normal(0.0, NOISE, 2), HEADING + rng.normal(0.0, COMPASS)])
        f, q, b = model(x[2], H)
        x, p = f @ x + b @ TAU, f @ p @ f.T + q
        rows = [(2, COMPASS)] + ([(0, NOISE), (1, NOISE)] if k % EVERY == 0 else [])
        for axis, noise in rows:
            row = measured(axis)
            gain = p @ row / (row @ p @ row + noise**2)
            x, p = x + gain * (z[axis] - row @ x), p - np.outer(gain, row @ p)
        observer.step(inputs(z, k * H, k // EVERY * EVERY * H))
        deviation = np.sqrt(np.diag(p))
        spread = np.outer(deviation, deviation)
        assert (np.abs(observer.x[:15] - x) / deviation).max() < 0.02
        assert np.abs((covariance(observer) - p) / spread).max() < 0.02


def test_covariance_stays_definite(unit):
    """A million updates are too slow here; 20 000 with a noise of 0.1 mm: symmetric, eigenvalues positive."""
    references = ({"kind": "gnss", "noise": 1e-4},)
    rng = np.random.default_rng(1)
    observer = unit("observer.kalman", [0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0], H, references=references, **SHIP,
                    **{**FILTER, "heading_noise": 1e-6})  # fmt: skip
    for k in range(1, 20_000):
        z = rng.normal(0.0, [1e-4, 1e-4, 1e-6])
        observer.step([z[0], z[1], 0, 1, k * H, z[2], 1, k * H, 0, 0, 0])
    p = covariance(observer)
    scale = np.sqrt(np.diag(p))
    assert (p == p.T).all()
    assert np.linalg.eigvalsh(p / np.outer(scale, scale)).min() > 0.0


def test_dead_reckoning_is_the_model(unit):
    """Without references the estimate goes on as the linear model under the same load: expm over 60 s.

    The heading hardly changes, so that the model is linear to 1 %.
    """
    observer = start(unit, np.array([0.0, 0.0, HEADING]))
    rng = np.random.default_rng(5)
    for k in range(1, 1200):
        z = rng.normal([0.0, 0.0, HEADING], [NOISE, NOISE, COMPASS])
        observer.step(inputs(z, k * H, k // EVERY * EVERY * H))
    x = observer.x[:15].copy()
    spread = covariance(observer).copy()
    lost = [0, 0, 0, 0, 0, 0, 0, 0, *TAU]
    for _ in range(600):
        observer.step(lost)
    f, q, b = model(x[2], 60.0)
    expected = f @ x + b @ TAU
    assert observer["dead_reckoning"] == pytest.approx(60.0, abs=EVERY * H + 1e-9)
    assert observer["estimate.position"] == pytest.approx(expected[:2], abs=0.05)
    deviation = np.sqrt(np.diag(f @ spread @ f.T + q))[:2]
    assert observer["deviation.position"] == pytest.approx(deviation, rel=0.03)
    assert observer["status.references"] == 2.0
    assert observer["status.compass"] == 2.0
