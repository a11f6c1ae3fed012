"""Hard motions of the cable at its default settings, each against a closed form, a conserved sum or its own limit."""

import numpy as np
import pytest
from scipy.optimize import brentq

from components.compiled import as_compiled
from components.tether.cable import line

G = 9.80665
CHAIN = dict(
    length=3.5, segments=50, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e5, fluid_density=1000.0,
)  # fmt: skip
VACUUM = CHAIN | {"fluid_density": 0.0}
STILL = np.zeros(9)


def held(position, velocity=(0, 0, 0), acceleration=(0, 0, 0)):
    """Both ends' motions, the first at rest in the origin."""
    return np.concatenate([STILL, position, velocity, acceleration])


def masses(cable):
    lumps = np.full(cable.parameters.segments + 1, 0.1054 * 3.5 / cable.parameters.segments)
    lumps[[0, -1]] /= 2
    return lumps


def energy(cable, gravity=G):
    """Kinetic, gravitational and elastic energy [J] in vacuum."""
    q, v = cable.state[:, line.Q : line.Q + 3], cable.state[:, line.V : line.V + 3]
    n, stiffness = cable.parameters.segments, cable.parameters.axial_stiffness
    stretch = np.maximum(np.linalg.norm(np.diff(q, axis=0), axis=1) - 3.5 / n, 0)
    moving = np.sum(masses(cable) * (0.5 * np.sum(v**2, axis=1) - gravity * q[:, 2]))
    return moving + 0.5 * stiffness * n / 3.5 * (stretch @ stretch)


def thrown_taut(cable_of, h):
    """A straight weightless line that flies along itself at 1 m/s and is held at its first end from now on."""
    cable = cable_of(h, STILL, **VACUUM | {"gravity": 0.0, "end_b": "free"})
    cable.state[1:, line.V + 2] = 1.0
    return cable


def test_snap_resolved(cable_of):
    """A bar against a wall: sqrt(EA m) v at the wall until the wave is back, 2 L / c = 3.4 ms (Timoshenko, art. 167).

    The mean is exact but for the first waves of the lumped line (Gibbs' overshoot, 1 %); the impulse turns 2 m L v.
    """
    cable, wave = thrown_taut(cable_of, 1e-5), np.sqrt(4.5e5 * 0.1054)
    forces, worst = [], 0.0
    for _ in range(400):
        cable.step(STILL)
        forces.append(cable["force_a"][2])
        worst = max(worst, cable["validity.range"])
    assert worst < 1
    assert np.mean(forces[20:320]) == pytest.approx(wave, rel=0.01)
    assert np.sum(forces) * 1e-5 == pytest.approx(2 * 0.1054 * 3.5, rel=0.02)
    momentum = np.sum(masses(cable) * cable.state[:, line.V + 2])
    assert momentum - 0.1054 * 3.5 == pytest.approx(-np.sum(forces) * 1e-5, rel=0.02)


def test_snap_not_resolved_is_declared(cable_of):
    """The same at 20 ms, six wave times: the tension shown is too small, and the measure says by how much."""
    cable = thrown_taut(cable_of, 0.02)
    cable.step(STILL)
    shown = cable["tension"].max() + 0.1054 * 3.5 * G
    assert shown < 0.3 * np.sqrt(4.5e5 * 0.1054)
    assert cable["validity.snap"] * shown == pytest.approx(np.sqrt(4.5e5 * 0.1054), rel=1e-6)
    assert cable["validity.range"] > 1
    assert energy(cable, 0.0) < 0.5 * 0.1054 * 3.5


