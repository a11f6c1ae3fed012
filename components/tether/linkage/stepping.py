"""One implicit step of the chain: the second backward difference (BDF2), for all angles and joint forces at once.

v = (3 r_{k+1} - 4 r_k + r_{k-1}) / 2h of every node, and a likewise of v; the balances and the closure of the chain
between its ends hold at the end of the step. Second order, L-stable, and without drift: positions are what is closed.
"""

from math import sqrt
from typing import NamedTuple

from components.compiled import kernel
from components.tether.linkage.chain import (
    DELTA,
    DRIVEN,
    HN,
    LAST,
    PULLED,
    RN,
    SCRATCH,
    STATE,
    THETA,
    TN,
    TURN,
    TURN_BEFORE,
    VN,
    H,
    Q,
    R,
    T,
    U,
    V,
    stretched,
)
from components.tether.linkage.hinged import sweep_hinged
from components.tether.linkage.rotation import rotate
from components.tether.linkage.segment import place_node
from components.tether.linkage.sweep import close, substitute, sweep

# What the chain may miss end b by, over its length.
CLOSED = 1e-11
# A chain between driven ends is kept so much longer than their distance, over its length: beyond it, it stretches.
SLACK = 1e-6
# Largest correction of an angle in one iteration [rad].
LARGEST_TURN = 0.5
# Drag along over drag across below which a segment's shifts along itself are too large to invert its impedance.
ALONG = 1e-4
# Bend that is given to a straight chain which has to find a way out [rad].
KICK = 1e-3


class Scheme(NamedTuple):
    """v = c (r - r_k) + k_u u_k and a = c_a (v - v_k) + k_q q_k, u and q being the last step's mean rates."""

    c: float
    k_u: float
    c_a: float
    k_q: float


class Account(NamedTuple):
    """How a step went. stretch: of the segments; damped: whether the closure lost rank."""

    converged: bool
    iterations: int
    stretch: float
    damped: bool


@kernel
def second_difference(h):
    """BDF2 for equal steps [s]."""
    return Scheme(c=1.5 / h, k_u=-0.5, c_a=1.5 / h, k_q=-0.5)


@kernel
def fitted(chain, ends):
    """The chain and its stretch, to reach from driven end to end; a single segment is as long as they ask."""
    if chain.end_a != DRIVEN or chain.end_b != DRIVEN:
        return chain, 0.0
    dx, dy = ends.bx - ends.ax, ends.by - ends.ay
    distance = sqrt(dx * dx + dy * dy)
    reach = chain.n * chain.l0
    if chain.n > 1:
        if distance <= (1.0 - SLACK) * reach:
            return chain, 0.0
        distance /= 1.0 - SLACK
    return stretched(chain, distance / chain.n), distance / reach - 1.0


@kernel
def predict(chain, x, w, ends, h):
    """Angles that go on as in the last two steps; joint forces as they were."""
    for i in range(chain.n + 1):
        a, k = i * SCRATCH, i * STATE
        w[a + DELTA] = 2.0 * x[k + TURN] - x[k + TURN_BEFORE]
        w[a + HN], w[a + HN + 1] = x[k + H], x[k + H + 1]
    w[RN], w[RN + 1] = x[R] + h * x[U], x[R + 1] + h * x[U + 1]
    if chain.end_a == DRIVEN:
        w[RN], w[RN + 1] = ends.ax, ends.ay


@kernel
def place(chain, scheme, x, w):
    """Directions, positions and rates of all nodes, from end a's position and the angles' increments."""
    rx, ry = w[RN], w[RN + 1]
    place_node(chain, scheme, x, w, 0, rx, ry)
    for i in range(chain.n):
        a, k = i * SCRATCH, i * STATE
        tx, ty = rotate(x[k + T], x[k + T + 1], w[a + DELTA])
        w[a + TN], w[a + TN + 1] = tx, ty
        rx, ry = rx + chain.l0 * tx, ry + chain.l0 * ty
        place_node(chain, scheme, x, w, i + 1, rx, ry)


@kernel
def shorten(chain, w, factor):
    """Take back all of the last correction but a factor of it."""
    for i in range(chain.n):
        a = i * SCRATCH
        w[a + DELTA] -= (1.0 - factor) * w[a + LAST]


@kernel
def bend(chain, w, side):
    """Give a straight chain a slight arc to this side of it."""
    kick = KICK if side >= 0.0 else -KICK
    for i in range(chain.n):
        w[i * SCRATCH + DELTA] += kick * (1.0 - (2.0 * i + 1.0) / chain.n)


