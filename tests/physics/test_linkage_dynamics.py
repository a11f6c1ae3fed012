"""Motion of the chain of rigid segments: Lagrange's equations, the paper's rates, energy, closure, order in time."""

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp

LENGTH, DIAMETER, RHO = 18.288, 0.01905, 1000.0
LINEAR = {"normal_friction": 0.05, "tangential_friction": 0.02}
ROPE = {"drag_diameter": DIAMETER, "fluid_density": RHO, "tangential_drag": 0.01, "mass_per_length": 0.55}


def ends(a, b):
    """Inputs of two driven ends, each (position, velocity, acceleration) of north and east."""
    return np.array([[*vector, 0.0] for end in (a, b) for vector in end]).ravel()


def round_a_circle(t, radius=10.0, turn=0.1):
    """Two boats abreast, 8 m apart, round a circle; their distance swells and shrinks by a metre."""

    def boat(r, dr, ddr):
        c, s = np.cos(turn * t), np.sin(turn * t)
        along, across = np.array([c, s]), np.array([s, -c])
        return r * across, dr * across + r * turn * along, (ddr - r * turn**2) * across + 2.0 * dr * turn * along

    swell = np.array([np.sin(0.7 * t), 0.7 * np.cos(0.7 * t), -0.49 * np.sin(0.7 * t)])
    return ends(boat(radius + 4.0 + swell[0], *swell[1:]), boat(radius - 4.0, 0.0, 0.0))


class Dense:
    """The chain by Lagrange's equations with full matrices, of any load on its rods, from the shape functions alone.

    q = (x_L, y_L, theta_1 ... theta_n); the nodes' velocities are J(q) q'. Bhattacharya et al. 2011, (10)-(17).
    """

    def __init__(self, n, mass, c_S, c_V, k_S=0.0, k_V=0.0):
        self.n, self.l0, self.c, self.k = n, LENGTH / n, (c_S, c_V), (k_S, k_V)
        rods = np.zeros((n + 1, n + 1))
        for i in range(n):
            rods[i : i + 2, i : i + 2] += mass * self.l0 / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        self.mass = np.kron(rods, np.eye(2))
        self.xi, self.weight = np.polynomial.legendre.leggauss(3)  # exact for what is quadratic in the speeds

    def jacobian(self, theta):
        J = np.zeros((2 * self.n + 2, self.n + 2))
        J[0::2, 0] = J[1::2, 1] = 1.0
        for i, angle in enumerate(theta):
            J[2 * i + 2 :: 2, 2 + i], J[2 * i + 3 :: 2, 2 + i] = -self.l0 * np.sin(angle), self.l0 * np.cos(angle)
        return J

    def drag(self, theta, v):
        """Forces (n+1, 2) on the nodes, from their velocities, by quadrature along each rod, parted where u_n turns."""
        t = np.column_stack([np.cos(theta), np.sin(theta)])
        n = np.column_stack([-t[:, 1], t[:, 0]])
        a, b = (v[:-1] * n).sum(axis=1), (v[1:] * n).sum(axis=1)
        turns = a * b < 0.0
        middle = np.where(turns, a / np.where(turns, a - b, 1.0), 1.0)[:, None]
        force = np.zeros_like(v)
        for first, part in ((0.0, middle), (middle, 1.0 - middle)):
            for place, share in zip(0.5 + 0.5 * self.xi, 0.5 * self.weight, strict=True):
                xi, weight = first + part * place, part * share
                u = (1.0 - xi) * v[:-1] + xi * v[1:]
                u_t, u_n = (u * t).sum(axis=1)[:, None], (u * n).sum(axis=1)[:, None]
                f = -(self.c[1] + self.k[1] * abs(u_t)) * u_t * t - (self.c[0] + self.k[0] * abs(u_n)) * u_n * n
                force[:-1] += weight * self.l0 * (1.0 - xi) * f
                force[1:] += weight * self.l0 * xi * f
        return force

    def accelerations(self, q, dq, pull_a, pull_b):
        J = self.jacobian(q[2:])
        centripetal = np.zeros((self.n + 1, 2))
        inward = -self.l0 * dq[2:, None] ** 2 * np.column_stack([np.cos(q[2:]), np.sin(q[2:])])
        centripetal[1:] = np.cumsum(inward, axis=0)
        force = self.drag(q[2:], (J @ dq).reshape(-1, 2))
        force[0] += pull_a
        force[-1] += pull_b
        return np.linalg.solve(J.T @ self.mass @ J, J.T @ (force.ravel() - self.mass @ centripetal.ravel()))

    def rates(self, theta, v_a, v_b):
        """(24): the angles' rates without inertia, of ends at these velocities, and the force on end b."""
        J, n = self.jacobian(theta), self.n
        D = -np.array([self.drag(theta, e.reshape(-1, 2)).ravel() for e in np.eye(2 * n + 2)]).T
        turns, last = J[:, 2:], J[-2:, 2:]
        # Q_theta = 0 (22) and the closure (20), in theta' and f_R.
        A = np.block([[turns.T @ D @ turns, -last.T], [last, np.zeros((2, 2))]])
        b = np.concatenate([-turns.T @ D @ J[:, :2] @ v_a, v_b - v_a])
        found = np.linalg.solve(A, b)
        return found[:n], found[n:]


