"""The winch along the whole line: statics in the limit, a falling payout in closed form, energy, limits and slack."""

import numpy as np
import pytest

from components.tether.cable import line

G = 9.80665
CHAIN = dict(
    length=3.5, segments=20, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e5, fluid_density=1000.0,
)  # fmt: skip
VACUUM = CHAIN | {"fluid_density": 0.0, "end_b": "free"}
STILL = np.zeros(9)
BOTH = np.concatenate([STILL, [2.0, 0.0, 0.5], np.zeros(6)])


def wind(cable, ends, rate, steps):
    for _ in range(steps):
        cable.step(np.append(ends, rate))


TERMS = {
    "elastic": {},
    "inextensible": {"axial_stiffness": None},
    "on the bed": {"seabed": 1.4},
    "stiff": {"bending_stiffness": 0.01, "damping_time": 0.01},
}


@pytest.mark.parametrize(
    ("winch", "rate", "term"),
    [("a", 0.02, "elastic"), ("b", -0.02, "elastic"), *[("a", 0.02, term) for term in list(TERMS)[1:]]],
)
def test_slow_winding_follows_statics(cable_of, winch, rate, term):
    """Half a metre in 25 s, then rest: the shape and the end forces of a line of that length hung up anew.

    Tolerance: what is left of the motion, 1 mm and 2 mN; other segments than the wound ones see the same line. On a bed
    without friction it goes on sliding to and fro by 2 mm.
    """
    chain = CHAIN | TERMS[term]
    cable = cable_of(0.02, np.append(BOTH, 0.0), **chain, winch=winch)
    wind(cable, BOTH, rate, 1250)
    wind(cable, BOTH, 0.0, 300)
    length = float(cable["unstretched_length"])
    assert length == pytest.approx(3.5 + 25 * rate)
    rest = cable_of(0.02, BOTH, **chain | {"length": length})
    assert np.abs(cable["nodes"] - rest["nodes"]).max() < (3e-3 if term == "on the bed" else 1e-3)
    assert cable["force_b"] == pytest.approx(rest["force_b"], abs=2e-3)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_payout_that_falls(cable_of, share):
    """A free line let out at the rate f g t falls at f g, and its top pulls with m L (1 - f) g, which may be nothing.

    Exact for the continuous line, whose material all has one velocity. Tolerances: the step in the acceleration at t0,
    of which the scheme sees the half (f g t h = 0.1 m), and the highest half segment.
    """
    cable, h = cable_of(0.01, np.append(STILL, 0.0), **VACUUM, winch="a", damping_time=1e-3), 0.01
    for k in range(1, 101):
        cable.step(np.append(STILL, share * G * k * h))
    length = 3.5 + share * G / 2
    assert cable["unstretched_length"] == pytest.approx(length, rel=1e-9)
    assert cable["nodes"][-1, 2] == pytest.approx(length, abs=0.1)
    assert cable["force_a"][2] == pytest.approx(0.1054 * length * (1 - share) * G, abs=0.01)
    assert cable["converged"] == 1


def account(cable):
    """Energy of the line [J], and the power of its end, its winch and the material that the winch lets through [W].

    Material moves at V = dq/dt + w D past the nodes; see winch.py.
    """
    n, s, m = cable.parameters.segments, cable.state, 0.1054
    length, rate = float(cable["unstretched_length"]), cable.x[-1]
    l0, w = length / n, -rate * (n - np.arange(n + 1)) / n
    q, v = s[:, line.Q : line.Q + 3], s[:, line.V : line.V + 3]
    d = np.vstack([q[0] - q[1], (q[:-2] - q[2:]) / 2, q[-2] - q[-1]]) / l0
    v = v + w[:, None] * d
    stretch = np.maximum(np.linalg.norm(np.diff(q, axis=0), axis=1) - l0, 0)
    lumps = np.full(n + 1, m * l0)
    lumps[[0, -1]] /= 2
    energy = np.sum(lumps * (0.5 * np.sum(v**2, axis=1) - G * q[:, 2])) + 0.5 * 4.5e5 / l0 * (stretch @ stretch)
    through = rate * (0.5 * m * (v[0] @ v[0]) + 0.5 * 4.5e5 * (stretch[0] / l0) ** 2)
    return energy, -cable["force_a"] @ v[0] + through


def test_winch_work_is_the_energy_gained(cable_of):
    """A swinging chain hauled in at 0.5 m/s, in vacuum: its energy grows by what the winch does.

    Tolerance: 1e-3 of the 4 J, what 20 segments and 5 ms leave; at 40 and 2.5 ms it is half.
    """
    h = 0.005
    cable = cable_of(h, np.append(STILL, 0.0), **VACUUM, winch="a")
    cable.state[1:, line.V] = np.arange(1, 21) / 20
    energy, power = account(cable)
    start, work, worst = energy, 0.0, 0.0
    for k in range(1, 601):
        before = power
        cable.step(np.append(STILL, -0.5 * min(1.0, k * h / 0.5)))
        energy, power = account(cable)
        work += 0.5 * h * (before + power)
        worst = max(worst, abs(energy - start - work))
    assert work > 3.0  # J
    assert worst < 1e-3 * work


def test_winch_stops_before_nothing_is_left(cable_of):
    """Hauled in at 1 m/s for ever, the line stops at the shortest length, and swings there in peace."""
    cable = cable_of(0.02, np.append(STILL, 0.0), **VACUUM, winch="a", shortest=0.1)
    wind(cable, STILL, -1.0, 300)
    assert cable["unstretched_length"] == pytest.approx(0.35)
    assert np.linalg.norm(cable["nodes"][-1]) < 0.3501
    assert cable["converged"] == 1
    wind(cable, STILL, 1.0, 100)
    assert cable["unstretched_length"] == pytest.approx(0.35 + 2 - 0.01, abs=0.011)


def test_payout_of_a_slack_line(cable_of):
    """A loose line let out at 0.5 m/s comes to rest as a longer one hangs."""
    ends = np.concatenate([STILL, [0.5, 0.0, 0.0], np.zeros(6)])
    cable = cable_of(0.02, np.append(ends, 0.0), **CHAIN, winch="a")
    wind(cable, ends, 0.5, 100)
    wind(cable, ends, 0.0, 1000)
    rest = cable_of(0.02, ends, **CHAIN | {"length": float(cable["unstretched_length"])})
    assert cable["unstretched_length"] == pytest.approx(3.5 + 1.0, abs=0.006)
    assert cable["converged"] == 1
    assert np.abs(cable["nodes"] - rest["nodes"]).max() < 5e-3  # m, of 4.5: what still swings


def test_winch_at_a_free_end_is_refused(cable_of):
    with pytest.raises(ValueError, match="winch is at end b, which is free"):
        cable_of(0.02, np.append(STILL, 0.0), **VACUUM, winch="b")
