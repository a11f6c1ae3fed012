"""Bending stiffness: cantilever, elastica, Euler's column, beams under tension, and the band's elimination."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from components.tether.cable import banded, line
from components.tether.cable.component import COMPONENT

BEAM = dict(
    length=1.0, mass_per_length=1.0, volume_per_length=0.0, drag_diameter=0.0, fluid_density=0.0, bending_stiffness=1.0,
    axial_stiffness=1e6,
)  # fmt: skip


def elastica(load):
    """Tip of a cantilever of length and EI one under its own weight `load`, by collocation (Frisch-Fay 1962)."""
    s = np.linspace(0, 1, 50)
    guess = np.vstack([0.5 * s, 0 * s, s, 0 * s])
    return solve_bvp(
        lambda s, y: np.array([y[1], -load * (1 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]),
        lambda a, b: np.array([a[0], b[1], a[2], a[3]]), s, guess, tol=1e-10, max_nodes=50000,
    ).sol(1.0)[2:]  # fmt: skip


def test_cantilever_bends_as_a_beam(cable):
    """Tip w L^4 / 8 EI: the lumped beam is exactly 1 / n^2 too soft; 1e-6 is the deflection's own square and EA's."""
    for n in (5, 20):
        beam = cable(
            0.01, np.zeros(9), **BEAM, segments=n, end_b="free", clamp_a=(1.0, 0.0, 0.0), gravity=1e-3
        )  # fmt: skip
        assert beam["nodes"][-1, 2] / (1e-3 / 8) == pytest.approx(1 + 1 / n**2, abs=1e-6)


@pytest.mark.parametrize("load", [3.0, 50.0])
def test_cantilever_bends_as_the_elastica(cable, load):
    """Deflections to 0.9 of the length: second order in the segment length, 1e-3 of it at 40 segments."""
    exact, errors = elastica(load), []
    for n in (40, 80):
        beam = cable(0.01, np.zeros(9), **BEAM, segments=n, end_b="free", clamp_a=(1.0, 0.0, 0.0), gravity=load)
        assert beam.status == 0
        errors.append(np.abs(beam["nodes"][-1, [0, 2]] - exact).max())
    assert errors[0] < 1.2e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)


def test_column_buckles_at_eulers_load(cable):
    """P = pi^2 EI / L^2, a little more when bent: by 1 + d/2 at an end shortening d = 0.002 (Timoshenko 1961, 2.7).

    The lumped column carries (2 n / pi sin(pi / 2 n))^2 of it; 1e-4 is left for the weight that makes it buckle,
    4 w / (pi^3 a) of a deflection a = 0.03.
    """
    n, d = 40, 0.002
    column = cable(
        0.01, ((0.0, 0.0, 0.0), (1.0 - d, 0.0, 0.0)), **BEAM | {"axial_stiffness": 1e8}, segments=n, gravity=1e-5
    )
    assert column.status == 0
    lumped = (2 * n / pi * np.sin(pi / (2 * n))) ** 2
    assert column["force_b"][0] / pi**2 == pytest.approx(lumped * (1 + d / 2), rel=1e-4)


@pytest.mark.parametrize(("mode", "tension"), [(1, 0.0), (1, 50.0), (3, 50.0)])
def test_beam_under_tension_rings_true(cable, mode, tension):
    """Hinged: omega^2 = T k^2 / m + EI k^4 / m, k = mode pi / L (Blevins 1979); both discretisations below 2e-3."""
    h, n = 2e-4, 60
    stretched = (1.0 + tension / 1e6, 0.0, 0.0)
    beam = cable(h, ((0.0, 0.0, 0.0), stretched), **BEAM, segments=n, gravity=0.0, rho_inf=1.0, tolerance=1e-9)
    k = mode * pi
    omega = sqrt(tension * k**2 + k**4)
    state = beam.x[: line.STATE * (n + 1)].reshape(-1, line.STATE)
    state[:, line.V + 1] = 1e-4 * omega * np.sin(k * np.arange(n + 1) / n)
    u, y, steps = beam.u.copy(), [], round(3.2 * 2 * pi / omega / h)
    for _ in range(steps):
        beam.step(u)
        y.append(beam["nodes"][n // (2 * mode), 1])
    y = np.array(y)
    crossings = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    times = h * (crossings - y[crossings] / (y[crossings + 1] - y[crossings]))
    assert 2 * pi / np.diff(times).mean() == pytest.approx(omega, rel=3e-3)


def test_clamped_end_of_a_taut_line_has_a_boundary_layer(cable):
    """y = h (1 - exp(-s / lambda) - s / L), lambda = sqrt(EI / T), h = a lambda / (1 - lambda / L): slope a at the end.

    The weightless tensioned beam. Tolerance: (l0 / lambda)^2 = 0.01, of the layer's height.
    """
    ea, ei, tension, a = 1e6, 0.01, 4.0, 0.001
    layer = sqrt(ei / tension)
    taut = cable(
        0.01, ((0.0, 0.0, 0.0), (1.0 + tension / ea, 0.0, 0.0)),
        **BEAM | {"axial_stiffness": ea, "bending_stiffness": ei}, segments=200, gravity=0.0,
        clamp_a=(np.cos(a), np.sin(a), 0.0),
    )  # fmt: skip
    s = np.linspace(0, 1, 201)
    expected = a * layer / (1 - layer) * (1 - np.exp(-s / layer) - s)
    assert taut["nodes"][:, 1] == pytest.approx(expected, abs=0.01 * a * layer)


def test_damping_time_is_the_materials(cable):
    """EI (kappa + tau dkappa/dt): the logarithmic decrement of a mode is pi omega tau, whatever the mesh; to 2 %."""
    tau, h = 2e-3, 2e-4
    for n in (10, 40):
        beam = cable(
            h, ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)), **BEAM, segments=n, gravity=0.0, rho_inf=1.0, tolerance=1e-9,
            damping_time=tau,
        )  # fmt: skip
        state = beam.x[: line.STATE * (n + 1)].reshape(-1, line.STATE)
        state[:, line.V + 1] = 1e-4 * np.sin(pi * np.arange(n + 1) / n)
        u, y = beam.u.copy(), []
        for _ in range(7000):
            beam.step(u)
            y.append(beam["nodes"][n // 2, 1])
        y = np.array(y)
        peaks = y[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])]
        omega = pi**2
        assert np.log(peaks[0] / peaks[1]) == pytest.approx(pi * omega * tau, rel=0.02)


@pytest.mark.parametrize("n", [2, 3, 7])
def test_band_against_dense(n):
    """A random positive matrix of the band's shape, against numpy: solution and Schur complements to 1e-9."""
    parameters = COMPONENT.parameters(**BEAM, segments=n, bond_a=True, bond_b=True)
    made = line.unpack(COMPONENT.pack(parameters), 0.0)
    rng = np.random.default_rng(n)
    size = 3 * (n + 1)
    dense = np.zeros((size, size))
    for i in range(n - 1):
        part = rng.normal(size=(9, 9))
        dense[3 * i : 3 * i + 9, 3 * i : 3 * i + 9] += part @ part.T
    dense += np.eye(size)
    w = np.zeros(COMPONENT.sizes(parameters).workspace)
    for row in range(size):
        for column in range(row, min(row // 3 * 3 + 9, size)):
            w[made.band + banded.WIDTH * row + column - row] = dense[row, column]
    rhs = rng.normal(size=size)
    for row in range(size):
        w[banded.right(row)] = rhs[row]
    banded.solve(made, w, 1, n - 1)
    inner = slice(3, size - 3)
    got = np.array([w[banded.right(row)] for row in range(3, size - 3)])
    assert got == pytest.approx(np.linalg.solve(dense[inner, inner], rhs[inner]), rel=1e-9, abs=1e-12)
    y = np.zeros(9)
    for a, b in ((0, 0), (n, n), (0, n)):
        rows, columns = slice(3 * a, 3 * a + 3), slice(3 * b, 3 * b + 3)
        schur = dense[rows, columns] - dense[rows, inner] @ np.linalg.solve(dense[inner, inner], dense[inner, columns])
        banded.write_schur(made, w, b, a, 2.0, y, 0)
        assert y.reshape(3, 3) == pytest.approx(2.0 * schur, rel=1e-9, abs=1e-9)
