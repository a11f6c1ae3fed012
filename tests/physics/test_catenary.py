"""The static line against its closed form in 50 digits, against quadrature, and against published equations."""

from decimal import Decimal, localcontext
from itertools import product
from math import asinh, cos, hypot, inf, pi, radians, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

from components.compiled import functions
from components.constants import GRAVITY
from components.tether.catenary.component import COMPONENT
from components.tether.catenary.elastic import elastic
from components.tether.catenary.hang import hang
from components.tether.catenary.inextensible import inextensible
from components.tether.catenary.line import rest
from components.tether.catenary.status import END_BELOW_SEABED, NEUTRAL_SLACK, TAUT, TEXT, TOO_SHORT

CHORDS = [0.0, 1e-9, 0.1, 0.5, 0.9, 0.99, 0.9999, 1 - 1e-8, 1 - 1e-12, 1 - 2.0**-53, 1.0, 1.0001, 1.5, 3.0]
ANGLES = [0.0, 1e-6, 1.0, 45.0, 80.0, 89.9, 89.9999999, 90.0, -30.0, -90.0]
ELASTICITIES = [0.0, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 100.0]
CHAIN = 0.092 * GRAVITY  # N/m in water, Drupt et al. 2022, Table I

_, step = functions(COMPONENT)


def ends(chord, angle_deg):
    """Span and rise in lengths; exactly vertical at 90 degrees."""
    angle = radians(angle_deg)
    return (0.0 if abs(angle_deg) == 90.0 else chord * cos(angle)), chord * sin(angle)


def solve(h, v, e):
    return elastic(h, v, e) if e > 0.0 else inextensible(h, v)


def far_end(H, V, e):
    """Place of end b in 50 digits: Irvine 1981, section 1.2, in the units of shape.py."""
    H, V, e, half = Decimal(H), Decimal(V), Decimal(e), Decimal("0.5")
    T_a, T_b = (((H * H + (V + sign * half) ** 2).sqrt()) for sign in (-1, 1))
    # asinh(b) - asinh(a) as one logarithm, each argument taken where nothing cancels
    x = H * (log_of(V + half, T_b, H) - log_of(V - half, T_a, H)) if H > 0 else Decimal(0)
    return e * H + x, e * V + T_b - T_a


def log_of(V, T, H):
    return ((V + T) / H).ln() if V >= 0 else -((T - V) / H).ln()


@pytest.mark.parametrize("e", ELASTICITIES)
def test_far_end_is_where_it_should_be(e):
    # 980 cases. Tolerance: a few roundings of numbers of the size of the line (1, span and rise).
    solved = 0
    with localcontext() as context:
        context.prec = 50
        for chord, angle in product(CHORDS, ANGLES):
            h, v = ends(chord, angle)
            status, H, V = solve(h, v, e)
            if e == 0.0 and hypot(h, v) >= 1.0:
                assert status in (TAUT, TOO_SHORT)
                continue
            x, z = far_end(H, V, e)
            error = abs(x - Decimal(h)) + abs(z - Decimal(v))
            assert status == 0, (chord, angle)
            assert error <= Decimal("2e-15") * (1 + Decimal(h) + abs(Decimal(v))), (chord, angle)
            solved += 1
    assert solved >= (140 if e > 0.0 else 95)


def test_length_of_the_shape():
    # The arc through both ends with the parameter C found is sqrt(v^2 + (2/C sinh(C h/2))^2): L to 1e-14 of L, the
    # issue's figure; a vertical line has no such arc.
    with localcontext() as context:
        context.prec = 50
        for chord, angle in product(CHORDS, ANGLES):
            h, v = ends(chord, angle)
            status, H, _ = inextensible(h, v)
            if status or H == 0.0:
                continue
            u = Decimal(h) / (2 * Decimal(H))
            arc = (Decimal(v) ** 2 + (Decimal(H) * (u.exp() - (-u).exp())) ** 2).sqrt()
            assert abs(arc - 1) <= Decimal("1e-14"), (chord, angle)


