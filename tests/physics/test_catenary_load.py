"""The static line in any load field, on a seabed with friction, and how far it is valid."""

from decimal import Decimal, localcontext
from math import asinh, cos, hypot, inf, radians, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from components.compiled import functions
from components.tether.catenary.component import COMPONENT
from components.tether.catenary.elastic import elastic
from components.tether.catenary.hang import hang
from components.tether.catenary.line import rest
from components.tether.catenary.status import END_BELOW_SEABED, NEUTRAL_SLACK, NO_ANCHOR, TAUT, TEXT, TOO_SHORT

_, step = functions(COMPONENT)
STILL = (np.zeros(6), np.zeros(6))


def run(a, b, motion=STILL, load_input=None, **parameters):
    """(status, outputs by name) for ends at a and b; every output not written would stay NaN."""
    kind = COMPONENT.parameters(**{"length": 3.5, "load_input": load_input is not None, **parameters})
    u = np.concatenate([a, motion[0], b, motion[1], [] if load_input is None else load_input])
    ports = COMPONENT.outputs(kind)
    y = np.full(sum(port.size for port in ports), np.nan)
    status = step(0, 10**7, COMPONENT.pack(kind), u, np.empty(0), y, np.empty(0))
    edges = np.cumsum([0, *(port.size for port in ports)])
    named = {port.name: y[i:j].reshape(port.shape) for port, i, j in zip(ports, edges[:-1], edges[1:], strict=True)}
    assert status or np.isfinite(y).all()
    return status, named


# --- any load ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("ea", [None, 20.0])
def test_turning_everything_turns_the_result(seed, ea):
    # Frame invariance, to 1e-12 of the length and of the load: rounding of the turned vectors times the slack's
    # condition, which is below 100 at these distances (0.1 to 0.9 of the length).
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    a, d = random.normal(size=3), random.normal(size=3)
    b = a + d / np.linalg.norm(d) * 3.5 * random.uniform(0.1, 0.9)
    q = 0.9 * random.normal(size=3)
    _, plain = run(a, b, load=tuple(q), axial_stiffness=ea)
    _, turned = run(turn @ a, turn @ b, load=tuple(turn @ q), axial_stiffness=ea)
    size = np.linalg.norm(q) * 3.5
    np.testing.assert_allclose(turned["nodes"], plain["nodes"] @ turn.T, atol=1e-12 * 3.5)
    np.testing.assert_allclose(turned["tension"], plain["tension"], atol=1e-12 * size)
    for force in ("force_a", "force_b"):
        np.testing.assert_allclose(turned[force], turn @ plain[force], atol=1e-12 * size)


@pytest.mark.parametrize("q", [(0.5, -0.3, 0.9), (1.0, 0.0, 0.0), (0.0, -2.0, 1e-9), (1e-3, 0.0, -0.7)])
@pytest.mark.parametrize("ea", [None, 5.0])
def test_against_integration_of_the_balance(q, ea):
    # dT/ds = -q, dr/ds = (1/|T| + 1/EA) T from end a with the force found, by DOP853 at 1e-12.
    a, b = np.array([0.2, 0.1, 0.4]), np.array([1.1, -1.4, 1.6])
    _, y = run(a, b, load=q, axial_stiffness=ea)
    flexibility = 0.0 if ea is None else 1.0 / ea

    def rate(s, r):
        T = y["force_a"] - np.array(q) * s
        return T * (1.0 / np.linalg.norm(T) + flexibility)

    s = np.linspace(0.0, 3.5, 21)
    path = solve_ivp(rate, (0.0, 3.5), a, "DOP853", s, rtol=1e-12, atol=1e-13).y.T
    np.testing.assert_allclose(y["nodes"], path, atol=1e-10)
    np.testing.assert_allclose(y["nodes"][-1], b, atol=1e-14 * 3.5)
    np.testing.assert_allclose(y["force_a"] + y["force_b"], np.array(q) * 3.5, atol=1e-13)


def test_vertical_load_is_the_weight_to_the_last_bit():
    a, b = np.array([0.2, 0.1, 0.4]), np.array([1.1, -1.4, 1.6])
    weight, load = (run(a, b, **one)[1] for one in ({"weight": 0.9}, {"load": (0.0, 0.0, 0.9)}))
    for name, values in weight.items():
        np.testing.assert_array_equal(values, load[name])


def test_load_from_outside_adds_to_the_parameters():
    a, b = np.array([0.2, 0.1, 0.4]), np.array([1.1, -1.4, 1.6])
    whole = run(a, b, load=(0.25, -0.5, 0.75))[1]
    split = run(a, b, load_input=(0.25, -0.5, 0.25), load=(0.0, 0.0, 0.5))[1]
    for name, values in whole.items():
        np.testing.assert_array_equal(values, split[name])