def test_force_controlled_against_lagrange(unit):
    # (10)-(17) by DOP853 at 1e-9: second order in the step, and a start in which drag balances the pulls.
    n, T = 4, 4.0
    k_S, k_V = 0.5 * RHO * DIAMETER * 1.2, 0.5 * np.pi * RHO * DIAMETER * 0.01
    dense = Dense(n, 0.55, 0.3, 0.1, k_S, k_V)

    def pulls(t):
        a = 0.4 * t
        return np.array([15 * np.cos(a) + 8 * np.sin(a), 15 * np.sin(a) - 8 * np.cos(a)]), np.array([15.0, 8.0 + 2 * t])

    def u(t):
        a, b = pulls(t)
        return np.array([*a, 0.0, *b, 0.0])

    errors = []
    for h in (0.02, 0.01):
        line = unit(
            "tether.linkage", u(0.0), h=h, length=LENGTH, segments=n, end_a="pulled", end_b="pulled", start="arc",
            chord=(0.0, 8.0, 0.0), normal_friction=0.3, tangential_friction=0.1, tolerance=1e-9, **ROPE,
        )  # fmt: skip
        if not errors:
            # Both begin with the rates that drag alone allows; the chain's hold rigidity over its first 1e-5 s.
            theta = line["angle"]
            start = line.x.reshape(n + 1, -1)[:, 4:6].copy()
            dq = np.linalg.lstsq(dense.jacobian(theta), start.ravel(), rcond=None)[0]
            J = dense.jacobian(theta)
            assert J @ dq == pytest.approx(start.ravel(), abs=3e-5)
            load = dense.drag(theta, (J @ dq).reshape(-1, 2))
            load[0] += pulls(0.0)[0]
            load[-1] += pulls(0.0)[1]
            # 17 N at each end, lever arms up to 18 m; the rates are known to 1e-5 of themselves.
            assert np.abs(J.T @ load.ravel()).max() < 1e-2

            def rate(t, s):
                return np.concatenate([s[n + 2 :], dense.accelerations(s[: n + 2], s[n + 2 :], *pulls(t))])

            when = np.arange(1, 9) * 0.5
            exact = (
                solve_ivp(
                    rate, (0.0, T), np.concatenate([[0.0, 0.0], theta, dq]), "DOP853", when, rtol=1e-9, atol=1e-10
                )
                .y[: n + 2]
                .T
            )
        found = []
        for k in range(1, round(T / h) + 1):
            line.step(u(k * h))
            if k % round(0.5 / h) == 0:
                found.append(np.concatenate([line["nodes"][0, :2], line["angle"]]))
        errors.append(np.abs(np.array(found) - exact).max())
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] > 3.9


