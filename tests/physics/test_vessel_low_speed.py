"""The vessel at low speed against closed forms, scipy's DOP853, published data, and exchange with a moving frame."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from components.compiled import bind
from components.vessel.low_speed import closed_form
from components.vessel.low_speed.component import COMPONENT
from pipeline.parameters import build, gather
from pipeline.yaml_source import parse

ROOT = Path(__file__).parents[2]
FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


def published(*names):
    """Parameters of files, as a scenario would read them."""
    text, problems = f"file: [{', '.join(names)}]", []
    table, found = parse(text, "")
    given = gather(COMPONENT.parameters, table, ROOT / "scenarios" / "parameters", "", problems)
    parameters = build(COMPONENT.parameters, given, table.place, "", problems)
    assert not problems + list(found)
    return parameters.model_dump()


class Vessel:
    """A vessel outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, h, u=(), t0=0.0, **parameters):
        self.parameters = COMPONENT.parameters(**parameters)
        self.p = COMPONENT.pack(self.parameters)
        self.h, self.t = round(h * 1e9), round(t0 * 1e9)
        self.u, self.x, self.y, self.w = (np.full(int(n), np.nan) for n in self.p[1:5])
        self.u[:] = u
        entries = bind(COMPONENT)
        self._init, self._step = FUNCTION(entries.init), FUNCTION(entries.step)
        self._call(self._init)

    def _call(self, function):
        self.y[:] = self.w[:] = np.nan
        vectors = (self.p, self.u, self.x, self.y, self.w)
        assert function(self.t, self.h, *[vector.ctypes.data for vector in vectors]) == 0
        assert np.isfinite(self.y).all()
        assert np.isfinite(self.x).all()

    def step(self, u=None):
        self.t += self.h
        if u is not None:
            self.u[:] = u
        self._call(self._step)

    def run(self, seconds):
        for _ in range(round(seconds * 1e9 / self.h)):
            self.step()
        return self

    def __getitem__(self, name):
        k = 0
        for port in COMPONENT.outputs(self.parameters):
            if port.name == name:
                return self.y[k : k + port.size].reshape(port.shape).copy()
            k += port.size
        raise KeyError(name)


SUPPLY, SEMISUBMERSIBLE = (
    published(f"{ship}_linear.yaml", f"{ship}_windage.yaml", f"{ship}.yaml")
    for ship in ("supply_vessel", "semisubmersible")
)
CYBERSHIP = published("cybership_ii.yaml")
BARE = {"surge_mass": 2.0, "sway_mass": 3.0, "yaw_inertia": 4.0, "max_speed": 10.0}


def test_supply_vessel_is_the_published_one():
    """Fossen et al. 1996: dimensionless M and D of MSS's supply.m, made dimensional by the Bis system; 4 digits."""
    length, g, mass = 76.2, 9.81, 6000e3
    m = np.array([[1.1274, 0, 0], [0, 1.8902, -0.0744], [0, -0.0744, 0.1278]])
    d = np.array([[0.0358, 0, 0], [0, 0.1183, -0.0124], [0, -0.0041, 0.0308]])
    scale = np.array([1.0, 1.0, length])
    m, d = mass * m * np.outer(scale, scale), mass * np.sqrt(g / length) * d * np.outer(scale, scale)
    names = [("surge_mass", m[0, 0]), ("sway_mass", m[1, 1]), ("sway_yaw_mass", m[1, 2]), ("yaw_inertia", m[2, 2])]
    names += [("surge_damping", d[0, 0]), ("sway_damping", d[1, 1]), ("sway_yaw_damping", d[1, 2])]
    names += [("yaw_sway_damping", d[2, 1]), ("yaw_damping", d[2, 2])]
    for name, value in names:
        assert SUPPLY[name] == pytest.approx(value, rel=1e-4), name


def test_cybership_is_the_published_one():
    """Skjetne et al. 2004: M_11 = m - X_u', M_22 = m - Y_v', M_23 = m x_g, M_33 = I_z - N_r'."""
    m, x_g, i_z = 23.8, 0.046, 1.76
    assert CYBERSHIP["surge_mass"] == pytest.approx(m + 2.0)
    assert CYBERSHIP["sway_mass"] == pytest.approx(m + 10.0)
    assert CYBERSHIP["sway_yaw_mass"] == pytest.approx(m * x_g)
    assert CYBERSHIP["yaw_inertia"] == pytest.approx(i_z + 1.0)