@pytest.mark.parametrize("u", [1e-4, 0.01, 0.5, 1.9, 2.1, 10.0, 50.0])
@pytest.mark.parametrize("rise", [0.0, 0.3, -20.0])
def test_recovers_the_parameter_of_a_given_catenary(u, rise):
    # Span 1, C = 2 u; its exact length is rounded to a double, which moves C by (1 + 3/u^2 (L/chord)^2) roundings.
    length = sqrt(rise**2 + (np.sinh(u) / u) ** 2)
    line = hang(length, 2.0, 1.0, rise)
    condition = 1.0 + 3.0 * (1.0 + rise**2) / u**2
    assert abs(line.C_per_m / (2.0 * u) - 1.0) <= 8.0 * 2.2e-16 * condition


@pytest.mark.parametrize(
    ("span", "rise", "length"), [(2.1, 0.0, 3.5), (2.1, 0.7, 3.5), (1.0, -1.5, 3.5), (0.1, 1.0, 9.0)]
)
def test_against_drupt_eq_3(span, rise, length):
    # Drupt et al. 2022, eq. 3: C from sag, difference of elevation and length; it holds while the lowest point is on
    # the line. Tolerance: its denominator cancels by L^2/(L^2 - (2H + dH)^2), below 40 in these cases.
    line = hang(length, CHAIN, span, rise)
    H, dH, L = line.sag_m, abs(rise), length
    C = 2.0 * (2.0 * H + dH + 2.0 * L * sqrt(H * (H + dH) / (L**2 - dH**2))) / (L**2 - (2.0 * H + dH) ** 2)
    assert line.touches_seabed
    assert line.C_per_m == pytest.approx(C, rel=1e-12)
    assert line.C_per_m == pytest.approx(CHAIN / line.H_N, rel=1e-15)  # eq. 4


@pytest.mark.parametrize("ea", [1e-2, 1.0, 1e3, 5e5])
@pytest.mark.parametrize(("span", "rise"), [(2.1, 0.7), (0.2, -3.0), (3.49, 0.1), (4.0, 1.0)])
def test_elastic_line_against_quadrature(span, rise, ea):
    # dx/ds = H (1/T + 1/EA), dz/ds = V (1/T + 1/EA): integrated numerically, to quad's own 1e-11 of each extent.
    L, w = 3.5, CHAIN
    line = hang(L, w, span, rise, ea)

    def stretch(s):
        V = w * s - line.V_a_N
        return V, 1.0 / hypot(line.H_N, V) + 1.0 / ea

    middle = min(max(line.V_a_N / w, 0.0), L)  # the level point, where the integrands bend
    for wanted, share in ((span, lambda V: line.H_N), (rise, lambda V: V)):
        got = sum(
            quad(lambda s, f=share: f(stretch(s)[0]) * stretch(s)[1], a, b, epsabs=1e-12, epsrel=1e-12, limit=200)[0]
            for a, b in ((0.0, middle), (middle, L))
        )
        assert got == pytest.approx(wanted, abs=1e-10 * (span + abs(rise)))


def test_stiff_elastic_line_is_the_inextensible_one():
    # EA/(w L) = 1e12: the forces differ by the strain times the condition of the slack, far below 1e-9 here.
    stiff, rigid = (hang(3.5, CHAIN, 2.1, 0.7, ea) for ea in (3.2e12, None))
    np.testing.assert_allclose([stiff.H_N, stiff.V_b_N], [rigid.H_N, rigid.V_b_N], rtol=1e-9)


def test_taut_elastic_line_tends_to_a_spring():
    # Strain 0.5 with negligible weight: H = EA (span/L - 1); its weight adds (w L)^2/(24 T) to first order.
    line = hang(2.0, 1e-6, 3.0, 0.0, 100.0)
    np.testing.assert_allclose([line.H_N, line.V_a_N, line.V_b_N], [50.0, 1e-6, 1e-6], rtol=1e-9)


