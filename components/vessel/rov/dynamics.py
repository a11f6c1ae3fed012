"""The balance of forces on an ROV at the end of a step, solved for its accelerations there."""

from math import inf

from components.compiled import kernel
from components.vessel.hook import LAW as LAW_LENGTH
from components.vessel.hook import carry, follow_law
from components.vessel.rov.layout import (
    BALANCE,
    BY_HOOK,
    BY_VELOCITY,
    CURRENT,
    FORCE,
    HOOK,
    LAW,
    LINEAR,
    MASS,
    POINT,
    QUADRATIC,
    SINKS,
    SLOPE,
    THRUST,
    TRIAL,
    WATER,
    place,
)
from components.vessel.yawing import FREE, ITERATIONS, MASSES, correct, relate, resist_acceleration, slope
from components.vessel.yawing import TRIAL as TRIAL_LENGTH


@kernel
def gather(q, u, w):
    """Note what does not depend on the accelerations: the hook's place and the current."""
    for i in range(9):
        w[POINT + i] = q[HOOK + i] if i < 3 else 0.0
    at = place(q, CURRENT)
    for i in range(3):
        w[WATER + i] = u[at + i] if at >= 0 else 0.0


@kernel
def assemble(q, u, w, eta, rate, acc, h):
    """Write the balance of the trial motion in the body frame and its slope, the bonded line's law left out.

    Damping is uncoupled, D nu + D_n |nu| nu with diagonal matrices, as is usual for ROVs (Fossen 2011, section 6.5).
    """
    m, f = w[TRIAL : TRIAL + TRIAL_LENGTH], w[BALANCE : BALANCE + FREE]
    g, jac = w[BY_VELOCITY : BY_VELOCITY + 16], w[SLOPE : SLOPE + 28]
    mass = q[MASS : MASS + MASSES]
    relate(eta, rate, acc, w[WATER : WATER + 3], h, m)
    resist_acceleration(mass, m, f, g)
    for i in range(FREE):
        nu = m[i]
        f[i] += (q[LINEAR + i] + q[QUADRATIC + i] * abs(nu)) * nu
        g[FREE * i + i] += q[LINEAR + i] + 2.0 * q[QUADRATIC + i] * abs(nu)
    slope(mass, m, g, h, jac)
    f[2] -= q[SINKS]
    at = place(q, THRUST)
    if at >= 0:
        for i in range(FREE):
            f[i] -= u[at + i]
    at = place(q, FORCE)
    if at >= 0:
        carry(u[at], u[at + 1], u[at + 2], m, w[POINT : POINT + 9], f)


@kernel
def solve_balance(q, u, w, eta, rate, acc, h):
    """Find the accelerations acc (4) that balance all forces; the last change over what is allowed."""
    m, f, a = w[TRIAL : TRIAL + TRIAL_LENGTH], w[BALANCE : BALANCE + FREE], w[BY_HOOK : BY_HOOK + 12]
    jac = w[SLOPE : SLOPE + 28]
    at, excess = place(q, LAW), inf
    for _ in range(ITERATIONS):
        assemble(q, u, w, eta, rate, acc, h)
        if at >= 0:
            follow_law(u[at : at + LAW_LENGTH], acc, m, w[POINT : POINT + 9], h, a, f, jac)
        excess = correct(jac, f, acc)
        if excess <= 1.0:
            break
    return excess
