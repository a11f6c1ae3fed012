"""The chain of rigid segments where it is hard: touching, crossing, taut, reversed, stopped and parted ends."""

import numpy as np
import pytest

LENGTH = 18.288
LINEAR = {"normal_friction": 0.05, "tangential_friction": 0.05}
ROPE = {"drag_diameter": 0.01905, "fluid_density": 1000.0, "tangential_drag": 0.01, "mass_per_length": 0.55}
BOTH = pytest.mark.parametrize("given", [LINEAR, ROPE, {"normal_friction": 0.05}], ids=("linear", "rope", "across"))


class Tow:
    """A line between two boats whose paths are functions of time; velocities by differences, balances asserted."""

    def __init__(self, unit, a, b, h=0.02, segments=20, **given):
        self.paths, self.h, self.k = (a, b), h, 0
        self.line = unit("tether.linkage", self.u(), h=h, length=LENGTH, segments=segments, **given)

    def u(self):
        t, tiny = self.k * self.h, 1e-4
        row = []
        for path in self.paths:
            before, now, after = (np.array([*path(s), 0.0]) for s in (t - tiny, t, t + tiny))
            row += [now, (after - before) / (2 * tiny), (after - 2 * now + before) / tiny**2]
        return np.concatenate(row)

    def until(self, t):
        while self.k * self.h < t - 1e-9:
            self.k += 1
            self.line.step(self.u())
            assert self.line["converged"] == 1.0, self.k * self.h
            if self.line["validity.stretch"] == self.line.parameters.parted_b == 0.0:
                assert np.linalg.norm(self.line["nodes"][-1] - self.line.u[9:12]) < 1e-10 * LENGTH
        return self.line


def smooth(t, start, end):
    """From 0 to 1 between two times, at rest there."""
    s = np.clip((t - start) / (end - start), 0.0, 1.0)
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


@BOTH
def test_boats_touch_and_cross(unit, given):
    # Abreast at 0.8 m/s they come together, exactly, at 10 s, then part on the other side to 6 m.
    # 25 s later the shape is the mirrored steady one: the boats have changed sides.
    def apart(t):
        return 6.0 * (1.0 - 2.0 * smooth(t, 4.0, 16.0))

    tow = Tow(unit, lambda t: (0.8 * t, -0.5 * apart(t)), lambda t: (0.8 * t, 0.5 * apart(t)), segments=21, **given)
    before = tow.line["nodes"].copy()
    line = tow.until(10.0)
    assert np.linalg.norm(line["nodes"][0] - line["nodes"][-1]) < 1e-9
    line = tow.until(60.0)
    mirrored = before * [1.0, -1.0, 1.0] + [0.8 * 60.0, 0.0, 0.0]
    assert line["nodes"] == pytest.approx(mirrored, abs=2e-2 * LENGTH)


@BOTH
def test_a_straight_rope_says_so_and_goes_on(unit, given):
    # The boats go apart to 2 % more than the rope is long, which rigid segments cannot follow, and come back.
    def apart(t):
        return 8.0 + (1.02 * LENGTH - 8.0) * smooth(t, 2.0, 20.0) * (1.0 - smooth(t, 24.0, 42.0))

    tow = Tow(unit, lambda t: (0.5 * t, -0.5 * apart(t)), lambda t: (0.5 * t, 0.5 * apart(t)), **given)
    steady = tow.line["nodes"].copy()
    line = tow.until(22.0)
    # The stretch is 2 % over 1 %; the tension stays finite: that of an arc with a millionth of its length to spare,
    # q L / sqrt(24e-6) = 204 q L, and as much again for its other shape.
    assert line["validity.stretch"] == pytest.approx(2.0, rel=1e-3)
    assert line["validity.range"] > 1.0
    load = abs(line["force_a"][0] + line["force_b"][0])
    assert 0.0 < line["tension"].max() < 500.0 * load
    line = tow.until(90.0)
    assert line["validity.stretch"] == 0.0
    assert line["nodes"] == pytest.approx(steady + np.array([45.0, 0.0, 0.0]), abs=1e-2 * LENGTH)


