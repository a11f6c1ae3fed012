"""Power bond of cable and mass: against a monolithic Runge-Kutta solution, and the law against finite differences."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

PATH = Path(__file__).parents[1] / "benchmarks" / "bond_convergence.py"
spec = importlib.util.spec_from_file_location("bond_convergence", PATH)
assert spec is not None
assert spec.loader is not None
bond = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = bond  # dataclasses look their module up
spec.loader.exec_module(bond)

H = 0.02


def errors(case, method, steps):
    found = [bond.measure(case, method, h) for h in steps]
    assert all(stable for _, stable in found)
    return [error for error, _ in found]


@pytest.mark.parametrize(
    ("ratio", "far", "motion"), [(100, "free", "swinging"), (0.1, "anchored", "hanging"), (0.1, "anchored", "swinging")]
)
def test_rounds_reach_the_monolithic_motion_at_second_order(ratio, far, motion):
    """Monolithic reference. From 100 to 20 ms the error falls by 5^2 = 25; 12 leaves room for the coarse end."""
    coarse, fine = errors(bond.Case(ratio, far, motion), "re-linearised rounds", (0.1, 0.02))
    assert fine < coarse / 12
    assert fine < 5e-3  # m, of motions of 0.1 to 1 m: what a scheme of order two leaves at 20 ms


@pytest.mark.parametrize("h", [0.1, 0.02])
def test_one_round_is_bounded_for_a_light_body(h):
    """Where the force alone blows up, the affine law stays within bounds in a single round."""
    case = bond.Case(0.1, "free", "hanging")
    error, stable = bond.measure(case, "one round", h)
    assert stable
    assert error < 0.02  # m: the second-order error of 100 ms
    assert not bond.measure(case, "plainly delayed force", h)[1]
    assert not bond.measure(case, "held velocity", h)[1]


def law_of(line, name):
    law = line.bundle(name)
    return law[:3].copy(), law[3:6].copy(), law[6:].reshape(3, 3).copy()


def push(line, start, acceleration, end=slice(-9, None), h=H):
    """Step from the state `start` with the end moving by the scheme's formulas; returns the accepted force."""
    node = 0 if end.start == 0 else -1
    q, v, _, a = start.reshape(-1, 13)[node, :12].reshape(4, 3)
    line.x[:] = start
    line.u[end] = np.concatenate(
        [q + h * v + h**2 / 2 * acceleration, v + h / 4 * (a + 3 * acceleration), acceleration]
    )
    line.step()
    assert line.bundle("converged") == 1
    return law_of(line, "accepted_b" if node else "accepted_a")


@pytest.fixture
def swinging():
    """A bonded line that hangs from one end and has swung for half a second, tightly converged."""
    parameters = bond.CABLE.parameters(**bond.CHAIN, bond_b=True, tolerance=1e-10)
    line = bond.Instance(bond.CABLE, parameters, H)
    line.u[-9:-6] = (2.0, 0.3, 0.5)
    line.init()
    for k in range(1, 26):
        t = k * H
        line.u[-9:] = np.concatenate([[2 + 0.5 * t**3, 0.3, 0.5], [1.5 * t**2, 0, 0], [3 * t, 0, 0]])
        line.step()
    return line


def test_law_is_the_force_of_the_trial(swinging):
    """Force, reference and mass of the law are those accepted when the end does take the reference acceleration."""
    force, reference, mass = law_of(swinging, "law_b")
    accepted, acceleration, again = push(swinging, swinging.x.copy(), reference)
    assert accepted == pytest.approx(force, abs=1e-6)  # N: the two Newton iterations' tolerance
    assert np.array_equal(acceleration, reference)
    assert again == pytest.approx(mass, rel=1e-6)


def test_mass_is_symmetric_and_the_slope_of_the_force(swinging):
    """G = -dF/da by central differences; within 3 %, which the tangent's turning in drag leaves out of the matrix."""
    _, reference, mass = law_of(swinging, "law_b")
    start = swinging.x.copy()
    slope = np.empty((3, 3))
    for j in range(3):
        d = 1e-2 * np.eye(3)[j]
        ahead, behind = push(swinging, start, reference + d)[0], push(swinging, start, reference - d)[0]
        slope[:, j] = -(ahead - behind) / 2e-2
    assert np.array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0
    assert np.abs(slope - mass).max() < 0.03 * np.abs(mass).max()


