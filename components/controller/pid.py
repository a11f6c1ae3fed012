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
    UNWIND,
)
from components.kinematics import wrapped


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
def unwind(q, x, achieved, heading, h):
    """Let the integral load follow what the thrusters gave of the demand, (4) in the body frame, over h [s].

    Back-calculation (Astrom and Hagglund 2006, section 3.5): while the demand is beyond the thrusters the integral
    goes, with the time constant UNWIND, to where the demand would be what they give, and starts from there.
    """
    c, s, share = cos(heading), sin(heading), min(h / q[UNWIND], 1.0)
    ahead, across = achieved[0] - x[ASKED], achieved[1] - x[ASKED + 1]
    x[LOAD] += share * (c * ahead - s * across)
    x[LOAD + 1] += share * (s * ahead + c * across)
    x[LOAD + 2] += share * (achieved[2] - x[ASKED + 2])
    x[LOAD + 3] += share * (achieved[3] - x[ASKED + 3])


@kernel
def demand(q, x, eta, nu, h, error):
    """Write the load (4) in the body frame to x[ASKED:], feed-forward of known loads left out.

    eta: (4) position and heading, nu: (4) velocity in the body frame, h: the step [s]; error: (4) reference less
    position, in the body frame. Fossen 2011, section 12.2.4; the integral is a load in the world's frame, where slow
    loads stay as the vehicle turns.
    """
    c, s = cos(eta[3]), sin(eta[3])
    north, east = x[PLACE] - eta[0], x[PLACE + 1] - eta[1]
    error[0], error[1] = c * north + s * east, c * east - s * north
    error[2], error[3] = x[PLACE + 2] - eta[2], wrapped(x[PLACE + 3] - eta[3])
    # Each world axis takes the mean of surge's and sway's gain, so that the integral turns with neither.
    level = 0.5 * (q[INTEGRAL] + q[INTEGRAL + 1])
    x[LOAD] += h * level * north
    x[LOAD + 1] += h * level * east
    x[LOAD + 2] += h * q[INTEGRAL + 2] * error[2]
    x[LOAD + 3] += h * q[INTEGRAL + 3] * error[3]
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
