"""The thrust that keeps the speed along the path, and its parts of two propellers side by side."""

from math import cos, sin

from components.compiled import kernel
from components.controller.towing.layout import (
    AHEAD,
    ARM,
    ASKED,
    ASTERN,
    HEADING_ERROR,
    IS_LIMITED,
    MAX_ACCELERATION,
    MAX_SPEED,
    PACE,
    SPEED_ERROR,
    SQUARE_DAMPING,
    STEADY,
    SURGE_DAMPING,
    SURGE_GAIN,
    SURGE_INTEGRAL,
    SURGE_MASS,
    THRUST,
    VELOCITY,
)

STEEP = 0.5  # cosine of the angle off the path beyond which the boat is not made faster for it
SIDEWAYS = 0.70710678118654752  # cosine of the heading's error from which on the boat slows down until it has turned


@kernel
def surge(q, u, x, w, wanted, off, h):
    """Note the speed to make ahead; returns the thrust [N] but for the integral's.

    wanted: along the path [m/s], which is followed with limited acceleration. off: of the heading from the path [rad].
    """
    change = min(max(wanted - x[ASKED], -h * q[MAX_ACCELERATION]), h * q[MAX_ACCELERATION])
    x[ASKED] += change
    ahead = (x[ASKED] + u[VELOCITY + 1] * sin(off)) / max(cos(off), STEEP)
    w[PACE] = min(max(ahead, 0.0), q[MAX_SPEED]) * min(max(cos(w[HEADING_ERROR]) / SIDEWAYS, 0.0), 1.0)
    w[SPEED_ERROR] = w[PACE] - u[VELOCITY]
    steady = (q[SURGE_DAMPING] + q[SQUARE_DAMPING] * w[PACE]) * w[PACE]
    return q[SURGE_GAIN] * w[SPEED_ERROR] + steady + (q[SURGE_MASS] * change / h if h > 0.0 else 0.0)


@kernel
def divide(q, x, w, force, torque, h):
    """Write both propellers' thrust, port first, for a force ahead [N] and a moment [N m]; the moment goes before.

    The integral thrust grows with the speed's error, but not while the propellers cannot give what it asks for already
    (conditional integration, Astrom and Hagglund 2006, section 3.5).
    """
    room = 0.5 * (q[AHEAD] + q[ASTERN])
    half = min(max(0.5 * torque / q[ARM], -room), room)
    asked = 0.5 * (force + x[STEADY])
    mean = min(max(asked, abs(half) - q[ASTERN]), q[AHEAD] - abs(half))
    w[IS_LIMITED] = 1.0 if mean != asked or half != 0.5 * torque / q[ARM] else 0.0
    if w[SPEED_ERROR] * (asked - mean) <= 0.0:
        x[STEADY] += h * q[SURGE_INTEGRAL] * w[SPEED_ERROR]
    x[THRUST], x[THRUST + 1] = mean + half, mean - half
