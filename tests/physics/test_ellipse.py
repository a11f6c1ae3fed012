"""The point on an ellipse: closed forms after its ramp, and derivatives that belong to its path."""

from math import pi

import numpy as np
import pytest

from components.compiled import functions
from components.motion.ellipse.component import COMPONENT
from components.motion.ellipse.model import Ellipse

CENTRE, COSINE, SINE = (1.0, -2.0, 3.0), (0.25, 0.0, 0.1), (0.0, 0.4, 0.0)
FREQUENCY, RAMP = 0.5, 2.0
_, step = functions(COMPONENT)


def motion(seconds):
    """Position, velocity, acceleration, each (len(seconds), 3); whatever is not written would be NaN."""
    p = COMPONENT.pack(Ellipse(centre=CENTRE, cosine=COSINE, sine=SINE, frequency=FREQUENCY, ramp=RAMP))
    y = np.full((len(seconds), 9), np.nan)
    for row, t in zip(y, seconds, strict=True):
        assert step(round(t * 1e9), 10**7, p, np.empty(0), np.empty(0), row, np.empty(0)) == 0
    return y[:, :3], y[:, 3:6], y[:, 6:]


def test_starts_at_rest_in_the_centre():
    position, velocity, acceleration = motion([0.0])
    assert (position[0] == CENTRE).all()
    assert not velocity.any()
    assert not acceleration.any()


def test_after_the_ramp_it_is_harmonic():
    """x'' = -omega^2 (x - centre) of any ellipse; rounding is the only error."""
    omega = 2 * pi * FREQUENCY
    seconds = np.linspace(RAMP, RAMP + 3 / FREQUENCY, 61)
    position, velocity, acceleration = motion(seconds)
    c, s = np.cos(omega * seconds), np.sin(omega * seconds)
    assert position == pytest.approx(CENTRE + np.outer(c, COSINE) + np.outer(s, SINE), abs=1e-14)
    assert velocity == pytest.approx(omega * (np.outer(c, SINE) - np.outer(s, COSINE)), abs=1e-14)
    assert acceleration == pytest.approx(-(omega**2) * (position - CENTRE), abs=1e-13)


def test_velocity_and_acceleration_are_the_derivatives_throughout():
    """Fourth-order central differences over d = 1 ms, across the end of the ramp too, where only x''' jumps.

    Their error is d^4/30 times the fifth derivative, below 1e3 m/s^5 here; at the jump d^2/6 times its 10 m/s^3 (of
    the velocity) and d times that (of the acceleration).
    """
    d = 1e-3
    seconds = np.arange(0.01, 3.0, 0.01)
    at = {k: motion(seconds + k * d) for k in (-2, -1, 0, 1, 2)}
    for k, tolerance in ((0, 2e-6), (1, 1e-2)):
        slope = (8 * (at[1][k] - at[-1][k]) - (at[2][k] - at[-2][k])) / (12 * d)
        assert slope == pytest.approx(at[0][k + 1], abs=tolerance)
        inside = np.abs(seconds - RAMP) > 3 * d
        assert slope[inside] == pytest.approx(at[0][k + 1][inside], abs=1e-9)
