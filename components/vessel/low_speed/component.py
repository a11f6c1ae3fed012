"""Binds the vessel at low speed to the contract."""

from math import cos, sin

from components.compiled import kernel
from components.contract import HEADER, BodyEnd, Component
from components.vessel.hook import follow, write_accelerance
from components.vessel.low_speed import model
from components.vessel.low_speed.layout import (
    BALANCE,
    BY_HOOK,
    LAW_A,
    LAW_B,
    MAX_SPEED,
    POINT_A,
    POINT_B,
    RESPONSE,
    SLOPE,
    START,
    SWITCHES,
    TRIAL,
    WATER,
    WIND_LOAD,
)
from components.vessel.low_speed.manoeuvring import assemble, gather, hold_heave, solve_balance, speed_through_water
from components.vessel.yawing import TRIAL as TRIAL_LENGTH
from components.vessel.yawing import UNSOLVED, U, V, advance, relate, settle

ETA, RATE, ACC, ALGORITHMIC = range(0, 16, 4)
(POSITION, ATTITUDE, VELOCITY, RATES, LOW, LOW_HEADING, LOW_VELOCITY, LOW_RATE, THROUGH_WATER, WIND, DRIFT, HOOK_A,
 HOOK_B, VALIDITY, ACCELERANCE) = (0, 3, 6, 9, 12, 14, 15, 17, 18, 20, 23, 26, 35, 44, 48)  # fmt: skip
SMALL_ANGLE = 0.35


@kernel
def write_motion(x, w, y):
    """Write the motions with and without the waves' part."""
    z, m = w[RESPONSE : RESPONSE + 21], w[TRIAL : TRIAL + TRIAL_LENGTH]
    c, s = cos(x[ETA + 3]), sin(x[ETA + 3])
    u, v, r = c * x[RATE] + s * x[RATE + 1], c * x[RATE + 1] - s * x[RATE], x[RATE + 3]
    y[POSITION] = x[ETA] + c * z[0] - s * z[1]
    y[POSITION + 1] = x[ETA + 1] + s * z[0] + c * z[1]
    y[POSITION + 2] = z[2]
    y[ATTITUDE], y[ATTITUDE + 1], y[ATTITUDE + 2] = z[3], z[4], x[ETA + 3] + z[5]
    y[VELOCITY], y[VELOCITY + 1], y[VELOCITY + 2] = u + z[6] - r * z[1], v + z[7] + r * z[0], z[8]
    y[RATES], y[RATES + 1], y[RATES + 2] = z[9], z[10], r + z[11]
    y[LOW], y[LOW + 1], y[LOW_HEADING] = x[ETA], x[ETA + 1], x[ETA + 3]
    y[LOW_VELOCITY], y[LOW_VELOCITY + 1], y[LOW_RATE] = u, v, r
    y[THROUGH_WATER], y[THROUGH_WATER + 1] = m[U], m[V]


@kernel
def observe(q, u, x, w, h, excess, y):
    """Write all outputs of the motion just found."""
    eta, rate, acc = x[ETA : ETA + 4], x[RATE : RATE + 4], x[ACC : ACC + 4]
    m, a = w[TRIAL : TRIAL + TRIAL_LENGTH], w[BY_HOOK : BY_HOOK + 12]
    f, jac = w[BALANCE : BALANCE + 4], w[SLOPE : SLOPE + 28]
    relate(eta, rate, acc, w[WATER : WATER + 3], 0.0, m)
    write_motion(x, w, y)
    for i in range(3):
        y[WIND + i], y[DRIFT + i] = w[WIND_LOAD + i], w[RESPONSE + 18 + i]
    follow(eta, rate, acc, m, w[POINT_A : POINT_A + 9], y[HOOK_A : HOOK_A + 9])
    follow(eta, rate, acc, m, w[POINT_B : POINT_B + 9], y[HOOK_B : HOOK_B + 9])
    y[VALIDITY + 1] = speed_through_water(w) / q[MAX_SPEED]
    y[VALIDITY + 2] = max(abs(w[RESPONSE + 3]), abs(w[RESPONSE + 4])) / SMALL_ANGLE
    y[VALIDITY + 3] = excess / UNSOLVED
    y[VALIDITY] = max(y[VALIDITY + 1], y[VALIDITY + 2], y[VALIDITY + 3])
    at = ACCELERANCE
    for which, point in ((LAW_A, POINT_A), (LAW_B, POINT_B)):
        if q[SWITCHES + which] > 0.0:
            assemble(q, u, w, eta, rate, acc, h)
            hold_heave(f, jac)
            write_accelerance(jac, acc, m, w[point : point + 9], h, False, a, y[at : at + 9])
            at += 9


def init(t_ns, dt_ns, p, u, x, y, w):
    """Start in balance with the forces there are; a bonded line's is not known yet, and the start is without force."""
    q = p[HEADER:]
    c, s = cos(q[START + 2]), sin(q[START + 2])
    for i in range(16):
        x[i] = 0.0
    x[ETA], x[ETA + 1], x[ETA + 3] = q[START], q[START + 1], q[START + 2]
    x[RATE] = c * q[START + 3] - s * q[START + 4]
    x[RATE + 1] = s * q[START + 3] + c * q[START + 4]
    x[RATE + 3] = q[START + 5]
    eta, rate, acc = x[ETA : ETA + 4], x[RATE : RATE + 4], x[ACC : ACC + 4]
    gather(q, u, w, eta, rate, t_ns * 1e-9)
    assemble(q, u, w, eta, rate, acc, 0.0)
    excess = 0.0
    if q[SWITCHES + LAW_A] == 0.0 and q[SWITCHES + LAW_B] == 0.0:
        excess = solve_balance(q, u, w, eta, rate, acc, 0.0)
    for i in range(4):
        x[ALGORITHMIC + i] = x[ACC + i]
    observe(q, u, x, w, dt_ns * 1e-9, excess, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Solve the balance at the step's end."""
    q, h = p[HEADER:], dt_ns * 1e-9
    eta, rate, acc, algorithmic = x[:RATE], x[RATE:ACC], x[ACC:ALGORITHMIC], x[ALGORITHMIC : ALGORITHMIC + 4]
    advance(eta, rate, algorithmic, h)
    gather(q, u, w, eta, rate, t_ns * 1e-9)
    excess = solve_balance(q, u, w, eta, rate, acc, h)
    settle(eta, rate, acc, algorithmic, h)
    observe(q, u, x, w, h, excess, y)
    return 0


COMPONENT = Component(
    name="vessel.low_speed",
    parameters=model.LowSpeed,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    bodies={
        "hook_a": BodyEnd(motion="hook_a", law="line_a", switch="takes_law_a", accelerance="accelerance_a"),
        "hook_b": BodyEnd(motion="hook_b", law="line_b", switch="takes_law_b", accelerance="accelerance_b"),
    },
    terms=model.terms,
    validity="validity.range",
    assumptions="Surge, sway and yaw obey forces with constant added mass and damping (zero frequency, low speed); "
    "heave, roll and pitch only follow the waves, linearly and with the response of zero speed, and no line's pull "
    "changes them; current and wind are the same over the hull and steady over a step; the drift force is Newman's.",
)
