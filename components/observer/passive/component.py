"""Binds the nonlinear passive observer to the contract."""

from math import cos, inf, sin, sqrt

from components.compiled import kernel
from components.contract import HEADER, Component
from components.kinematics import wrapped
from components.observer import ship
from components.observer.layout import (
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
from components.observer.motion import drift_on, parts, swing, swing_back, swing_on
from components.observer.output import write_estimate, write_reading
from components.observer.passive import model
from components.observer.passive.correction import correct
from components.observer.passive.layout import COMMON, GATE_SPEEDS, GATES
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

TAU, SCRATCH, SEEN, SUMS = 0, 3, 9, 12


@kernel
def expected(q, state, axis, age):
    """The position or heading on an axis `age` [s] ago, the waves' part included."""
    from_first, from_second, _ = swing_back(q[WAVE_FREQUENCY], q[WAVE_DAMPING], age)
    c, s, u, v = cos(state[ETA + 2]), sin(state[ETA + 2]), state[NU], state[NU + 1]
    rate = c * u - s * v if axis == 0 else s * u + c * v if axis == 1 else state[NU + 2]
    k = WAVE + 2 * axis
    return state[ETA + axis] - age * rate + from_first * state[k] + from_second * state[k + 1]


@kernel
def begin_heading(state, kept, value):
    """Take a heading as the first, and the next position too: levers were turned by a wrong heading until now."""
    gap = value - state[ETA + 2]
    state[ETA + 2] = value if kept[HAS_HEADING] == 0.0 else state[ETA + 2] + wrapped(gap)
    kept[HAS_HEADING], kept[HAS_POSITION] = 1.0, 0.0


@kernel
def read_compass(p, u, t, x, y, w):
    """Use the compass if it gives a new and sound heading."""
    q, state, kept, seen = p[COMMON:], x[:STATES], x[STATES:], w[SEEN : SEEN + 3]
    at, n, last = compass_at(q), int(q[REFERENCES]), len(x) - 1
    record = kept[RECORDS + RECORD * n : RECORDS + RECORD * (n + 1)]
    status = receive(q, record, u[at : at + 1], u[at + 1], u[at + 2], t)
    seen[0] = 0.0
    if status == USED:
        if kept[HAS_HEADING] == 0.0:
            begin_heading(state, kept, u[at])
        gap = t - x[last]
        seen[0] = wrapped(u[at] - expected(q, state, 2, t - u[at + 2]))
        is_wild = abs(seen[0]) > p[GATES + 2] + p[GATE_SPEEDS + 2] * gap
        if is_wild and is_believed(q, record, NEVER, t):
            begin_heading(state, kept, u[at])
            seen[0], is_wild = wrapped(u[at] - expected(q, state, 2, t - u[at + 2])), False
        if is_wild:
            status = WILD
        else:
            correct(p, state, 2, seen[0], gap, t - u[at + 2], 1.0, 0.0)
            x[last], record[WILD_SINCE] = t, NEVER
    write_reading(y, n, n, status, seen)
    return status


@kernel
def judge_reference(p, u, t, index, h, x, y, w):
    """Add a position reference's innovation to the sums in w by its weight, if its position is new and sound."""
    q, state, kept, seen = p[COMMON:], x[:STATES], x[STATES:], w[SEEN : SEEN + 3]
    at, n = INPUT * index, int(q[REFERENCES])
    record = kept[RECORDS + RECORD * index : RECORDS + RECORD * (index + 1)]
    status = receive(q, record, u[at : at + 3], u[at + 3], u[at + 4], t)
    seen[0] = seen[1] = 0.0
    if status == USED:
        north, east = locate(q, u, kept, index, t - u[at + 4], h)
        if kept[HAS_POSITION] == 0.0:
            state[ETA], state[ETA + 1], kept[HAS_POSITION] = north, east, 1.0
        age, gap = t - u[at + 4], t - kept[LAST_FIX]
        seen[0], seen[1] = north - expected(q, state, 0, age), east - expected(q, state, 1, age)
        is_wild = sqrt(seen[0] * seen[0] + seen[1] * seen[1]) > p[GATES] + p[GATE_SPEEDS] * gap
        if is_wild and is_believed(q, record, kept[LAST_FIX], t):
            state[ETA], state[ETA + 1], is_wild = north, east, False
            seen[0], seen[1] = north - expected(q, state, 0, age), east - expected(q, state, 1, age)
        if is_wild:
            status = WILD
        else:
            weight = 1.0 / q[FIRST + REFERENCE * index + NOISE] ** 2
            w[SUMS] += weight * seen[0]
            w[SUMS + 1] += weight * seen[1]
            w[SUMS + 2] += weight
            w[SUMS + 3] += weight * age
            record[WILD_SINCE] = NEVER
    write_reading(y, n, index, status, seen)


@kernel
def read_all(p, u, t, h, x, y, w):
    """Use what the instruments gave, references that give at once by their weights, and write all outputs."""
    q, state, kept = p[COMMON:], x[:STATES], x[STATES:]
    status = read_compass(p, u, t, x, y, w)
    heading = heading_now(q, u, status, state[ETA + 2] + state[WAVE + 5], t, h)
    for i in range(4):
        w[SUMS + i] = 0.0
    remember(q, u, kept, heading)
    for index in range(int(q[REFERENCES])):
        judge_reference(p, u, t, index, h, x, y, w)
    if w[SUMS + 2] > 0.0:
        gap, c, s = t - kept[LAST_FIX], cos(heading), sin(heading)
        for axis in range(2):
            correct(p, state, axis, w[SUMS + axis] / w[SUMS + 2], gap, w[SUMS + 3] / w[SUMS + 2], c, s)
        kept[LAST_FIX] = t
    write_estimate(state, kept, t, y)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with what the instruments give."""
    t, q = t_ns * 1e-9, p[HEADER:]
    common, kept = q[COMMON:], x[STATES:]
    for i in range(len(x)):
        x[i] = 0.0
    for i in range(3):
        x[ETA + i] = common[START + i]
    kept[LAST_FIX] = x[len(x) - 1] = t
    for i in range(int(common[REFERENCES]) + 1):
        forget(kept[RECORDS + RECORD * i : RECORDS + RECORD * (i + 1)])
    feel_wind(common, u, kept[LOAD : LOAD + 3], inf)
    read_all(q, u, t, dt_ns * 1e-9, x, y, w)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Move the estimate on, then correct it."""
    t, h, own = t_ns * 1e-9, dt_ns * 1e-9, p[HEADER:]
    q, state, wind = own[COMMON:], x[:STATES], x[STATES + LOAD : STATES + LOAD + 3]
    tau = w[TAU : TAU + 3]
    push(q, u, wind, tau)
    n = parts(q, h)
    for _ in range(n):
        drift_on(q, state, tau, h / n, w[SCRATCH : SCRATCH + 6])
    swing_on(state, swing(q[WAVE_FREQUENCY], q[WAVE_DAMPING], h))
    feel_wind(q, u, wind, h)
    read_all(own, u, t, h, x, y, w)
    return 0


COMPONENT = Component(
    name="observer.passive",
    parameters=model.Passive,
    inputs=ship.inputs,
    outputs=ship.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=ship.terms,
    assumptions="A vessel at low speed with linear damping and no Coriolis forces; what is slow is a load in the "
    "world's frame, motion in waves a resonance at one period, alike north and east; roll and pitch are small.",
)
