"""Binds the extended Kalman filter to the contract."""

from math import inf, sqrt

from components.compiled import kernel
from components.contract import HEADER, Component
from components.kinematics import wrapped
from components.matrices import table
from components.observer import ship
from components.observer.kalman import model
from components.observer.kalman.covariance import LOW, begin_anew, grow
from components.observer.kalman.layout import COMMON, COMPASS_NOISE, GATE, MOVING, PLACED, SLOW, WAVES
from components.observer.kalman.measuring import unseen, use_heading, use_position
from components.observer.layout import (
    BIAS,
    ETA,
    FIRST,
    HAS_HEADING,
    HAS_POSITION,
    INPUT,
    LAST_FIX,
    LOAD,
    NOISE,
    NU,
    RECORD,
    RECORDS,
    REFERENCE,
    REFERENCES,
    START,
    STATES,
    WAVE,
    WAVE_DAMPING,
    WAVE_FREQUENCY,
    WILD_SINCE,
)
from components.observer.motion import drift_on, parts, swing, swing_on
from components.observer.output import write_estimate, write_reading
from components.observer.reading import (
    NEVER,
    USED,
    WILD,
    compass_at,
    feel_wind,
    forget,
    heading_now,
    is_believed,
    locate,
    push,
    receive,
    remember,
)

COVARIANCE, KEPT = STATES, STATES + STATES * STATES
SLOPE, TRANSITION, OTHER, ROWS = 0, LOW * LOW, 2 * LOW * LOW, 2 * LOW * LOW + STATES * STATES
SEEN, TAU, MIDDLE = ROWS + 3 * STATES, ROWS + 3 * STATES + 3, ROWS + 3 * STATES + 6


@kernel
def begin_heading(p, state, cov, kept, value):
    """Take a heading as the first, and the next position too: levers were turned by a wrong heading until now."""
    gap = value - state[ETA + 2]
    state[ETA + 2] = value if kept[HAS_HEADING] == 0.0 else state[ETA + 2] + wrapped(gap)
    begin_anew(cov, ETA + 2, p[PLACED + 2])
    kept[HAS_HEADING], kept[HAS_POSITION] = 1.0, 0.0


@kernel
def begin_position(p, state, cov, kept, north, east):
    """Take a position as the first."""
    state[ETA], state[ETA + 1], kept[HAS_POSITION] = north, east, 1.0
    for i in range(2):
        begin_anew(cov, ETA + i, p[PLACED + i])


@kernel
def read_compass(p, u, t, x, y, w, cov):
    """Use the compass if it gives a new and sound heading."""
    q, kept = p[COMMON:], x[KEPT:]
    at, n = compass_at(q), int(q[REFERENCES])
    seen, state = w[SEEN : SEEN + 3], x[:STATES]
    seen[0] = seen[1] = 0.0
    record = kept[RECORDS + RECORD * n : RECORDS + RECORD * (n + 1)]
    status = receive(q, record, u[at : at + 1], u[at + 1], u[at + 2], t)
    if status == USED:
        omega, zeta, age = q[WAVE_FREQUENCY], q[WAVE_DAMPING], t - u[at + 2]
        noise = p[COMPASS_NOISE] + unseen(p[WAVES + 2], omega, zeta, age)
        rows = w[ROWS : ROWS + 3 * STATES]
        if kept[HAS_HEADING] == 0.0:
            begin_heading(p, state, cov, kept, u[at])
        status = use_heading(state, cov, u[at], noise, omega, zeta, age, p[GATE], rows, seen)
        if status == WILD and is_believed(q, record, NEVER, t):
            begin_heading(p, state, cov, kept, u[at])
            status = use_heading(state, cov, u[at], noise, omega, zeta, age, p[GATE], rows, seen)
        if status == USED:
            record[WILD_SINCE] = NEVER
    write_reading(y, n, n, status, seen)
    y[len(y) - 1] = seen[1]
    return status


