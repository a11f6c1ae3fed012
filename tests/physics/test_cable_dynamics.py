"""The moving cable, against pendulum, hanging chain, towed line, energy, and its own convergence."""

from math import pi

import numpy as np
import pytest
from scipy.special import ellipk, j0, jn_zeros

from components.compiled import functions
from components.tether.cable import block_tridiagonal, line
from components.tether.cable.component import COMPONENT

init, step = functions(COMPONENT)
G = 9.80665
CHAIN = dict(
    length=3.5, segments=50, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e5, fluid_density=1000.0,
)  # fmt: skip
VACUUM = CHAIN | {"fluid_density": 0.0, "end_b": "free", "tolerance": 1e-9}


class Cable:
    """A cable outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, h, u, **parameters):
        self.parameters = COMPONENT.parameters(**parameters)
        self.p = COMPONENT.pack(self.parameters)
        self.h, self.t = round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        self.call(init, u)

    def call(self, function, u):
        self.y[:] = self.w[:] = np.nan
        self.u[:] = u
        assert function(self.t, self.h, self.p, self.u, self.x, self.y, self.w) == 0

    def step(self, u):
        self.t += self.h
        self.call(step, u)

    def __getitem__(self, name):
        k = 0
        for port in COMPONENT.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape)
            k += port.size
        raise KeyError(name)

    @property
    def state(self):
        """A view of the nodes' records."""
        return self.x[: line.STATE * (self.parameters.segments + 1)].reshape(-1, line.STATE)


STILL = np.zeros(9)


def sweep(t, amplitude=0.3, omega=3.0, rise=0.5):
    """Smooth motion of the far end about (2, 0, 0), from rest: position, velocity, acceleration by differences."""

    def position(t):
        phases = np.array([omega, 0.7 * omega, 1.3 * omega]) * t + [0, 0.3, 0.6]
        return np.array([2.0, 0, 0]) + amplitude * (1 - np.exp(-((t / rise) ** 4))) * np.sin(phases)

    d = 1e-4
    p, before, after = position(t), position(t - d), position(t + d)
    return np.concatenate([STILL, p, (after - before) / (2 * d), (after - 2 * p + before) / d**2])


def periods(times, signal):
    """Intervals between rising zero crossings, the crossings interpolated."""
    k = np.flatnonzero((signal[:-1] < 0) & (signal[1:] >= 0))
    crossings = times[k] - signal[k] * (times[k + 1] - times[k]) / (signal[k + 1] - signal[k])
    return np.diff(crossings)


def test_pendulum_of_large_amplitude():
    """One segment is a point pendulum: period 4 sqrt(L/g) K(sin(amplitude/2)). Tolerance: (omega h)^2 / 12 = 2e-5."""
    h, amplitude = 0.01, 1.0
    cable = Cable(h, STILL, **VACUUM | {"segments": 1, "rho_inf": 1.0, "axial_stiffness": 1e6})
    cable.state[1, line.V] = np.sqrt(2 * G * 3.5 * (1 - np.cos(amplitude)))
    cable.state[1, line.ACC + 2] = cable.state[1, line.A + 2] = -(cable.state[1, line.V] ** 2) / 3.5
    x = []
    for _ in range(1200):
        cable.step(STILL)
        x.append(cable["nodes"][1, 0])
    expected = 4 * np.sqrt(3.5 / G) * ellipk(np.sin(amplitude / 2) ** 2)
    assert periods(h * np.arange(1, 1201), np.array(x)).mean() == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_hanging_chain_against_bessel_zeros(mode):
    """Daniel Bernoulli's chain: omega = j_0k / 2 sqrt(g / L). Tolerance: (omega h)^2 and 1/n^2, both below 2e-3."""
    h, n, zero = 0.005, 100, jn_zeros(0, mode)[-1]
    cable = Cable(h, STILL, **VACUUM | {"segments": n})
    cable.state[1:, line.V] = 1e-3 * j0(zero * np.sqrt(1 - np.arange(1, n + 1) / n))
    tip = []
    for _ in range(1500):
        cable.step(STILL)
        tip.append(cable["nodes"][n, 0])
    omega = 2 * pi / periods(h * np.arange(1, 1501), np.array(tip)).mean()
    assert omega == pytest.approx(zero / 2 * np.sqrt(G / 3.5), rel=3e-3)


def test_towed_line_hangs_at_the_angle_of_normal_drag():
    """Steady tow of a free line: straight, w cos(phi) = rho d C_n U^2 sin(phi)^2 / 2, phi from the horizontal.

    Exact for the lumped line too, whose segments all have one tangent; tolerance: what is left of the transient.
    """
    speed, h = 0.4, 0.02
    tow = np.concatenate([np.zeros(3), [speed, 0, 0], np.zeros(3)])
    cable = Cable(h, tow, **CHAIN | {"end_b": "free", "segments": 20})
    for k in range(1, 5001):
        tow[0] = speed * h * k
        cable.step(tow)
    weight = (0.1054 - 1000 * 0.1054 / 7850) * G
    drag = 0.5 * 1000 * 0.01 * 1.2 * speed**2
    cosine = (-weight + np.sqrt(weight**2 + 4 * drag**2)) / (2 * drag)
    span = cable["nodes"][0] - cable["nodes"][-1]
    assert span[0] / np.linalg.norm(span) == pytest.approx(cosine, rel=1e-4)
    assert cable["force_a"][0] == pytest.approx(-drag * 3.5 * (1 - cosine**2) * np.sqrt(1 - cosine**2), rel=1e-3)