@pytest.mark.parametrize("stretch", [0.9999, 1.0001])
def test_near_taut_swings_at_irvines_frequency(cable_of, stretch):
    """Irvine 1981, Cable Structures, sect. 3.3: tan x = x - 4 x^3 / lambda^2, x = omega span sqrt(m / H) / 2.

    First symmetric mode in the plane. 1.0001: lambda^2 = 64, H = 45 N; 0.9999: 2e5, a sag of 0.6 %. Tolerance: 50
    segments and steps of 1 ms, each below 1e-3, and the parabola for the catenary.
    """
    span, m = stretch * 3.5, 0.1054
    u = held((span, 0, 0))
    cable = cable_of(0.001, u, **VACUUM)
    pull = cable["force_a"][0]
    weight = m * G * span / pull
    square = weight**2 * span / (pull * span * (1 + weight**2 / 8) / 4.5e5)
    low = np.pi / 2 if square < 4 * np.pi**2 else np.pi
    x = brentq(lambda x: np.tan(x) - x + 4 / square * x**3, low + 1e-6, low + np.pi / 2 - 1e-6)
    s = np.arange(51) / 50
    shape = 1 - np.tan(x) * np.sin(2 * x * s) - np.cos(2 * x * s)
    rest = cable["nodes"][25, 2]
    cable.state[1:-1, line.V + 2] = 1e-3 * shape[1:-1] / np.abs(shape).max()
    z = []
    for _ in range(2000):
        cable.step(u)
        z.append(cable["nodes"][25, 2] - rest)
    z = np.array(z)
    up = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    period = np.diff(up - z[up] / (z[up + 1] - z[up])).mean() * 0.001
    assert 2 * np.pi / period == pytest.approx(2 * x / span * np.sqrt(pull / m), rel=5e-3)


def ridden(cable_of, motions, h=0.02, **parameters):
    cable = cable_of(h, motions[0], **CHAIN | parameters)
    says = []
    for u in motions[1:]:
        cable.step(u)
        says.append([float(cable["converged"]), float(cable["validity.range"])])
    return cable, np.array(says)


def reversing(k):
    """Out at 1 m/s and back, turned round between two instants."""
    return held((2.0 + 0.02 * min(k, 60 - k), 0, 0.3), (1 if k < 30 else -1, 0, 0))


def racing(k):
    """Round at 6 m/s, where transverse waves run at sqrt(T / m) = 3 m/s."""
    across = np.array([np.cos(0.15 * k), -np.sin(0.15 * k), 0])
    along = np.array([np.sin(0.15 * k), np.cos(0.15 * k), 0])
    return held((2.2, 0, 0) - 0.8 * across, 6 * along, 45 * across)


@pytest.mark.parametrize("motion", [reversing, racing])
def test_rough_ends_converge_to_one_motion(cable_of, motion):
    """Against 256 fixed sub-steps a period: the shape within 1 % of the length, every balance met."""
    motions = [motion(k) for k in range(61)]
    fine, _ = ridden(cable_of, motions, sub_steps=256)
    coarse, says = ridden(cable_of, motions)
    assert says[:, 0].min() == 1
    assert np.linalg.norm(coarse["nodes"] - fine["nodes"], axis=1).max() < 0.035


def test_end_that_does_not_move(cable_of):
    """Steps of zero length leave a line at rest where it is: the same end motions, to rounding."""
    cable, says = ridden(cable_of, [held((2, 0.3, 0.5))] * 200)
    rest = cable_of(0.02, held((2, 0.3, 0.5)), **CHAIN)
    assert np.abs(cable["nodes"] - rest["nodes"]).max() < 1e-9
    assert says.max(0) == pytest.approx([1, says[0, 1]])


def test_end_that_says_it_moves_but_does_not(cable_of):
    """A held position with a velocity of 1 m/s, which no motion has: followed all the same, and bounded."""
    cable, says = ridden(cable_of, [held((2, 0, 0.5), (1, 0, 0))] * 100)
    assert says[:, 0].min() == 1
    assert np.abs(cable["nodes"]).max() < 3.5


@as_compiled
def leapfrog(q, v, f, length, stiffness, damping, mass, h, steps, z):
    """The same lumped chain by another method: explicit steps of h [s] from the nodes q (x, z), the first one held."""
    n = len(q) - 1
    for step in range(steps):
        for i in range(n + 1):
            f[i, 0], f[i, 1] = 0.0, mass[i] * G
        for i in range(n):
            dx, dz = q[i + 1, 0] - q[i, 0], q[i + 1, 1] - q[i, 1]
            d = np.sqrt(dx * dx + dz * dz)
            rate = ((v[i + 1, 0] - v[i, 0]) * dx + (v[i + 1, 1] - v[i, 1]) * dz) / d
            pull = max(stiffness * (d - length) + damping * rate, 0.0) / d if d > length else 0.0
            f[i, 0], f[i, 1] = f[i, 0] + pull * dx, f[i, 1] + pull * dz
            f[i + 1, 0], f[i + 1, 1] = f[i + 1, 0] - pull * dx, f[i + 1, 1] - pull * dz
        for i in range(1, n + 1):
            for c in range(2):
                v[i, c] += h * f[i, c] / mass[i]
                q[i, c] += h * v[i, c]
        z[step] = q[n, 1]


