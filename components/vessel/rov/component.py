"""Binds the ROV to the contract."""

from math import cos, sin, sqrt

from components.compiled import kernel
from components.contract import HEADER, BodyEnd, Component
from components.vessel.hook import follow, write_accelerance
from components.vessel.rov import model
from components.vessel.rov.dynamics import assemble, gather, solve_balance
from components.vessel.rov.layout import BY_HOOK, LAW, MAX_SPEED, POINT, SLOPE, START, SWITCHES, TRIAL, WATER
from components.vessel.yawing import TRIAL as TRIAL_LENGTH
from components.vessel.yawing import UNSOLVED, U, V, W, advance, relate, settle

ETA, RATE, ACC, ALGORITHMIC = range(0, 16, 4)
POSITION, ATTITUDE, VELOCITY, RATES, THROUGH_WATER, HOOK, VALIDITY, ACCELERANCE = 0, 3, 6, 9, 12, 15, 24, 28


@kernel
def observe(q, u, x, w, h, excess, y):
    """Write all outputs of the motion just found."""
    eta, rate, acc = x[:RATE], x[RATE:ACC], x[ACC:ALGORITHMIC]
    m, point = w[TRIAL : TRIAL + TRIAL_LENGTH], w[POINT : POINT + 9]
    relate(eta, rate, acc, w[WATER : WATER + 3], 0.0, m)
    c, s = cos(eta[3]), sin(eta[3])
    for i in range(3):
        y[POSITION + i], y[ATTITUDE + i], y[RATES + i] = eta[i], 0.0, 0.0
    y[ATTITUDE + 2], y[RATES + 2] = eta[3], rate[3]
    y[VELOCITY], y[VELOCITY + 1], y[VELOCITY + 2] = c * rate[0] + s * rate[1], c * rate[1] - s * rate[0], rate[2]
    y[THROUGH_WATER], y[THROUGH_WATER + 1], y[THROUGH_WATER + 2] = m[U], m[V], m[W]
    follow(eta, rate, acc, m, point, y[HOOK : HOOK + 9])
    y[VALIDITY + 1] = sqrt(m[U] * m[U] + m[V] * m[V] + m[W] * m[W]) / q[MAX_SPEED]
    y[VALIDITY + 2] = max(1.0 - eta[2], 0.0)
    y[VALIDITY + 3] = excess / UNSOLVED
    y[VALIDITY] = max(y[VALIDITY + 1], y[VALIDITY + 2], y[VALIDITY + 3])
    if q[SWITCHES + LAW] > 0.0:
        a, jac = w[BY_HOOK : BY_HOOK + 12], w[SLOPE : SLOPE + 28]
        assemble(q, u, w, eta, rate, acc, h)
        write_accelerance(jac, acc, m, point, h, True, a, y[ACCELERANCE : ACCELERANCE + 9])


def init(t_ns, dt_ns, p, u, x, y, w):
    """Start in balance with the forces there are; a bonded line's is not known yet, and the start is without force."""
    q = p[HEADER:]
    eta, rate, acc = x[:RATE], x[RATE:ACC], x[ACC:ALGORITHMIC]
    c, s = cos(q[START + 3]), sin(q[START + 3])
    for i in range(4):
        eta[i], acc[i] = q[START + i], 0.0
    rate[0], rate[1] = c * q[START + 4] - s * q[START + 5], s * q[START + 4] + c * q[START + 5]
    rate[2], rate[3] = q[START + 6], q[START + 7]
    gather(q, u, w)
    excess = 0.0
    if q[SWITCHES + LAW] == 0.0:
        excess = solve_balance(q, u, w, eta, rate, acc, 0.0)
    for i in range(4):
        x[ALGORITHMIC + i] = acc[i]
    observe(q, u, x, w, dt_ns * 1e-9, excess, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Solve the balance at the step's end."""
    q, h = p[HEADER:], dt_ns * 1e-9
    eta, rate, acc, algorithmic = x[:RATE], x[RATE:ACC], x[ACC:ALGORITHMIC], x[ALGORITHMIC : ALGORITHMIC + 4]
    advance(eta, rate, algorithmic, h)
    gather(q, u, w)
    excess = solve_balance(q, u, w, eta, rate, acc, h)
    settle(eta, rate, acc, algorithmic, h)
    observe(q, u, x, w, h, excess, y)
    return 0


COMPONENT = Component(
    name="vessel.rov",
    parameters=model.Rov,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    bodies={"hook": BodyEnd(motion="hook", law="line", switch="takes_law", accelerance="accelerance")},
    terms=model.terms,
    validity="validity.range",
    assumptions="Level in roll and pitch, and wholly under water; constant added mass, damping without coupling; the "
    "current is steady over a step and the same over the vehicle.",
)