def test_vertical_and_coincident_ends():
    bight = hang(3.5, CHAIN, 0.0, 0.0)
    assert (bight.H_N, bight.sag_m, bight.touches_seabed) == (0.0, 1.75, True)
    assert (bight.V_a_N, bight.V_b_N) == (0.5 * 3.5 * CHAIN, 0.5 * 3.5 * CHAIN)
    assert bight.C_per_m == np.finfo(float).max
    elastic_bight = hang(3.5, CHAIN, 0.0, 0.0, 10.0)  # each half stretches by w (L/2)^2/(2 EA)
    assert elastic_bight.sag_m == pytest.approx(1.75 + CHAIN * 1.75**2 / 20.0, rel=1e-15)
    pulled = hang(2.0, 1.0, 0.0, 3.0, 4.0)  # strain 0.5: 2 N in the middle, 1 N more above and less below
    assert (pulled.V_a_N, pulled.V_b_N, pulled.sag_m) == (-1.0, 3.0, 0.0)


def test_upright_line_is_the_limit_of_a_steep_one():
    # H falls as span/log(1/span); the vertical forces are off by its square.
    limit = hang(3.5, CHAIN, 0.0, 1.0)
    steep = hang(3.5, CHAIN, 1e-13, 1.0)
    assert 0.0 < steep.H_N < 1e-13
    assert (steep.V_a_N, steep.V_b_N) == pytest.approx((limit.V_a_N, limit.V_b_N), rel=1e-14)


def test_buoyant_line_is_the_heavy_one_upside_down():
    heavy, light = hang(3.5, CHAIN, 2.1, 0.7), hang(3.5, -CHAIN, 2.1, -0.7)
    assert (light.H_N, light.V_a_N, light.V_b_N) == (heavy.H_N, -heavy.V_a_N, -heavy.V_b_N)
    assert (light.sag_m, light.touches_seabed) == (heavy.sag_m, False)


@pytest.mark.parametrize(
    ("figures", "status"),
    [
        ((3.5, 1.0, 3.5, 0.0), TAUT),
        ((3.5, 1.0, 0.0, -3.5), TAUT),
        ((3.5, 1.0, 3.0, 4.0), TOO_SHORT),
        ((3.5, 0.0, 3.6, 0.0), TOO_SHORT),
        ((3.5, 0.0, 1.0, 0.0), NEUTRAL_SLACK),
        ((3.5, 0.0, 1.0, 0.0, 10.0), NEUTRAL_SLACK),
    ],
)
def test_impossible_lines_are_refused(figures, status):
    with pytest.raises(ValueError, match=r"ends .* m apart on a line of 3\.5 m") as refusal:
        hang(*figures)
    assert TEXT[status] in str(refusal.value)


@pytest.mark.parametrize(
    "figures", [(0.0, 1.0, 1.0, 0.0), (1.0, 1.0, -0.5, 0.0), (1.0, inf, 0.5, 0.0), (1.0, 1.0, 0.5, 0.0, 0.0)]
)
def test_bad_figures_are_refused(figures):
    with pytest.raises(ValueError, match="must"):
        hang(*figures)


def test_forces_beyond_the_largest_double_are_refused():
    with pytest.raises(ValueError, match="too far apart in size"):
        hang(1e200, 1e200, 1.0, 0.0)


# --- the component -----------------------------------------------------------------------------------------------


def run(a, b, **parameters):
    """(status, outputs by name) for ends at a and b; every output not written would stay NaN."""
    kind = COMPONENT.parameters(**{"length": 3.5, "weight": CHAIN, **parameters})
    u = np.zeros(18)
    u[0:3], u[9:12] = a, b
    ports = COMPONENT.outputs(kind)
    y = np.full(sum(port.size for port in ports), np.nan)
    status = step(0, 10**7, COMPONENT.pack(kind), u, np.empty(0), y, np.empty(0))
    edges = np.cumsum([0, *(port.size for port in ports)])
    named = {port.name: y[i:j].reshape(port.shape) for port, i, j in zip(ports, edges[:-1], edges[1:], strict=True)}
    return status, named


