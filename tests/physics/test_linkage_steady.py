"""Steady shapes of the chain of rigid segments against the closed forms of the continuous line."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import brentq, minimize

from components.tether.linkage.component import COMPONENT

# Bhattacharya et al. 2011, section V: rope of 60 ft and 3/4 in; separations D [m] and speeds v [m/s] of the trials.
LENGTH, DIAMETER = 18.288, 0.01905
SPEEDS = {4: (0.8, 1.0, 1.4), 6: (0.6, 0.9, 1.2), 8: (0.6, 0.7, 0.8, 0.9, 1.0), 10: (0.5, 0.7, 0.8), 12: (0.5, 0.75)}
LINEAR = {"normal_friction": 0.05, "tangential_friction": 0.05}  # their c_S = c_V [N s/m^2]


def abreast(D, v):
    """Inputs of two boats D [m] apart, end a to the west, going north at v [m/s]."""
    u = np.zeros(18)
    u[10], u[3], u[12] = D, v, v
    return u


def towed(unit, D, v, segments, **parameters):
    """The linkage of 18.288 m at t0, which is the steady tow."""
    line = unit("tether.linkage", abreast(D, v), h=0.01, length=LENGTH, segments=segments, **parameters)
    assert line["converged"] == 1.0
    return line


def catenary(D, segments):
    """Nodes (n+1, 2), north and east, of (9)'s catenary through the boats, and its parameter a [m]."""
    a = brentq(lambda a: 2.0 * a * np.sinh(0.5 * D / a) - LENGTH, D / 40.0, 1e3)
    s = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, segments + 1)
    return np.column_stack([np.hypot(a, s) - np.hypot(a, s[0]), 0.5 * D + a * np.arcsinh(s / a)]), a


def miss(line, nodes):
    """Largest distance of a node from the exact ones, over the length."""
    return np.linalg.norm(line["nodes"][:, :2] - nodes, axis=1).max() / LENGTH


@pytest.mark.parametrize("D", SPEEDS)
def test_trials_against_the_catenary(unit, D):
    # c_S = c_V: (9). The bounds are the issue's. The shape does not depend on the speed, the forces are linear in it.
    for v in SPEEDS[D]:
        errors = []
        for segments in (20, 40):
            line = towed(unit, D, v, segments, **LINEAR)
            exact, a = catenary(D, segments)
            errors.append(miss(line, exact))
            # A boat's force is the catenary's tension c v y at the end, y = hypot(a, L/2); second order as the shape.
            pull = 0.05 * v * np.hypot(a, 0.5 * LENGTH)
            assert np.linalg.norm(line["force_a"]) == pytest.approx(pull, rel=5.0 * errors[-1])
        assert errors[0] < 5e-3
        assert errors[1] < 1e-3
        # Second order: a quarter; 4.1 at D = 4 m, where twenty segments are coarse for the bottom's curvature.
        assert 3.8 < errors[0] / errors[1] < 4.3


def test_quadratic_drag_across_alone_is_a_catenary_of_constant_tension(unit):
    # T kappa = k v^2 cos^2(psi) gives tan(psi) = s/a with a = T / (k v^2) (shared/PAPERS.md).
    errors, spread = [], []
    for segments in (20, 40):
        line = towed(unit, 8.0, 0.9, segments, drag_diameter=DIAMETER, fluid_density=1000.0)
        exact, a = catenary(8.0, segments)
        errors.append(miss(line, exact))
        T = 0.5 * 1000.0 * DIAMETER * 1.2 * 0.9**2 * a
        assert np.linalg.norm(line["force_b"]) == pytest.approx(T, rel=10.0 * errors[-1])
        spread.append(np.ptp(line["tension"]) / T)
    assert errors[1] < 1e-3
    assert 3.8 < errors[0] / errors[1] < 4.3
    # The same tension all along, to the chain's order: a quarter (1.5e-4 with 320 segments), 3.64 from 20 segments on.
    assert spread[1] < 0.01
    assert spread[0] / spread[1] > 3.5


@pytest.mark.parametrize("D", [3.0, 8.0])
def test_linear_drag_across_alone(unit, D):
    # T kappa = c v cos(psi), T constant: y = -a ln cos(x/a), which is s = a gd^-1(x/a), y = a ln cosh(s/a).
    def gd(s):
        return 2.0 * np.arctan(np.tanh(0.5 * s))

    a = brentq(lambda a: 2.0 * a * gd(0.5 * LENGTH / a) - D, 0.2, 1e3)
    errors = []
    for segments in (20, 40):
        line = towed(unit, D, 0.6, segments, normal_friction=0.05)  # 3 m: the ends are along the tow to 0.01 degrees
        s = np.linspace(-0.5 * LENGTH, 0.5 * LENGTH, segments + 1)
        y = a * np.log(np.cosh(s / a))
        errors.append(miss(line, np.column_stack([y - y[0], 0.5 * D + a * gd(s / a)])))
        # The force is as the apex's radius, which is about as D.
        assert np.linalg.norm(line["force_a"]) == pytest.approx(0.05 * 0.6 * a, rel=80.0 / D * errors[-1])
    assert errors[1] < 1e-3
    assert 3.8 < errors[0] / errors[1] < 4.3


