"""The momentum of each node of random lines, written anew with numpy from positions, velocities and accelerations."""

import numpy as np
import pytest

from components.tether.cable import line as layout

G, RHO = 9.80665, 1025.0
SECTION = ("axial_stiffness", "mass_per_length", "volume_per_length", "drag_diameter", "tangential_drag")


def drawn(random):
    """Parameters, period [s] and far end of a random line of one to three sections, clumps on it, in a current."""
    length, mass, buoyancy = (
        10 ** random.uniform(-0.3, 2.7),
        10 ** random.uniform(-2, 2),
        random.choice([0.0, 0.3, 1.5]),
    )
    volume, weight = buoyancy * mass / RHO, mass * G * length
    diameter = np.sqrt(4 / np.pi * mass * max(buoyancy, 0.1) / RHO)

    def properties():
        return {
            "axial_stiffness": weight * 10 ** random.uniform(1.5, 5.5),
            "mass_per_length": mass * random.uniform(0.5, 2),
            "volume_per_length": volume * random.uniform(0.5, 1.2), "drag_diameter": diameter * random.uniform(0.5, 2),
            "tangential_drag": random.choice([0.0, 0.05]), "normal_added_mass": random.uniform(0, 1.5),
            "tangential_added_mass": random.uniform(0, 0.2),
        }  # fmt: skip

    lengths = random.dirichlet(3 * np.ones(random.integers(1, 4))) * length
    sections = tuple({"length": x, "segments": int(random.integers(2, 10)), **properties()} for x in lengths)
    line = properties() | {
        "length": sum(s["length"] for s in sections), "segments": sum(s["segments"] for s in sections),
        "sections": sections, "current": tuple(random.uniform(-1, 1, 3) * [1, 1, 0.1]),
        "clumps": tuple(
            {"at": random.uniform(0, 1) * length, "mass": 0.2 * mass * length * random.uniform(),
             "volume": 0.3 * volume * length * random.uniform(), "drag_area": 0.1 * diameter * length}
            for _ in range(random.integers(3))
        ),
    }  # fmt: skip
    far = length * random.uniform(0.2, 0.98) * np.append(random.normal(size=2), 0.5 * random.normal())
    far *= min(1.0, 0.98 * length / np.linalg.norm(far))
    if random.uniform() < 0.4:
        line["damping_time"] = 10 ** random.uniform(-3, -1)
    elif random.uniform() < 0.4:
        line["bending_stiffness"] = weight * length**2 * 10 ** random.uniform(-6, -3)
    if random.uniform() < 0.4:
        line |= {"seabed": max(far[2], 0) + 0.1 * length, "seabed_friction": random.choice([0.0, 0.6])}
    return line, 10 ** random.uniform(-2.5, -0.7), far


def swinging(far, length, random):
    """The ends' motions by time: the second one swings from rest, at 10 m/s at most."""
    omega = 2 * np.pi * 10 ** random.uniform(-1, 0.5)
    swing = 10 ** random.uniform(-2, -0.5) * length * random.normal(size=3)
    swing *= min(1.0, 10 / (omega * np.linalg.norm(swing)))

    def ends(t):
        s, c = np.sin(omega * t), np.cos(omega * t)
        moving = s**3, 3 * omega * s**2 * c, 3 * omega**2 * (2 * s * c**2 - s**3)
        return np.concatenate([np.zeros(9), far + moving[0] * swing, moving[1] * swing, moving[2] * swing])

    return ends


def per_segment(line):
    """{parameter: its values in all segments} and the segments' lengths."""
    names = (*SECTION, "normal_added_mass", "tangential_added_mass")
    values = {
        name: np.repeat([s[name] for s in line["sections"]], [s["segments"] for s in line["sections"]])
        for name in names
    }
    return values, np.concatenate([np.full(s["segments"], s["length"] / s["segments"]) for s in line["sections"]])


