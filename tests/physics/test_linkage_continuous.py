"""The chain in a turn against the continuous line, the differential equations (8) of Bhattacharya et al. 2011.

Solved by a Galerkin method in Legendre polynomials of the angle theta(s) and the tension T(s), in which the ends'
motions are natural boundary conditions. From lambda r_tt = (T t)' + f with t' = kappa n and v_s = theta_t n follow

    T'' - kappa^2 T = kappa f_n - f_t' - lambda theta_t^2,   lambda theta_tt = kappa (T' + f_t) + (T kappa + f_n)'.
"""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp
from scipy.interpolate import BPoly
from scipy.optimize import brentq

LENGTH, APART, MASS, K_S, UNTIL = 18.288, 12.0, 0.55, 0.5 * 1000.0 * 0.01905 * 1.2, 6.0
MODES, POINTS = 26, 52
# Times [s] and north, east [m] of both ends, each with velocity and acceleration: a hard turn to starboard within 6 s,
# the outer boat faster. Quintic between.
PORT = BPoly.from_derivatives([0.0, 6.0], [[[0, 0], [1, 0], [0, 0]], [[8.0, 3.0], [0, 1.2], [0, 0]]])
STARBOARD = BPoly.from_derivatives([0.0, 6.0], [[[0, 12], [1, 0], [0, 0]], [[2.0, 12.5], [0, 0.5], [0, 0]]])


def end_motions(t):
    """The inputs (18,) at t: both ends' positions, velocities and accelerations."""
    return np.concatenate([[*course(t, nu), 0.0] for course in (PORT, STARBOARD) for nu in range(3)])


class Continuous:
    """The line under quadratic drag across it, in MODES polynomials."""

    def __init__(self):
        xi, weights = legendre.leggauss(POINTS)
        eye = np.eye(MODES)
        self.weights = 0.5 * LENGTH * weights
        self.P = legendre.legvander(xi, MODES - 1)
        self.slope = legendre.legval(xi, legendre.legder(eye)).T * 2.0 / LENGTH
        self.first, self.last = (-1.0) ** np.arange(MODES), np.ones(MODES)
        self.norm = LENGTH / (2.0 * np.arange(MODES) + 1.0)
        # Integral from end a to the points, of what is given there: through the interpolating polynomial.
        values = np.linalg.inv(legendre.legvander(xi, POINTS - 1))
        whole = legendre.legint(np.eye(POINTS), lbnd=-1.0)
        self.integral = 0.5 * LENGTH * legendre.legval(xi, whole).T @ values
        self.xi = xi

    def project(self, f):
        """Coefficients of a function of s."""
        return self.P.T @ (self.weights * f(0.5 * LENGTH * (1.0 + self.xi))) / self.norm

    def rate(self, t, state):
        a, b = state[:MODES], state[MODES:]
        theta, kappa, omega = self.P @ a, self.slope @ a, self.P @ b
        across = np.array([-np.sin(theta), np.cos(theta)])
        v = PORT(t, 1)[:, None] + (self.integral @ (omega * across).T).T
        v_n = (v * across).sum(axis=0)
        f_n = -K_S * np.abs(v_n) * v_n
        ends = [(PORT(t, 2), self.first, -1.0), (STARBOARD(t, 2), self.last, 1.0)]
        in_T = self.P.T @ (self.weights * (MASS * omega**2 - kappa * f_n))
        in_theta = np.zeros(MODES)
        for acceleration, phi, sign in ends:
            th = phi @ a
            in_T += sign * MASS * (acceleration @ [np.cos(th), np.sin(th)]) * phi
            in_theta += sign * MASS * (acceleration @ [-np.sin(th), np.cos(th)]) * phi
        W = self.weights[:, None]
        K = self.slope.T @ (W * self.slope) + self.P.T @ (W * kappa[:, None] ** 2 * self.P)
        tau = np.linalg.solve(K, in_T)
        T, dT = self.P @ tau, self.slope @ tau
        in_theta += self.P.T @ (self.weights * kappa * dT) - self.slope.T @ (self.weights * (T * kappa + f_n))
        return np.concatenate([b, in_theta / (MASS * self.norm)])

    def nodes(self, state, t, segments):
        """Positions (segments + 1, 2) of equidistant points, north and east."""
        fine, weights = legendre.leggauss(POINTS)
        r = [PORT(t)]
        for i in range(segments):
            theta = legendre.legval((2.0 * i + 1.0 + fine) / segments - 1.0, state[:MODES])
            r.append(r[-1] + 0.5 * LENGTH / segments * np.array([weights @ np.cos(theta), weights @ np.sin(theta)]))
        return np.array(r)


@pytest.fixture(scope="module")
def reference():
    """Nodes of the continuous line at the end of the turn, by the number of segments between them."""
    line = Continuous()
    # The steady tow under drag across is a catenary, tan(theta - 90 deg) = (L/2 - s) / a.
    a = brentq(lambda a: 2.0 * a * np.arcsinh(0.5 * LENGTH / a) - APART, 0.2, 1e3)
    start = line.project(lambda s: 0.5 * np.pi + np.arctan((0.5 * LENGTH - s) / a))
    found = solve_ivp(line.rate, (0.0, UNTIL), np.concatenate([start, 0.0 * start]), "BDF", rtol=1e-5, atol=1e-6)
    assert found.success
    state = found.y[:, -1]
    # It closes at end b by itself: only accelerations are prescribed there.
    closed = np.linalg.norm(line.nodes(state, UNTIL, 8)[-1] - STARBOARD(UNTIL))
    assert closed < 3e-4
    return lambda segments: line.nodes(state, UNTIL, segments)


def test_the_chain_converges_to_the_continuous_line_in_a_turn(unit, reference):
    errors = []
    for segments, h in ((10, 0.02), (20, 0.01), (40, 0.005)):
        line = unit(
            "tether.linkage", end_motions(0.0), h=h, length=LENGTH, segments=segments, mass_per_length=MASS,
            drag_diameter=0.01905, fluid_density=1000.0,
        )  # fmt: skip
        for k in range(1, round(UNTIL / h) + 1):
            line.step(end_motions(k * h))
            assert line["converged"] == 1.0
        errors.append(np.linalg.norm(line["nodes"][:, :2] - reference(segments), axis=1).max() / LENGTH)
    # Second order in the segments, the step going with them: 2.9e-3, 7.3e-4 and 1.8e-4 of the length.
    assert errors[2] < 2e-4
    assert 3.7 < errors[0] / errors[1] < 4.3
    assert 3.7 < errors[1] / errors[2] < 4.3
