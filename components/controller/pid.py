"""The load that a vehicle needs to follow its reference: PID in its own axes, feed-forward, integral kept in bounds."""

from math import cos, sin

from components.compiled import kernel
from components.controller.layout import (
    ASKED,
    AXES,
    CHANGE,
    DAMPING,
    DERIVATIVE,
    INTEGRAL,
    LOAD,
    MASS,
    PLACE,
    PROPORTIONAL,
    RATE,
)
from components.kinematics import wrapped

SHORT = 0.01


@kernel
def are_numbers(u):
    """Whether all inputs are finite."""
    total = 0.0
    for i in range(len(u)):
        total += 0.0 * u[i]
    return total == 0.0


@kernel
def turned(x, at, c, s):
    """A world vector x[at : at + 2] along and across a vehicle; c, s: of its heading."""
    return c * x[at] + s * x[at + 1], c * x[at + 1] - s * x[at]


@kernel
def integrate(q, x, north, east, error, achieved, c, s, h):
    """Let the integral load grow with the error over h [s], but not while the thrusters fall short of the last demand.

    Conditional integration (Astrom and Hagglund 2006, section 3.5): where achieved, (4) in the body frame, is less than
    the demand by more than SHORT of it, the integral takes only what takes the demand back. So it stays at the slow
    load while thrusters are saturated, and nothing has to be unlearnt afterwards.
    """
    ahead, across = x[ASKED] - achieved[0], x[ASKED + 1] - achieved[1]
    along = north * (c * ahead - s * across) + east * (s * ahead + c * across)
    asked = x[ASKED] * x[ASKED] + x[ASKED + 1] * x[ASKED + 1]
    is_short = ahead * ahead + across * across > SHORT * SHORT * asked
    # Each world axis takes the mean of surge's and sway's gain, so that the integral turns with neither.
    level = 0.5 * (q[INTEGRAL] + q[INTEGRAL + 1])
    if along <= 0.0 or not is_short:
        x[LOAD] += h * level * north
        x[LOAD + 1] += h * level * east
    for i in range(2, AXES):
        lack = x[ASKED + i] - achieved[i]
        if error[i] * lack <= 0.0 or abs(lack) <= SHORT * abs(x[ASKED + i]):
            x[LOAD + i] += h * q[INTEGRAL + i] * error[i]


@kernel
def demand(q, x, eta, nu, achieved, h, error):
    """Write the load (4) in the body frame to x[ASKED:], feed-forward of known loads left out.

    eta: (4) position and heading, nu: (4) velocity and achieved: (4) what the thrusters gave of the last demand, in the
    body frame; h: the step [s]; error: (4) reference less position, in the body frame. Fossen 2011, section 12.2.4; the
    integral is a load in the world's frame, where slow loads stay as the vehicle turns.
    """
    c, s = cos(eta[3]), sin(eta[3])
    north, east = x[PLACE] - eta[0], x[PLACE + 1] - eta[1]
    error[0], error[1] = c * north + s * east, c * east - s * north
    error[2], error[3] = x[PLACE + 2] - eta[2], wrapped(x[PLACE + 3] - eta[3])
    integrate(q, x, north, east, error, achieved, c, s, h)
    speed, change, load = turned(x, RATE, c, s), turned(x, CHANGE, c, s), turned(x, LOAD, c, s)
    for i in range(AXES):
        wanted = speed[i] if i < 2 else x[RATE + i]
        rate = change[i] if i < 2 else x[CHANGE + i]
        steady = load[i] if i < 2 else x[LOAD + i]
        x[ASKED + i] = (
            q[PROPORTIONAL + i] * error[i]
            + q[DERIVATIVE + i] * (wanted - nu[i])
            + q[MASS + i] * rate
            + q[DAMPING + i] * wanted
            + steady
        )