@kernel
def read_reference(p, u, t, index, h, x, y, w, cov):
    """Use a position reference if it gives a new and sound position."""
    q, kept = p[COMMON:], x[KEPT:]
    at, n = INPUT * index, int(q[REFERENCES])
    seen, state = w[SEEN : SEEN + 3], x[:STATES]
    seen[0] = seen[1] = seen[2] = 0.0
    record = kept[RECORDS + RECORD * index : RECORDS + RECORD * (index + 1)]
    status = receive(q, record, u[at : at + 3], u[at + 3], u[at + 4], t)
    if status == USED:
        north, east = locate(q, u, kept, index, t - u[at + 4], h)
        omega, zeta, age = q[WAVE_FREQUENCY], q[WAVE_DAMPING], t - u[at + 4]
        noise = q[FIRST + REFERENCE * index + NOISE] ** 2 + unseen(p[WAVES], omega, zeta, age)
        if kept[HAS_POSITION] == 0.0:
            begin_position(p, state, cov, kept, north, east)
        rows = w[ROWS : ROWS + 3 * STATES]
        status = use_position(state, cov, north, east, noise, omega, zeta, age, p[GATE], rows, seen)
        if status == WILD and is_believed(q, record, kept[LAST_FIX], t):
            begin_position(p, state, cov, kept, north, east)
            status = use_position(state, cov, north, east, noise, omega, zeta, age, p[GATE], rows, seen)
    if status == USED:
        kept[LAST_FIX], record[WILD_SINCE] = t, NEVER
    write_reading(y, n, index, status, seen)
    y[len(y) - 1 - n + index] = seen[2]


@kernel
def read_all(p, u, t, h, x, y, w):
    """Use what the instruments gave, and write all outputs."""
    q, state, kept = p[COMMON:], x[:STATES], x[KEPT:]
    cov = table(x, COVARIANCE, STATES, STATES)
    status = read_compass(p, u, t, x, y, w, cov)
    n = int(q[REFERENCES])
    remember(q, u, kept, heading_now(q, u, status, state[ETA + 2] + state[WAVE + 5], t, h))
    for index in range(n):
        read_reference(p, u, t, index, h, x, y, w, cov)
    write_estimate(state, kept, t, y)
    at = len(y) - 4 - n
    for i in range(3):
        y[at + i] = sqrt(max(cov[i, i], 0.0))


@kernel
def begin(p, t, x):
    """Before the first value: at the given position, at rest, as uncertain as the parameters say."""
    q, cov, kept = p[COMMON:], table(x, COVARIANCE, STATES, STATES), x[KEPT:]
    for i in range(len(x)):
        x[i] = 0.0
    square = q[WAVE_FREQUENCY] ** 2
    for i in range(3):
        x[ETA + i] = q[START + i]
        cov[ETA + i, ETA + i], cov[NU + i, NU + i], cov[BIAS + i, BIAS + i] = p[PLACED + i], p[MOVING + i], p[SLOW + i]
        k = WAVE + 2 * i
        cov[k, k], cov[k + 1, k + 1] = p[WAVES + i] / square, p[WAVES + i]
    kept[LAST_FIX] = t
    for i in range(int(q[REFERENCES]) + 1):
        forget(kept[RECORDS + RECORD * i : RECORDS + RECORD * (i + 1)])


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with what the instruments give."""
    t, q = t_ns * 1e-9, p[HEADER:]
    begin(q, t, x)
    feel_wind(q[COMMON:], u, x[KEPT + LOAD : KEPT + LOAD + 3], inf)
    read_all(q, u, t, dt_ns * 1e-9, x, y, w)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Move the estimate on, then correct it."""
    t, h, own = t_ns * 1e-9, dt_ns * 1e-9, p[HEADER:]
    q, state = own[COMMON:], x[:STATES]
    wind, tau, middle = x[KEPT + LOAD : KEPT + LOAD + 3], w[TAU : TAU + 3], w[MIDDLE : MIDDLE + 6]
    push(q, u, wind, tau)
    omega, zeta = q[WAVE_FREQUENCY], q[WAVE_DAMPING]
    slopes, shift = table(w, SLOPE, LOW, LOW), table(w, TRANSITION, LOW, LOW)
    cov, other = table(x, COVARIANCE, STATES, STATES), table(w, OTHER, STATES, STATES)
    n = parts(q, h)
    for _ in range(n):
        drift_on(q, state, tau, h / n, middle)
        swing_on(state, swing(omega, zeta, h / n))
        grow(own, state, middle[:3], omega, zeta, h / n, slopes, shift, cov, other)
    feel_wind(q, u, wind, h)
    read_all(own, u, t, h, x, y, w)
    return 0


COMPONENT = Component(
    name="observer.kalman",
    parameters=model.Kalman,
    inputs=ship.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=ship.terms,
    assumptions="A vessel at low speed with linear damping and no Coriolis forces; what is slow is a Gauss-Markov load "
    "in the world's frame, motion in waves a resonance at one period, alike north and east; noise is white.",
)
