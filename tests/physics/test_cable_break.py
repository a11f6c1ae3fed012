"""Breaking and cutting: free fall of what comes off, the instant within the step, and what is refused."""

import numpy as np
import pytest

from components.compiled import functions
from components.tether.cable import line
from components.tether.cable.component import BREAKS_AT_REST, COMPONENT, CUT_AT_REST

G = 9.80665
CHAIN = dict(
    length=3.5, segments=20, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e5, fluid_density=0.0,
)  # fmt: skip
STILL = np.zeros(9)


@pytest.mark.parametrize("more", [{}, {"bending_stiffness": 0.1}, {"axial_stiffness": None}])
def test_what_is_cut_off_falls_freely(cable_of, more):
    """A hanging line cut in the middle: what is below falls by g t^2 / 2, what is above hangs on.

    Exact: no force but gravity acts on the lower part. Tolerance: the first step after the cut.
    """
    cable = cable_of(0.02, STILL, **CHAIN | more, end_b="free", damping_time=1e-3)
    lumps = np.full(10, 0.1054 * 3.5 / 20)
    lumps[-1] /= 2
    before = lumps @ cable["nodes"][11:, 2] / lumps.sum()
    cable.p = COMPONENT.pack(cable.parameters.model_copy(update={"cut": 11}))
    for _ in range(50):
        cable.step(STILL)
    assert cable["broken_segment"] == 11
    assert cable["converged"] == 1
    assert lumps @ cable["nodes"][11:, 2] / lumps.sum() - before == pytest.approx(G / 2, rel=1e-3)
    assert cable["force_a"][2] == pytest.approx(0.1054 * 3.5 * 10.5 / 20 * G, rel=1e-3)
    assert cable["tension"][10] == 0


def test_breaks_within_the_step(cable_of):
    """A weightless taut line drawn at 0.5 m/s, broken at 20 N: at the same instant.

    Against 128 fixed sub-steps a period: 2 mm, which is a millisecond of the recoil at 1.9 m/s.
    """
    soft = CHAIN | {"axial_stiffness": 1e3, "gravity": 0.0}

    def pulled(t):
        speed = 0.5
        return np.concatenate([STILL, [3.5 + speed * t, 0, 0], [speed, 0, 0], np.zeros(3)])

    cable, h = cable_of(0.02, pulled(0.0), **soft, breaking_load=20.0, damping_time=0.01), 0.02
    k = 0
    while cable["broken_segment"] == 0:
        k += 1
        before = cable["tension"].max()
        cable.step(pulled(k * h))
    assert before < 20.0
    fine = cable_of(h, pulled(0.0), **soft, breaking_load=20.0, damping_time=0.01, sub_steps=128)
    for j in range(1, k + 1):
        fine.step(pulled(j * h))
    assert fine["broken_segment"] == cable["broken_segment"]
    assert np.abs(fine["nodes"] - cable["nodes"]).max() < 2e-3
    for j in range(k + 1, k + 26):
        cable.step(pulled(j * h))
    assert cable["converged"] == 1
    assert np.abs(cable["force_a"]).max() < 20.0


def test_a_line_does_not_start_broken(cable_of):
    """Refused with the status that says why: cut already, or loaded beyond its strength at rest."""
    init, _ = functions(COMPONENT)
    for change, status in (({"cut": 3}, CUT_AT_REST), ({"breaking_load": 1.0}, BREAKS_AT_REST)):
        cable = cable_of(0.02, STILL, **CHAIN, end_b="free")
        p = COMPONENT.pack(cable.parameters.model_copy(update=change))
        assert init(0, cable.h, p, cable.u, cable.x, cable.y, cable.w) == status


def test_line_without_breaking_load_never_breaks(cable_of):
    """A snap of 200 N and more in a line that has no breaking load, against the same with one."""
    for load in (0.0, 50.0):
        cable = cable_of(1e-4, STILL, **CHAIN | {"gravity": 0.0}, end_b="free", breaking_load=load)
        cable.state[1:, line.V + 2] = 1.0
        for _ in range(20):
            cable.step(STILL)
        assert (cable["broken_segment"] > 0) == (load > 0)