@pytest.mark.parametrize("c", [1e-12, 0.05, 1e6])
def test_the_shape_does_not_depend_on_the_drag_nor_on_the_speed(unit, c):
    # (9) with T/c: also for c -> 0.
    line = towed(unit, 8.0, 3.0, 20, normal_friction=c, tangential_friction=c)
    exact, a = catenary(8.0, 20)
    assert miss(line, exact) < 5e-3
    assert np.linalg.norm(line["force_b"]) == pytest.approx(c * 3.0 * np.hypot(a, 0.5 * LENGTH), rel=1e-2)


def test_five_hundred_segments(unit):
    # Second order from 4e-3 at 20 segments: 6e-6.
    exact, _ = catenary(8.0, 500)
    assert miss(towed(unit, 8.0, 0.8, 500, **LINEAR), exact) < 1e-5


@pytest.mark.parametrize("segments", [20, 160])
@pytest.mark.parametrize("along", [0.0, 0.01], ids=("across", "mixed"))
def test_every_trial_has_a_steady_tow_with_hardly_any_drag_along(unit, along, segments):
    # The separations of the trials, and 2 and 18.28 m: `towed` asserts that the tow is found.
    for D in (2.0, *SPEEDS, 18.28):
        line = towed(unit, D, 0.8, segments, drag_diameter=DIAMETER, fluid_density=1000.0, tangential_friction=along)
        assert line["nodes"][segments // 2, 0] < 0.0


def test_two_segments_by_hand(unit):
    # Two rods of L/2 as a V: each is turned about its end by half its own drag and the force at the tip,
    # which is across the tow: H = c v l0 sin(a) / (2 cos(a)) with sin(a) = D / 2l, by hand from (22).
    D, v, l0 = 8.0, 0.7, 0.5 * LENGTH
    line = towed(unit, D, v, 2, **LINEAR)
    rise = np.sqrt(l0 * l0 - 0.25 * D * D)
    assert line["nodes"][1] == pytest.approx([-rise, 0.5 * D, 0.0], abs=1e-9)
    H = 0.05 * v * l0 * (0.5 * D) / (2.0 * rise)
    assert line["force_a"] == pytest.approx([-0.05 * v * l0, H, 0.0], abs=1e-9)
    assert line["force_b"] == pytest.approx([-0.05 * v * l0, -H, 0.0], abs=1e-9)


def test_one_segment_is_a_rod_between_the_boats(unit):
    # The distance alone leaves the force along it open; half the drag on each end is the least.
    line = towed(unit, LENGTH, 1.0, 1, **LINEAR)
    assert line["nodes"] == pytest.approx(np.array([[0.0, 0.0, 0.0], [0.0, LENGTH, 0.0]]), abs=1e-9)
    assert line["force_a"] == pytest.approx([-0.025 * LENGTH, 0.0, 0.0], abs=1e-9)
    assert line["damped"] == 1.0


def test_a_hanging_chain_with_springs_against_its_minimum_of_energy(unit):
    # In the vertical plane, with weight and joint springs, against scipy's minimum over the angles.
    n, L, weight, k = 8, 4.0, 2.0, 0.7
    u = np.zeros(18)
    u[9], u[11] = 2.5, 0.6
    line = unit(
        "tether.linkage", u, h=0.2, length=L, segments=n, plane="vertical", weight=weight, joint_stiffness=k,
        normal_friction=1.0, tangential_friction=1.0, side="port", start="arc",
    )  # fmt: skip
    for _ in range(400):
        line.step()
    l0 = L / n

    def energy(theta):
        z = np.cumsum(l0 * np.sin(theta))
        middle = z - 0.5 * l0 * np.sin(theta)
        return -weight * l0 * middle.sum() + 0.5 * k * (np.diff(theta) ** 2).sum()

    def closure(theta):
        return [l0 * np.cos(theta).sum() - 2.5, l0 * np.sin(theta).sum() - 0.6]

    found = minimize(
        energy, line["angle"] + 0.05 * np.cos(np.arange(n)), method="SLSQP", tol=1e-13,
        constraints={"type": "eq", "fun": closure}, options={"maxiter": 500},
    )  # fmt: skip
    # SLSQP's own accuracy in the angles is the root of its tolerance.
    assert line["angle"] == pytest.approx(found.x, abs=2e-6)
    assert line["force_a"][2] + line["force_b"][2] == pytest.approx(weight * L, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "something must resist"),
        (LINEAR | {"weight": 1.0}, "set plane to vertical"),
        (LINEAR | {"end_b": "free"}, "set start to arc"),
        (LINEAR | {"angles": (0.1,) * 20}, "start is steady with 20 angles"),
        (LINEAR | {"angles": (0.1,) * 3, "start": "given"}, "3 angles for 20 segments"),
        ({"normal_friction": 1.0, "end_a": "free", "end_b": "free", "start": "arc"}, "nothing holds the line along"),
        (LINEAR | {"chord": (20.0, 0.0, 0.0)}, "chord is 20 m long, the line 18.288 m"),
        (LINEAR | {"mass_per_length": 1.0, "virtual_mass": 1.0}, "leave it out beside mass_per_length"),
    ],
)
def test_what_does_not_fit_is_refused(given, words):
    with pytest.raises(ValidationError, match=words):
        COMPONENT.parameters(length=LENGTH, **given)
