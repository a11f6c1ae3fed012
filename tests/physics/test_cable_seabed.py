"""The seabed under the cable: the touchdown catenary, Coulomb friction, and a touchdown that moves."""

from math import pi

import numpy as np
import pytest
from scipy.optimize import brentq

MOORING = dict(
    length=500.0, mass_per_length=115.0, volume_per_length=15 / 1025, drag_diameter=0.1, axial_stiffness=1e9,
    seabed=100.0, segments=100,
)  # fmt: skip
W = 100 * 9.80665


def exact_tension(span, height=100.0, length=500.0, ea=1e9):
    """H of an elastic line from a point on the bed to `height` above it (Irvine 1981, 1.2; bed rigid, no friction)."""

    def short(h):
        s = np.sqrt(height * (height + 2 * h / W))
        for _ in range(50):
            t = np.hypot(h, W * s)
            s -= (s * s * W / (t + h) + W * s * s / (2 * ea) - height) / (W * s / t + W * s / ea)
        return length - s + h / W * np.arcsinh(W * s / h) + h * length / ea - span

    return brentq(short, 1.0, 1e8)


@pytest.mark.parametrize("span", [440.0, 460.0, 480.0])
def test_rests_as_the_touchdown_catenary(cable, span):
    """Fairlead 100 m up: H at 400 segments to 5e-3: the touchdown falls between nodes and the bed yields by 1 cm."""
    at_rest = cable(0.05, ((0.0, 0.0, 100.0), (span, 0.0, 0.0)), **MOORING | {"segments": 400})
    assert at_rest.status == 0
    assert -at_rest["force_b"][0] == pytest.approx(exact_tension(span), rel=5e-3)
    assert at_rest["force_b"][0] + at_rest["force_a"][0] == pytest.approx(0.0, abs=1e-3)
    assert at_rest["nodes"][:, 2].max() == pytest.approx(100.02, abs=1e-3)  # 2 w / k, k = w / 0.1 d


def test_stiff_bed_reaches_the_rigid_one(cable):
    """The bed's yielding is what is left: H gets nearer with each tenfold stiffness, to 1e-3 and the mesh's error."""
    exact = exact_tension(460.0)
    errors = []
    for stiffness in (1e3, 1e4, 1e6):
        parameters = MOORING | {"segments": 400, "seabed_stiffness": stiffness}
        at_rest = cable(0.05, ((0.0, 0.0, 100.0), (460.0, 0.0, 0.0)), **parameters)
        errors.append(abs(-at_rest["force_b"][0] / exact - 1))
    assert errors[0] > errors[1]
    assert errors[2] < 1e-3


def test_line_drawn_over_the_bed_pulls_with_its_friction(cable):
    """mu w L, and the tension falls along the line by mu w per length: Coulomb. Drawn at 1 cm/s, free at the far end.

    Tolerance: axial waves, damped, and the bed's stick, which is elastic over mu 1 cm.
    """
    mu, speed, h = 0.4, 0.01, 0.05
    line = MOORING | {"length": 50.0, "segments": 20, "end_b": "free", "drag_diameter": 0.1, "damping_time": 0.1}
    u = np.concatenate([[0.0, 0.0, 100.01], np.zeros(6)])
    drawn = cable(h, u, **line | {"seabed_friction": mu, "normal_drag": 0.0})
    assert drawn.status == 0
    for k in range(1, 801):
        u[0], u[3] = -speed * h * k, -speed
        drawn.step(u)
        assert drawn["converged"] == 1
    shares = (np.arange(20)[::-1] + 0.5) / 20
    assert drawn["tension"] == pytest.approx(mu * W * 50 * shares, rel=2e-3)


def test_friction_holds_a_line_that_lies_in_a_curve(cable):
    """Laid on the bed and pulled sideways by a current below what friction holds, it does not creep: 60 s, 1 mm."""
    line = MOORING | {"length": 100.0, "seabed_friction": 0.8, "segments": 40}
    u = np.zeros(21)
    u[2], u[9:12] = 100.01, (90.0, 0.0, 100.01)
    held = cable(0.1, u, **line | {"current_input": True})
    u[18:21] = (0.0, 1.0, 0.0)  # drag 62 N/m across, friction 785 N/m
    for _ in range(100):
        held.step(u)
    before = held["nodes"]
    for _ in range(500):
        held.step(u)
    assert held["converged"] == 1
    assert np.abs(held["nodes"] - before).max() < 1e-3


def heave(t, amplitude, period=8.0, rise=4.0):
    """The mooring's ends: anchor at rest, fairlead heaving from rest, derivatives by differences."""

    def place(t):
        z = amplitude * (1 - np.exp(-((t / rise) ** 4))) * np.sin(2 * pi * t / period)
        return np.array([450.0, 0.0, z])

    d = 1e-4
    u = np.zeros(18)
    u[2] = 100.0
    before, now, after = place(t - d), place(t), place(t + d)
    u[9:12], u[12:15], u[15:18] = now, (after - before) / (2 * d), (after - 2 * now + before) / d**2
    return u