def folded(cable_of, n, h):
    """The tip's fall [m] at each h [s], of a chain that hung by both ends 2 % of its length apart, and its start."""
    hung = cable_of(h, held((0.07, 0, 0)), **VACUUM | {"segments": n})
    fall = cable_of(h, STILL, **VACUUM | {"segments": n, "end_b": "free"})
    fall.x[:] = hung.x
    z = []
    for _ in range(round(0.95 * np.sqrt(7 / G) / h)):
        fall.step(STILL)
        assert fall["converged"] == 1
        z.append(fall["nodes"][n, 2])
    return np.array(z), hung


def fall_time(z, h):
    """Until the tip is lowest, over that of a free fall of 3.5 m."""
    return h * (1 + np.argmax(z)) / np.sqrt(7 / G)


@pytest.mark.parametrize("n", [50, 100, 200])
def test_folded_chain_falls_faster_than_free(cable_of, n):
    """Calkin and March 1989 (Am. J. Phys. 57): v^2 = g x (2 L - x) / (L - x), down in 0.8472 of a free fall's time.

    The formula is for a fold of no width and no loss. A chain of n links takes the longer, by 1.7 / n of it in
    `leapfrog`: the tip turns with the last links. Tolerance 2.5 / n of the time; of the speed between 75 and 85 % of
    the depth 4 / n, for in the whirl it varies by as much.
    """
    h = 2e-3
    z, _ = folded(cable_of, n, h)
    assert 0.8472 < fall_time(z, h) < 0.8472 * (1 + 2.5 / n)
    x, down = np.array([0.75, 0.85]) * 3.5, np.argmax(z)
    speed = np.diff(x) / np.diff(np.interp(x, z[: down + 1], h * np.arange(1, down + 2)))
    assert speed[0] == pytest.approx(np.sqrt(G * 0.8 * 3.5 * 1.2 / 0.2), rel=4 / n)


def test_folded_chain_of_links_falls_as_an_explicit_one(cable_of):
    """50 links: the time of 10^6 explicit steps of a chain whose links meet without rebound, 0.876; to 1 %.

    What an impact gives back is not the line's alone: without damping the explicit one is down at 0.866.
    """
    n, h, length = 50, 2e-3, 3.5 / 50
    z, hung = folded(cable_of, n, h)
    q = np.ascontiguousarray(hung["nodes"][:, [0, 2]])
    h_explicit, stiffness = 2e-6, 4.5e4 / length
    reference = np.zeros(round(0.95 * np.sqrt(7 / G) / h_explicit))
    v, f = np.zeros_like(q), np.zeros_like(q)
    leapfrog(q, v, f, length, stiffness, 5e-5 * stiffness, masses(hung), h_explicit, len(reference), reference)
    assert fall_time(reference, h_explicit) == pytest.approx(0.876, abs=1e-3)
    assert fall_time(z, h) == pytest.approx(fall_time(reference, h_explicit), rel=0.01)


def test_energy_does_not_grow_in_closed_motion(cable_of):
    """A chain let go from a straight line between held ends falls, goes taut, snaps and swings on in vacuum.

    Never more than its energy at first but for 0.1 %, at 20 ms and the default scheme; the snaps take what they take.
    """
    u = held((3.0, 0, 0))
    cable = cable_of(0.02, u, **VACUUM)
    cable.state[:, line.Q] = 3.0 * np.arange(51) / 50
    cable.state[:, line.Q + 2] = 0.0
    cable.state[1:-1, line.ACC + 2] = cable.state[1:-1, line.A + 2] = G
    cable.state[:, line.T] = 0.0
    energies = []
    for _ in range(500):
        cable.step(u)
        energies.append(energy(cable))
        assert cable["converged"] == 1
    assert max(energies) < 1e-3 * 0.1054 * 3.5 * G


def test_unconverged_is_a_failure(cable_of):
    """A finite result that does not balance says so, in `converged` and in its range."""
    motions = [held((2 + 0.3 * np.sin(0.3 * k), 0, 0)) for k in range(10)]
    cable, says = ridden(cable_of, motions, max_iterations=1, tolerance=1e-13)
    assert np.isfinite(cable["nodes"]).all()
    failed = says[:, 0] == 0
    assert failed.any()
    assert (says[failed, 1] > 1).all()