def test_second_order_in_time():
    """Halving the step quarters the error of the shape, the reference being 16 times finer."""

    def shape(h):
        cable = Cable(h, sweep(0.0), **CHAIN | {"segments": 10, "tolerance": 1e-10, "axial_stiffness": 4.5e3})
        for k in range(1, round(1.0 / h) + 1):
            cable.step(sweep(k * h))
        return cable["nodes"].copy()

    reference = shape(0.000625)
    errors = [np.abs(shape(h) - reference).max() for h in (0.02, 0.01, 0.005)]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.2)
    assert errors[2] < 1e-3  # m, of a motion of 0.3 m


def test_sub_steps_follow_the_quintic():
    """An end that moves by a quintic is followed exactly: four sub-steps are four steps, to rounding times Newton."""
    c = np.array([0.3, -0.2, 0.1])

    def motion(t):
        return np.concatenate([STILL, np.array([2.0, 0, 0]) + c * t**5, 5 * c * t**4, 20 * c * t**3])

    fine = Cable(0.005, motion(0), **CHAIN | {"tolerance": 1e-10})
    coarse = Cable(0.02, motion(0), **CHAIN | {"tolerance": 1e-10, "sub_steps": 4})
    for k in range(1, 201):
        fine.step(motion(k * 0.005))
        if k % 4 == 0:
            coarse.step(motion(k * 0.005))
    assert np.abs(fine["nodes"] - coarse["nodes"]).max() < 1e-8


@pytest.mark.parametrize("rho_inf", [0.6, 0.0])
def test_rough_handling_converges_and_keeps_bits(rho_inf):
    """Sweeps at 3 m/s that slacken and snap the chain: every balance met, bounded, the same bits with any scratch."""
    motions = [sweep(0.02 * k, amplitude=0.4, omega=8.0) for k in range(501)]
    first, second = (Cable(0.02, motions[0], **CHAIN | {"rho_inf": rho_inf}) for _ in range(2))
    slack = False
    for u in motions[1:]:
        first.step(u)
        second.w[:] = 1e300
        second.u[:], second.t = u, second.t + second.h
        assert step(second.t, second.h, second.p, second.u, second.x, second.y, second.w) == 0
        assert first["converged"] == 1
        slack = slack or first["tension"].min() == 0
    assert slack
    assert np.abs(first["nodes"]).max() < 5  # m: the chain is 3.5 m long
    assert first.x.tobytes() == second.x.tobytes()
    assert first.y.tobytes() == second.y.tobytes()


def test_energy_does_not_grow():
    """Free swinging in vacuum from a hard kick: never more energy than at first, but for 2 % of the scheme's error."""
    cable = Cable(0.01, STILL, **VACUUM | {"segments": 20})
    cable.state[1:, line.V] = 4.0 * np.arange(1, 21) / 20
    mass = np.full(21, 0.1054 * 3.5 / 20)
    mass[[0, 20]] /= 2

    def energy():
        s = cable.state
        q, v = s[:, line.Q : line.Q + 3], s[:, line.V : line.V + 3]
        stretch = np.maximum(np.linalg.norm(np.diff(q, axis=0), axis=1) - 3.5 / 20, 0)
        return np.sum(mass * (0.5 * np.sum(v**2, axis=1) - G * q[:, 2])) + 0.5 * 4.5e5 * 20 / 3.5 * np.sum(stretch**2)

    rest = -np.sum(mass * G * cable.state[:, line.Q + 2])
    energies = [energy() - rest]
    for _ in range(1000):
        cable.step(STILL)
        energies.append(energy() - rest)
    assert max(energies) < 1.02 * energies[0]
    assert np.mean(energies[-100:]) < energies[0]


def test_block_elimination_against_dense():
    """A random symmetric system with a condition number of 1e6, against numpy's dense solver."""
    rng = np.random.default_rng(1)
    n = 7
    dense = np.zeros((3 * n, 3 * n))
    for i in range(n - 1):
        t = rng.normal(size=3)
        k = 1e6 * np.outer(t, t)
        for a, b, sign in ((i, i, 1), (i + 1, i + 1, 1), (i, i + 1, -1), (i + 1, i, -1)):
            dense[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * k
    dense += np.diag(rng.uniform(1, 2, 3 * n))
    w = np.full(n * line.SCRATCH, np.nan)
    rhs = rng.normal(size=3 * n)
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    for i in range(n):
        b = i * line.SCRATCH
        w[b + line.R : b + line.R + 3] = rhs[3 * i : 3 * i + 3]
        w[b + line.D : b + line.D + 6] = [dense[3 * i + r, 3 * i + c] for r, c in order]
        if i < n - 1:
            w[b + line.E : b + line.E + 6] = [dense[3 * i + r, 3 * i + 3 + c] for r, c in order]
    block_tridiagonal.solve(w, 0, n - 1)
    got = np.concatenate([w[i * line.SCRATCH + line.R :][:3] for i in range(n)])
    assert got == pytest.approx(np.linalg.solve(dense, rhs), abs=1e-9)