def test_moving_touchdown_is_smooth_and_converges_in_time(cable):
    """Fairlead heaving by 1 m, the touchdown running over some 20 segments: no chatter, order two at small steps.

    Errors of the fairlead tension against a step a quarter of the smallest, over its range. Every step converges.
    """
    parameters = MOORING | {"damping_time": 0.02, "seabed_friction": 0.5, "seabed_stiffness": 2e4}

    def tension(h):
        line = cable(h, heave(0.0, 1.0), **parameters)
        found = []
        for k in range(1, round(16 / h) + 1):
            line.step(heave(k * h, 1.0))
            assert line["converged"] == 1
            found.append(np.linalg.norm(line["force_b"]))
        return np.array(found)[round(0.1 / h) - 1 :: round(0.1 / h)]

    reference = tension(0.00625)
    errors = [np.sqrt(np.mean((tension(h) - reference) ** 2)) / np.ptp(reference) for h in (0.1, 0.05, 0.025)]
    assert errors[0] < 0.02
    assert errors[2] < errors[1] / 2.5
    assert errors[2] < 2e-3


def slamming(cable, h, **more):
    """Tension at the fairlead each 0.2 s, heaving by 5 m: the line slackens at the touchdown and draws taut."""
    line = cable(h, heave(0.0, 5.0), **MOORING | more)
    found = []
    for k in range(1, round(16 / h) + 1):
        line.step(heave(k * h, 5.0))
        assert line["converged"] == 1
        found.append(np.linalg.norm(line["force_b"]))
    return np.array(found)[round(0.2 / h) - 1 :: round(0.2 / h)]


@pytest.mark.parametrize(("accuracy", "most"), [({}, 0.015), ({"accuracy": 1e-6}, 0.004)])
def test_touchdown_that_slams_is_resolved(cable, accuracy, most):
    """Internal damping of 0.1 s, periods of 0.2 and 0.05 s, which the line divides itself, against steps of 3 ms.

    Rms over the range of the tension. The default accuracy of 1e-5 leaves 1e-5 EA = 10 kN at an instant, 5 % of the
    range: 1.1 % in the mean, and a tenth of it a quarter.
    """
    reference = slamming(cable, 0.0125, damping_time=0.1, sub_steps=4)
    for h in (0.2, 0.05):
        tension = slamming(cable, h, damping_time=0.1, **accuracy)
        assert np.sqrt(np.mean((tension - reference) ** 2)) / np.ptp(reference) < most


def test_slam_without_internal_damping_has_no_limit(cable):
    """After a slam an undamped line rings axially for ever, and which segment slackens next hangs on the rounding.

    Steps of 0.8 and 0.2 ms, well below the 5 ms of the mesh's fastest wave, end 5 % apart at least (10 % measured, and
    as much down to 0.05 ms); with 10 ms of internal damping they agree to 0.1 %: that, not the step, is what lacks.
    """
    apart = []
    for tau in (0.0, 0.01):
        coarse, fine = (slamming(cable, 0.0125, damping_time=tau, sub_steps=n) for n in (16, 64))
        apart.append(np.sqrt(np.mean((coarse - fine) ** 2)) / np.ptp(fine))
    assert apart[0] > 0.05
    assert apart[1] < 1e-3


@pytest.mark.parametrize("h", [0.01, 0.02, 0.05, 0.1])
def test_bonded_end_drags_its_line_over_the_bed(cable, h):
    """A line on the bed, drawn by its bonded end along itself, then across and back: every step balances.

    Drawn along it pulls with mu w L (Coulomb) and its inertia, to 1 %: the acceleration changes within a period.
    """
    mu, w, length = 0.5, 0.092 * 9.80665, 3.5
    chain = dict(
        length=length, segments=10, mass_per_length=0.1054, volume_per_length=0.1054 - 0.092, drag_diameter=0.01,
        axial_stiffness=4.5e5, fluid_density=1.0, normal_drag=0.0, seabed=0.0, seabed_friction=mu, end_a="free",
        bond_b=True,
    )  # fmt: skip

    def drawn(t):
        """Back along x, where the line lies ahead, at up to 0.5 m/s; after 1.5 s across too, in a swing."""
        along = 0.5 * (t - 0.5 * (1 - np.exp(-2 * t)))
        swing = max(t - 1.5, 0.0)
        return np.array([-along, 0.3 * np.sin(2 * swing) ** 3, depth])

    depth, d = 0.002, 1e-4  # 2 w / k, at which the line rests

    def u(t):
        before, now, after = drawn(t - d), drawn(t), drawn(t + d)
        return np.concatenate([now, (after - before) / (2 * d), (after - 2 * now + before) / d**2])

    line = cable(h, u(0.0), **chain)
    assert line.status == 0
    for k in range(1, round(3.0 / h) + 1):
        line.step(u(k * h))
        assert line["converged"] == 1
        if k == round(1.5 / h):
            inertia = -(0.1054 + 0.0134) * length * u(1.5)[6]
            assert line["force_b"][0] == pytest.approx(mu * w * length + inertia, rel=0.01)