def test_semisubmersible_follows_from_its_stated_shape():
    """The file's own account in numpy: displacement, added masses, drag; the pontoons are the paper's (table 1)."""
    length, width, gap, rho = 97.5, 23.2, 32.8, 1026.9
    y, x = 0.5 * (gap + width), 38.0
    dry = rho * (2 * 0.9 * length * width * 10 + 4 * 14**2 * 10)
    columns, along = 4 * 1.51 * rho * np.pi * 49 * 10, 0.05 * rho * 2 * 0.9 * length * width * 10
    across = 2 * 1.7 * rho * np.pi * 25 * length
    yaw = dry * 35**2 + across * length**2 / 12 + along * y**2 + columns * (x**2 + y**2)
    p = SEMISUBMERSIBLE
    assert p["surge_mass"] == pytest.approx(dry + columns + along, rel=0.01)
    assert p["sway_mass"] == pytest.approx(dry + columns + across, rel=0.01)
    assert p["yaw_inertia"] == pytest.approx(yaw, rel=0.02)
    assert p["damping"]["surge_surge"] == pytest.approx(0.5 * rho * (2 * 10 * width + 4 * 140 * 1.5), rel=0.01)
    vessel = Vessel(0.5, (15.0, 0.0, 0.0), **p | {"takes_wind": True}).run(600.0)
    assert 0.2 < vessel["low.velocity"][0] < 1.0  # it drifts away with the wind, in minutes


def test_surge_decays_as_the_closed_form():
    """Linear damping: the path u0 m / d (1 - exp(-d t / m)); quadratic: u = u0 / (1 + k u0 t / m). Second order."""
    linear, quadratic = [], []
    for h in (0.2, 0.1, 0.05):
        a = Vessel(h, **BARE, surge_damping=0.5, velocity=(2.0, 0.0)).run(4.0)
        b = Vessel(h, **BARE, damping={"surge_surge": 0.5}, velocity=(2.0, 0.0)).run(4.0)
        linear.append(abs(a["low.position"][0] - 2 * 4 * (1 - np.exp(-1.0))))
        quadratic.append(abs(b["low.velocity"][0] - 2 / (1 + 0.5 * 2 * 4 / 2)))
    for errors in (linear, quadratic):
        assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
        assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


def rates(p, current=(0.0, 0.0)):
    """The equations of motion in plain numpy, from Fossen 2011, eqs. 6.43, 6.53 and 7.75, for scipy."""
    d = p["damping"]
    mass = np.array([[p["surge_mass"], 0, 0], [0, p["sway_mass"], p["sway_yaw_mass"]]])
    mass = np.vstack([mass, [0, p["sway_yaw_mass"], p["yaw_inertia"]]])

    def derivative(_, state, tau):
        _, _, psi, u, v, r = state
        c, s = np.cos(psi), np.sin(psi)
        water = np.array([c * current[0] + s * current[1], c * current[1] - s * current[0], 0.0])
        ur, vr, _ = nu = np.array([u, v, r]) - water
        a, b = mass[1, 1] * vr + mass[1, 2] * r, mass[0, 0] * ur
        coriolis = np.array([[0, 0, -a], [0, 0, b], [a, -b, 0]]) @ nu
        x = (p["surge_damping"] + d["surge_surge"] * abs(ur) + d["surge_cubed"] * ur**2) * ur
        parts = []
        for row in ("sway", "yaw"):
            own, cross = (p["sway_damping"], p["sway_yaw_damping"])
            if row == "yaw":
                own, cross = p["yaw_sway_damping"], p["yaw_damping"]
            k = [d[f"{row}_{of}"] for of in ("sway", "turning", "drifting", "yaw")]
            parts.append((own + k[0] * abs(vr) + k[1] * abs(r)) * vr + (cross + k[2] * abs(vr) + k[3] * abs(r)) * r)
        drag = np.array([x, *parts])
        relative = np.linalg.solve(mass, tau - coriolis - drag)
        carried = np.array([r * water[1], -r * water[0], 0.0])  # the steady current's rate in the turning frame
        return [c * u - s * v, s * u + c * v, r, *(relative + carried)]

    return derivative