def test_rates_against_the_dense_quasi_static_model(unit):
    # (24), from a bent shape with ends that move apart and turn; c_S and c_V differ. First differences over 1e-5 s.
    n, h = 7, 1e-5
    dense = Dense(n, 0.0, 0.05, 0.02)
    v_a, v_b = np.array([0.9, -0.2]), np.array([0.4, 0.3])
    line = unit(
        "tether.linkage", ends(((0, 0), v_a, (0, 0)), ((3, 8), v_b, (0, 0))), h=h, length=LENGTH, segments=n,
        start="arc", **LINEAR,
    )  # fmt: skip
    before = line["angle"]
    rates, force = dense.rates(before, v_a, v_b)
    # At t0 rates and forces are solved for over 1e-5 s, to first order in it.
    assert -line["force_b"][:2] == pytest.approx(force, rel=3e-5)
    line.step(ends((v_a * h, v_a, (0, 0)), (np.array([3, 8]) + v_b * h, v_b, (0, 0))))
    assert (line["angle"] - before) / h == pytest.approx(rates, abs=2e-5)


@pytest.mark.parametrize(
    "given", [ROPE, LINEAR, {"normal_friction": 0.005, "tangential_friction": 0.002, "mass_per_length": 0.55}], ids=str
)
def test_work_of_the_ends_is_drag_and_kinetic_energy(unit, given):
    # Over 10 s of manoeuvre, with drag and kinetic energy from the nodes alone, differenced: to 1e-4 of the work, as
    # the issue asks; 6e-6 of the rope, 1e-5 of the last one, which hardly any drag keeps from swinging.
    n, T, h = 10, 12.0, 0.01
    line = unit("tether.linkage", round_a_circle(0.0), h=h, length=LENGTH, segments=n, **given)
    t = np.arange(round(T / h) + 1) * h
    u = np.array([round_a_circle(s) for s in t])
    nodes, force = [line["nodes"][:, :2]], [[*line["force_a"], *line["force_b"]]]
    for row in u[1:]:
        line.step(row)
        nodes.append(line["nodes"][:, :2])
        force.append([*line["force_a"], *line["force_b"]])
    k_S, k_V = (0.5 * RHO * DIAMETER * 1.2, 0.5 * np.pi * RHO * DIAMETER * 0.01) if given is ROPE else (0.0, 0.0)
    dense = Dense(n, given.get("mass_per_length", 0.0), given.get("normal_friction", 0.0),
                  given.get("tangential_friction", 0.0), k_S, k_V)  # fmt: skip
    nodes, force = np.array(nodes), np.array(force)
    v = np.gradient(nodes, h, axis=0)
    chords = np.diff(nodes, axis=1)
    every = slice(round(1.0 / h), round(11.0 / h) + 1)
    angles = np.arctan2(chords[..., 1], chords[..., 0])
    loss = [-(dense.drag(theta, w) * w).sum() for theta, w in zip(angles[every], v[every], strict=True)]
    work = -(force * u[:, [3, 4, 5, 12, 13, 14]]).sum(axis=1)[every]
    kinetic = [0.5 * w.ravel() @ dense.mass @ w.ravel() for w in (v[every][0], v[every][-1])]
    work, loss = simpson(work, dx=h), simpson(np.array(loss), dx=h)
    assert work - loss == pytest.approx(kinetic[1] - kinetic[0], abs=1e-4 * abs(work))


def test_the_closure_does_not_drift(unit):
    # Ten simulated minutes of turning; below 1e-9 of the length is the issue's, the method's own bound is 1e-11.
    h = 0.05
    line = unit("tether.linkage", round_a_circle(0.0), h=h, length=LENGTH, segments=10, **LINEAR)
    worst = 0.0
    for k in range(1, round(600.0 / h) + 1):
        line.step(round_a_circle(k * h))
        worst = max(worst, np.linalg.norm(line["nodes"][-1] - line.u[9:12]))
    assert worst < 1e-11 * LENGTH * 1.01
    lengths = np.linalg.norm(np.diff(line["nodes"], axis=0), axis=1)
    assert lengths == pytest.approx(LENGTH / 10, rel=1e-14)