@pytest.mark.parametrize(("separation", "length"), [(1.0, 1.2), (8.0, 10.0), (3.0, 9.0)])
def test_towed_across_the_water_against_bhattacharya_eq_9(separation, length):
    # Two boats side by side at speed v tow a floating rope: y = T_x/(c v) (cosh(c v x/T_x) - 1), with T_x from
    # the length, 2 T_x/(c v) sinh(c v D/(2 T_x)) = L, solved here by Brent. Tolerance: Brent's on the parameter.
    c, v = 0.05, 1.4
    half = brentq(lambda u: np.sinh(u) / u - length / separation, 1e-6, 20.0, xtol=1e-14)
    T_x = c * v * separation / (2.0 * half)
    a, b = np.array([0.0, 0.0, 0.0]), np.array([0.0, separation, 0.0])
    _, y = run(a, b, length=length, load=(-c * v, 0.0, 0.0), segments=30)
    across = y["nodes"][:, 1] - separation / 2.0
    sag = T_x / (c * v) * (np.cosh(half) - 1.0)
    np.testing.assert_allclose(
        y["nodes"][:, 0] + sag, T_x / (c * v) * (np.cosh(c * v * across / T_x) - 1.0), atol=1e-11
    )
    assert y["horizontal_tension"] == pytest.approx(T_x, rel=1e-11)
    assert y["sag"] == pytest.approx(sag, rel=1e-11)
    assert (y["nodes"][:, 2] == 0.0).all()


@pytest.mark.parametrize("inclination_deg", [0.0, 1.0, 30.0, 60.0, 89.0])
def test_inclined_catenary_lies_in_drupts_plane(inclination_deg):
    # Drupt et al. 2022, eqs. 6-8: a side load tilts the plane through both (level) ends by alpha = atan(side/weight),
    # and in that plane the line is the vertical catenary of the resulting load. Roundings of 3.5 m.
    alpha = radians(inclination_deg)
    side, down = 0.9 * sin(alpha), 0.9 * cos(alpha)
    _, y = run(np.zeros(3), np.array([2.0, 0.0, 0.0]), load=(0.0, side, down), segments=40)
    _, upright = run(np.zeros(3), np.array([2.0, 0.0, 0.0]), load=(0.0, 0.0, 0.9), segments=40)
    depth = upright["nodes"][:, 2]
    np.testing.assert_allclose(y["nodes"][:, 1], depth * sin(alpha), atol=2e-14)
    np.testing.assert_allclose(y["nodes"][:, 2], depth * cos(alpha), atol=2e-14)
    np.testing.assert_allclose(y["tension"], upright["tension"], rtol=1e-13)


@pytest.mark.parametrize("q", [(0.5, -0.3, 0.9), (0.0, 0.0, -0.9), (2.0, 0.0, 0.0)])
@pytest.mark.parametrize("chord", [0.0, 1e-9, 0.5, 0.9999, 1.0001, 1.3])
@pytest.mark.parametrize("ea", [1e-1, 1e3, 1e9])
def test_ends_along_the_load_and_stiffness_from_soft_to_rigid(q, chord, ea):
    # The end force at a, walked along the closed form by quadrature of 20 Gauss points on each side of the turning
    # point, ends at b; along the load the force is exact to rounding times stiffness (EA 1e9 m stretches 1e-9 m/N).
    up = -np.array(q) / np.linalg.norm(q)
    _, y = run(np.zeros(3), up * 3.5 * chord, load=q, axial_stiffness=ea)
    np.testing.assert_allclose(y["nodes"][-1], up * 3.5 * chord, atol=3e-15 * (3.5 + np.abs(y["nodes"]).max()))
    np.testing.assert_allclose(y["force_a"] + y["force_b"], np.array(q) * 3.5, atol=1e-14 * (1.0 + y["tension"].max()))


@pytest.mark.parametrize("segments", [1, 2, 500])
def test_any_number_of_segments_gives_the_same_force(segments):
    a, b = np.zeros(3), np.array([2.0, 0.5, 0.3])
    force = run(a, b, weight=0.9, segments=segments)[1]["force_a"]
    np.testing.assert_array_equal(force, run(a, b, weight=0.9)[1]["force_a"])