@pytest.mark.parametrize(
    ("name", "tau", "seconds"), [("cybership", (2.0, 0.1, 0.3), 20.0), ("supply", (2e5, 5e4, 4e6), 200.0)]
)
def test_turning_under_thrust_in_a_current_is_that_of_scipy(name, tau, seconds):
    """DOP853 at 1e-11. Second order: half the step, a quarter of the error; at the usual step under 1 % of the path."""
    p = CYBERSHIP if name == "cybership" else SUPPLY
    current = (0.05, -0.1) if name == "cybership" else (0.3, -0.5)
    start = [0.0, 0.0, 0.7, 0.1, 0.0, 0.0]
    truth = solve_ivp(rates(p, current), (0, seconds), start, "DOP853", rtol=1e-11, atol=1e-12, args=(np.array(tau),))
    usual, errors = seconds / 200, []
    for h in (usual, usual / 2, usual / 4):
        vessel = Vessel(
            h, [*tau, *current, 0.0], **p | {"takes_thrust": True, "takes_current": True, "heading": 0.7,
            "velocity": (0.1, 0.0)},
        ).run(seconds)  # fmt: skip
        errors.append(np.hypot(*(vessel["low.position"] - truth.y[:2, -1])))
    path = np.hypot(*np.diff(truth.y[:2])).sum()
    assert errors[0] < 0.01 * path
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)
    assert vessel["validity.balance"] <= 1.0


def test_steady_turn_balances():
    """Fossen 2011, chapter 12: at the end of a turn M nu' vanishes and C nu + D nu = tau, in numpy; to 1e-6."""
    tau = np.array([1e5, 0.0, 3e6])
    vessel = Vessel(0.5, tau, **SUPPLY | {"takes_thrust": True}).run(3000.0)
    nu = np.array([*vessel["low.velocity"], vessel["low.yaw_rate"]])
    left = rates(SUPPLY)(0.0, [0.0, 0.0, 0.0, *nu], tau)[3:]
    assert abs(np.array(left)).max() < 1e-6 * abs(nu).max()
    assert nu[2] > 0.0  # a moment to starboard turns to starboard


def test_no_damping_keeps_the_energy():
    """C(nu) does no work: the energy of a tumbling body drifts by the scheme's dissipation only, third order in h."""
    p = BARE | {"sway_yaw_mass": 0.6, "velocity": (1.0, 0.4), "yaw_rate": 0.3}
    m = np.array([[2.0, 0, 0], [0, 3.0, 0.6], [0, 0.6, 4.0]])
    start = np.array([1.0, 0.4, 0.3])
    losses = []
    for h in (0.1, 0.05):
        vessel = Vessel(h, **p).run(10.0)
        nu = np.array([*vessel["low.velocity"], vessel["low.yaw_rate"]])
        losses.append(abs(nu @ m @ nu / (start @ m @ start) - 1.0))
    assert losses[0] < 2e-3
    assert losses[0] / losses[1] > 3.5


def test_current_is_a_moving_frame():
    """Galilei: in a steady current the vessel moves as without, and with it; to roundings."""
    current, tau = np.array([0.4, -0.3, 0.0]), [1.5, 0.2, 0.1]
    p = CYBERSHIP | {"takes_thrust": True, "heading": 0.3}
    still = Vessel(0.1, tau, **p).run(30.0)
    c, s = np.cos(0.3), np.sin(0.3)
    along = (c * current[0] + s * current[1], c * current[1] - s * current[0])
    moved = Vessel(0.1, [*tau, *current], **p | {"takes_current": True, "velocity": along}).run(30.0)
    assert moved["low.heading"] == pytest.approx(still["low.heading"], abs=1e-10)
    assert moved["low.position"] - 30.0 * current[:2] == pytest.approx(still["low.position"], abs=1e-9)
    assert moved["water_velocity"] == pytest.approx(still["low.velocity"], abs=1e-10)


def test_cross_flow_drag_is_the_integral_over_the_hull():
    """Pure sway: rho C_D T L v^2 / 2. Pure yaw: moment rho C_D T L^4 r^2 / 64 (Faltinsen 1990, eq. 6.6)."""
    flow = {"length": 40.0, "draught": 5.0, "coefficient": 0.8}
    p = BARE | {"sway_mass": 2e6, "yaw_inertia": 4e8, "cross_flow": flow, "water_density": 1000.0}
    sway = Vessel(0.1, **p | {"velocity": (0.0, 1.5)})
    assert sway["hook_a.acceleration"][1] * 2e6 == pytest.approx(-0.5 * 1000 * 0.8 * 5 * 40 * 1.5**2, rel=1e-9)
    yaw = Vessel(0.1, **p | {"yaw_rate": 0.1, "hook_a": (1.0, 0.0, 0.0)})
    moment = yaw["hook_a.acceleration"][1] * 4e8
    assert moment == pytest.approx(-1000 * 0.8 * 5 * 40**4 * 0.1**2 / 64, rel=5.1e-3)  # 20 strips: 2 / 20^2