@pytest.mark.parametrize("n", [8, 32])
def test_axial_damping_is_the_materials(cable_of, n):
    """T = EA (e + tau de/dt): the logarithmic decrement of an axial mode is pi omega tau, whatever the mesh; to 3 %.

    First mode of a taut weightless line, omega = 2 sqrt(k / m) sin(pi / 2 n); 200 steps a period, whose own damping is
    below 1 % of it.
    """
    tau, k, m = 1.1e-5, 4.5e5 * n / 3.5, 0.1054 * 3.5 / n
    omega = 2 * np.sqrt(k / m) * np.sin(np.pi / (2 * n))
    u = held((3.5035, 0, 0))
    cable = cable_of(np.pi / omega / 100, u, **VACUUM | {"segments": n, "gravity": 0.0, "damping_time": tau})
    cable.state[:, line.V] = 0.1 * np.sin(np.pi * np.arange(n + 1) / n)
    x = []
    for _ in range(1000):
        cable.step(u)
        x.append(cable["nodes"][n // 2, 0] - 0.5 * 3.5035)
    peaks = [max(np.abs(x[i : i + 100])) for i in range(0, 1000, 100)]  # one in each half period
    decrement = 2 * np.log(peaks[0] / peaks[-1]) / (len(peaks) - 1)
    assert decrement == pytest.approx(np.pi * omega * tau, rel=0.03)


def test_neutral_line_rings_as_a_string_in_water(cable_of):
    """omega = pi / L sqrt(T / (m + Ca rho V)), straight at rest: what is left without weight is tension, added mass."""
    neutral = CHAIN | {"volume_per_length": 0.1054 / 1000, "normal_drag": 0.0}
    u, h = held((3.5 * 1.0001, 0, 0)), 2e-3
    cable = cable_of(h, u, **neutral)
    assert np.abs(cable["nodes"][:, 1:]).max() < 1e-12
    cable.state[:, line.V + 2] = 1e-3 * np.sin(np.pi * np.arange(51) / 50)
    z = []
    for _ in range(2000):
        cable.step(u)
        z.append(cable["nodes"][25, 2])
    z = np.array(z)
    up = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    period = np.diff(up - z[up] / (z[up + 1] - z[up])).mean() * h
    tension = 4.5e5 * 1e-4
    assert 2 * np.pi / period == pytest.approx(np.pi / 3.5 * np.sqrt(tension / (2 * 0.1054)), rel=2e-3)


def test_buoyant_line_is_the_mirror_of_a_heavy_one(cable_of):
    """Twice as much water as line: upside down it moves as it would with gravity upwards; to Newton's tolerance."""
    motions = [reversing(k) for k in range(61)]
    turned = [u * np.tile([1, 1, -1], 6) for u in motions]
    buoyant = {"volume_per_length": 2 * 0.1054 / 1000}
    up, _ = ridden(cable_of, motions, **buoyant)
    down, says = ridden(cable_of, turned, **buoyant, gravity=-G)
    assert says[:, 0].min() == 1
    assert up["nodes"][:, 2].min() < -0.5
    assert up["nodes"] == pytest.approx(down["nodes"] * [1, 1, -1], abs=1e-5)


@pytest.mark.parametrize("slackens", [True, False])
def test_slack_line_pushes_nothing(cable_of, slackens):
    """Drawn together at 1 m/s a weightless straight line that takes no compression stays where it is, pulls at nothing.

    One that does take it pushes with its waves: sqrt(EA m) v. Tolerance: k times the rounding of a length.
    """
    cable = cable_of(1e-5, held((3.5, 0, 0)), **VACUUM | {"gravity": 0.0, "tension_only": slackens})
    for k in range(1, 101):
        cable.step(held((3.5 - 1e-5 * k, 0, 0), (-1, 0, 0)))
    if slackens:
        assert np.abs(cable["nodes"][:-1, 0] - 3.5 * np.arange(50) / 50).max() < 1e-12
        assert cable["tension"].max() < 1e-8
        assert np.abs(cable["force_b"]).max() < 1e-8
    else:
        assert cable["force_b"][0] == pytest.approx(np.sqrt(4.5e5 * 0.1054), rel=0.05)
