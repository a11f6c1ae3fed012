"""The cable's start: its discrete static equilibrium, against the elastic catenary and against plain statics."""

import numpy as np
import pytest
from scipy.optimize import fsolve

from components.compiled import functions
from components.tether.cable.component import COMPONENT

init, step = functions(COMPONENT)
CHAIN = dict(
    length=3.5, segments=50, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e5, fluid_density=1000.0,
)  # fmt: skip
H = 20_000_000  # ns
STILL = np.zeros(6)


def wet_weight(**changes):
    """N/m"""
    chain = CHAIN | changes
    return (chain["mass_per_length"] - chain["fluid_density"] * chain["volume_per_length"]) * 9.80665


def vectors(parameters):
    """p, u and the three others full of NaN."""
    p = COMPONENT.pack(parameters)
    n_u, n_x, n_y, n_w = (int(n) for n in p[1:5])
    return p, np.zeros(n_u), np.full(n_x, np.nan), np.full(n_y, np.nan), np.full(n_w, np.nan)


def at_rest(far, /, **changes):
    """The vectors after init between the origin and `far` (None: free), and the outputs by name."""
    parameters = COMPONENT.parameters(**CHAIN | changes)
    p, u, x, y, w = vectors(parameters)
    if far is not None:
        u[9:12] = far
    assert init(0, H, p, u, x, y, w) == 0
    outputs, k = {}, 0
    for port in COMPONENT.outputs(parameters):
        outputs[port.name] = y[k : k + port.size].reshape(port.shape)
        k += port.size
    return (p, u, x, y, w), outputs


def elastic_catenary(span, rise, length, weight, ea):
    """H and V_a of a line from the origin to (span, rise down), both taken up by end a (Irvine 1981, ch. 1)."""

    def ends(hv):
        h, v = np.exp(hv[0]), hv[1]
        x = h * length / ea + h / weight * (np.arcsinh(v / h) - np.arcsinh((v - weight * length) / h))
        z = (length * v - 0.5 * weight * length**2) / ea + (np.hypot(h, v) - np.hypot(h, v - weight * length)) / weight
        return x - span, z - rise

    h, v = fsolve(ends, (np.log(weight * length / 2), weight * length / 2), xtol=1e-13)
    return np.exp(h), v


@pytest.mark.parametrize(("span", "rise"), [(1.0, 0.0), (2.0, 1.0), (3.3, -0.5)])
def test_against_the_elastic_catenary(span, rise):
    """End forces approach the closed form with the square of the segment length; Richardson leaves less than 2e-5."""
    exact = np.array(elastic_catenary(span, rise, 3.5, wet_weight(), 4.5e5))
    errors, forces = [], []
    for n in (80, 160, 320):
        _, out = at_rest((span, 0.0, rise), segments=n)
        forces.append(out["force_a"][[0, 2]])
        errors.append(np.abs(forces[-1] - exact).max())
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)
    assert np.abs((4 * forces[2] - forces[1]) / 3 - exact).max() < 2e-5 * exact.max()


HARD = {
    "slack": ((1.0, 0.5, 0.2), {}),
    "near taut": ((3.4999, 0, 0), {}),
    "stretched": ((3.51, 0, 0), {}),
    "ends at one point, even": ((0, 0, 0), {}),
    "ends at one point, odd": ((0, 0, 0), {"segments": 51}),
    "straight above, slack": ((0, 0, 2.0), {}),
    "straight below, nearly taut": ((0, 0, -3.49), {}),
    "lighter than water": ((2, 0, 0), {"volume_per_length": 3e-4}),
    "no weight, slack": ((2, 0, 0), {"fluid_density": 7850.0}),
    "inextensible but for rounding": ((1, 2, 0), {"axial_stiffness": 1e9}),
    "rubber": ((1, 2, 0), {"axial_stiffness": 100.0}),
    "taking compression": ((1, 2, 0), {"tension_only": False}),
    "one segment": ((1, 0, 0), {"segments": 1}),
    "a thousand": ((2, 0, 0), {"segments": 1000}),
    "ship's mooring": ((900, 100, 100), {"length": 1e3, "mass_per_length": 100.0, "axial_stiffness": 1e9}),
    "free end": (None, {"end_b": "free"}),
    "free start": (None, {"end_a": "free"}),
}  # fmt: skip


@pytest.mark.parametrize("name", HARD)
def test_balances_to_rounding_and_stays_at_rest(name):
    """Statics: the end forces carry the wet weight. Tolerance: lengths are known to 2^-52 times the coordinates."""
    far, changes = HARD[name]
    (p, u, x, y, w), out = at_rest(far, **changes)
    chain = CHAIN | changes
    rounding = (
        50 * 2.0**-52 * np.abs(out["nodes"]).max() * chain["axial_stiffness"] * chain["segments"] / chain["length"]
    )
    assert out["residual"] <= rounding
    weight = wet_weight(**changes) * chain["length"]
    assert np.abs(out["force_a"] + out["force_b"] - [0, 0, weight]).max() <= rounding * chain["segments"]
    nodes = out["nodes"].copy()
    for k in range(1, 51):
        assert step(k * H, H, p, u, x, y, w) == 0
    assert np.abs(out["nodes"] - nodes).max() < 1e-9  # m, over a second
    assert out["converged"] == 1


def test_hanging_free_line():
    """The weight below a point is its tension: exact for a lumped line at the middle of each segment."""
    _, out = at_rest(None, end_b="free", segments=7)
    hung = wet_weight() * 0.5 * (np.arange(7)[::-1] + 0.5)
    assert out["tension"] == pytest.approx(hung, rel=1e-7)  # k times the rounding of a length
    assert np.array_equal(out["force_b"], np.zeros(3))


def test_refuses_two_free_ends_and_sub_stepped_bonds():
    for wrong, text in (
        ({"end_a": "free", "end_b": "free"}, "held nowhere"),
        ({"end_b": "free", "bond_b": True}, "make it driven"),
        ({"bond_a": True, "sub_steps": 2}, "bonded line takes 1"),
    ):
        with pytest.raises(ValueError, match=text):
            COMPONENT.parameters(**CHAIN | wrong)


def test_says_when_the_motion_is_lost():
    """An end at an infinite place cannot be followed: a status, not numbers."""
    (p, u, x, y, w), _ = at_rest((2.0, 0, 0))
    u[9] = np.inf
    status = step(H, H, p, u, x, y, w)
    assert status in COMPONENT.status_text
