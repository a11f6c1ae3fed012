"""Binds the chain of rigid segments to the contract: ends in, shape and forces out."""

from math import cos, isfinite, sin

from components.compiled import kernel
from components.contract import Component
from components.tether.linkage import model
from components.tether.linkage.chain import (
    ANGLES,
    CHORD,
    DRIVEN,
    END_A,
    END_B,
    FREE,
    GIVEN,
    HN,
    LENGTH,
    MASS,
    POSITION,
    PULLED,
    RN,
    SCRATCH,
    SECOND_AXIS,
    SEGMENTS,
    START,
    STATE,
    THETA,
    TN,
    TOLERATED,
    VIRTUAL_MASS,
    Ends,
    chain_of,
)
from components.tether.linkage.start import begin
from components.tether.linkage.stepping import balance, keep, missing, second_difference
from components.tether.linkage.validity import assess, inertia, size

NOT_FINITE, NOT_STEADY, MISSES = 1, 2, 3
VELOCITY, ACCELERATION, MOTION = 3, 6, 9
# Behind the nodes, tensions, forces and angles in y.
CONVERGED, ITERATED, MISSED, DAMPED, VALIDITY = range(5)


@kernel
def end_b_input(p):
    """Where end b's input begins in u."""
    return MOTION if p[END_A] == DRIVEN else (3 if p[END_A] == PULLED else 0)


@kernel
def ends_of(p, u):
    """The ends' positions in the plane, by the chord where they are not driven, and the pulls."""
    second, b = int(p[SECOND_AXIS]), end_b_input(p)
    ax, ay, bx, by = p[POSITION], p[POSITION + second], 0.0, 0.0
    pull_ax = pull_ay = pull_bx = pull_by = 0.0
    if p[END_A] == DRIVEN:
        ax, ay = u[0], u[second]
    elif p[END_B] == DRIVEN:
        ax, ay = u[b] - p[CHORD], u[b + second] - p[CHORD + 1]
    bx, by = ax + p[CHORD], ay + p[CHORD + 1]
    if p[END_B] == DRIVEN:
        bx, by = u[b], u[b + second]
    if p[END_A] == PULLED:
        pull_ax, pull_ay = u[0], u[second]
    if p[END_B] == PULLED:
        pull_bx, pull_by = u[b], u[b + second]
    return Ends(ax, ay, bx, by, pull_ax, pull_ay, pull_bx, pull_by)


@kernel
def across_plane(p, u):
    """The coordinate that stays: a driven end's, else the parameters'."""
    third = 3 - int(p[SECOND_AXIS])
    if p[END_A] == DRIVEN:
        return u[third]
    return u[end_b_input(p) + third] if p[END_B] == DRIVEN else p[POSITION + third]


@kernel
def rate(p, u, of_b, which):
    """An end's VELOCITY or ACCELERATION in the plane: the other's where it is not driven, none where neither is."""
    at = -1
    if p[END_B] == DRIVEN and (of_b or p[END_A] != DRIVEN):
        at = end_b_input(p)
    elif p[END_A] == DRIVEN:
        at = 0
    if at < 0:
        return 0.0, 0.0
    return u[at + which], u[at + which + int(p[SECOND_AXIS])]


@kernel
def neglected(p, u, chain, ends, load):
    """The measure of inertia, -1 where it is in the model or not to be judged; load: of the water in sum [N]."""
    if p[VIRTUAL_MASS] == 0.0 or p[MASS] > 0.0:
        return -1.0
    second, b, acceleration = ACCELERATION + int(p[SECOND_AXIS]), end_b_input(p), 0.0
    if p[END_A] == DRIVEN:
        acceleration = size(u[ACCELERATION], u[second])
    if p[END_B] == DRIVEN:
        acceleration = max(acceleration, size(u[b + ACCELERATION], u[b + second]))
    chord = size(ends.bx - ends.ax, ends.by - ends.ay)
    return inertia(p[VIRTUAL_MASS], acceleration, p[LENGTH], chord, load / p[LENGTH], p[TOLERATED])


