"""The chain's shape at the beginning: given angles, a circular arc between the ends, or that of a steady tow."""

from math import atan2, cos, pi, sin, sqrt

from components.compiled import kernel
from components.tether.linkage.chain import (
    ANGLES,
    DELTA,
    DRIVEN,
    GIVEN,
    HN,
    RN,
    SCRATCH,
    SIDE,
    START,
    STATE,
    STEADY,
    THETA,
    TN,
    TURN,
    TURN_BEFORE,
    VN,
    Ends,
    H,
    Q,
    R,
    T,
    U,
    V,
    massless,
)
from components.tether.linkage.stepping import Scheme, balance, correct, fitted, keep, place, solve

# Bisections to the last bit of the arc's angle.
BISECTIONS = 60
# Steps towards the steady tow, the first and the longest, over the time in which the chain goes its length (longer ones
# do not lessen the corrections of a line near along the tow that nothing drags along itself); the most of them, and the
# turn of a segment in one below which it is steady, and steady if it does not fall any more [rad].
FIRST, LONGEST, GROWTH, MOST, STILL, ROUNDED = 0.02, 0.1, 1.3, 400, 1e-11, 1e-9
# Times over which the first rates and accelerations are found [s], and to what corrections of an angle in them [rad]:
# 1e-5 rad/s and 1e-5 rad/s^2, which a step's own tolerance would be far from.
TINY, SHORT = 1e-5, 1e-3
SLIGHT, SLIGHTER = 1e-10, 1e-11


@kernel
def half_angle(n, ratio):
    """Half the opening angle of the polygon of n equal segments on a circle whose chord is `ratio` of their length."""
    low, high = 0.0, pi
    for _ in range(BISECTIONS):
        phi = 0.5 * (low + high)
        chord = sin(phi) / (n * sin(phi / n))
        if chord > ratio:
            low = phi
        else:
            high = phi
    return 0.5 * (low + high)


@kernel
def lay(chain, p, x, ends, side):
    """Write angles and directions: the given ones, or an arc from end a to b that bulges to a side (+1: starboard)."""
    dx, dy = ends.bx - ends.ax, ends.by - ends.ay
    phi = side * half_angle(chain.n, min(sqrt(dx * dx + dy * dy) / (chain.n * chain.l0), 1.0))
    heading = atan2(dy, dx)
    for i in range(chain.n):
        theta = heading + phi * (1.0 - (2.0 * i + 1.0) / chain.n)
        if p[START] == GIVEN:
            theta = p[ANGLES + i]
        x[i * STATE + THETA] = theta
        x[i * STATE + T], x[i * STATE + T + 1] = cos(theta), sin(theta)


@kernel
def set_moving(chain, x, ends, v):
    """Write positions, and this velocity for all nodes."""
    rx, ry = ends.ax, ends.ay
    if chain.end_a != DRIVEN and chain.end_b == DRIVEN:
        rx, ry = ends.bx, ends.by
        for i in range(chain.n):
            rx, ry = rx - chain.l0 * x[i * STATE + T], ry - chain.l0 * x[i * STATE + T + 1]
    for i in range(chain.n + 1):
        k = i * STATE
        x[k + R], x[k + R + 1] = rx, ry
        for j in range(2):
            x[k + U + j] = x[k + V + j] = v[j]
            x[k + Q + j] = x[k + H + j] = 0.0
        x[k + TURN] = x[k + TURN_BEFORE] = 0.0
        if i < chain.n:
            rx, ry = rx + chain.l0 * x[k + T], ry + chain.l0 * x[k + T + 1]


@kernel
def set_going(chain, x, w, h):
    """Write the velocities found, which do not stretch the segments, the turns in h [s] and the joints' forces."""
    for i in range(chain.n + 1):
        a, k = i * SCRATCH, i * STATE
        for j in range(2):
            x[k + U + j] = x[k + V + j] = w[a + VN + j]
            x[k + H + j] = w[a + HN + j]
        if i < chain.n:
            b = a + SCRATCH
            across = w[a + TN] * (w[b + VN + 1] - w[a + VN + 1]) - w[a + TN + 1] * (w[b + VN] - w[a + VN])
            x[k + TURN] = x[k + TURN_BEFORE] = across * h / chain.l0


@kernel
def drift(chain, x, vx, vy):
    """Let every node's velocity be that of the tow, and forget the turns: the water streams past the ends."""
    for i in range(chain.n + 1):
        k = i * STATE
        x[k + U], x[k + U + 1] = vx, vy
        x[k + TURN] = x[k + TURN_BEFORE] = 0.0


@kernel
def settling_time(chain, vx, vy):
    """Time [s] in which the tow goes the chain's length, or the chain at rest sinks by it; 0 where it does neither."""
    length, speed = chain.n * chain.l0, sqrt(vx * vx + vy * vy)
    if speed == 0.0:
        weight = abs(chain.weight) / chain.l0
        if chain.c_S > 0.0:
            speed = weight / chain.c_S
        elif chain.k_S > 0.0:
            speed = sqrt(weight / chain.k_S)
    return length / speed if speed > 0.0 else 0.0


