"""The mass on springs, against the oscillator's closed form and the affine law's own balance."""

import numpy as np
import pytest

from components.compiled import functions
from components.vessel.mass.component import COMPONENT

init, step = functions(COMPONENT)


class Mass:
    """A mass outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, h, **parameters):
        self.p = COMPONENT.pack(COMPONENT.parameters(**parameters))
        self.h, self.t = round(h * 1e9), 0
        self.u, self.x, self.y, self.w = (np.full(int(n), 0.0) for n in self.p[1:5])
        self.call(init)

    def call(self, function):
        self.y[:] = self.w[:] = np.nan
        assert function(self.t, self.h, self.p, self.u, self.x, self.y, self.w) == 0

    def step(self):
        self.t += self.h
        self.call(step)
        return self.y[:9].reshape(3, 3)


def test_damped_oscillator_at_second_order():
    """q = exp(-zeta w t) (cos wd t + ...) per axis, released at rest; halving the step quarters the error."""
    stiffness, damping, mass = np.array([9.0, 4.0, 25.0]), np.array([0.4, 0.0, 1.0]), 2.0
    start, rest = np.array([0.3, -0.2, 0.1]), np.array([0.0, 1.0, 0.5])
    away = start - rest
    decay = damping / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    t = 2.0
    exact = rest + away * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    errors = []
    for h in (0.02, 0.01, 0.005):
        body = Mass(
            h, mass=mass, stiffness=tuple(stiffness), damping=tuple(damping), rest=tuple(rest), position=tuple(start),
            acceleration=tuple(-stiffness * away / mass),
        )  # fmt: skip
        for _ in range(round(t / h)):
            motion = body.step()
        errors.append(np.abs(motion[0] - exact).max())
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.1)


def test_force_law_enters_the_balance_implicitly():
    """M a + C v + K (q - rest) = weight + force + F - G (a - a_ref) at the end of the step, to rounding."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3))
    g, reference, law, force = root @ root.T, rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)
    body = Mass(
        0.05, mass=0.7, weight=(1, 2, 3), stiffness=(4, 5, 6), damping=(0.1, 0.2, 0.3), rest=(1, 0, -1),
        velocity=(0.5, 0, 0), takes_force=True, takes_law=True,
    )  # fmt: skip
    body.u[:] = np.concatenate([force, law, reference, g.ravel()])
    for _ in range(3):
        q, v, a = body.step()
    left = 0.7 * a + np.array([0.1, 0.2, 0.3]) * v + np.array([4, 5, 6]) * (q - [1, 0, -1])
    right = np.array([1, 2, 3]) + force + law - g @ (a - reference)
    assert left == pytest.approx(right, abs=1e-12)


def test_stays_where_it_is_in_balance():
    """Weight taken up by the springs: not a bit moves."""
    body = Mass(0.1, mass=1.0, weight=(0, 0, 8.0), stiffness=(1.0, 1.0, 16.0), rest=(0, 0, -0.5))
    for _ in range(100):
        motion = body.step()
    assert np.array_equal(motion, np.zeros((3, 3)))