def imbalance(line, state):
    """Largest force [N] that is missing at an inner node, and the scale of all forces."""
    q, v, a = (state[:, k : k + 3] for k in (layout.Q, layout.V, layout.ACC))
    own, l0 = per_segment(line)
    half, displaced, current = own["mass_per_length"] * l0 / 2, RHO * own["volume_per_length"] * l0 / 2, line["current"]
    edges = np.diff(q, axis=0)
    length = np.linalg.norm(edges, axis=1)
    t = edges / length[:, None]
    rate = np.einsum("ij,ij->i", np.diff(v, axis=0), t)
    tension = own["axial_stiffness"] / l0 * (length - l0 + line.get("damping_time", 0.0) * rate)
    stiffness = line.get("bending_stiffness", 0.0)
    if stiffness == 0.0:
        tension = np.maximum(tension, 0.0)
    force = np.zeros_like(q)
    force[:-1] += tension[:, None] * t
    force[1:] -= tension[:, None] * t
    pressure = (0.5 * RHO * own["drag_diameter"] * l0 / 2)[:, None]
    for j in (0, 1):  # at both ends of each segment
        node = slice(j, len(l0) + j)
        along = np.einsum("ij,ij->i", v[node] - current, t)[:, None] * t
        across = v[node] - current - along
        surge = np.einsum("ij,ij->i", a[node], t)[:, None] * t
        force[node] -= 1.2 * pressure * np.linalg.norm(across, axis=1)[:, None] * across
        force[node] -= (
            np.pi * own["tangential_drag"][:, None] * pressure * np.linalg.norm(along, axis=1)[:, None] * along
        )
        force[node] -= half[:, None] * a[node]
        force[node] -= displaced[:, None] * own["normal_added_mass"][:, None] * (a[node] - surge)
        force[node] -= displaced[:, None] * own["tangential_added_mass"][:, None] * surge
        force[node, 2] += (half - displaced) * G
    for i in range(1, len(l0)):  # energy B (1 - t0 . t1) of each node between two segments
        b = stiffness * 2.0 / (l0[i - 1] + l0[i])
        after, before = t[i - 1] - (t[i - 1] @ t[i]) * t[i], t[i] - (t[i] @ t[i - 1]) * t[i - 1]
        after, before = b * after / length[i], b * before / length[i - 1]
        force[i - 1] -= before
        force[i] += before - after
        force[i + 1] += after
    places = np.concatenate([[0.0], np.cumsum(l0)])
    for clump in line["clumps"]:
        for i in range(len(places)):
            share = np.interp(clump["at"], places, np.eye(len(places))[i])
            flow, mass = v[i] - current, clump["mass"] + 0.5 * RHO * clump["volume"]
            force[i] -= share * (0.5 * RHO * clump["drag_area"] * np.linalg.norm(flow) * flow + mass * a[i])
            force[i, 2] += share * (clump["mass"] - RHO * clump["volume"]) * G
    if "seabed" in line:
        force = on_bed(
            line, force, q, v, l0, (half - displaced).sum() * 2 * G, half, displaced * own["normal_added_mass"]
        )
    dry = 2 * half.sum() * G + sum(clump["mass"] for clump in line["clumps"]) * G
    return np.abs(force[1:-1]).max(), dry + np.abs(tension).max()


def on_bed(line, force, q, v, l0, weight, half, added):
    """The forces with the bed's: its support, and sideways what friction need not hold."""
    stiffness = abs(weight) / line["length"] / (0.1 * line["drag_diameter"])
    onset, sunk = 2 * abs(weight) / line["length"] / stiffness, q[:, 2] - line["seabed"]
    critical = 2 * np.sqrt(2 * (half + added).sum() / line["length"] / stiffness)
    depth = np.clip(sunk, 0, onset)
    support = (
        stiffness * (depth**2 / (2 * onset) + np.maximum(sunk - onset, 0))
        + critical * stiffness * depth / onset * v[:, 2]
    )
    share = 0.5 * (np.append(l0, 0) + np.append(0, l0))
    support = np.where(sunk > 0, np.maximum(support, 0), 0) * share
    left = force - support[:, None] * [0, 0, 1]
    side = np.linalg.norm(left[:, :2], axis=1)
    held = np.minimum(1.0, line["seabed_friction"] * support / np.maximum(side, 1e-300))
    left[:, :2] *= (1.0 - held)[:, None]
    return left


def is_calmed(state):
    """Whether the accelerations are means over the step, as after an iteration that failed on the way."""
    inner = state[1:-1]
    return np.array_equal(inner[:, layout.ACC : layout.ACC + 3], inner[:, layout.A : layout.A + 3])


@pytest.mark.parametrize("part", range(2))
def test_every_node_balances(cable, part):
    """30 lines, 12 periods each. Tolerance: 1e-6 of dry weight and tension is the line's own, 3 allows for its scale
    (the last tension, where Newton's is meant) and a few roundings of the lengths.
    """
    judged = 0
    for seed in range(30 * part, 30 * part + 30):
        random = np.random.default_rng(seed)
        line, h, far = drawn(random)
        ends = swinging(far, line["length"], random)
        ridden = cable(h, ends(0.0), **line)
        assert ridden.status == 0
        for k in range(1, 13):
            ridden.step(ends(k * h))
            if ridden["converged"] == 0.0 or is_calmed(ridden.state):
                continue
            missing, scale = imbalance(line, ridden.state)
            own, l0 = per_segment(line)
            rounding = (own["axial_stiffness"] / l0).max() * np.abs(ridden.state[:, : layout.V]).max() * 2.0**-52
            assert missing <= 3e-6 * scale + 20 * rounding, seed
            judged += 1
    assert judged > 300