def test_load_that_fades_ends_in_the_straight_line_or_in_a_refusal():
    # A taut line tends to the spring; a slack one keeps its shape whatever the size of the load, until there is none.
    a, b = np.zeros(3), np.array([3.0, 2.5, 0.0])
    for q in (1e-12, 1e-16, 1e-22, 1e-100, 1e-250, 1e-310, 0.0):
        status, y = run(a, b, load=(0.0, 0.0, q), axial_stiffness=50.0)
        stretch = hypot(3.0, 2.5) / 3.5 - 1.0
        assert status == 0
        np.testing.assert_allclose(y["tension"], 50.0 * stretch, rtol=1e-12)
    shapes = [run(a, 0.5 * b, load=(q, 0.0, q))[1]["nodes"] for q in (1.0, 1e-12, 1e-150)]
    np.testing.assert_allclose(shapes[1:], [shapes[0]] * 2, atol=1e-13)
    assert run(a, 0.5 * b, load=(0.0, 0.0, 0.0))[0] == NEUTRAL_SLACK


# --- seabed with friction ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("ea", [1e5, 300.0, 20.0])
@pytest.mark.parametrize("mu", [0.1, 0.7, 3.0])
@pytest.mark.parametrize("span", [2.6, 3.0, 3.3])
def test_friction_against_jonkman(mu, ea, span):
    # Anchor on the seabed, fairlead 1 m above: Jonkman 2007, NREL/TP-500-41958, eqs. 2-37a, b for the place of the
    # fairlead from H and V, and 2-38 for the anchor's force, friction included. Roundings of 3.5 m.
    w, L = 0.9, 3.5
    _, y = run([0.0, 0.0, 4.0], [span, 0.0, 3.0], weight=w, seabed=4.0, seabed_friction=mu, axial_stiffness=ea)
    H, V = y["horizontal_tension"], -y["force_b"][2] * -1.0
    lying = L - V / w
    assert y["touches_seabed"] == 1.0
    assert y["grounded_length"] == pytest.approx(lying, rel=1e-12)
    free = lying - H / (mu * w)
    held = mu * w / (2.0 * ea) * (-(lying**2) + free * max(free, 0.0))
    assert lying + H / w * asinh(V / H) + H * L / ea + held == pytest.approx(span, abs=2e-14 * L)
    assert H / w * (sqrt(1.0 + (V / H) ** 2) - 1.0) + V**2 / (2.0 * ea * w) == pytest.approx(1.0, abs=2e-14 * L)
    np.testing.assert_allclose(y["force_a"], [max(H - mu * w * lying, 0.0), 0.0, 0.0], atol=1e-13)
    s = np.linspace(0.0, L, 21)
    grounded = s < lying
    expected = np.maximum(H - mu * w * (lying - s[grounded]), 0.0)
    np.testing.assert_allclose(y["tension"][grounded], expected, atol=1e-13)
    np.testing.assert_allclose(y["nodes"][[0, -1]], [[0.0, 0.0, 4.0], [span, 0.0, 3.0]], atol=2e-14 * L)


@pytest.mark.parametrize("ea", [None, 50.0])
def test_anchor_at_end_b_is_the_mirror(ea):
    given = {"weight": 0.9, "seabed": 4.0, "seabed_friction": 0.4, "axial_stiffness": ea, "segments": 30}
    _, one = run([0.0, 0.0, 4.0], [3.0, 0.0, 3.0], **given)
    _, other = run([3.0, 0.0, 3.0], [0.0, 0.0, 4.0], **given)
    np.testing.assert_allclose(other["nodes"][::-1], one["nodes"], atol=1e-14 * 3.5)
    np.testing.assert_allclose(other["tension"][::-1], one["tension"], atol=1e-13)
    np.testing.assert_allclose(other["force_b"], one["force_a"], atol=1e-13)


def test_friction_changes_nothing_where_nothing_lies():
    free, rough = (
        run([0.0, 0.0, 4.0], [3.3, 0.0, 2.85], weight=0.9, seabed=4.0, seabed_friction=mu)[1] for mu in (0.0, 1.0)
    )
    assert free["touches_seabed"] == 0.0
    for name, values in free.items():
        np.testing.assert_array_equal(values, rough[name])


def test_friction_without_an_anchor_is_refused():
    given = {"weight": 0.9, "seabed": 4.0, "seabed_friction": 0.4}
    assert run([0.0, 0.0, 3.5], [2.0, 0.0, 3.0], **given)[0] == NO_ANCHOR
    assert "how the line was laid" in TEXT[NO_ANCHOR]
    assert run([0.0, 0.0, 4.5], [2.0, 0.0, 3.0], **given)[0] == END_BELOW_SEABED


