"""Sub-steps of the cable: order on a changing step, the error estimate against the error, and what is remembered."""

import numpy as np
import pytest

from components.tether.cable import line

SOFT = dict(
    length=3.5, segments=10, mass_per_length=0.1054, volume_per_length=0.1054 / 7850, drag_diameter=0.01,
    axial_stiffness=4.5e3, fluid_density=1000.0, tolerance=1e-11,
)  # fmt: skip


def sweep(t, amplitude=0.3, omega=3.0, rise=0.5):
    """Smooth motion of the far end about (2, 0, 0), from rest: position, velocity, acceleration by differences."""

    def position(t):
        phases = np.array([omega, 0.7 * omega, 1.3 * omega]) * t + [0, 0.3, 0.6]
        return np.array([2.0, 0, 0]) + amplitude * (1 - np.exp(-((t / rise) ** 4))) * np.sin(phases)

    d = 1e-4
    p, before, after = position(t), position(t - d), position(t + d)
    return np.concatenate([np.zeros(9), p, (after - before) / (2 * d), (after - 2 * p + before) / d**2])


def run(cable_of, steps, forget=False, **parameters):
    """Positions, tensions after steps of these lengths [s]; forget: their lead stays the last step's."""
    cable = cable_of(steps[0], sweep(0.0), **SOFT | parameters)
    lead, t = line.STATE * (cable.parameters.segments + 1) + line.LEAD, 0.0
    for h in steps:
        if forget:
            cable.x[lead] *= h / (cable.h * 1e-9)
        cable.h = round(h * 1e9)
        t += h
        cable.step(sweep(t))
    return cable["nodes"].copy(), cable["tension"].copy()


def test_second_order_in_time_with_a_changing_step(cable_of):
    """Steps of 4 h and h in turn: halving both quarters the errors of positions and tensions at least (reference h/16).

    Without the shift of the accelerations the errors only halve once they are small.
    """

    def errors(pairs, **options):
        q, force = run(cable_of, [0.8 / pairs, 0.2 / pairs] * pairs, sub_steps=1, rho_inf=0.0, **options)
        return np.array([np.abs(q - nodes).max(), np.abs(force - tension).max()])

    nodes, tension = run(cable_of, [1.0 / 6144] * 6144, sub_steps=1, rho_inf=0.0)
    coarse, middle, fine = (errors(pairs) for pairs in (48, 96, 192))
    assert (coarse > 3.5 * middle).all()
    assert (middle > 3.5 * fine).all()
    assert errors(192, forget=True)[0] > 2 * fine[0]


def test_second_order_in_space(cable_of):
    """Twice the segments quarter the errors of the middle and of the end force, the reference being 4 times finer."""

    def at(segments):
        cable = cable_of(0.005, sweep(0.0), **SOFT | {"segments": segments, "sub_steps": 1})
        for k in range(1, 161):
            cable.step(sweep(0.005 * k))
        return cable["nodes"][segments // 2].copy(), cable["force_b"].copy()

    finest = at(128)
    errors = np.array([[np.linalg.norm(v - r) for v, r in zip(at(n), finest, strict=True)] for n in (8, 16, 32)])
    assert (errors[:-1] / errors[1:] > 3.2).all()


@pytest.mark.parametrize(("stiffness", "most"), [(450.0, 1.5), (4500.0, 6.0)])
def test_estimate_is_the_local_error(cable_of, stiffness, most):
    """One step from one state against 64 sub-steps of it: the estimate is the largest distance, or more.

    More where axial waves are too short for the step (6 ms here): they move the accelerations, hardly the positions.
    """
    for start in (0.5, 0.7, 0.9):
        soft = SOFT | {"axial_stiffness": stiffness}
        coarse, fine = (cable_of(0.02, sweep(0.0), **soft | {"sub_steps": n}) for n in (1, 64))
        for k in range(1, round(start / 0.02) + 1):
            coarse.step(sweep(0.02 * k))
        fine.x[:] = coarse.x
        coarse.step(sweep(start + 0.02))
        fine.step(sweep(start + 0.02))
        ratio = coarse["error"] / np.linalg.norm(coarse["nodes"] - fine["nodes"], axis=1).max()
        assert 0.8 < ratio < most


def test_accuracy_sets_the_sub_steps(cable_of):
    """Each tenth of the accuracy takes more sub-steps, and less error against 64 fixed ones; none exceeds its own."""

    def ride(**parameters):
        cable = cable_of(0.05, sweep(0.0), **SOFT | parameters)
        taken, worst = 0, 0.0
        for k in range(1, 41):
            cable.step(sweep(0.05 * k))
            taken += cable["sub_steps"]
            worst = max(worst, cable["validity.error"])
        return cable["nodes"].copy(), taken, worst

    reference = ride(sub_steps=64)[0]
    rides = [ride(accuracy=accuracy) for accuracy in (1e-3, 1e-4, 1e-5)]
    errors = [np.abs(nodes - reference).max() for nodes, _, _ in rides]
    assert rides[0][1] < rides[1][1] < rides[2][1]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-3  # m: 200 steps of at most 3.5e-5 m, damped by the water
    assert max(worst for _, _, worst in rides) <= 1.0


def test_memory_of_the_step_is_in_the_state(cable_of):
    """A cable that is given the state of another in the middle of a rough ride goes on with the same bits."""
    motions = [sweep(0.02 * k, amplitude=0.4, omega=8.0) for k in range(121)]
    first = cable_of(0.02, motions[0], **SOFT)
    for u in motions[1:61]:
        first.step(u)
    second = cable_of(0.02, motions[0], **SOFT)
    second.x[:] = first.x
    for u in motions[61:]:
        first.step(u)
        second.step(u)
        assert first.y.tobytes() == second.y.tobytes()
    assert first.x.tobytes() == second.x.tobytes()
