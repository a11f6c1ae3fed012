"""The balance of forces on a vessel at the end of a step, solved for its accelerations there."""

from math import inf, sqrt

from components.compiled import kernel
from components.vessel.hook import LAW, carry, follow_law
from components.vessel.low_speed.layout import (
    BALANCE,
    BY_HOOK,
    BY_VELOCITY,
    CELL,
    COUNT,
    CURRENT,
    DAMPING,
    FORCE_A,
    FORCE_B,
    HOOKS,
    LAW_A,
    LAW_B,
    LOAD,
    MASS,
    POINT_A,
    POINT_B,
    RESPONSE,
    SLOPE,
    STEADY,
    STRIPS,
    SWITCHES,
    THRUST,
    TRIAL,
    WATER,
    WAVES,
    WIND,
    WIND_LOAD,
    WINDAGE,
    place,
)
from components.vessel.low_speed.resistance import resist_cross_flow, resist_velocity
from components.vessel.low_speed.seakeeping import offset, respond
from components.vessel.mass.translation import reach
from components.vessel.wind_load import blow
from components.vessel.yawing import (
    COS,
    FREE,
    ITERATIONS,
    MASSES,
    SIN,
    WIDE,
    correct,
    relate,
    resist_acceleration,
    slope,
)
from components.vessel.yawing import TRIAL as TRIAL_LENGTH


@kernel
def gather(q, u, w, eta, rate, t):
    """Note what does not depend on the accelerations: the sea's response at eta, rate and t, current, steady loads."""
    for i in range(RESPONSE, WIND_LOAD + 3):
        w[i] = 0.0
    n, z = int(q[SWITCHES + WAVES]), w[RESPONSE : RESPONSE + 21]
    if n > 0:
        at = place(q, WAVES)
        respond(q[STRIPS + 2 * int(q[COUNT]) :], u[at : at + 5 * n], n, eta, rate, t, w[CELL : CELL + 15], z)
    offset(q[HOOKS : HOOKS + 3], z, w[POINT_A : POINT_A + 9])
    offset(q[HOOKS + 3 : HOOKS + 6], z, w[POINT_B : POINT_B + 9])
    at = place(q, CURRENT)
    if at >= 0:
        w[WATER], w[WATER + 1] = u[at], u[at + 1]
    for i in range(3):
        w[STEADY + i] = z[18 + i]
    for which in (THRUST, LOAD):
        at = place(q, which)
        if at >= 0:
            for i in range(3):
                w[STEADY + i] += u[at + i]


@kernel
def take_wind(q, u, w, rate, acc, h):
    """Note the wind's load on the moving vessel."""
    at = place(q, WIND)
    if at >= 0:
        _, v_acc = reach(h)
        north, east = rate[0] + v_acc * acc[0] - u[at], rate[1] + v_acc * acc[1] - u[at + 1]
        c, s = w[TRIAL + COS], w[TRIAL + SIN]
        x, y, n = blow(q[WINDAGE : WINDAGE + 8], c * north + s * east, c * east - s * north)
        w[WIND_LOAD], w[WIND_LOAD + 1], w[WIND_LOAD + 2] = x, y, n


@kernel
def assemble(q, u, w, eta, rate, acc, h):
    """Write the balance of the trial motion in the body frame and its slope, the bonded lines' laws left out."""
    m, f = w[TRIAL : TRIAL + TRIAL_LENGTH], w[BALANCE : BALANCE + FREE]
    g, jac = w[BY_VELOCITY : BY_VELOCITY + 16], w[SLOPE : SLOPE + 28]
    mass = q[MASS : MASS + MASSES]
    relate(eta, rate, acc, w[WATER : WATER + 3], h, m)
    resist_acceleration(mass, m, f, g)
    resist_velocity(q[DAMPING : DAMPING + 15], m, f, g)
    count = int(q[COUNT])
    resist_cross_flow(q[STRIPS : STRIPS + 2 * count], count, m, f, g)
    slope(mass, m, g, h, jac)
    take_wind(q, u, w, rate, acc, h)
    for i, row in ((0, 0), (1, 1), (2, 3)):
        f[row] -= w[STEADY + i] + w[WIND_LOAD + i]
    for which, point in ((FORCE_A, POINT_A), (FORCE_B, POINT_B)):
        at = place(q, which)
        if at >= 0:
            carry(u[at], u[at + 1], u[at + 2], m, w[point : point + 9], f)


@kernel
def hold_heave(f, jac):
    """Take heave out of the balance: the water carries what pulls down, and waves move the vessel as they do."""
    f[2] = 0.0
    for j in range(FREE):
        jac[2 * WIDE + j] = 1.0 if j == 2 else 0.0


@kernel
def solve_balance(q, u, w, eta, rate, acc, h):
    """Find the accelerations acc (4) that balance all forces; the last change over what is allowed."""
    m, f, a = w[TRIAL : TRIAL + TRIAL_LENGTH], w[BALANCE : BALANCE + FREE], w[BY_HOOK : BY_HOOK + 12]
    jac = w[SLOPE : SLOPE + 28]
    excess = inf
    for _ in range(ITERATIONS):
        assemble(q, u, w, eta, rate, acc, h)
        for which, point in ((LAW_A, POINT_A), (LAW_B, POINT_B)):
            at = place(q, which)
            if at >= 0:
                follow_law(u[at : at + LAW], acc, m, w[point : point + 9], h, a, f, jac)
        hold_heave(f, jac)
        excess = correct(jac, f, acc)
        if excess <= 1.0:
            break
    return excess


@kernel
def speed_through_water(w):
    """Of the motion noted last [m/s]."""
    return sqrt(w[TRIAL] * w[TRIAL] + w[TRIAL + 1] * w[TRIAL + 1])