@kernel
def settle(chain, x, w, ends, vx, vy):
    """March without inertia in water that streams past at the tow's velocity until nothing turns; whether it does."""
    chain = massless(chain)
    span = settling_time(chain, vx, vy)
    h, before = FIRST * span, 1.0
    for _ in range(MOST):
        drift(chain, x, vx, vy)
        # Backward Euler of the shape, with the tow's velocity on top.
        scheme = Scheme(1.0 / h, 1.0, 0.0, 0.0)
        fit, account = balance(chain, scheme, x, w, ends, 0.0)
        if not account.converged:
            h *= 0.25
            continue
        keep(fit, scheme, x, w, h)
        largest = 0.0
        for i in range(chain.n):
            largest = max(largest, abs(w[i * SCRATCH + DELTA]))
        if largest < STILL or (largest < ROUNDED and largest > 0.5 * before):
            return True
        before = largest
        h = min(GROWTH * h, LONGEST * span)
    return False


@kernel
def refine(chain, scheme, x, w, ends, correction):
    """Go on correcting a solved chain until its angles' corrections are this small [rad], and place it."""
    for _ in range(chain.iterations):
        largest, _, _ = correct(chain, scheme, x, w, ends)
        if largest <= correction:
            break
    place(chain, scheme, x, w)


@kernel
def find_rates(chain, x, w, ends, v_a, v_b, h):
    """Let the chain go with its ends, as drag alone allows (without drag as inertia does); how that went."""
    # In the frame of end a, end b goes a tiny way.
    goal = Ends(
        ends.ax, ends.ay, ends.bx + TINY * (v_b[0] - v_a[0]), ends.by + TINY * (v_b[1] - v_a[1]),
        ends.pull_ax, ends.pull_ay, ends.pull_bx, ends.pull_by,
    )  # fmt: skip
    dragged = chain.c_S > 0.0 or chain.k_S > 0.0
    scheme = Scheme(1.0 / TINY, 1.0, 1.0 / TINY, 0.0)
    fit, account = solve(massless(chain) if dragged else chain, scheme, x, w, goal, 0.0)
    refine(fit, scheme, x, w, goal, SLIGHT)
    set_going(fit, x, w, h)
    return account


@kernel
def find_accelerations(chain, x, w, ends, v_a, v_b, a_a, a_b, h):
    """Balance the chain with its inertia at these rates by a short step of backward Euler; how that went."""
    s, n = SHORT, chain.n
    goal = Ends(
        ends.ax + s * (v_a[0] + s * a_a[0]), ends.ay + s * (v_a[1] + s * a_a[1]),
        ends.bx + s * (v_b[0] + s * a_b[0]), ends.by + s * (v_b[1] + s * a_b[1]),
        ends.pull_ax, ends.pull_ay, ends.pull_bx, ends.pull_by,
    )  # fmt: skip
    for i in range(n):
        x[i * STATE + TURN_BEFORE] = x[i * STATE + TURN]
        x[i * STATE + TURN] *= s / h
    scheme = Scheme(1.0 / s, 0.0, 1.0 / s, 0.0)
    fit, account = solve(chain, scheme, x, w, goal, s)
    refine(fit, scheme, x, w, goal, SLIGHTER)
    for i in range(n + 1):
        a, k = i * SCRATCH, i * STATE
        for j in range(2):
            x[k + Q + j] = (w[a + VN + j] - x[k + V + j]) / s
            x[k + U + j] -= 0.5 * h * x[k + Q + j]
            x[k + H + j] = w[a + HN + j]
        x[k + TURN] = x[k + TURN_BEFORE]
    return account


@kernel
def begin(chain, p, x, w, ends, v_a, v_b, a_a, a_b, h):
    """Write the state at t0, solved for rates and forces: the chain as it lies, how that went, whether it is steady.

    v_a, v_b: velocities of the ends [m/s], that of the driven one where only one is; a_a, a_b: their accelerations
    [m/s^2]; h: period [s].
    """
    vx, vy = 0.5 * (v_a[0] + v_b[0]), 0.5 * (v_a[1] + v_b[1])
    fit, _ = fitted(chain, ends)
    # A steady shape trails behind the tow.
    across = (ends.bx - ends.ax) * vy - (ends.by - ends.ay) * vx
    side = p[SIDE]
    if p[START] == STEADY and across != 0.0:
        side = -1.0 if across > 0.0 else 1.0
    x[:] = 0.0
    lay(fit, p, x, ends, side)
    set_moving(fit, x, ends, v_a)
    if p[START] == GIVEN and chain.end_a == chain.end_b == DRIVEN:
        # Draw a given shape to the end that it misses.
        scheme = Scheme(1.0, 1.0, 0.0, 0.0)
        balance(fit, scheme, x, w, ends, 0.0)
        keep(fit, scheme, x, w, 1.0)
        set_moving(fit, x, ends, v_a)
    settled = True
    if p[START] == STEADY and settling_time(chain, vx, vy) > 0.0:
        settled = settle(chain, x, w, ends, vx, vy)
        set_moving(fit, x, ends, v_a)
    account = find_rates(chain, x, w, ends, v_a, v_b, h)
    if chain.mass > 0.0:
        account = find_accelerations(chain, x, w, ends, v_a, v_b, a_a, a_b, h)
    # And all is put back where it was.
    for i in range(chain.n):
        w[i * SCRATCH + DELTA] = 0.0
    w[RN], w[RN + 1] = x[R], x[R + 1]
    place(fit, Scheme(0.0, 0.0, 0.0, 0.0), x, w)
    return fit, account, settled