@pytest.mark.parametrize("heading", np.linspace(-pi, pi, 7))
@pytest.mark.parametrize("ea", [None, 20.0])
def test_component_agrees_with_the_plain_function(heading, ea):
    # The same numbers through world coordinates: a few roundings of positions of 10 m.
    a, b = np.array([4.0, -5.0, 1.2]), np.array([4.0 + 2.1 * cos(heading), -5.0 + 2.1 * sin(heading), 0.5])
    status, y = run(a, b, axial_stiffness=ea)
    line = hang(3.5, CHAIN, 2.1, 0.7, ea)
    along = np.array([cos(heading), sin(heading)])
    assert status == 0
    assert np.isfinite(np.concatenate([value.ravel() for value in y.values()])).all()
    np.testing.assert_allclose(y["force_a"], [*(line.H_N * along), line.V_a_N], atol=1e-13)
    np.testing.assert_allclose(y["force_b"], [*(-line.H_N * along), line.V_b_N], atol=1e-13)
    np.testing.assert_allclose(y["tension"][[0, -1]], np.hypot(line.H_N, [line.V_a_N, line.V_b_N]), rtol=1e-13)
    np.testing.assert_allclose(y["nodes"][[0, -1]], [a, b], atol=1e-14 * 10.0)
    assert y["sag"] == pytest.approx(line.sag_m, rel=1e-12)
    assert y["touches_seabed"] == y["grounded_length"] == 0.0


def test_nodes_lie_on_drupt_eq_1():
    # z = (cosh(C x) - 1)/C from the lowest point, within roundings of the line's length.
    _, y = run([0.0, 0.0, 0.0], [2.1, 0.0, -0.7], segments=40)
    C, a_to_lowest = y["catenary_parameter"], asinh(-y["force_a"][2] / y["horizontal_tension"])
    x = y["nodes"][:, 0] + a_to_lowest / C
    lowest = y["sag"]
    np.testing.assert_allclose(y["nodes"][:, 2], lowest - (np.cosh(C * x) - 1.0) / C, atol=1e-14 * 3.5)


@pytest.mark.parametrize("seabed", [None, 1.0])
def test_tension_grows_by_the_weight_of_the_height(seabed):
    # T - w z is the same all along an inextensible catenary, on a frictionless seabed too (Irvine 1981, section 1.2).
    _, y = run([0.0, 0.0, 0.0], [1.0, 1.0, 0.3], segments=10, seabed=seabed)
    np.testing.assert_allclose(y["tension"] + CHAIN * y["nodes"][:, 2], y["tension"][0], atol=1e-14 * 3.5 * CHAIN)


def test_neutral_line_is_straight_when_taut_and_refused_when_slack():
    status, y = run([0.0, 0.0, 0.0], [3.0, 4.0, 0.0], weight=0.0, axial_stiffness=70.0)
    assert status == 0
    np.testing.assert_allclose(y["force_a"], [18.0, 24.0, 0.0], rtol=1e-14)  # 70 N * 1.5/3.5 along (3, 4)/5
    np.testing.assert_allclose(y["nodes"][10], [1.5, 2.0, 0.0], rtol=1e-14)
    assert run([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], weight=0.0)[0] == NEUTRAL_SLACK