@pytest.mark.parametrize("given", [LINEAR, ROPE], ids=("linear", "rope"))
def test_a_rope_laid_exactly_straight_finds_its_way(unit, given):
    # All angles alike, the ends exactly its length apart: the closure has lost rank, and the force along is open.
    line = unit(
        "tether.linkage", np.zeros(18) + np.eye(18)[10] * LENGTH, h=0.02, length=LENGTH, segments=20, start="given",
        angles=(0.5 * np.pi,) * 20, **given,
    )  # fmt: skip
    assert line["converged"] == 1.0
    u = np.zeros(18)
    for k in range(1, 500):
        u[10] = LENGTH - 0.3 * smooth(0.02 * k, 0.0, 10.0) * LENGTH
        u[0] = u[9] = 0.5 * 0.02 * k * smooth(0.02 * k, 0.0, 5.0)
        line.step(u)
        assert line["converged"] == 1.0
    assert (line["nodes"][1:-1, 0] < u[0]).all()


@BOTH
def test_the_boats_reverse(unit, given):
    # From 1 m/s ahead to 1 m/s astern within 2 s: the rope is pushed, turns inside out and trails on the other side.
    def north(t):
        return t if t < 4.0 else 4.0 + (lambda s: s - s * s / 2.0)(min(t - 4.0, 2.0)) - max(t - 6.0, 0.0)

    tow = Tow(unit, lambda t: (north(t), -4.0), lambda t: (north(t), 4.0), **given)
    start = tow.line["nodes"].copy()
    line = tow.until(80.0)
    assert line["nodes"][:, 0] - line["nodes"][0, 0] == pytest.approx(-start[:, 0], abs=2e-2 * LENGTH)


def test_one_boat_stops(unit):
    # The other one goes on, abeam of it, until the rope is nearly straight.
    stop = Tow(unit, lambda t: (0.8 * min(t, 5.0), -4.0), lambda t: (0.8 * t, 4.0), **ROPE)
    line = stop.until(24.0)
    # The distance is 15.2 / 8: 17.2 m of 18.288 m.
    assert np.linalg.norm(line["nodes"][-1] - line["nodes"][0]) == pytest.approx(np.hypot(15.2, 8.0), abs=1e-6)
    assert line["tension"].min() > 0.0


@pytest.mark.parametrize("end", ["a", "b"])
@BOTH
def test_a_tow_line_parts(unit, end, given):
    # The free rope streams behind the other boat; straight, its drag is that along it alone.
    tow = Tow(unit, lambda t: (0.8 * t, -4.0), lambda t: (0.8 * t, 4.0), **given)
    tow.until(2.0)
    tow.line.set(**{f"parted_{end}": 1.0})
    line = tow.until(120.0)
    held = "b" if end == "a" else "a"
    assert (line[f"force_{end}"] == 0.0).all()
    boat = line["nodes"][-1 if held == "b" else 0]
    behind = line["nodes"][0 if held == "b" else -1]
    # 96 m on, five times its length, the rope has come into the boat's wake; drag across alone turns it slower.
    assert boat[0] - behind[0] > 0.97 * LENGTH
    if given is LINEAR:
        assert line[f"force_{held}"][0] == pytest.approx(-0.05 * 0.8 * LENGTH, rel=1e-2)


def test_without_drag_the_middle_goes_as_a_point_mass(unit):
    # c = 0 with inertia: the centre of mass under a constant pull goes by F t^2 / 2m, which BDF2 follows exactly from a
    # first acceleration that is found over 1e-3 s, to first order in that.
    F, m, h, n = 0.3, 2.0, 0.01, 8
    line = unit(
        "tether.linkage", np.array([F, 0.0, 0.0]), h=h, length=4.0, segments=n, mass_per_length=m / 4.0,
        end_a="pulled", end_b="free", start="arc", chord=(0.0, 3.0, 0.0),
    )  # fmt: skip

    def centre():
        nodes = line["nodes"]
        return 0.5 * (nodes[1:] + nodes[:-1]).mean(axis=0)

    start = centre()
    for _ in range(200):
        line.step()
    gone = centre() - start
    assert gone[0] == pytest.approx(F * 2.0**2 / (2.0 * m), rel=1e-4)
    assert gone[1] == pytest.approx(0.0, abs=1e-6)
