"""The batch of catenaries through given ends, against components.tether.catenary, which solves them otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from components.tether.catenary.hang import hang
from pipeline.analysis.through_ends import through_ends

SHARE = np.linspace(0.0, 1.0, 21)


def one(length, load, span, rise, ea, **options):
    """A single line from the origin, as `hang` takes it."""
    flexibility = 0.0 if ea is None else 1.0 / ea
    ends = np.zeros((1, 3)), np.array([[span, 0.0, -rise]])
    return through_ends(*ends, np.array([length]), np.array([load]), flexibility, SHARE, **options)


def force_error(found, reference) -> float:
    """Largest error of the end forces over the larger one."""
    forces = np.array([reference.force_a_N, reference.force_b_N])
    return np.abs(np.stack([found.force_a[0], found.force_b[0]]) - forces).max() / np.abs(forces).max()


def gap(found, length, span, rise) -> float:
    """Of the shape's last point from end b, over the length."""
    return np.abs(found.shape[0, -1] - [span, 0.0, -rise]).max() / length


def test_random_lines_slack_taut_and_stretched():
    """Both solvers go to rounding: 1e-12 of the larger force leaves two digits for the shallow and stiff ones; shapes
    are differences, which lose as many digits as the tension is greater than the weight, here up to six."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        length, ea = 10 ** rng.uniform(0, 2.5), None if rng.random() < 0.3 else 10 ** rng.uniform(2, 7)
        load = tuple(10 ** rng.uniform(-2, 2) * rng.choice([-1, 1]) * np.array([rng.choice([0.0, 0.3]), 0.0, 1.0]))
        chord, slope = length * rng.uniform(0.05, 0.999 if ea is None else 1.2), rng.uniform(-1.5, 1.5)
        span, rise = chord * np.cos(slope), chord * np.sin(slope)
        reference = hang(length, load, span, rise, ea)
        found = one(length, load, span, rise, ea)
        assert force_error(found, reference) < 1e-12
        assert gap(found, length, span, rise) < 1e-9


def test_random_lines_on_a_seabed():
    """Tolerance: 1e-7 of the force where a line of some thousand weights' stiffness barely touches."""
    rng = np.random.default_rng(2)
    touching = 0
    for _ in range(100):
        length, ea = 10 ** rng.uniform(1, 2.5), None if rng.random() < 0.3 else 10 ** rng.uniform(4, 7)
        depth, above = length * rng.choice([0.0, 0.2]), length * rng.uniform(0.05, 0.4)
        load, rise = (0.0, 0.0, 10 ** rng.uniform(-1, 2)), above - depth
        span = length - depth - above + (0.97 * length - length + depth + above) * rng.uniform(0.1, 0.9)
        if np.hypot(span, rise) >= 0.999 * length:
            continue
        reference = hang(length, load, span, rise, ea, depth)
        touching += reference.touches_seabed
        found = one(length, load, span, rise, ea, seabed=depth)
        assert force_error(found, reference) < 1e-7
        assert gap(found, length, span, rise) < 1e-9
        assert found.shape[0, :, 2].max() < depth + 1e-9 * length
    assert touching > 40


def test_what_is_not_determined_is_not_told():
    """Too short a line without stretch; more line on the bed than it has room for; friction at an end that lies."""
    assert np.isnan(one(1.0, (0.0, 0.0, 1.0), 1.5, 0.0, None).tension_a).all()
    heap = one(10.0, (0.0, 0.0, 1.0), 1.0, 2.0, None, seabed=0.0)
    assert heap.tension_b[0] == pytest.approx(2.0, rel=1e-9)
    assert np.isnan(heap.shape[0, 10]).any()
    rough = one(10.0, (0.0, 0.0, 1.0), 8.5, 2.0, None, seabed=0.0, rough=True)
    assert np.isnan(rough.tension_a[0])
    assert rough.tension_b[0] == pytest.approx(hang(10.0, 1.0, 8.5, 2.0, None, 0.0).H_N + 2.0, rel=1e-9)