# --- seabed ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ea", [None, 1e3, 10.0])
@pytest.mark.parametrize("span", [2.6, 3.0, 3.3])
def test_touchdown_against_jonkman(span, ea):
    # Anchor on the seabed, fairlead 1 m above: Jonkman 2007, NREL/TP-500-41958, eqs. 2-37a, b without friction give
    # the place of the fairlead from H and V. Tolerance: roundings of 3.5 m.
    status, y = run([0.0, 0.0, 4.0], [span, 0.0, 3.0], seabed=4.0, axial_stiffness=ea)
    H, V, w, L, c = y["horizontal_tension"], y["force_b"][2], CHAIN, 3.5, 0.0 if ea is None else 1.0 / ea
    assert (status, y["touches_seabed"]) == (0, 1.0)
    assert y["grounded_length"] == pytest.approx(L - V / w, rel=1e-13)
    assert (L - V / w) + H / w * asinh(V / H) + H * L * c == pytest.approx(span, abs=1e-14 * L)
    assert H / w * (sqrt(1.0 + (V / H) ** 2) - 1.0) + V**2 * c / (2.0 * w) == pytest.approx(1.0, abs=1e-14 * L)
    assert y["force_a"][2] == 0.0
    assert y["nodes"][:, 2].max() <= 4.0 + 1e-14 * L
    np.testing.assert_allclose(y["nodes"][-1], [span, 0.0, 3.0], atol=1e-14 * L)


@pytest.mark.parametrize("ea", [None, 10.0])
def test_seabed_raised_to_the_lowest_point_changes_nothing(ea):
    # The line hanging free and the line touching at one point are the same: continuity through the switch. The force
    # moves by the square root of nothing here, in proportion to the depth given away (1e-9 m).
    free = run([0.0, 0.0, 0.0], [2.1, 0.0, -0.7], axial_stiffness=ea)[1]
    touching = run([0.0, 0.0, 0.0], [2.1, 0.0, -0.7], axial_stiffness=ea, seabed=float(free["sag"]) - 1e-9)[1]
    assert (free["touches_seabed"], touching["touches_seabed"]) == (0.0, 1.0)
    np.testing.assert_allclose(touching["nodes"], free["nodes"], atol=1e-7)
    np.testing.assert_allclose(touching["force_b"], free["force_b"], atol=1e-7)


def test_seabed_grid_closes():
    # The three parts span the distance of the ends, for all depths and stiffnesses; roundings of the line's length.
    cases = 0
    for h, p_a, p_b, e in product([1e-6, 0.3, 0.7, 0.9, 0.99, 1.2], [0.0, 1e-9, 0.1, 0.4], [0.0, 0.2], ELASTICITIES):
        status, (*_, touches, H, _, s_a, s_b, _, _) = rest(h, p_a - p_b, e, p_a, p_b, 0.0)
        if e == 0.0 and hypot(h, p_a - p_b) >= 1.0:
            assert status == TOO_SHORT
            continue
        assert status == 0
        if not touches:
            continue
        cases += 1
        spans = [H * asinh(s / H) + e * H * s if H > 0.0 else 0.0 for s in (s_a, s_b)]
        lying = (1.0 - s_a - s_b) * (1.0 + e * H)
        for s, p in ((s_a, p_a), (s_b, p_b)):
            height = s * s / (hypot(H, s) + H) + e * s * s / 2.0 if s > 0.0 else 0.0
            assert height == pytest.approx(p, abs=4e-16)
        if H > 0.0:
            assert sum(spans) + lying == pytest.approx(h, abs=2e-15 * (1.0 + h))
        else:
            assert lying >= h
    assert cases > 100


def test_heap_on_the_seabed_carries_nothing():
    status, y = run([0.0, 0.0, 0.0], [0.5, 0.0, 0.0], seabed=1.0)
    assert (status, y["horizontal_tension"], y["grounded_length"], y["sag"]) == (0, 0.0, 1.5, 1.0)
    np.testing.assert_allclose(y["force_a"], [0.0, 0.0, CHAIN], rtol=1e-15)


def test_end_below_the_seabed_is_refused():
    assert run([0.0, 0.0, 1.0], [2.0, 0.0, 5.0], seabed=4.0)[0] == END_BELOW_SEABED


@pytest.mark.parametrize(
    "wrong", [{"segments": 0}, {"weight": -1.0, "seabed": 4.0}, {"length": 0.0}, {"axial_stiffness": -1.0}]
)
def test_bad_parameters_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        COMPONENT.parameters(**{"length": 3.5, "weight": CHAIN, **wrong})