def test_mass_at_rest_is_the_slope_at_both_ends():
    """At rest nothing is left out: both ends' laws agree with central differences to their own error."""
    line = bond.Instance(bond.CABLE, bond.CABLE.parameters(**bond.CHAIN, bond_a=True, bond_b=True, tolerance=1e-12), H)
    line.u[9:12] = (2.0, 0.3, 0.5)
    line.init()
    start, rest = line.x.copy(), line.u.copy()
    for end, name in ((slice(0, 9), "law_a"), (slice(9, 18), "law_b")):
        _, reference, mass = law_of(line, name)
        slope = np.empty((3, 3))
        for j in range(3):
            line.u[:] = rest
            d = 1e-3 * np.eye(3)[j]
            ahead, behind = push(line, start, reference + d, end)[0], push(line, start, reference - d, end)[0]
            slope[:, j] = -(ahead - behind) / 2e-3
        line.x[:], line.u[:] = start, rest
        line.init()
        assert slope == pytest.approx(mass, rel=1e-3, abs=1e-3 * np.abs(mass).max())


def test_trial_leaves_no_trace(swinging):
    """The state after a step does not depend on the trial that follows it: an unbonded line has the same bits."""
    plain = bond.Instance(bond.CABLE, bond.CABLE.parameters(**bond.CHAIN, rho_inf=0.0, tolerance=1e-10), H)
    plain.u[-9:-6] = (2.0, 0.3, 0.5)
    plain.init()
    for k in range(1, 26):
        t = k * H
        plain.u[-9:] = np.concatenate([[2 + 0.5 * t**3, 0.3, 0.5], [1.5 * t**2, 0, 0], [3 * t, 0, 0]])
        plain.step()
    assert plain.x.tobytes() == swinging.x.tobytes()


def test_bodies_at_both_ends_mirror_each_other():
    """Two equal bodies let go on a sagging line move as mirror images; rounds meet the tolerance. Authority: symmetry.

    Tolerance: 100 steps with the force left within 1e-6 N on 0.37 kg, (2 s)^2 / 2 times that, twice.
    """
    mass = bond.Case(1, "free", "hanging").mass
    line = bond.Instance(bond.CABLE, bond.CABLE.parameters(**bond.CHAIN, bond_a=True, bond_b=True, tolerance=1e-9), H)
    bodies = []
    for x in (-1.25, 1.25):
        springs = {"stiffness": (6.0, 6.0, 6.0), "rest": (1.2 * x, 0, -0.3), "position": (x, 0, 0)}
        bodies.append(bond.Instance(bond.MASS, bond.MASS.parameters(mass=mass, **springs, takes_law=True), H))
        bodies[-1].init()
    line.u[:] = np.concatenate([body.y for body in bodies])
    line.init()
    for _ in range(100):
        saved = [part.x.copy() for part in (*bodies, line)]
        laws = [line.bundle(name).copy() for name in ("law_a", "law_b")]
        for _ in range(10):
            for part, x in zip((*bodies, line), saved, strict=True):
                part.x[:] = x
            for body, law in zip(bodies, laws, strict=True):
                body.u[:] = law
                body.step()
            line.u[:] = np.concatenate([body.y for body in bodies])
            line.step()
            accepted = [line.bundle(name).copy() for name in ("accepted_a", "accepted_b")]
            expected = [
                law[:3] - law[6:].reshape(3, 3) @ (b.y[6:] - law[3:6]) for b, law in zip(bodies, laws, strict=True)
            ]
            gap = max(np.abs(a[:3] - e).max() for a, e in zip(accepted, expected, strict=True))
            if gap <= 1e-6:
                break
            laws = accepted
        assert gap <= 1e-6
    assert np.abs(bodies[1].y[0] - 1.25) > 0.01
    assert bodies[0].y * np.tile([-1, 1, 1], 3) == pytest.approx(bodies[1].y, abs=1e-5)


def test_rows_have_the_columns_of_the_benchmark():
    """The table that `towline bench bond` prints."""
    table = bond.rows([bond.Case(100, "free", "swinging")], (0.1,))
    assert [row["method"] for row in table] == list(bond.METHODS)
    assert all(set(row) == {"case", "method", "step", "error", "error_unit", "stable"} for row in table)
