"""The chain of bars as a pseudo-rigid-body model: equations by sympy, exact slopes, springs from EI, a seabed."""

import numpy as np
import pytest
import sympy
from pydantic import ValidationError
from scipy.optimize import brentq

from components.compiled import kernel
from components.tether.linkage.component import COMPONENT
from components.tether.linkage.lagrangian import bars_at, constants, evaluate, size, slopes_at

N, L, GAMMA = 3, 0.2, 0.85
MASS, WEIGHT, J, C_S, K_S, CLAMP = 0.07, 0.2, 3e-4, 0.3, 5.0, 0.1
SPRINGS = np.array([0.3, 0.2, 0.1])
P = constants(N, L, MASS, WEIGHT, SPRINGS, 0.5 * GAMMA * L, J, C_S, K_S, CLAMP)


@kernel
def all_of(p, theta, omega, alpha, v, load, w):
    bars = bars_at(p, 0)
    evaluate(bars, theta, omega, alpha, v, load, slopes_at(w, 0, bars.n))
    return 0


def chain(*arguments, p=P, n=N):
    """r and its slopes by angles, rates, second rates, pivot's velocity, loads."""
    w = np.full(size(n), np.nan)
    all_of(p, *arguments, w)
    r, w = w[:n], w[n:]
    M, theta, omega = w[: 3 * n * n].reshape(3, n, n)
    v, load = w[3 * n * n :][: 2 * n].reshape(n, 2), w[3 * n * n + 2 * n :][: 4 * n].reshape(n, 4)
    return r, theta, omega, M, v, load


def lagrange(n):
    """Lagrange's equations in the angles of the joints, as the paper has them, by sympy: a function of numbers."""
    q, dq, ddq = (sympy.symbols(f"{kind}:{n + 2}") for kind in ("q", "dq", "ddq"))  # the pivot's x and z at the end
    F = sympy.symbols("F_x F_z")
    T = V = angle = sympy.Integer(0)
    x, z = q[n:]
    for i in range(n):
        angle += q[i]
        # (7), (8) with the bar's own rate, (10) with gamma / 2 in every term.
        gx, gz = x + GAMMA * L / 2 * sympy.cos(angle), z + GAMMA * L / 2 * sympy.sin(angle)
        rates = [sum(s.diff(a) * b for a, b in zip(q, dq, strict=True)) for s in (gx, gz, angle)]
        T += (MASS * (rates[0] ** 2 + rates[1] ** 2) + J * rates[2] ** 2) / 2
        V += SPRINGS[i] * (q[i] - (CLAMP if i == 0 else 0)) ** 2 / 2 - WEIGHT * gz
        x, z = x + L * sympy.cos(angle), z + L * sympy.sin(angle)
    # (12) with minus dL/dtheta, (11).
    equations = []
    for i in range(n):
        momentum = T.diff(dq[i])
        rate = sum(momentum.diff(dq[j]) * ddq[j] + momentum.diff(q[j]) * dq[j] for j in range(n + 2))
        equations.append(rate - (T - V + F[0] * x + F[1] * z).diff(q[i]))
    return sympy.lambdify([q, dq, ddq, F], equations, "numpy")


def test_equations_against_sympy():
    rng = np.random.default_rng(1)
    exact, joints = lagrange(N), np.tril(np.ones((N, N)))
    free = constants(N, L, MASS, WEIGHT, SPRINGS, 0.5 * GAMMA * L, J, 0.0, 0.0, CLAMP)
    for _ in range(20):
        phi, dphi, ddphi = rng.normal(size=(3, N))
        v, load = rng.normal(size=2), rng.normal(size=4)
        r = chain(joints @ phi, joints @ dphi, joints @ ddphi, v, load, p=free)[0]
        numbers = [*phi, 0.0, 0.0], [*dphi, *v], [*ddphi, *load[2:]], load[:2]
        assert np.cumsum(r[::-1])[::-1] == pytest.approx(exact(*numbers), abs=1e-13)


def test_slopes_are_exact():
    # Central differences over 1e-6: 1e-10 of the largest. Drag's |v| v has a slope everywhere.
    arguments = [np.random.default_rng(2).normal(size=k) for k in (N, N, N, 2, 4)]
    slopes = chain(*arguments)[1:]
    for i, slope in enumerate(slopes):
        for j in range(slope.shape[1]):
            ahead, behind = [a.copy() for a in arguments], [a.copy() for a in arguments]
            ahead[i][j] += 1e-6
            behind[i][j] -= 1e-6
            assert (chain(*ahead)[0] - chain(*behind)[0]) / 2e-6 == pytest.approx(slope[:, j], abs=1e-9)


def test_drag_takes_its_power_from_the_motion():
    # Against the integral along each bar by a fine rule; Gauss's two points are exact for linear drag, and for
    # quadratic drag while a bar does not turn through the water's velocity.
    rng = np.random.default_rng(3)
    theta, omega, v = rng.normal(size=N), 0.1 * rng.normal(size=N), np.array([0.4, 2.0])
    still = chain(theta, omega, np.zeros(N), v, np.zeros(4),
                  p=constants(N, L, MASS, WEIGHT, SPRINGS, 0.5 * GAMMA * L, J, 0.0, 0.0, CLAMP))[0]  # fmt: skip
    power = -(chain(theta, omega, np.zeros(N), v, np.zeros(4))[0] - still) @ omega
    xi, weight = np.polynomial.legendre.leggauss(20)
    expected = 0.0
    normals = np.column_stack([-np.sin(theta), np.cos(theta)])
    for i in range(N):
        for x, part in zip(0.5 + 0.5 * xi, 0.5 * L * weight, strict=True):
            own = L * (omega[:i] @ normals[:i]) + x * L * omega[i] * normals[i]
            across = normals[i] @ (own + v)
            expected -= part * (C_S + K_S * abs(across)) * across * (normals[i] @ own)
    assert power == pytest.approx(expected, rel=1e-12)


