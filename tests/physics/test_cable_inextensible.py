"""The inextensible line: rigid links against their own equations of motion, lengths kept, and a chain that unfolds."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from components.tether.cable import line

G = 9.80665
LINKS = dict(
    length=2.0, segments=2, mass_per_length=1.0, volume_per_length=0.0, drag_diameter=0.0, fluid_density=0.0,
    end_b="free", tension_only=False, tolerance=1e-8,
)  # fmt: skip


def double_pendulum(times, a, b):
    """Tip (x, z) of masses 1 and 0.5 on massless links of 1 m, from rest at the angles a and b from the vertical."""
    m1, m2 = 1.0, 0.5

    def slope(_, y):
        p, q, u, v = y
        c, s = np.cos(p - q), np.sin(p - q)
        mass = np.array([[m1 + m2, m2 * c], [m2 * c, m2]])
        force = np.array([-m2 * s * v * v - (m1 + m2) * G * np.sin(p), m2 * s * u * u - m2 * G * np.sin(q)])
        return np.concatenate([[u, v], np.linalg.solve(mass, force)])

    y = solve_ivp(slope, (0, times[-1]), [a, b, 0, 0], t_eval=times, rtol=1e-11, atol=1e-12).y
    return np.stack([np.sin(y[0]) + np.sin(y[1]), np.cos(y[0]) + np.cos(y[1])], axis=1)


def released(cable, h, a, b):
    """Two links released at these angles."""
    links = cable(h, np.zeros(9), **LINKS)
    state = links.x[: 3 * line.STATE].reshape(3, line.STATE)
    state[1, [line.Q, line.Q + 2]] = np.sin(a), np.cos(a)
    state[2, [line.Q, line.Q + 2]] = np.sin(a) + np.sin(b), np.cos(a) + np.cos(b)
    c = np.cos(a - b)
    turn = np.linalg.solve([[1.5, 0.5 * c], [0.5 * c, 0.5]], [-1.5 * G * np.sin(a), -0.5 * G * np.sin(b)])
    first = turn[0] * np.array([np.cos(a), 0, -np.sin(a)])
    for node, acceleration in ((1, first), (2, first + turn[1] * np.array([np.cos(b), 0, -np.sin(b)]))):
        state[node, line.ACC : line.ACC + 3] = state[node, line.A : line.A + 3] = acceleration
    return links


def test_links_are_a_double_pendulum(cable):
    """1.5 s of large swings against scipy: second order in time, and the lengths kept to the tolerance over penalty.

    Richardson of the two finest leaves 2e-6 m; the constraint holds to 1e-8 of weight and tension
    over a penalty of 1e5 weights.
    """
    times = np.linspace(0, 1.5, 31)
    expected, found = double_pendulum(times, 1.2, 0.4), []
    for h in (2e-3, 1e-3, 5e-4):
        links = released(cable, h, 1.2, 0.4)
        tips = [[np.sin(1.2) + np.sin(0.4), np.cos(1.2) + np.cos(0.4)]]
        for k in range(1, round(1.5 / h) + 1):
            links.step(np.zeros(9))
            assert links["converged"] == 1
            lengths = np.linalg.norm(np.diff(links["nodes"], axis=0), axis=1)
            assert np.abs(lengths - 1.0).max() < 1e-10
            if k % round(0.05 / h) == 0:
                tips.append(links["nodes"][2, [0, 2]])
        found.append(np.array(tips))
    errors = [np.abs(one - expected).max() for one in found]
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.1)
    assert np.abs((4 * found[2] - found[1]) / 3 - expected).max() < 1e-2 * errors[2]


@pytest.mark.parametrize("h", [2e-3, 1e-3])
def test_folded_chain_falls_faster_than_free(cable, h):
    """One end of a folded chain let go: it has fallen 0.98 L after 0.853 of a free fall's time (Calkin and March 1989).

    Of 200 links, 0.859: `leapfrog` of test_cable_motion_hard with as many, damped or not. 0.5 % of that, for what is
    between impacts of links that give nothing back and steps that do not end on them. Every step converges, also those
    in which a hundred slack links are drawn taut at once.
    """
    n = 200
    chain = cable(
        h, ((0.0, 0.0, 0.0), (0.02, 0.0, 0.0)), **LINKS | {"segments": n, "end_b": "driven", "tension_only": True,
        "tolerance": 1e-6},
    )  # fmt: skip
    free = cable(h, np.zeros(9), **LINKS | {"segments": n, "tension_only": True, "tolerance": 1e-6})
    free.x[: len(chain.x)] = chain.x
    depths = [0.0]
    while depths[-1] < 2.0 * 0.98:
        free.step(np.zeros(9))
        assert free["converged"] == 1
        depths.append(free["nodes"][n, 2])
    lengths = np.linalg.norm(np.diff(free["nodes"], axis=0), axis=1)
    assert lengths.max() < (2.0 / n) * (1 + 1e-9)
    fallen = h * np.interp(1.96, depths, np.arange(len(depths)))
    assert fallen / np.sqrt(2 * 1.96 / G) == pytest.approx(0.859, rel=0.005)


def test_inextensible_is_the_limit_of_stiff(cable):
    """The same slack chain moved for a second with EA = 1e9 N and none: positions to 1e-5 m."""
    chain = dict(
        length=3.5, segments=50, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
        fluid_density=1000.0,
    )  # fmt: skip
    u = np.zeros(18)
    u[9:12] = (2.0, 0.0, 0.0)
    stiff, rigid = cable(0.02, u, **chain, axial_stiffness=1e9), cable(0.02, u, **chain)
    assert rigid.status == 0
    for k in range(1, 51):
        t = 0.02 * k
        u[9], u[12], u[15] = (
            2 + 0.5 * np.sin(t) ** 3,
            1.5 * np.sin(t) ** 2 * np.cos(t),
            1.5 * np.sin(t) * (3 * np.cos(t) ** 2 - 1),
        )
        stiff.step(u)
        rigid.step(u)
        assert rigid["converged"] == 1
    assert rigid["nodes"] == pytest.approx(stiff["nodes"], abs=1e-5)
    assert rigid["tension"] == pytest.approx(stiff["tension"], rel=1e-3)