def blown(angle, speed=10.0):
    """Wind load on the supply vessel at rest, heading north, with the wind from an angle to the bow."""
    wind = [-speed * np.cos(angle), -speed * np.sin(angle), 0.0]
    vessel = Vessel(0.1, wind, **SUPPLY | {"takes_wind": True})
    return np.array([*vessel["wind_load.force"], vessel["wind_load.moment"]])


def test_wind_load_is_blendermanns():
    """Blendermann 1994 as Fossen 2011, eqs. 8.30-8.34, in numpy by the angle gamma; it pushes to where it blows."""
    a = SUPPLY["windage"]
    for gamma in np.radians([0, 30, 60, 90, 120, 150, 180]):
        cd = a["ahead"] if gamma <= np.pi / 2 else a["astern"]
        lengthwise = cd * a["frontal_area"] / a["lateral_area"]
        below = 1 - 0.5 * a["shape"] * (1 - lengthwise / a["cross"]) * np.sin(2 * gamma) ** 2
        cx, cy = -cd * np.cos(gamma) / below, -a["cross"] * np.sin(gamma) / below
        cn = (a["centroid"] / a["length"] - 0.18 * (gamma - np.pi / 2)) * cy
        q = 0.5 * 1.247 * 100.0
        expected = q * np.array([cx * a["frontal_area"], cy * a["lateral_area"], cn * a["lateral_area"] * a["length"]])
        scale = q * a["lateral_area"] * np.array([1, 1, a["length"]])
        assert abs(blown(gamma) - expected).max() < 1e-9 * scale.max()
        assert blown(-gamma) == pytest.approx(blown(gamma) * [1, -1, -1], abs=1e-9 * scale.max())
    assert blown(0.0)[0] < 0
    assert blown(np.pi / 2)[1] < 0


def sea(rows):
    """Input `sea` of components (amplitude, frequency, direction, phase) in deep water."""
    a, omega, beta, phase = np.array(rows).T
    return np.concatenate([a, omega, omega**2 / 9.80665, beta, phase])


def test_long_waves_carry_the_vessel_as_the_water():
    """For waves much longer than the hull it follows the surface and its slope, and moves along as the water does.

    To 6 %: k B = 5 % is the damping's part at 0.16 rad/s, directions between two of the table's are 0.9 % off; roll is
    nearer to its resonance, (0.16 / 0.6)^2 = 7 %.
    """
    omega, a = 0.16, 1.3
    k = omega**2 / 9.80665
    for beta in (0.0, 0.6, np.pi / 2, 2.5, np.pi, -0.6, -2.0):
        for t in (0.0, 3.0, 11.0):
            vessel = Vessel(0.1, sea([(a, omega, beta, 0.3)]), t0=t, **SUPPLY | {"waves": 1, "heading": 0.0})
            theta = -omega * t + 0.3
            slope = -a * k * np.sin(theta)  # of the elevation, along its way
            roll, pitch, _ = vessel["attitude"]
            north, east, down = vessel["position"]
            assert down == pytest.approx(-a * np.cos(theta), abs=0.06 * a)
            assert pitch == pytest.approx(slope * np.cos(beta), abs=0.06 * a * k)
            assert roll == pytest.approx(-slope * np.sin(beta), abs=0.1 * a * k)
            orbit = -a * np.sin(theta)  # of the water along the wave's way: Airy
            assert (north, east) == pytest.approx((orbit * np.cos(beta), orbit * np.sin(beta)), abs=0.06 * a)


@pytest.mark.parametrize(("waves", "yaw_rate", "error"), [((), 0.5, 1e-5), ([1.0, 0.5], 0.002, 0.01)])
def test_motion_of_points_is_differentiated(waves, yaw_rate, error):
    """Central differences of the hook's position and velocity over 1 ms, while the vessel turns, in two waves or none.

    Waves: how the response changes with the heading is left out of its rates, 2 r / omega = 0.6 % of the acceleration.
    """
    u = sea([(a, 0.7 + 0.4 * i, 0.4 - i, 1.0 + i) for i, a in enumerate(waves)]) if waves else ()
    vessel = Vessel(1e-3, u, **SUPPLY | {"waves": len(waves), "velocity": (0.5, 0.2), "yaw_rate": yaw_rate})
    vessel.run(0.5)
    rows = []
    for _ in range(3):
        vessel.step()
        rows.append([vessel[f"hook_a.{of}"] for of in ("position", "velocity", "acceleration")])
    before, at, after = np.array(rows)
    assert (after[0] - before[0]) / 2e-3 == pytest.approx(at[1], abs=error * abs(at[1]).max())
    assert (after[1] - before[1]) / 2e-3 == pytest.approx(at[2], abs=error * abs(at[2]).max())