def test_nothing_between_the_regimes_is_lost():
    # Chord, direction, elasticity, seabed and friction over all magnitudes, stiffness to 1e12 weights: none gives up.
    random = np.random.default_rng(1)
    grounded = 0
    for _ in range(10_000):
        chord = random.choice([random.uniform(), 1 - 10 ** random.uniform(-16, 0), 1 + 10 ** random.uniform(-16, 2)])
        angle = radians(random.choice([random.uniform(-90, 90), 90 - 10 ** random.uniform(-14, 1)]))
        e = 10 ** random.uniform(-12, 5)
        assert elastic(chord * cos(angle), chord * sin(angle), e)[0] == 0, (chord, angle, e)
        depth = random.choice([0.0, 10 ** random.uniform(-12, 0)])
        mu, e = random.choice([0.0, 10 ** random.uniform(-3, 2)]), random.choice([0.0, e])
        span = random.choice([random.uniform(0.0, 1.2), 1 - 10 ** random.uniform(-14, 0)])
        status, line = rest(span, -depth, e, 0.0, depth, mu)
        assert status in (0, *((TAUT, TOO_SHORT) if e == 0.0 and hypot(span, depth) >= 1.0 else ()))
        grounded += line.touches
    assert grounded > 3000


def far_end(line):
    """Where end b comes out, in 50 digits: Irvine 1981, section 1.2; on the bed Jonkman 2007, eqs. 2-37."""
    with localcontext() as context:
        context.prec = 50
        H, V, e, mu = (Decimal(float(value)) for value in (line.H, line.V, line.e, line.mu_a))
        half = Decimal("0.5")
        s_a, s_b = (Decimal(0), Decimal(float(line.s_b))) if line.touches else (half - V, half + V)
        T_a, T_b = (H * H + s_a * s_a).sqrt(), (H * H + s_b * s_b).sqrt()
        x = H * ((s_b + T_b) / H).ln() + H * ((s_a + T_a) / H).ln() + e * H * (s_a + s_b)
        z = T_b - T_a + e * (s_b * s_b - s_a * s_a) / 2
        if line.touches:
            loaded = min(1 - s_b, H / mu) if mu else 1 - s_b
            x += 1 - s_b + e * loaded * (H - mu * loaded / 2)
        return x, z


@pytest.mark.parametrize("seed", range(4))
def test_random_lines_against_fifty_digits(seed):
    # Nearly coincident to nearly straight and stretched threefold, level to upright, EA from 1e-2 to 1e10 weights and
    # rigid, hanging or on a bed with friction. Tolerance: two roundings of the extent hanging, some more
    # on the bed, whose parts add up. 100 000 such lines tried by hand missed by 4.9e-16 and 1.7e-15.
    random = np.random.default_rng(seed)
    solved = grounded = 0
    for _ in range(600):
        near = 10 ** random.uniform(-12.0, 0.0)
        chord = random.choice([random.uniform(), 1.0 - near, near, 1.0 + 10 ** random.uniform(-12.0, 0.3)])
        angle = radians(random.choice([random.uniform(-90.0, 90.0), 90.0 - 10 ** random.uniform(-10.0, 1.0), 0.0]))
        h, v, e = chord * cos(angle), chord * sin(angle), random.choice([0.0, 10 ** random.uniform(-10.0, 2.0)])
        mu, bed = 0.0, (inf, inf)
        if random.uniform() < 0.4:
            h, v = random.choice([random.uniform(0.0, 1.2), 1.0 - near]), 10 ** random.uniform(-8.0, -0.2)
            mu, bed = random.choice([0.0, 10 ** random.uniform(-2.0, 1.5)]), (0.0, v)
        status, line = rest(h, v, e, *bed, mu)
        if status or line.H == 0.0:
            assert e == 0.0 or line.touches or h == 0.0
            continue
        x, z = far_end(line)
        miss = hypot(float(x - Decimal(float(h))), float(z - Decimal(float(v))))
        allowed = (2e-15 if line.touches else 5e-16) * max(1.0, hypot(h, v))
        assert miss <= allowed, (h, v, e, mu)
        solved, grounded = solved + 1, grounded + line.touches
    assert solved > 300
    assert grounded > 40


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({}, "weight and load: neither"),
        ({"weight": 1.0, "load": (0.0, 0.0, 1.0)}, "weight and load: both"),
        ({"load": (0.1, 0.0, 1.0), "seabed": 4.0}, "on a level seabed the load must be vertical"),
        ({"load": (0.0, 0.0, -1.0), "seabed": 4.0}, "load is -1 N/m down: only a line heavier than water"),
        ({"weight": 1.0, "seabed": 4.0, "load_input": True}, "load_input is true"),
        ({"weight": 1.0, "seabed_friction": 0.5}, "seabed_friction is 0.5 without a seabed"),
    ],
)
def test_impossible_parameters_are_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        COMPONENT.parameters(length=3.5, **wrong)


