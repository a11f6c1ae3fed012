"""Sections, clump weights and floats: plain statics, the uniform line they must agree with, and moments."""

import numpy as np
import pytest

from components.tether.cable.component import COMPONENT

G = 9.80665
LINE = dict(
    length=10.0, segments=40, mass_per_length=0.5, volume_per_length=1e-4, drag_diameter=0.02, axial_stiffness=1e6,
    fluid_density=1000.0,
)  # fmt: skip
W = (0.5 - 0.1) * G


def test_equal_sections_are_the_uniform_line(cable):
    """The same line in two sections: shape and tension to Newton's rounding, at rest and after 2 s of motion."""
    halves = ({"length": 4.0, "segments": 16}, {"length": 6.0, "segments": 24})
    u = np.zeros(18)
    u[9:12] = (7.0, 0.0, 1.0)
    one, two = (cable(0.02, u, **LINE | {"tolerance": 1e-10} | more) for more in ({}, {"sections": halves}))
    for k in range(1, 101):
        t = 0.02 * k
        u[11], u[14], u[17] = (
            1 + np.sin(t) ** 3,
            3 * np.sin(t) ** 2 * np.cos(t),
            3 * np.sin(t) * (3 * np.cos(t) ** 2 - 1),
        )
        one.step(u)
        two.step(u)
    assert two["nodes"] == pytest.approx(one["nodes"], abs=1e-8)
    assert two["tension"] == pytest.approx(one["tension"], rel=1e-4)


def test_heavy_section_hangs_as_statics_says(cable):
    """Hanging free: tension is the weight below, each segment stretched by its own EA."""
    sections = (
        {"length": 6.0, "segments": 6, "axial_stiffness": 1e4},
        {"length": 4.0, "segments": 8, "mass_per_length": 2.0, "volume_per_length": 2e-4},
    )
    line = cable(0.02, np.zeros(9), **LINE | {"end_b": "free", "segments": 14, "sections": sections})
    heavy = (2.0 - 0.2) * G
    below = np.concatenate([4 * heavy + W * (5.5 - np.arange(6)), heavy * 0.5 * (7.5 - np.arange(8))])
    assert line["tension"] == pytest.approx(below, rel=1e-6)
    assert np.diff(line["nodes"][:, 2])[:6] == pytest.approx(1 + below[:6] / 1e4, rel=1e-9)


def test_clump_bends_the_line_where_it_is(cable):
    """A clump of any place and a float: forces at the ends carry all weights, and moments balance about end a.

    Wherever between two nodes the clump is, its weight and the weight's lever arm are those of its place on the chord.
    """
    clumps = ({"at": 3.1, "mass": 2.0, "volume": 2.5e-4}, {"at": 7.04, "volume": 1e-3})
    line = cable(0.02, ((0.0, 0.0, 0.0), (8.0, 0.0, 1.0)), **LINE | {"clumps": clumps})
    weights = np.array([(2.0 - 0.25) * G, -1.0 * G])
    q = line["nodes"]
    assert line.status == 0
    assert (line["force_a"] + line["force_b"])[2] == pytest.approx(10 * W + weights.sum(), abs=1e-6)
    places = np.array([np.interp(c["at"], 0.25 * np.arange(41), q[:, 0]) for c in clumps])
    middles = 0.5 * (q[1:, 0] + q[:-1, 0])
    moment = np.sum(places * weights) + np.sum(middles * W * 0.25)
    force = line["force_b"]
    assert q[-1, 0] * force[2] - q[-1, 2] * force[0] == pytest.approx(moment, rel=1e-6)


def test_clump_on_a_towed_line_is_a_sphere_in_the_flow(cable):
    """A body alone on a line of almost nothing: drag over weight; then it falls with added mass."""
    thin = dict(
        length=2.0, segments=4, mass_per_length=1e-5, volume_per_length=0.0, drag_diameter=0.0, axial_stiffness=1e5,
        fluid_density=1000.0, end_b="free",
    )  # fmt: skip
    ball = {"at": 2.0, "mass": 3.0, "volume": 1e-3, "drag_area": 0.01}
    towed = cable(0.02, np.zeros(9), **thin, clumps=(ball,), current=(0.0, 1.5, 0.0))
    span = towed["nodes"][-1] - towed["nodes"][0]
    assert span[1] / span[2] == pytest.approx(0.5 * 1000 * 0.01 * 1.5**2 / (2.0 * G), rel=1e-4)
    h = 1e-3
    u = np.concatenate([np.zeros(8), [20.0]])  # the holder falls faster than the ball
    falling = cable(h, np.zeros(9), **thin, clumps=(ball,))
    v = []
    for k in range(1, 26):
        u[2], u[5] = 10.0 * (h * k) ** 2, 20.0 * h * k
        z = falling["nodes"][-1, 2]
        falling.step(u)
        v.append((falling["nodes"][-1, 2] - z) / h)
    assert (v[20] - v[10]) / (10 * h) == pytest.approx(2.0 * G / 3.5, rel=3e-3)  # ten steps of transient; drag 1e-3


def test_refuses_what_does_not_fit():
    part = {"length": 4.0, "segments": 16}
    for wrong, text in (
        ({"sections": (part,)}, "sum up to 4 m in 16 segments"),
        ({"clumps": ({"at": 11.0},)}, "clumps.0 is at 11 m of a line of 10 m"),
        ({"current": (1, 0, 0), "current_profile": ({"depth": 0, "velocity": (1, 0, 0)},)}, "either current or"),
        ({"clamp_a": (1, 0, 0)}, "without bending_stiffness"),
        ({"clamp_a": (2, 0, 0), "bending_stiffness": 1.0}, "direction of length 1"),
        ({"seabed_friction": 0.5}, "without a seabed"),
    ):
        with pytest.raises(ValueError, match=text):
            COMPONENT.parameters(**LINE | wrong)