def test_drift_is_newmans():
    """The double sum over pairs with the mean of their coefficients, in numpy; its mean is sum a^2 D."""
    rng = np.random.default_rng(4)
    n = 7
    rows = np.column_stack(
        [rng.uniform(0.2, 1, n), rng.uniform(0.4, 1.5, n), rng.uniform(-3, 3, n), rng.uniform(0, 6, n)]
    )
    t = 12.5
    vessel = Vessel(0.1, sea(rows), t0=t, **SUPPLY | {"waves": n})
    single = []
    for row in rows:
        alone = Vessel(0.1, sea([(1.0, *row[1:])]), **SUPPLY | {"waves": 1})
        single.append([*alone["drift_load.force"], alone["drift_load.moment"]])
    d, theta, a = np.array(single), rows[:, 3] - rows[:, 1] * t, rows[:, 0]
    mean = 0.5 * (d[:, None, :] + d[None, :, :])
    expected = np.einsum("i,j,ijk,ij->k", a, a, mean, np.cos(theta[:, None] - theta[None, :]))
    drift = np.array([*vessel["drift_load.force"], vessel["drift_load.moment"]])
    assert drift == pytest.approx(expected, rel=1e-9, abs=1e-6)
    ahead = Vessel(0.1, sea([(1.0, 1.8, np.pi, 0.0)]), **SUPPLY | {"waves": 1})["drift_load.force"]
    assert ahead[0] == pytest.approx(-0.5 * 1026.9 * 9.80665 * 18 * 0.6, rel=0.05)  # short head seas: all thrown back


def test_table_of_responses_gives_back_what_was_written():
    """At the grid's points and mirrored for the other side."""
    rows = []
    for frequency in (0.5, 1.0):
        for j, direction in enumerate((0.0, np.pi / 2, np.pi)):
            rows.append(
                {"frequency": frequency, "direction": direction, "shift": (0.1, 0.2 + j, 0.3), "drift_moment": 5.0,
                 "shift_phase": (0.0, 0.5, np.pi), "turn": (0.01, 0.02, 0.03), "turn_phase": (0.0, 1.0, 2.0)}
            )  # fmt: skip
    p = SUPPLY | {"hull": None, "responses": tuple(rows), "waves": 1}
    star = Vessel(0.1, sea([(1.0, 1.0, np.pi / 2, 0.0)]), **p)
    port = Vessel(0.1, sea([(1.0, 1.0, -np.pi / 2, 0.0)]), **p)
    assert star["position"] == pytest.approx([0.1, 1.2 * np.cos(0.5), -0.3], abs=1e-12)
    assert port["position"] == pytest.approx([0.1, -1.2 * np.cos(0.5), -0.3], abs=1e-12)
    assert star["attitude"] == pytest.approx([0.01, 0.02 * np.cos(1), 0.03 * np.cos(2)], abs=1e-12)
    assert port["attitude"] == pytest.approx([-0.01, 0.02 * np.cos(1), -0.03 * np.cos(2)], abs=1e-12)
    with pytest.raises(ValueError, match="one for each pair"):
        COMPONENT.parameters(**p | {"responses": tuple(rows[:-1])})


def test_bessel_functions_and_reflection():
    """Abramowitz and Stegun, table 9.8: I_1(1) = 0.565159104, K_1(1) = 0.601907230; Ursell's limits 0 and 1."""
    i1, k1 = closed_form.first_order_bessel(np.array([1.0]))
    assert i1[0] == pytest.approx(0.565159104, rel=1e-9)
    assert k1[0] == pytest.approx(0.601907230, rel=1e-8)
    r = closed_form.reflected(np.array([1e-3, 10.0]), 1.0)
    assert r[0] < 1e-8
    assert r[1] == pytest.approx(1.0, abs=1e-6)


def law(force, reference, mass):
    return np.concatenate([force, reference, np.ravel(mass)])