@kernel
def missing(chain, w, ends):
    """Vector from the last node to a driven end b; none to others."""
    last = chain.n * SCRATCH
    if chain.end_b == DRIVEN:
        return ends.bx - w[last + RN], ends.by - w[last + RN + 1]
    return 0.0, 0.0


@kernel
def correct(chain, scheme, x, w, ends):
    """Place the chain and correct it once by Newton's method.

    Returns the largest correction [rad, or of end a over the length], whether the closure determined the force, and
    what the chain misses end b by now, to the correction's second order [m].
    """
    if chain.spring == 0.0 and (chain.c_V > ALONG * chain.c_S or chain.mass > 0.0):
        Sxx, Sxy, Syy, sx, sy = sweep_hinged(chain, scheme, x, w, ends.pull_ax, ends.pull_ay)
    else:
        Sxx, Sxy, Syy, sx, sy = sweep(chain, scheme, x, w, ends.pull_ax, ends.pull_ay)
    miss_x, miss_y = missing(chain, w, ends)
    h_x = h_y = 0.0
    determined = True
    if chain.end_b == DRIVEN:
        h_x, h_y, determined = close(Sxx, Sxy, Syy, sx - miss_x, sy - miss_y)
    elif chain.end_b == PULLED:
        h_x, h_y = -ends.pull_bx, -ends.pull_by
    largest, turn_x, turn_y, bent_x, bent_y = substitute(chain, w, h_x, h_y)
    factor = 1.0
    if largest > LARGEST_TURN:
        factor = LARGEST_TURN / largest
        shorten(chain, w, factor)
    # What end b shifts by, less what the angles turn it against end a.
    shift_x, shift_y = sx - (Sxx * h_x + Sxy * h_y) - turn_x, sy - (Sxy * h_x + Syy * h_y) - turn_y
    if chain.end_a != DRIVEN:
        w[RN], w[RN + 1] = w[RN] + factor * shift_x, w[RN + 1] + factor * shift_y
        largest = max(largest, sqrt(shift_x * shift_x + shift_y * shift_y) / (chain.n * chain.l0))
    after = sqrt(bent_x * bent_x + bent_y * bent_y) if chain.end_b == DRIVEN else 0.0
    if not determined:
        after += sqrt(miss_x * miss_x + miss_y * miss_y)
    return largest, determined, after


@kernel
def balance(chain, scheme, x, w, ends, h):
    """Find the angles and forces that balance the chain at the end of the step of h [s], without placing it."""
    chain, stretch = fitted(chain, ends)
    predict(chain, x, w, ends, h)
    allowed = CLOSED * chain.n * chain.l0
    lost = converged = False
    iteration = 0
    while iteration < chain.iterations and not converged:
        largest, determined, after = correct(chain, scheme, x, w, ends)
        lost = lost or not determined
        if not determined and after > allowed and chain.n > 1:
            bend(chain, w, w[chain.n * SCRATCH + HN] * w[TN + 1] - w[chain.n * SCRATCH + HN + 1] * w[TN])
        iteration += 1
        converged = largest <= chain.tolerance and after <= allowed
    return chain, Account(converged, iteration, stretch, lost)


@kernel
def solve(chain, scheme, x, w, ends, h):
    """Bring the chain into balance at the end of the step of h [s] and place it; x is only read."""
    chain, account = balance(chain, scheme, x, w, ends, h)
    place(chain, scheme, x, w)
    return chain, account


@kernel
def keep(chain, scheme, x, w, h):
    """Place the balanced chain, and keep what the next step has to know."""
    rate = 1.0 / h
    rx, ry = w[RN], w[RN + 1]
    for i in range(chain.n + 1):
        a, k = i * SCRATCH, i * STATE
        w[a + RN], w[a + RN + 1] = rx, ry
        ux, uy = rate * (rx - x[k + R]), rate * (ry - x[k + R + 1])
        if chain.mass > 0.0:
            place_node(chain, scheme, x, w, i, rx, ry)
            for j in range(2):
                x[k + Q + j] = (w[a + VN + j] - x[k + V + j]) * rate
                x[k + V + j] = w[a + VN + j]
        x[k + U], x[k + U + 1], x[k + R], x[k + R + 1] = ux, uy, rx, ry
        x[k + H], x[k + H + 1] = w[a + HN], w[a + HN + 1]
        if i < chain.n:
            turn = w[a + DELTA]
            tx, ty = rotate(x[k + T], x[k + T + 1], turn)
            rx, ry = rx + chain.l0 * tx, ry + chain.l0 * ty
            w[a + TN], w[a + TN + 1], x[k + T], x[k + T + 1] = tx, ty, tx, ty
            x[k + THETA] += turn
            x[k + TURN_BEFORE] = x[k + TURN]
            x[k + TURN] = turn
