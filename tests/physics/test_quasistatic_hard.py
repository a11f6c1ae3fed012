"""The line in a current over its whole range: turning points of the loads, folds, softness; none is left unsolved."""

import numpy as np
import pytest

from components.compiled import functions
from components.tether.quasistatic.component import COMPONENT
from components.tether.quasistatic.line import RECORD
from components.tether.quasistatic.pivoted import BELOW, RATE, STEP, WIDTH, solve_rows
from components.tether.quasistatic.status import NEUTRAL_SLACK, TOO_SOFT

_, step = functions(COMPONENT)


def line(seed: int) -> tuple[dict, np.ndarray]:
    """Parameters and inputs of a random line.

    0.1 to 5000 m; ends from together to 1.05 lengths apart, often near 1; EA from 10 N to 10 GN; weights of either
    sign, 1e-5 N/m to 1 kN/m, or none; up to six depths of a current to 3 m/s, in one plane, turning or at random; tow
    and ends that move against each other; free ends with heavy and buoyant bodies; 1 to 100 segments.
    """
    random = np.random.default_rng(seed)
    length = 10.0 ** random.uniform(-1.0, np.log10(5000.0))
    direction = random.normal(size=3)
    if random.uniform() < 0.25:
        direction = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)][random.integers(3)])
    near = 1.0 + random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-5.0, -1.3)
    ratio = random.choice([random.uniform(0.0, 1.05), near, 0.0, random.uniform(0.9, 1.0)], p=[0.6, 0.2, 0.03, 0.17])
    b = length * ratio * direction / np.linalg.norm(direction)
    depths = int(random.integers(7))
    size, angle = random.uniform(-1.0, 1.0, size=(depths, 1)), random.uniform(0.0, 2.0 * np.pi)
    if random.uniform() < 0.5:
        angle += np.cumsum(random.normal(size=(depths, 1)), axis=0)
    angle = angle + 0.0 * size
    fastest = 10.0 ** random.uniform(-3.0, np.log10(3.0))
    current = fastest * size * np.hstack([np.cos(angle), np.sin(angle), 0.3 * size])
    given = {
        "length": length,
        "weight": 0.0 if random.uniform() < 0.05 else random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-5.0, 3.0),
        "axial_stiffness": 10.0 ** random.uniform(1.0, 10.0),
        "drag_diameter": 10.0 ** random.uniform(-3.0, np.log10(0.5)),
        "tangential_drag": random.choice([0.0, 0.02, 0.3]),
        "current_depth": tuple(np.sort(random.uniform(-1.2, 1.2, size=depths)) * length),
        "current": tuple(map(tuple, current)),
        "segments": int(random.choice([1, 2, 3, 5, 10, 20, 50, 100])),
    }
    tow = random.choice([0.0, 10.0 ** random.uniform(-2.0, 0.5)]) * random.normal(size=3)
    apart = random.choice([0.0, 0.3], p=[0.9, 0.1]) * random.normal(size=3)
    u = [*np.zeros(3), *tow, *np.zeros(3), *b, *(tow + apart), *np.zeros(3)]
    if random.uniform() < 0.1:
        body = random.choice([-1.0, 0.0, 1.0]) * 10.0 ** random.uniform(-1.0, 4.0)
        given |= {"end_b": "free", "body_weight": body, "body_drag_area": 10.0 ** random.uniform(-3.0, 0.0)}
        u = u[:9]
    return given, np.array(u)


def solved(given: dict, u: np.ndarray):
    """(status, outputs by name, scratch)."""
    parameters = COMPONENT.parameters(**given)
    ports = COMPONENT.outputs(parameters)
    y = np.full(sum(port.size for port in ports), np.nan)
    w = np.full(COMPONENT.sizes(parameters).workspace, np.nan)
    status = step(0, 10**7, COMPONENT.pack(parameters), u, np.empty(0), y, w)
    edges = np.cumsum([0, *(port.size for port in ports)])
    return status, {port.name: y[i:j] for port, i, j in zip(ports, edges[:-1], edges[1:], strict=True)}, w