def test_line_law_is_in_the_balance():
    """A plain force of what the law gives at the accelerations found makes the same motion; the solver's tolerance."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    g, reference, pull = 40.0 * root @ root.T, 0.1 * rng.normal(size=3), 5.0 * rng.normal(size=3)
    p = CYBERSHIP | {"velocity": (0.4, 0.1), "yaw_rate": 0.2, "heading": 1.1, "hook_a": (-0.55, 0.1, 0.0)}
    tied = Vessel(0.1, law(pull, reference, g), **p | {"takes_law_a": True})
    free = Vessel(0.1, np.zeros(3), **p | {"takes_force_a": True})
    free.x[:] = tied.x
    for _ in range(5):
        tied.step()
        force = pull - g @ (tied["hook_a.acceleration"] - reference)
        free.step(force)
        assert free["hook_a.acceleration"] == pytest.approx(tied["hook_a.acceleration"], abs=1e-9)
        assert free["low.position"] == pytest.approx(tied["low.position"], abs=1e-12)


def test_accelerance_is_the_slope_of_the_acceleration():
    """Central differences by a force at the hook; what is not symmetric (drag, turning) is of the order of the step."""
    h = 0.01
    p = CYBERSHIP | {"velocity": (0.3, 0.1), "yaw_rate": 0.2, "heading": 0.5, "hook_a": (-0.5, 0.1, 0.0)}
    both = {"takes_law_a": True, "takes_force_a": True}
    start = Vessel(h, np.zeros(18), **p | both).run(0.1)
    slopes = []
    for j in range(3):
        found = []
        for sign in (1, -1):
            vessel = Vessel(h, np.zeros(18), **p | both)
            vessel.x[:], vessel.t = start.x, start.t
            u = np.zeros(18)
            u[j] = sign * 1e-3
            vessel.step(u)
            found.append(vessel["hook_a.acceleration"])
        slopes.append((found[0] - found[1]) / 2e-3)
    told, slopes = vessel["accelerance_a"], np.array(slopes).T
    assert np.array_equal(told, told.T)
    assert np.abs(told - slopes).max() < 0.02 * np.abs(slopes).max()
    assert not told[2].any()  # no line lifts a ship


def pull_by_spring(vessel, k):
    """A step with a spring to the origin as the line on hook_a: its law about the motion that the last round found."""
    h, before = vessel.h * 1e-9, vessel.x.copy()
    a = vessel["hook_a.acceleration"]
    at = vessel["hook_a.position"] + h * vessel["hook_a.velocity"] + 0.5 * h * h * a
    for k_round in range(3):
        vessel.x[:] = before
        vessel.u[:] = law(-k * at * [1, 1, 0], a, 0.5 * h * h * k * np.diag([1.0, 1.0, 0.0]))
        vessel.step()
        vessel.t -= vessel.h if k_round < 2 else 0
        at, a = vessel["hook_a.position"], vessel["hook_a.acceleration"]


def test_hook_of_a_tied_vessel_has_second_order():
    """A spring of 3 N/m on the hook of a turning ASV, against DOP853 of the equations with it."""
    k, arm, seconds = 3.0, -0.55, 8.0
    derivative = rates(CYBERSHIP)

    def tied(t, state):
        c, s = np.cos(state[2]), np.sin(state[2])
        n, e = -k * (state[:2] + arm * np.array([c, s]))
        ahead, across = c * n + s * e, c * e - s * n
        return derivative(t, state, np.array([ahead, across, arm * across]))

    start = [1.0, 0.4, 0.8, 0.0, 0.0, 0.0]
    truth = solve_ivp(tied, (0, seconds), start, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    p, errors = CYBERSHIP | {"position": (1.0, 0.4), "heading": 0.8}, []
    for h in (0.2, 0.1, 0.05):
        vessel = Vessel(h, np.zeros(15), **p | {"takes_law_a": True})
        pull = -k * vessel["hook_a.position"] * [1, 1, 0]
        vessel.x[:] = Vessel(h, pull, **p | {"takes_force_a": True}).x  # accelerations that know of the spring
        for _ in range(round(seconds / h)):
            pull_by_spring(vessel, k)
        errors.append(np.hypot(*(vessel["low.position"] - truth[:2])))
    assert errors[0] < 0.02
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.3)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({"sway_yaw_mass": 1e3}, "not positive"),
        ({"takes_wind": True}, "needs windage"),
        ({"waves": 3}, "needs hull or responses"),
    ],
)
def test_what_does_not_fit_is_refused(more, text):
    with pytest.raises(ValueError, match=text):
        COMPONENT.parameters(**BARE | more)
