"""A run must say that it is wrong when it is: results that look like any other, and are beyond the validity range."""

import numpy as np
import pytest

from components.tether.cable.component import COMPONENT, NO_EQUILIBRIUM

CHAIN = {"mass_per_length": 0.1705, "volume_per_length": 7.85e-5, "drag_diameter": 0.01}


def between(a, b):
    u = np.zeros(18)
    u[0:3], u[9:12] = a, b
    return u


@pytest.mark.parametrize(("stiffness", "is_right"), [(5e5, True), (1e9, False)])
def test_rounding_far_from_the_origin(cable_of, stiffness, is_right):
    # Northings of a map are 6.7e6 m, of which a double keeps 0.9 nm: times EA / l0 that is 7 mN or 13 N, beside a
    # tension of 1.6 N. The same line at the origin tells what is right; 1 % is what the range stands for.
    forces = []
    for north in (0.0, 6.7e6):
        u = between((north, 0, 1), (north + 2.0, 0, 1))
        line = cable_of(0.02, u, length=3.5, axial_stiffness=stiffness, **CHAIN)
        line.step(u)
        forces.append(line["force_a"])
    assert bool(np.linalg.norm(forces[1] - forces[0]) < 0.01 * np.linalg.norm(forces[0])) is is_right
    assert bool(line["validity.range"] <= 1.0) is is_right


def whipped(t):
    """Ends 9 m apart, the second one swinging by 6 m at up to 24 m/s."""
    u = between((0, 0, 0), (9.0 + 3.0 * (1 - np.cos(8 * t)), 0, 0))
    u[12], u[15] = 24.0 * np.sin(8 * t), 192.0 * np.cos(8 * t)
    return u


def test_a_broken_line_does_not_break_again(cable_of):
    given = {"length": 10.0, "segments": 10, "axial_stiffness": 1e5, "breaking_load": 50.0, **CHAIN}
    line = cable_of(0.02, whipped(0.0), **given)
    line.p[:] = COMPONENT.pack(COMPONENT.parameters(**given, cut=3))
    overloaded = 0
    for k in range(1, 41):
        line.step(whipped(0.02 * k))
        if line["tension"].max() > 50.0:
            overloaded += 1
            assert line["validity.again"] >= line["tension"].max() / 50.0
            assert line["validity.range"] > 1.0
    assert overloaded > 0


def test_a_second_cut_is_not_made_in_silence(cable_of):
    u = between((0, 0, 0), (9, 0, 0))
    given = {"length": 10.0, "segments": 10, "axial_stiffness": 1e5, **CHAIN}
    line = cable_of(0.02, u, **given)
    for segment, beyond in ((3, False), (3, False), (8, True)):
        line.p[:] = COMPONENT.pack(COMPONENT.parameters(**given, cut=segment))
        line.step(u)
        assert line["broken_segment"] == 3
        assert bool(line["validity.again"] > 1.0) is beyond


def test_a_line_inside_the_bed(cable_of):
    # An end 2 m below the bed is pushed up by a force that no bed has; on the bed the line sinks by 0.1 diameters.
    for depth, beyond in ((5.0, False), (7.0, True)):
        given = {"length": 10.0, "segments": 10, "axial_stiffness": 1e8, "seabed": 5.0, **CHAIN}
        line = cable_of(0.02, between((0, 0, depth), (8, 0, 0)), **given)
        assert bool(line["validity.sinking"] > 1.0) is beyond


def test_a_line_out_of_the_water(cable_of):
    # Where there are waves the surface is known: 5 m above it on 20 m of line, or awash on a crest 1 m high.
    for height, beyond in ((5.0, True), (0.9, False)):
        given = {"length": 20.0, "segments": 20, "axial_stiffness": 1e5, "waves": ({"amplitude": 1.0, "period": 8.0},)}
        line = cable_of(0.02, between((0, 0, -height), (0, 15, 5)), **given, **CHAIN)
        assert bool(line["validity.emerging"] > 1.0) is beyond


def test_a_winch_keeps_what_it_paid_out_when_the_line_breaks(cable_of):
    # Breaks some way into a period of 0.1 s, in which 0.05 m are paid out; against a period of 2 ms, in which 1 mm is.
    lengths = []
    for h in (0.1, 0.002):
        u = np.zeros(19)
        u[9] = 9.9
        given = {"length": 10.0, "segments": 10, "axial_stiffness": 1e4, "winch": "a", "breaking_load": 60.0}
        line = cable_of(h, u, damping_time=0.05, **given, **CHAIN)
        k = 0
        while line["broken_segment"] == 0.0:
            k += 1
            t = k * h
            u[9], u[12], u[15], u[18] = 9.9 + 0.25 * t**2, 0.5 * t, 0.5, 0.5 * min(t, 1.0)
            line.step(u)
        lengths.append(line["unstretched_length"])
    assert lengths[0] == pytest.approx(lengths[1], abs=0.005)
    assert lengths[0] % 0.05 > 0.005  # that is not what either end of the period has


def test_an_inextensible_line_that_is_too_short(cable_of):
    # Ends that part beyond the line's length: the tension that Newton finds is 1e13 N, where there is none.
    def parting(t):
        u = between((0, 0, 0), (9.9 + 0.25 * t**2, 0, 0))
        u[12], u[15] = 0.5 * t, 0.5
        return u

    line = cable_of(0.05, parting(0.0), length=10.0, segments=20, axial_stiffness=None, **CHAIN)
    for k in range(1, 21):
        line.step(parting(0.05 * k))
        is_too_short = np.linalg.norm(line["nodes"][-1] - line["nodes"][0]) > 10.0
        assert bool(line["validity.range"] > 1.0) or not is_too_short
        assert bool(line["validity.strain"] <= 1.0) or is_too_short
    assert is_too_short


def test_an_inextensible_line_that_is_too_short_at_once(cable):
    line = cable(0.05, between((0, 0, 0), (10.01, 0, 0)), length=10.0, segments=20, axial_stiffness=None, **CHAIN)
    assert line.status == NO_EQUILIBRIUM