# --- the plain function ------------------------------------------------------------------------------------------


def test_plain_function_agrees_with_the_component():
    line = hang(3.5, (0.5, -0.3, 0.9), 2.0, 0.7, 40.0)
    _, y = run([0.0, 0.0, 0.0], [2.0, 0.0, -0.7], load=(0.5, -0.3, 0.9), axial_stiffness=40.0)
    np.testing.assert_array_equal([line.force_a_N, line.force_b_N], [y["force_a"], y["force_b"]])
    assert line.sag_m == y["sag"]
    line = hang(3.5, 0.9, 3.0, 1.0, 40.0, 0.0, 0.5)
    given = {"weight": 0.9, "axial_stiffness": 40.0, "seabed": 4.0, "seabed_friction": 0.5}
    _, y = run([0.0, 0.0, 4.0], [3.0, 0.0, 3.0], **given)
    np.testing.assert_array_equal([line.force_a_N, line.force_b_N], [y["force_a"], y["force_b"]])
    assert (line.grounded_m, line.H_N, line.sag_m) == (y["grounded_length"], y["horizontal_tension"], y["sag"])
    neutral = hang(1.0, 0.0, 3.0, 4.0, 10.0)  # 40 N along (3, 4)/5
    assert (neutral.H_N, neutral.V_a_N, neutral.V_b_N) == pytest.approx((24.0, -32.0, 32.0), rel=1e-14)


# --- validity ----------------------------------------------------------------------------------------------------

JUDGED = {"weight": 0.9, "drag_diameter": 0.01, "virtual_mass": 0.12, "bending_stiffness": 1e-3, "axial_stiffness": 1e4}


def test_only_what_can_be_judged_is_told():
    some = run(np.zeros(3), [2.0, 0.0, 0.0], weight=0.9)[1]
    assert [name for name in some if name.startswith("validity")] == [
        "validity.range",
        "validity.inertia",
        "validity.wave",
    ]


@pytest.mark.parametrize("span", [1.0, 2.5, 3.4])
def test_drag_is_at_the_border_where_it_shifts_the_line_by_the_tolerance(span):
    # The side load of the drag at the end's speed, put on as a load, moves the line by the tolerated shift: the tilted
    # plane's largest displacement, against the estimate with the half axis of the ellipse, within 25 %.
    ends = np.zeros(3), np.array([span, 0.0, 0.0])
    still = run(*ends, **JUDGED, segments=100)[1]
    speed = 0.1
    moving = run(*ends, motion=(np.zeros(6), np.array([0.0, speed, 0.0, 0.0, 0.0, 0.0])), **JUDGED)[1]
    drag = 0.5 * 1025.97 * 0.01 * 1.2 * speed**2
    pushed = {**JUDGED, "weight": None, "load": (0.0, drag, 0.9)}
    shift = np.linalg.norm(run(*ends, **pushed, segments=100)[1]["nodes"] - still["nodes"], axis=1).max()
    assert moving["validity.drag"] == pytest.approx(shift / (0.01 * 3.5), rel=0.25)
    assert still["validity.drag"] == 0.0


def test_measures_follow_their_definitions():
    motion = (np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.5]), np.zeros(6))
    y = run(np.zeros(3), [2.0, 0.0, 0.0], motion=motion, **JUDGED)[1]
    T = y["tension"]
    # The stretch of 1e-4 under a newton or two moves the half axis by no more than that.
    depth = 0.5 * sqrt(3.5**2 - 2.0**2)
    assert y["validity.inertia"] == pytest.approx(0.12 * 0.5 / 0.9 * depth / 0.035, rel=1e-3)
    assert y["validity.wave"] == pytest.approx(0.3 / sqrt(T[0] / 0.12), rel=1e-14)
    assert y["validity.bending"] == pytest.approx(sqrt(1e-3 / y["horizontal_tension"]) / 0.035, rel=1e-13)
    assert y["validity.strain"] == pytest.approx(T.max() / 1e4 / 0.1, rel=1e-13)
    assert y["validity.range"] == max(value for name, value in y.items() if name.startswith("validity."))


def test_a_line_without_tension_stays_finite():
    motion = (np.ones(6), np.zeros(6))
    for given in ({"seabed": 0.0, "seabed_friction": 0.5}, {}):
        assert run(np.zeros(3), [0.0, 0.0, 0.0], motion=motion, **JUDGED, **given)[0] == 0
    assert run(np.zeros(3), [3.5, 0.0, 0.0], motion=motion, **{**JUDGED, "weight": 0.0})[0] == 0