def imbalance(given: dict, u: np.ndarray, scratch: np.ndarray) -> float:
    """Largest imbalance of the finer mesh's nodes over all load, or misfit of a segment over the stretched length.

    Written anew with numpy from the equations in newton.py and loads.py, of the places and forces in the scratch.
    """
    n, free, L = 2 * given["segments"], "end_b" in given, given["length"]
    records = scratch[: (n + 1) * RECORD].reshape(n + 1, RECORD)
    r, N, share = records[:, :3], records[:n, 3:6], np.linspace(0.0, 1.0, n + 1)[:, None]
    c_n = 0.5 * 1025.97 * given["drag_diameter"] * 1.2
    c_t = 0.5 * 1025.97 * given["drag_diameter"] * np.pi * given["tangential_drag"]
    down = np.array([0.0, 0.0, given["weight"]])

    def flow(z):
        table = np.reshape(given["current"], (-1, 3))
        current = [np.interp(z, given["current_depth"], column) for column in table.T] if len(table) else 0.0 * r.T
        return np.array(current).T - (1.0 - share) * u[3:6] - share * u[3 if free else 12 :][:3]

    def body(v):
        area = 0.5 * 1025.97 * given["body_drag_area"]
        return area * np.linalg.norm(v) * v + np.array([0.0, 0.0, given["body_weight"]])

    chord = np.array([0.0, 0.0, L]) if free else u[9:12] - u[:3]
    # Scale of the forces on the coarse mesh: drag as if across, at the depths of the straight line.
    v = flow(share[:, 0] * chord[2])[::2]
    first = (c_n * np.linalg.norm(v, axis=1)[:, None] * v + down) * L / (n // 2)
    first[[0, -1]] *= 0.5
    if free:
        first[-1] += body(v[-1])
    scale = np.linalg.norm(first, axis=1).sum()
    if not free:
        scale += max(np.linalg.norm(chord) / L - 1.0, 0.0) * given["axial_stiffness"]

    size = np.sqrt((N**2).sum(axis=1) + (1e-9 * scale) ** 2)[:, None]
    misfit = np.diff(r, axis=0) - L / n * N * (1.0 / size + 1.0 / given["axial_stiffness"])
    v, t, load = flow(r[:, 2]), N / size, np.zeros((n + 1, 3))
    for i in (0, 1):  # each half segment loads the node before and the one behind it, by that node's flow
        along = (v[i : n + i] * t).sum(axis=1)[:, None]
        across = v[i : n + i] - along * t
        drag = c_n * np.linalg.norm(across, axis=1)[:, None] * across + c_t * np.abs(along) * along * t
        load[i : n + i] += 0.5 * L / n * (drag + down)
    missing = load[1:] + np.diff(np.vstack([N, 0.0 * u[:3]]), axis=0)
    if free:
        missing[-1] += body(v[-1])
    stretched = L * (1.0 + scale / given["axial_stiffness"])
    return max(np.abs(misfit).max() / stretched, np.abs(missing[: None if free else -1]).max(initial=0.0) / scale)


@pytest.mark.parametrize("part", range(4))
def test_nothing_in_the_range_is_left_unsolved(part):
    # 1200 lines, each in balance by the equations written anew: 1e-9 of all force is what Newton's method is content
    # with where rounding keeps it from 1e-13 (a line stretched a thousandfold). 20 000 more were tried by hand,
    # of which 35901 needs a second rounding to begin with.
    refused = 0
    for seed in (*range(300 * part, 300 * (part + 1)), *([35901] if part == 0 else [])):
        given, u = line(seed)
        status, y, scratch = solved(given, u)
        if status == NEUTRAL_SLACK:
            refused += 1
            continue
        assert status == 0
        assert y["converged"] == 1.0, seed
        assert imbalance(given, u, scratch) <= 2e-9, seed
    assert refused < 10


def test_what_is_not_solved_says_so():
    # The two of 20 000 more lines, 500000 to 519999, for which no balance was found. One is stretched beyond twice its
    # length; the other hangs free in a current that turns by a right angle within 0.4 mm of its 0.3 m, on one segment.
    given, u = line(508393)
    assert solved(given, u)[0] == TOO_SOFT
    given, u = line(516669)
    status, y, _ = solved(given, u)
    assert status == 0
    assert y["converged"] == 0.0
    assert y["validity.range"] > 1.0
    assert y["error"] >= given["length"]
    assert np.isfinite(np.concatenate(list(y.values()))).all()


def test_rows_against_numpy():
    # A random band of half width 5 with rows that must be interchanged: solutions to ten
    # roundings times the condition, and the determinant's sign.
    random = np.random.default_rng(5)
    m = 40
    for _ in range(20):
        matrix = np.triu(np.tril(random.normal(size=(m, m)), BELOW), -BELOW)
        matrix[np.arange(m), np.arange(m)] *= 1e-3
        rows, sides = np.zeros((m, WIDTH)), random.normal(size=(m, 2))
        for row in range(m):
            for column in range(max(row - BELOW, 0), min(row + BELOW, m - 1) + 1):
                rows[row, column - row + BELOW] = matrix[row, column]
        rows[:, [STEP, RATE]] = sides
        w = rows.ravel()
        sign = solve_rows(w, 0, m)
        expected = np.linalg.solve(matrix, sides)
        tolerance = 1e-15 * np.linalg.cond(matrix) * np.abs(expected).max()
        np.testing.assert_allclose(w.reshape(m, WIDTH)[:, [STEP, RATE]], expected, atol=10.0 * tolerance)
        assert sign == np.linalg.slogdet(matrix)[0]
    assert solve_rows(np.zeros(m * WIDTH), 0, m) == 0.0
