"""Random lines at default settings: each run is right by what can be checked from outside, or says that it is not."""

import numpy as np
import pytest

G = 9.80665
NO_EQUILIBRIUM, BREAKS_AT_REST = 2, 4


def drawn(random):
    """Parameters, period [s] and far end of a random line, whose ends are nearer to each other than it is long."""
    length, mass = 10 ** random.uniform(-0.5, 3), 10 ** random.uniform(-2.5, 2.3)
    segments, buoyancy = round(10 ** random.uniform(0.5, 1.7)), random.choice([0.1, 0.5, 0.9, 2.0])
    diameter = np.sqrt(4 / np.pi * mass * max(buoyancy, 0.1) / 1025)
    weight = mass * G * length
    line = dict(
        length=length, segments=segments, mass_per_length=mass, volume_per_length=buoyancy * mass / 1025,
        drag_diameter=diameter, axial_stiffness=weight * 10 ** random.uniform(1, 6),
    )  # fmt: skip
    far = length * random.uniform(0.2, 0.98) * np.append(random.normal(size=2), 0.5 * random.normal())
    far *= min(1.0, 0.98 * length / np.linalg.norm(far))
    terms = {
        "current": {"current": (*random.uniform(-1, 1, 2), 0.0)},
        "bed": {"seabed": max(far[2], 0) + 0.1 * length, "seabed_friction": random.uniform(0, 1.2)},
        "stiff": {"bending_stiffness": weight * length**2 * 10 ** random.uniform(-6, -2)},
        "inextensible": {"axial_stiffness": None},
        "bonded": {"bond_b": True},
        "damped": {"damping_time": 10 ** random.uniform(-3, -1)},
        "breaking": {"breaking_load": weight * 10 ** random.uniform(0, 2)},
    }
    for term in random.choice(list(terms), 2, replace=False):
        line |= terms[term]
    return line, 10 ** random.uniform(-2.5, -0.7), far


def motion(far, length, random):
    """The ends' motions by time: the second one swings from rest, at 10 m/s at most."""
    omega = 2 * np.pi * 10 ** random.uniform(-1, 0.5)
    swing = 10 ** random.uniform(-2, -0.5) * length * random.normal(size=3)
    swing *= min(1.0, 10 / (omega * np.linalg.norm(swing)))

    def ends(t):
        s, c = np.sin(omega * t), np.cos(omega * t)
        moving = s**3, 3 * omega * s**2 * c, 3 * omega**2 * (2 * s * c**2 - s**3)
        offset = np.concatenate([far, np.zeros(6)])
        return np.concatenate([np.zeros(9), offset + np.concatenate([f * swing for f in moving])])

    return ends


def stray_tension(line, cable):
    """Largest difference of a tension [N] from Hooke's law over the nodes, and what rounding may make of it."""
    nodes, l0 = cable["nodes"], line["length"] / line["segments"]
    k = line["axial_stiffness"] / l0
    law = k * (np.linalg.norm(np.diff(nodes, axis=0), axis=1) - l0)
    if "bending_stiffness" not in line:
        law = np.maximum(law, 0)
    stray = np.abs(cable["tension"] - law)
    broken = int(cable["broken_segment"])
    if broken:
        stray[broken - 1] = 0
    scale = line["mass_per_length"] * G * line["length"] + np.abs(law).max()
    return stray.max(), 2e-6 * scale + 8 * np.finfo(float).eps * k * np.abs(nodes).max()


@pytest.mark.parametrize("part", range(4))
def test_random_lines_are_right_or_say_so(cable, part):
    """25 lines, 25 periods each. Finite always; a step that did not converge is beyond its validity range.

    Of all that did, the tensions obey Hooke's law over the nodes (to the tolerance of a balance). Two lines of 25 may
    have steps that do not: what is thrown about at 10 m/s on a bond, or beyond its length if it does not stretch.
    """
    wrong, refused = 0, 0
    for seed in range(25 * part, 25 * part + 25):
        random = np.random.default_rng(seed)
        line, h, far = drawn(random)
        ends = motion(far, line["length"], random)
        ridden = cable(h, ends(0.0), **line)
        if ridden.status != 0:
            assert ridden.status in (NO_EQUILIBRIUM, BREAKS_AT_REST)
            refused += ridden.status == NO_EQUILIBRIUM
            continue
        failed = False
        for k in range(1, 26):
            ridden.step(ends(k * h))
            assert ridden.status == 0
            assert np.isfinite(ridden.y).all()
            if ridden["converged"] == 0:
                assert ridden["validity.range"] > 1
                failed = True
            elif line["axial_stiffness"] is not None and "damping_time" not in line:
                stray, allowed = stray_tension(line, ridden)
                assert stray <= allowed
        wrong += failed
    assert wrong <= 2
    assert refused <= 1
