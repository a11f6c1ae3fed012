"""The cable in moving water: tow angle, shear, Galileo's principle, and Airy waves against their own formulae."""

from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad, solve_bvp, solve_ivp

from components.environment.current import current
from components.environment.waves import DEEP, orbit, wave_number
from components.tether.cable import balance, flow, line
from components.tether.cable.component import COMPONENT

G = 9.80665
CHAIN = dict(
    length=3.5, segments=20, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e5, fluid_density=1000.0, tolerance=1e-10,
)  # fmt: skip
SHEAR = ({"depth": 0.0, "velocity": (1.0, 0.2, 0.0)}, {"depth": 10.0, "velocity": (0.0, 0.2, 0.0)})


def test_hangs_in_a_current_at_the_angle_of_normal_drag(cable):
    """cos(phi) = (sqrt(1 + 4 k^2) - 1) / 2 k, k = rho C_n d U^2 / 2 w; exact for a lumped line."""
    speed = 0.4
    line = cable(0.02, np.zeros(9), **CHAIN | {"end_b": "free", "current": (0.0, speed, 0.0)})
    weight = (0.1054 - 1000 * 0.1054 / 7850) * G
    k = 0.5 * 1000 * 0.01 * 1.2 * speed**2 / weight
    span = line["nodes"][-1] - line["nodes"][0]
    assert line.status == 0
    assert span[1] / np.linalg.norm(span) == pytest.approx((sqrt(1 + 4 * k**2) - 1) / (2 * k), rel=1e-8)


def test_towing_and_a_current_are_one(cable):
    """Galileo: ends that move through still water, and ends at rest in the opposite current, from the same start.

    Tolerance: the transient of 2 s is compared after the tow's way is taken off; Newton's tolerance of 1e-10.
    """
    speed = np.array([0.3, -0.2, 0.0])

    def towed(t):
        drift, still = speed * t, np.zeros(3)
        far = np.array([2.0, 0.3 * sin(2 * t) ** 3, 0.4])
        swing = np.array([0.0, 1.8 * sin(2 * t) ** 2 * cos(2 * t), 0.0])
        turn = np.array([0.0, 3.6 * (2 * sin(2 * t) * cos(2 * t) ** 2 - sin(2 * t) ** 3), 0.0])
        return drift, np.concatenate([drift, speed, still, far + drift, speed + swing, turn])

    def held(t):
        drift, u = towed(t)
        u[0:3], u[9:12] = u[0:3] - drift, u[9:12] - drift
        u[3:6], u[12:15] = u[3:6] - speed, u[12:15] - speed
        return u

    here = cable(0.02, held(0.0), **CHAIN | {"current": tuple(-speed)})
    there = cable(0.02, held(0.0), **CHAIN | {"current": tuple(-speed)})
    there.state[:, line.V : line.V + 3] += speed
    still = cable(0.02, towed(0.0)[1], **CHAIN)
    still.x[:] = there.x[: len(still.x)]
    for k in range(1, 101):
        here.step(held(0.02 * k))
        still.step(towed(0.02 * k)[1])
    assert here["nodes"] == pytest.approx(still["nodes"] - speed * 2.0, abs=1e-8)
    assert here["force_b"] == pytest.approx(still["force_b"], abs=1e-4)  # k times 1e-10 m


