"""Hard lines at rest and set moving: every static start is found, and 2 s of motion converge, at default settings."""

import numpy as np
import pytest

LINE = dict(
    length=10.0, segments=30, mass_per_length=0.5, volume_per_length=1e-4, drag_diameter=0.02, axial_stiffness=1e5,
    fluid_density=1000.0,
)  # fmt: skip
SEA = {
    "current_profile": (
        {"depth": 0.0, "velocity": (0.8, 0.0, 0.0)},
        {"depth": 8.0, "velocity": (0.0, 0.3, 0.0)},
    ),
    "waves": ({"amplitude": 0.2, "period": 3.0}, {"amplitude": 0.1, "period": 2.0, "direction": 1.0}),
}  # fmt: skip
BED = {"seabed": 4.0, "seabed_friction": 0.5}
STIFF = {"bending_stiffness": 0.5}
BUOYANT, NEUTRAL = {"volume_per_length": 8e-4}, {"volume_per_length": 5e-4}
SLACK, TAUT, ABOVE, HERE = (6.0, 0.0, 1.0), (9.99, 0.0, 1.0), (0.0, 0.0, 3.0), (0.0, 0.0, 0.0)
CASES = {
    "slack": (SLACK, {}),
    "slack in the sea": (SLACK, SEA),
    "near taut in the sea": ((9.9, 0.0, 1.0), SEA),
    "stretched in the sea": (TAUT, SEA),
    "very stiff in the sea": (SLACK, SEA | {"axial_stiffness": 1e9}),
    "very soft in the sea": (SLACK, SEA | {"axial_stiffness": 50.0}),
    "upside down in the sea": (SLACK, SEA | BUOYANT),
    "neutral in the sea": (SLACK, SEA | NEUTRAL),
    "inextensible in the sea": (SLACK, SEA | {"axial_stiffness": None}),
    "one segment in the sea": (SLACK, SEA | {"segments": 1, "length": 6.5}),
    "many segments in the sea": (SLACK, SEA | {"segments": 500}),
    "both ends together in the sea": (HERE, SEA),
    "vertical in the sea": (ABOVE, SEA),
    "free in the sea": (None, SEA | {"end_b": "free"}),
    "on the bed": (SLACK, BED),
    "on the bed, very stiff": (SLACK, BED | {"axial_stiffness": 1e9}),
    "on the bed, inextensible": (SLACK, BED | {"axial_stiffness": None}),
    "on the bed, both ends together": (HERE, BED),
    "on the bed, free": (None, BED | {"end_b": "free"}),
    "on the bed, upside down": (SLACK, BED | BUOYANT),
    "on the bed in the sea": (SLACK, BED | SEA),
    "stiff": (SLACK, STIFF),
    "stiff, both ends together": (HERE, STIFF),
    "stiff, both ends together, odd": (HERE, STIFF | {"segments": 31}),
    "stiff, inextensible, both ends together, odd": (HERE, STIFF | {"segments": 31, "axial_stiffness": None}),
    "stiff, vertical": (ABOVE, STIFF),
    "stiff, one segment": (SLACK, STIFF | {"segments": 1, "length": 6.5}),
    "stiff, clamped against its sag": (SLACK, STIFF | {"clamp_a": (0.0, 0.0, -1.0)}),
    "stiff on the bed in the sea": (SLACK, STIFF | BED | SEA),
    "stiff, neutral in the sea": (SLACK, STIFF | SEA | NEUTRAL),
    "with clump and float in the sea": (
        SLACK,
        SEA | {"clumps": ({"at": 3.0, "mass": 5.0, "volume": 6e-4}, {"at": 7.1, "volume": 2e-3, "drag_area": 0.02})},
    ),
    "of sections on the bed in the sea": (
        SLACK,
        SEA | BED | {
            "segments": 30,
            "sections": ({"length": 4.0, "segments": 10, "mass_per_length": 2.0}, {"length": 6.0, "segments": 20}),
        },
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_starts_and_moves_at_default_settings(cable, name):
    """Status 0, every step converged, and no node farther from an end than the line is long (and 1 % for waves)."""
    far, changes = CASES[name]
    u = np.zeros(18 if far is not None else 9)
    if far is not None:
        u[9:12] = far
    line = cable(0.02, u, **LINE | changes)
    assert line.status == 0, "no static start"
    for k in range(1, 101):
        t = 0.02 * k
        u[1], u[4], u[7] = (
            0.2 * np.sin(t) ** 3,
            0.6 * np.sin(t) ** 2 * np.cos(t),
            0.6 * np.sin(t) * (3 * np.cos(t) ** 2 - 1),
        )
        line.step(u)
        assert line.status == 0
        assert line["converged"] == 1
    reach = (LINE | changes)["length"] * (4.0 if changes.get("axial_stiffness") == 50.0 else 1.01)
    assert np.linalg.norm(line["nodes"] - u[0:3], axis=1).max() < reach