@kernel
def observe(p, u, x, w, y, chain, ends, account):
    """Write all outputs; the angles are those in the state."""
    n, second = chain.n, int(p[SECOND_AXIS])
    third, still = 3 - second, across_plane(p, u)
    tensions, after = 3 * (n + 1), 4 * n + 3
    least = most = outer = 0.0
    inner = 1.0
    for i in range(n + 1):
        a = i * SCRATCH
        y[3 * i], y[3 * i + second], y[3 * i + third] = w[a + RN], w[a + RN + 1], still
        if i < n:
            tx, ty, b = w[a + TN], w[a + TN + 1], a + SCRATCH
            tension = -0.5 * (tx * (w[a + HN] + w[b + HN]) + ty * (w[a + HN + 1] + w[b + HN + 1]))
            y[tensions + i] = tension
            y[after + 6 + i] = x[i * STATE + THETA]
            least, most = min(least, tension), max(most, tension)
            if i < n - 1:
                ux, uy = w[b + TN], w[b + TN + 1]
                inner, outer = min(inner, tx * ux + ty * uy), max(outer, abs(tx * uy - ty * ux))
    last = n * SCRATCH
    for c in range(6):
        y[after + c] = 0.0
    if chain.end_a != FREE:
        y[after], y[after + second] = -w[HN], -w[HN + 1]
    if chain.end_b != FREE:
        y[after + 3], y[after + 3 + second] = w[last + HN], w[last + HN + 1]
    load = size(w[last + HN] - w[HN], w[last + HN + 1] - w[HN + 1])
    after += 6 + n
    y[after + CONVERGED] = 1.0 if account.converged else 0.0
    miss_x, miss_y = missing(chain, w, ends)
    y[after + ITERATED], y[after + MISSED] = account.iterations, size(miss_x, miss_y)
    y[after + DAMPED] = 1.0 if account.damped else 0.0
    rest = neglected(p, u, chain, ends, load)
    assess(y, after + VALIDITY, inner, outer, least, most, account.stretch, rest)


@kernel
def misses(p, ends):
    """Whether given angles miss a driven end b by more than may be drawn to it."""
    n, x, y = int(p[SEGMENTS]), ends.ax, ends.ay
    for i in range(n):
        x, y = x + p[LENGTH] / n * cos(p[ANGLES + i]), y + p[LENGTH] / n * sin(p[ANGLES + i])
    return size(ends.bx - x, ends.by - y) > model.MISS * p[LENGTH]


def init(t_ns, dt_ns, p, u, x, y, w):
    """Lay the chain between its ends, or find the shape of the steady tow, and solve for its rates and forces."""
    chain, ends = chain_of(p), ends_of(p, u)
    if p[START] == GIVEN and p[END_A] == p[END_B] == DRIVEN and misses(p, ends):
        return MISSES
    v_a, v_b = rate(p, u, False, VELOCITY), rate(p, u, True, VELOCITY)
    a_a, a_b = rate(p, u, False, ACCELERATION), rate(p, u, True, ACCELERATION)
    fit, account, steady = begin(chain, p, x, w, ends, v_a, v_b, a_a, a_b, dt_ns * 1e-9)
    if not steady:
        return NOT_STEADY
    observe(p, u, x, w, y, fit, ends, account)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Advance the chain to the ends' new positions, or by the forces on them."""
    h, chain, ends = dt_ns * 1e-9, chain_of(p), ends_of(p, u)
    scheme = second_difference(h)
    fit, account = balance(chain, scheme, x, w, ends, h)
    keep(fit, scheme, x, w, h)
    last = chain.n * SCRATCH
    if not isfinite(w[last + RN] + w[last + RN + 1] + w[HN] + w[HN + 1]):
        return NOT_FINITE
    observe(p, u, x, w, y, fit, ends, account)
    return 0


COMPONENT = Component(
    name="tether.linkage",
    parameters=model.Linkage,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    status_text={
        NOT_FINITE: "the chain's motion became non-finite: shorten the period or check the ends' motion",
        NOT_STEADY: "no steady tow was found between the ends: set start to arc, or give the angles",
        MISSES: "the given angles miss end b by more than 1 % of the length: give others, or start: arc",
    },
    terms=model.terms,
    validity="validity.range",
    assumptions="Inextensible line without twist in one plane, in still water that it does not move; segments short "
    "against the radius of curvature; the water that it moves weighs the same along and across; the seabed is elastic "
    "and without friction. Driven ends farther apart than the length stretch it, and it says so.",
)