def test_linear_shear_against_the_boundary_value_problem(cable):
    """Ends 4 m apart on a line of 5 m in u = 1 - z / 10: scipy's collocation of the continuous inextensible line.

    dT/ds = -w sin(theta) - tangential drag, T dtheta/ds = w cos(theta) ... in the plane; Richardson's extrapolation of
    two meshes leaves 1e-4 of the shape's size, the meshes alone differ by the square of the segment length.
    """
    w, d, c_n, c_t = 2.0, 0.02, 1.2, 0.02
    mass = w / G + 1000 * pi / 4 * d**2
    level = ({"depth": 0.0, "velocity": (1.0, 0.0, 0.0)}, {"depth": 10.0, "velocity": (0.0, 0.0, 0.0)})

    def slope(s, y):
        _, z, tx, tz = y
        size = np.hypot(tx, tz)
        ux, uz = tx / size, tz / size
        u = 1.0 - z / 10.0
        t = u * ux
        nx, nz = u - t * ux, -t * uz
        n = np.hypot(nx, nz)
        b, a = 0.5 * 1000 * d * c_n * n, 0.5 * 1000 * pi * d * c_t * np.abs(t) * t
        return np.array([ux, uz, -b * nx - a * ux, -b * nz - a * uz - w])

    def held(ya, yb):
        return np.array([ya[0], ya[1] - 1.0, yb[0] - 4.0, yb[1] - 1.0])

    s = np.linspace(0, 5, 41)
    guess = np.array([4 * s / 5, 1 + 1.2 * (1 - (s / 2.5 - 1) ** 2), 10 + 0 * s, 5 * (2.5 - s)])
    exact = solve_bvp(slope, held, s, guess, tol=1e-9, max_nodes=20000)
    assert exact.success
    found = []
    for n in (40, 80):
        at_rest = cable(
            0.02, ((0.0, 0.0, 1.0), (4.0, 0.0, 1.0)), length=5.0, segments=n, mass_per_length=mass,
            volume_per_length=pi / 4 * d**2, drag_diameter=d, axial_stiffness=1e8, fluid_density=1000.0,
            normal_drag=c_n, tangential_drag=c_t, current_profile=level,
        )  # fmt: skip
        assert at_rest.status == 0
        found.append(np.concatenate([at_rest["nodes"][:: n // 8, 0], at_rest["nodes"][:: n // 8, 2]]))
    expected = np.concatenate(exact.sol(np.linspace(0, 5, 9))[:2])
    errors = [np.abs(one - expected).max() for one in found]
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
    assert np.abs((4 * found[1] - found[0]) / 3 - expected).max() < 1e-4


@pytest.mark.parametrize("length", [300.0, 1000.0])
def test_long_tether_streams_into_its_shape_in_a_sheared_current(cable, length):
    """Hung in still water, then let stream out in a shear, it comes to where statics has it (test_quasistatic's too).

    ROV tether, 0.5 N/m in water, ends 0.6 of its length apart in depth; four hours in steps of 4 s, each converged.
    What is left is the slow end of streaming out, 1e-3 of the length.
    """
    d = 0.015
    displaced = pi / 4 * d**2
    tether = dict(
        length=length, segments=50, mass_per_length=1025 * displaced + 0.5 / G, volume_per_length=displaced,
        drag_diameter=d, axial_stiffness=1e6, tangential_drag=0.02, damping_time=0.1,
    )  # fmt: skip
    shear = (
        {"depth": 0.0, "velocity": (1.0, 0.0, 0.0)},
        {"depth": 0.3 * length, "velocity": (0.5, 0.3, 0.0)},
        {"depth": length, "velocity": (-0.4, 0.1, 0.0)},
    )
    ends = ((0.0, 0.0, 0.0), (0.3 * length, 0.0, 0.6 * length))
    hung, rest = cable(4.0, ends, **tether), cable(4.0, ends, **tether, current_profile=shear)
    assert hung.status == rest.status == 0
    shape, u = rest["nodes"], rest.u.copy()
    assert np.linalg.norm(hung["nodes"] - shape, axis=1).max() > 0.05 * length
    rest.x[:] = hung.x
    for _ in range(3600):
        rest.step(u)
        assert rest["converged"] == 1
    assert np.linalg.norm(rest["nodes"] - shape, axis=1).max() < 1e-3 * length


def test_current_from_a_table_and_from_a_port(cable):
    table = np.array([2, 0.0, 1.0, 0.2, 0.0, 10.0, 0.0, 0.2, 0.0])
    assert current(table, 0, -1.0) == (1.0, 0.2, 0.0)
    assert current(table, 0, 2.5) == pytest.approx((0.75, 0.2, 0.0))
    assert current(table, 0, 99.0) == (0.0, 0.2, 0.0)
    u = np.zeros(21)
    u[9:12], u[18:21] = (2.0, 0.0, 0.5), (0.3, 0.1, 0.0)
    port = cable(0.02, u, **CHAIN | {"current_input": True})
    parameter = cable(0.02, u[:18], **CHAIN | {"current": (0.3, 0.1, 0.0)})
    assert np.array_equal(port["nodes"], parameter["nodes"])
    levels = np.concatenate([u[:18], np.ravel([level["velocity"] for level in SHEAR])])
    over_depth = cable(0.02, levels, **CHAIN | {"current_input": True, "current_depths": (0.0, 10.0)})
    profile = cable(0.02, u[:18], **CHAIN | {"current_profile": SHEAR})
    for _ in range(20):
        over_depth.step(levels)
        profile.step(u[:18])
    assert np.array_equal(over_depth["nodes"], profile["nodes"])
    assert not np.array_equal(profile["nodes"], port["nodes"])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (
            {"current_input": True, "current_depths": (0.0, 5.0, 5.0)},
            "current_depths are .*expected each below the last",
        ),
        ({"current_depths": (0.0, 5.0)}, "set current_input"),
    ],
)
def test_refused_depths_of_a_current(parameters, message):
    with pytest.raises(ValueError, match=message):
        COMPONENT.parameters(**CHAIN | parameters)


def sea(depth=DEEP, amplitude=1e-3, period=3.0, direction=0.5, phase=0.3):
    omega = 2 * pi / period
    k = wave_number(omega, depth, G)
    return np.array([1, depth, amplitude, omega, k, cos(direction), sin(direction), phase]), omega, k


@pytest.mark.parametrize("depth", [0.2, 3.0, 50.0, DEEP])
def test_wave_number_solves_the_dispersion_relation(depth):
    _, omega, k = sea(depth)
    assert G * k * np.tanh(min(k * depth, 50)) == pytest.approx(omega**2, rel=1e-14)


def test_water_particle_goes_round_in_a_circle():
    """Deep water: radius a exp(-k z). Tolerance: Stokes' drift and the stretching are of the order k a = 4.5e-4."""
    table, omega, k = sea()
    start = np.array([3.0, -2.0, 1.0])
    way = solve_ivp(
        lambda t, q: orbit(table, 0, *q, t)[:3], (0, 2 * pi / omega), start, rtol=1e-9, atol=1e-12, dense_output=True
    ).sol(np.linspace(0, 2 * pi / omega, 200))
    middle = way[:, :-1].mean(axis=1)
    radii = np.linalg.norm(way - middle[:, None], axis=0)
    assert radii == pytest.approx(np.full(200, 1e-3 * exp(-k)), rel=5e-3)


@pytest.mark.parametrize("depth", [4.0, DEEP])
def test_waves_obey_the_equations_of_water(depth):
    """No divergence, no rotation, acceleration as the velocity's derivative, no flow through the bottom: to O(k a)."""
    table, omega, k = sea(depth)
    at, t, d = np.array([1.0, 2.0, 1.5]), 0.7, 1e-4

    def velocity(q, t):
        return np.array(orbit(table, 0, *q, t)[:3])

    gradient = np.column_stack([(velocity(at + d * e, t) - velocity(at - d * e, t)) / (2 * d) for e in np.eye(3)])
    scale = k * np.linalg.norm(velocity(at, t))
    assert abs(np.trace(gradient)) < 2e-3 * scale
    assert np.abs(gradient - gradient.T).max() < 2e-3 * scale
    change = (velocity(at, t + d) - velocity(at, t - d)) / (2 * d)
    assert orbit(table, 0, *at, t)[3:] == pytest.approx(change, abs=2e-3 * omega * np.linalg.norm(velocity(at, t)))
    if depth < DEEP:
        assert abs(orbit(table, 0, 1.0, 2.0, depth, t)[2]) < 1e-18


def test_stretched_orbits_reach_the_surface_and_stop_there():
    """Wheeler 1970: at the crest the velocity is a omega, as at the mean level without stretching; above, the same."""
    table, omega, _ = sea(amplitude=0.5, phase=0.0)
    assert orbit(table, 0, 0, 0, -0.5, 0.0)[0] == pytest.approx(0.5 * omega * cos(0.5), rel=1e-12)
    assert orbit(table, 0, 0, 0, -0.9, 0.0) == orbit(table, 0, 0, 0, -0.5, 0.0)


def test_wave_force_on_a_fixed_vertical_line():
    """Morison's force, drag plus (1 + Ca) rho V a, integrated over a vertical line of 8 m from 1 m below the surface.

    The lumped line sums by the trapezoidal rule: error (l0 k)^2 / 12, 3e-5 for 100 segments, of the integral.
    """
    wave = {"amplitude": 0.3, "period": 4.0, "direction": 0.0, "phase": 0.4}
    parameters = COMPONENT.parameters(
        length=8.0, segments=100, mass_per_length=1.0, volume_per_length=1e-3, drag_diameter=0.03, axial_stiffness=1e6,
        fluid_density=1000.0, normal_drag=1.1, normal_added_mass=0.9, waves=(wave,), water_depth=20.0,
    )  # fmt: skip
    made = line.unpack(COMPONENT.pack(parameters), 0.0)
    w = np.zeros(COMPONENT.sizes(parameters).workspace)
    nodes = w[: line.SCRATCH * 101].reshape(-1, line.SCRATCH)
    nodes[:, line.Q + 2] = 1.0 + 0.08 * np.arange(101)
    flow.hear(made, np.zeros(18), w)
    flow.sample(made, w, 1.3, True)
    balance.assemble(made, w, 0.0, 0.0)
    table, *_ = sea(20.0, 0.3, 4.0, 0.0, 0.4)

    def force(z):
        u, _, _, a, _, _ = orbit(table, 0, 0.0, 0.0, z, 1.3)
        return 0.5 * 1000 * 0.03 * 1.1 * abs(u) * u + 1000 * 1e-3 * 1.9 * a

    assert nodes[:, line.R].sum() == pytest.approx(quad(force, 1.0, 9.0, epsabs=1e-12)[0], rel=1e-4)


def test_rides_on_waves_with_all_balances_met(cable):
    """A light slack line between fixed points in steep short waves, 5 s: every step converged, the same bits again."""
    waves = tuple({"amplitude": 0.1, "period": p, "direction": 0.4 * p, "phase": p} for p in (1.5, 2.0, 2.7))
    first, second = (
        cable(0.02, ((0.0, 0.0, 0.5), (2.5, 0.0, 0.5)), **CHAIN | {"waves": waves, "current_profile": SHEAR})
        for _ in range(2)
    )
    u = first.u.copy()
    for _ in range(250):
        first.step(u)
        second.step(u)
        assert first["converged"] == 1
    assert first.x.tobytes() == second.x.tobytes()
    assert np.abs(first["nodes"]).max() < 5  # m: the chain is 3.5 m long
