"""The published allocations against the paper's equations solved by NumPy, the exact optimum, and known faults."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from components.allocator.newton.component import COMPONENT as NEWTON
from components.allocator.published.component import COMPONENT as PUBLISHED
from components.allocator.quadratic.component import COMPONENT as QUADRATIC
from components.allocator.thrusters import contains

PATH = Path(__file__).parents[1] / "benchmarks" / "allocation.py"
SPEC = importlib.util.spec_from_file_location("benchmark_allocation_published", PATH)
bench = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = bench
SPEC.loader.exec_module(bench)

SEMI = bench.open_water(bench.LAYOUTS["semi-submersible"])
CAPACITY = sum(t.max_thrust for t in SEMI)


def system(layout, demand):
    """Solution F of van Daalen et al. 2011, eqs. 14 and 15, azimuth thrusters: (n, 2)."""
    n = len(layout)
    R = np.zeros((3, 2 * n))
    for i, t in enumerate(layout):
        R[0, 2 * i] = R[1, 2 * i + 1] = 1.0
        R[2, 2 * i : 2 * i + 2] = -t.y, t.x
    C = np.diag(np.repeat([2.0 * t.max_power / t.max_thrust**1.5 for t in layout], 2))
    A = np.block([[C, R.T], [R, np.zeros((3, 3))]])
    return np.linalg.solve(A, np.concatenate([np.zeros(2 * n), demand]))[: 2 * n].reshape(n, 2)


def test_quadratic_solves_the_printed_system():
    """To the conditioning of NumPy's solution: its blocks differ by 1e4 in size."""
    allocator = bench.Allocator(component=QUADRATIC, thrusters=SEMI)
    for demand in bench.demands(SEMI, 50):
        allocator.step(demand)
        assert allocator.forces == pytest.approx(system(SEMI, demand), rel=1e-9, abs=1e-9 * CAPACITY)


def test_newton_comes_to_the_exact_power_where_no_limit_is_active():
    newton = bench.Allocator(component=NEWTON, thrusters=SEMI)
    exact = bench.Allocator(thrusters=SEMI)
    converged = 0
    for demand in 0.4 * bench.demands(SEMI, 100):
        newton.step(demand)
        exact.step(demand)
        if newton["converged"] == 1.0 and newton["overload"] <= 1.0:
            converged += 1
            assert newton["power"].sum() == pytest.approx(exact["power"].sum(), rel=1e-9)
    assert converged > 80


def test_published_loop_leaves_saturated_thrusters_over_their_limit():
    """Rows (24) fix a projection only. Wherever the unlimited optimum saturates and the demand can be met."""
    published = bench.Allocator(component=PUBLISHED, thrusters=SEMI)
    exact = bench.Allocator(thrusters=SEMI)
    newton = bench.Allocator(component=NEWTON, thrusters=SEMI)
    over = []
    for demand in bench.demands(SEMI, 400):
        for allocator in (published, exact, newton):
            allocator.step(demand)
        if exact["met"] == 1.0 and newton["overload"] > 1.01 and published["converged"] == 1.0:
            over.append(float(published["overload"]))
            assert exact["thrust"].max() <= 496e3 * (1 + 1e-9)
    assert len(over) > 30
    assert np.mean(np.array(over) > 1.0 + 1e-6) > 0.9


def test_published_method_without_limits_active_is_newtons():
    published = bench.Allocator(component=PUBLISHED, thrusters=SEMI)
    newton = bench.Allocator(component=NEWTON, thrusters=SEMI)
    for demand in 0.2 * bench.demands(SEMI, 30):
        published.step(demand)
        newton.step(demand)
        assert np.array_equal(published["thrust"], newton["thrust"])


@pytest.mark.parametrize("component", [QUADRATIC, NEWTON, PUBLISHED], ids=lambda one: one.name)
def test_no_demand_gives_no_nan(component):
    """The printed Hessian is unbounded at zero thrust; ours leaves such thrusters at zero."""
    allocator = bench.Allocator(component=component, thrusters=SEMI)
    allocator.step((0.0, 0.0, 0.0))
    assert np.isfinite(allocator.y).all()
    assert np.all(allocator["thrust"] == 0.0)


def test_published_rows_leave_thrusters_in_their_forbidden_zones():
    """Rows (27) fix the projection on an edge, not the azimuth: ahead, all six with a zone there stay in it."""
    layout = bench.LAYOUTS["semi-submersible"]
    published, exact = bench.Allocator(component=PUBLISHED, thrusters=layout), bench.Allocator(thrusters=layout)
    for allocator, expected in ((published, 6), (exact, 0)):
        allocator.step((8e5, 2e5, 0.0))
        assert np.array([*allocator["achieved.force"], allocator["achieved.moment"]]) == pytest.approx(
            [8e5, 2e5, 0.0], abs=1e-3
        )
        assert inside_zones(allocator, layout) == expected


def inside_zones(allocator, layout):
    """How many thrusters push with an azimuth inside a forbidden zone."""
    commands = zip(layout, allocator["azimuth"], allocator["thrust"], strict=True)
    return sum(
        thrust > 1.0 and any(contains((a + 1e-6, b - 1e-6), azimuth) for a, b in thruster.forbidden)
        for thruster, azimuth, thrust in commands
    )


def test_what_the_methods_do_not_know_is_refused():
    with pytest.raises(ValueError, match="rates are for allocator\\.exact only"):
        bench.Allocator(component=QUADRATIC, thrusters=(SEMI[0].model_copy(update={"azimuth_rate": 0.1}),))