def test_printed_inertia_is_too_small():
    """(9) takes the joints' rates for the bars': M_11 as printed in (A-1) is 8.7 times too small."""
    n, straight = 5, np.zeros(5)
    p = constants(n, 1.0, 1.0, 0.0, np.zeros(n), 0.5 * GAMMA, 1.0 / 12.0, 0.0, 0.0, 0.0)
    M = chain(straight, straight, straight, np.zeros(2), np.zeros(4), p=p, n=n)[3]
    joints = np.tril(np.ones((n, n)))
    assert (joints.T @ M @ joints)[0, 0] / (GAMMA**2 / 4 + 4 + 5 / 12) == pytest.approx(8.7, abs=0.05)


@pytest.mark.parametrize(("factor", "expected"), [(1.0, 1.0), (0.85 * 2.6, 2.21)])
def test_a_strut_buckles_at_eulers_load(unit, factor, expected):
    # Ends 1e-3 nearer than the length: P = pi^2 EI / L^2 (1 + O(1e-3)); the chain's is 1/12 (pi / n)^2 = 5e-4 less.
    # With gamma K_theta of (6), which is of beams in an S, a line of many bars is 2.21 times too stiff.
    length, EI, n = 2.0, 0.7, 40
    u = np.zeros(18)
    u[9] = length * (1.0 - 1e-3)
    strut = unit("tether.linkage", u, h=0.02, length=length, segments=n, normal_friction=6.0, mass_per_length=1.0,
                 start="arc", flexural_rigidity=EI, spring_factor=factor)  # fmt: skip
    for _ in range(400):
        strut.step(u)
    assert strut["converged"] == 1.0
    assert strut["force_a"][0] == pytest.approx(-expected * np.pi**2 * EI / length**2, rel=3e-3)


RISER = {
    "length": 8.19, "plane": "vertical", "weight": 0.98, "mass_per_length": 0.338, "drag_diameter": 0.0123,
    "fluid_density": 1000.0, "seabed": 4.0, "seabed_stiffness": 3e3, "tolerance": 1e-5,
}  # fmt: skip
ANCHOR, FAIRLEAD = np.array([0.0, 0.0, 4.0]), np.array([5.87, 0.0, 0.0])


def ends(t, amplitude=0.0, f=0.5):
    w = 2.0 * np.pi * f
    u = np.zeros(18)
    u[:3], u[9:12] = ANCHOR, FAIRLEAD
    u[11] += amplitude * np.sin(w * t)
    u[14], u[17] = amplitude * w * np.cos(w * t), -amplitude * w * w * np.sin(w * t)
    return u


def test_it_hangs_on_the_seabed_as_the_catenary(unit):
    # Irvine 1981, section 1.2: s_0 on the bed, then a catenary of c = H / w; second order in the segments.
    c = brentq(
        lambda c: 8.19 - np.sqrt(16.0 + 8.0 * c) + c * np.arcsinh(np.sqrt(16.0 + 8.0 * c) / c) - FAIRLEAD[0], 0.1, 5.0
    )
    errors = []
    for n in (40, 80):
        line = unit("tether.linkage", ends(0.0), h=0.01, segments=n, **RISER)
        assert line["converged"] == 1.0
        errors.append(abs(-line["force_b"][0] / (0.98 * c) - 1.0))
        assert line["nodes"][:, 2].max() < 4.0 + 1e-3
    assert errors[0] < 2e-3
    assert errors[1] < 0.45 * errors[0]  # and the part of sinking in


def test_touchdown_under_a_harmonic_fairlead(unit):
    # Every step balances; over whole periods ends and bed carry the weight in the mean, since momentum comes back.
    h, k, l0 = 0.02, 300.0, 8.19 / 41
    line = unit("tether.linkage", ends(0.0), h=h, segments=41, **{**RISER, "seabed_stiffness": k})
    iterations, upright = [], []
    for step in range(1, 401):
        line.step(ends(step * h, 0.08))
        assert line["converged"] == 1.0
        iterations.append(line["iterations"])
        sunk = np.maximum(line["nodes"][1:-1, 2] - 4.0, 0.0)
        onset = 2.0 * 0.98 / k
        bed = l0 * k * np.where(sunk < onset, 0.5 * sunk**2 / onset, sunk - 0.5 * onset).sum()
        upright.append(line["force_b"][2] + line["force_a"][2] + bed)
    assert np.mean(iterations) < 5
    assert np.mean(upright[200:]) == pytest.approx(0.98 * 8.19, rel=0.02)  # the bed's damping left out


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"joint_stiffness": 1.0, "flexural_rigidity": 1.0}, "leave one out"),
        ({"seabed_stiffness": None}, "give both, or none"),
        ({"plane": "surface", "weight": 0.0}, "does not touch the seabed"),
    ],
    ids=str,
)
def test_refused(wrong, text):
    with pytest.raises(ValidationError, match=text):
        COMPONENT.parameters(**{**RISER, **wrong})
