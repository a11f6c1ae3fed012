"""Binds the filter of a tether to the contract."""

from math import sqrt

from components.compiled import kernel
from components.contract import Component
from components.estimator.tether import model
from components.estimator.tether.layout import (
    ACROSS,
    ALONG,
    ANGLE_BIAS,
    COVARIANCE,
    HOOK,
    IS_KNOWN,
    KEPT_LINE,
    MOVING,
    PLACED,
    SEEN,
    SHAPE,
    START,
    STATES,
    SWING,
    TENSIONS,
    B,
    C,
    D,
    R,
    V,
    own_at,
    segments_of,
)
from components.estimator.tether.pose import place_of, pose_at, remember
from components.estimator.tether.prediction import follow, predict
from components.estimator.tether.shape import hang
from components.estimator.tether.tension import deviation, use_cell
from components.estimator.tether.usbl import LOST, use_usbl
from components.matrices import table

NEVER = -1e300
LARGEST_NIS = 1e12  # that is given out
# Outputs behind the nodes.
(TENSION, TENSION_DEVIATION, END, END_DEVIATION, VELOCITY, OFFSET, OFFSET_DEVIATION, MEAN, HELD, STATUS, NIS,
 FREEDOM) = (0, 2, 4, 7, 10, 13, 15, 17, 19, 20, 22, 24)  # fmt: skip


@kernel
def begin(q, x):
    """Before the first measurement: end b where the parameters put it, at rest; no line is known yet."""
    for i in range(len(x)):
        x[i] = 0.0
    cov = table(x, COVARIANCE, STATES, STATES)
    for k in range(3):
        x[R + k] = q[START + k]
        cov[R + k, R + k], cov[V + k, V + k] = q[PLACED], q[MOVING]
    cov[C, C], cov[C + 1, C + 1], cov[D, D] = q[ALONG], q[ACROSS], q[SWING]
    cov[B, B] = cov[B + 1, B + 1] = q[ANGLE_BIAS]
    x[KEPT_LINE + SEEN] = NEVER


@kernel
def write_nodes(n, state, hook, kept, y):
    """The line's places where it is known, else a straight way to end b."""
    for i in range(n + 1):
        for k in range(3):
            straight = i / n * (state[R + k] - hook[k])
            y[3 * i + k] = hook[k] + (kept[SHAPE + 6 * i + k] if kept[IS_KNOWN] > 0.0 else straight)


@kernel
def write_estimate(q, state, cov, kept, y, w):
    """Tensions, end b, current, and how sure they are."""
    for end in range(2):
        y[TENSION + end] = max(kept[TENSIONS + end] + state[D], 0.0)
        y[TENSION_DEVIATION + end] = deviation(q, cov, kept, end, w)
        y[MEAN + end] = kept[TENSIONS + end]
    for k in range(3):
        y[END + k], y[VELOCITY + k] = state[R + k], state[V + k]
        y[END_DEVIATION + k] = sqrt(max(cov[R + k, R + k], 0.0))
    for k in range(2):
        y[OFFSET + k], y[OFFSET_DEVIATION + k] = state[C + k], sqrt(max(cov[C + k, C + k], 0.0))


@kernel
def read(t, h, p, u, x, y, w):
    """Use what the sensors say, find the line, and write all outputs."""
    q, n, kept = p[own_at(p) :], segments_of(p), x[KEPT_LINE:]
    state, cov = x[:STATES], table(x, COVARIANCE, STATES, STATES)
    remember(u, kept)
    hook = place_of(kept, pose_at(kept, 0.0, h), q[HOOK : HOOK + 3])
    usbl, usbl_nis = use_usbl(q, u, t, h, x, kept, w)
    follow(q, state, kept, h)
    cell, cell_nis = LOST, 0.0
    found = hang(q, p, u, state, hook, True, kept, w)
    if found:
        cell, cell_nis = use_cell(q, u, t, h, state, cov, kept, w)
        found = hang(q, p, u, state, hook, False, kept, w)
    write_nodes(n, state, hook, kept, y)
    out = y[3 * (n + 1) :]
    write_estimate(q, state, cov, kept, out, w)
    out[HELD] = 0.0 if found else 1.0
    out[STATUS], out[STATUS + 1] = usbl, cell
    out[NIS], out[NIS + 1] = min(usbl_nis, LARGEST_NIS), min(cell_nis, LARGEST_NIS)
    out[FREEDOM], out[FREEDOM + 1] = (3.0 if usbl_nis > 0.0 else 0.0), (1.0 if cell_nis > 0.0 else 0.0)


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with what the sensors say first."""
    begin(p[own_at(p) :], x)
    read(t_ns * 1e-9, dt_ns * 1e-9, p, u, x, y, w)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Move the estimate on, then correct it."""
    h = dt_ns * 1e-9
    predict(p[own_at(p) :], x[:STATES], table(x, COVARIANCE, STATES, STATES), h)
    read(t_ns * 1e-9, h, p, u, x, y, w)
    return 0


COMPONENT = Component(
    name="estimator.tether",
    parameters=model.Tether,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="A uniform elastic line at rest in a current over depth that is off by one slow vector; what moves it "
    "from there is a white error of its tension, coloured by one time and alike at both ends. The ship is where its "
    "observer has it; end b moves by white accelerations; noise is white, the angles' slow error apart.",
)
