"""Power bond of cable and mass: against a monolithic Runge-Kutta solution, and the law against finite differences."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from components import compiled
from pipeline import power_bond
from pipeline.loop_tables import Tables

PATH = Path(__file__).parents[1] / "benchmarks" / "bond_convergence.py"
spec = importlib.util.spec_from_file_location("bond_convergence", PATH)
assert spec is not None
assert spec.loader is not None
bond = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = bond  # dataclasses look their module up
spec.loader.exec_module(bond)

H = 0.02
let_yield = njit(**compiled.OPTIONS)(power_bond.let_yield.py_func)


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
    assert bond.measure(case, "held velocity", h)[0] > 1.0  # m, of a motion of 0.05 m; infinite where unbounded


def law_of(line, name):
    law = line.bundle(name)
    return law[:3].copy(), law[3:6].copy(), law[6:].reshape(3, 3).copy()


def push(line, start, acceleration, end=slice(-9, None), h=H):
    """Step from the state `start` with the end moving by the scheme's formulas; returns the accepted force."""
    node = 0 if end.start == 0 else -1
    nodes = start[: bond.STATE * (bond.SEGMENTS + 1)].reshape(-1, bond.STATE)
    q, v, _, a = nodes[node, :12].reshape(4, 3)
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


def test_masses_at_rest_are_the_slopes_at_both_ends():
    """At rest nothing is left out: laws and cross mass agree with central differences to the differences' error."""
    line = bond.Instance(bond.CABLE, bond.CABLE.parameters(**bond.CHAIN, bond_a=True, bond_b=True, tolerance=1e-12), H)
    line.u[9:12] = (2.0, 0.3, 0.5)
    line.init()
    start, rest = line.x.copy(), line.u.copy()
    cross = line.bundle("accepted_ab").reshape(3, 3).copy()
    masses = np.block([[law_of(line, "accepted_a")[2], cross], [cross.T, law_of(line, "accepted_b")[2]]])
    for end, name in ((slice(0, 9), "law_a"), (slice(9, 18), "law_b")):
        _, reference, mass = law_of(line, name)
        slope, d = np.empty((6, 3)), 1e-3
        for j in range(3):
            forces = []
            for sign in (1, -1):
                line.u[:] = rest
                push(line, start, reference + sign * d * np.eye(3)[j], end)
                forces.append(np.concatenate([law_of(line, f"accepted_{e}")[0] for e in "ab"]))
            slope[:, j] = -(forces[0] - forces[1]) / (2 * d)
        line.x[:], line.u[:] = start, rest
        line.init()
        columns = slice(0, 3) if name == "law_a" else slice(3, 6)
        assert slope[columns] == pytest.approx(mass, rel=1e-3, abs=1e-3 * np.abs(mass).max())
        assert slope == pytest.approx(masses[:, columns], rel=1e-3, abs=1e-3 * np.abs(masses).max())


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


def test_yielding_laws_solve_the_joint_system():
    """Two bodies, each solved alone with its own yielding law, move as numpy's solution of both with the line."""
    rng = np.random.default_rng(1)

    def positive(n):
        root = rng.normal(size=(n, n))
        return root @ root.T

    g, accepted, used, inertia = positive(6), rng.normal(size=6), rng.normal(size=6), [positive(3), positive(3)]
    sizes = dict.fromkeys(Tables._fields, 1) | {"laws": (2, 15), "system": (3, 7), "board": 69, "inputs": 30}
    tables = Tables(**{name: np.zeros(size) for name, size in sizes.items()})._replace(
        bonds=np.array([[0, e, 48 + 3 * e - 6, 15 * e, 15 * e, 8, 0, 1 - e, 39, e, 30] for e in (0, 1)])
    )
    tables.board[39:48] = g[:3, 3:].ravel()
    for e in (0, 1):
        own = slice(3 * e, 3 * e + 3)
        tables.board[15 * e : 15 * e + 15] = np.concatenate([accepted[own], np.zeros(3), g[own, own].ravel()])
        tables.inputs[15 * e : 15 * e + 3] = used[own]
    matrix = np.block([[inertia[0], np.zeros((3, 3))], [np.zeros((3, 3)), inertia[1]]])
    joint = np.linalg.solve(matrix + g, accepted - used)
    for e in (0, 1):
        tables.board[30:39] = np.linalg.inv(inertia[1 - e]).ravel()
        tables.laws[e] = tables.board[15 * e : 15 * e + 15]
        let_yield(tables, e)
        force, mass = tables.laws[e, :3], tables.laws[e, 6:].reshape(3, 3)
        assert np.array_equal(mass, mass.T)
        alone = np.linalg.solve(inertia[e] + mass, force - used[3 * e : 3 * e + 3])
        assert alone == pytest.approx(joint[3 * e : 3 * e + 3], rel=1e-9)  # conditioned to about 1e3


@pytest.mark.parametrize("motion", ["towed", "spinning"])
@pytest.mark.parametrize("ratio", bond.RATIOS)
def test_bodies_at_both_ends_reach_the_monolithic_motion(ratio, motion):
    """Monolithic reference, two bodies on a taut line: from 20 to 10 ms the error falls by 4, second order; 3 is asked.

    At most 1 cm at 10 ms, what a scheme of order two leaves of motions of metres. A delayed force flings light bodies.
    """
    case = bond.Case(ratio, "body", motion)
    coarse, fine = errors(case, "re-linearised rounds", (0.02, 0.01))
    assert fine < coarse / 3
    assert fine < 0.01
    if case == bond.Case(0.1, "body", "towed"):
        assert not bond.measure(case, "plainly delayed force", 0.01)[1]


def test_rows_have_the_columns_of_the_benchmark():
    """The table that `towline bench bond_convergence` prints."""
    table = bond.rows([bond.Case(100, "free", "swinging")], (0.1,))
    assert [row["method"] for row in table] == list(bond.METHODS)
    assert all(set(row) == {"case", "method", "step", "error", "error_unit", "stable"} for row in table)
