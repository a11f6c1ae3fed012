"""One step of the line between its ends' motions at two instants, with sub-steps and retries; and its trial step."""

from components.compiled import kernel
from components.tether.cable import flow, linear, seabed
from components.tether.cable.balance import assemble
from components.tether.cable.dynamics import finish, newton, predict, scheme
from components.tether.cable.ends import place
from components.tether.cable.line import (
    ACC,
    BONDED,
    SCRATCH,
    STATE,
    TC,
    A,
    R,
    T,
    V,
    first_unknown,
    last_unknown,
    load,
)
from components.tether.cable.statics import equilibrium

# A step whose iteration fails is repeated with the sub-steps doubled, so often at most.
DOUBLINGS = 6
# Reciprocal of a time so short that a node's acceleration owes nothing to its neighbours' reaction [1/s^2].
INSTANT = 1e30


@kernel
def bonded(line):
    """Whether an end exchanges a force law with a body."""
    return line.end_a == BONDED or line.end_b == BONDED


@kernel
def slack(line, w):
    """Whether a segment of a line that takes no compression hangs loose."""
    if line.tension_only:
        for i in range(line.n):
            if w[i * SCRATCH + T] <= 0.0:
                return True
    return False


@kernel
def attempt(line, x, u, w, h, parts, rho_inf):
    """Advance from the state x over h [s] in equal parts: Newton iterations, worst imbalance [N], convergence.

    The nodes are left in w. Ends at once where a balance fails, for the caller to try again. A part that begins with
    a slack segment uses rho_inf = 0: at a larger one the impact that ends the slack rings on and slackens it again.
    """
    load(line.n, x, w)
    if line.anchors:
        seabed.recall(line, x, w)
    iterations, worst = 0, 0.0
    for part in range(1, parts + 1):
        s = scheme(0.0 if slack(line, w) else rho_inf, h / parts)
        predict(s, w, 0, line.n)
        place(line, x, u, w, h, part, parts)
        if line.water:
            flow.sample(line, w, line.t - h * (parts - part) / parts, True)
        count, residual, converged = newton(line, s, w)
        finish(line, s, w)
        iterations += count
        worst = max(worst, residual)
        if not converged:
            return iterations, residual, False
    return iterations, worst, True


@kernel
def calm(line, x, w, h):
    """Leave to the free nodes the mean acceleration of the step of h [s] from x to w.

    After a snap the acceleration that short steps resolve would, held over a long one, throw the nodes away.
    """
    for i in range(first_unknown(line), last_unknown(line) + 1):
        for c in range(3):
            mean = (w[i * SCRATCH + V + c] - x[i * STATE + V + c]) / h
            w[i * SCRATCH + ACC + c] = mean
            w[i * SCRATCH + A + c] = mean


@kernel
def march(line, x, u, w, h):
    """Advance the line over the step of h [s] from the state x to the end motions in u; the new nodes are in w.

    Returns Newton iterations, largest imbalance of any sub-step [N], and whether all were within tolerance. A step
    that fails is repeated in more parts with rho_inf = 0, which an impact does not excite; if all fail the whole
    step's iterate stands. So does a bonded line's at once: its ends follow the body's scheme over the whole step.
    """
    if line.water:
        flow.hear(line, u, w)
    iterations, residual, converged = attempt(line, x, u, w, h, line.sub_steps, line.rho_inf)
    if converged:
        return iterations, residual, True
    doublings = 0 if bonded(line) else DOUBLINGS
    for doubling in range(1, doublings + 1):
        more, residual, converged = attempt(line, x, u, w, h, line.sub_steps << doubling, 0.0)
        iterations += more
        if converged:
            break
    if not (converged or bonded(line)):
        more, residual, converged = attempt(line, x, u, w, h, 1, 0.0)
        iterations += more
    calm(line, x, w, h)
    return iterations, residual, converged


@kernel
def try_on(line, w, h):
    """From the accepted nodes in w, step h [s] further with the ends' accelerations held; w becomes the trial.

    Returns whether the trial is within tolerance.
    """
    s = scheme(line.rho_inf, h)
    predict(s, w, 0, line.n)
    if line.water:
        flow.sample(line, w, line.t + h, True)
    return newton(line, s, w)[2]


@kernel
def set_moving(line, w):
    """Give the free nodes the ends' velocities, interpolated, and the acceleration their own balance asks for.

    A free end moves with the held one.
    """
    first, last = first_unknown(line), last_unknown(line)
    a = 0 if first == 1 else line.n * SCRATCH
    b = line.n * SCRATCH if last == line.n - 1 else 0
    moving = 0.0
    for c in range(3):
        va, vb = w[a + V + c], w[b + V + c]
        moving += abs(va) + abs(vb)
        for i in range(first, last + 1):
            w[i * SCRATCH + V + c] = va + (vb - va) * i / line.n
    if moving > 0.0 and first <= last:
        assemble(line, w, INSTANT, 0.0)
        linear.solve(line, w, first, last)
        for i in range(first, last + 1):
            for c in range(3):
                w[i * SCRATCH + ACC + c] = INSTANT * w[i * SCRATCH + R + c]


@kernel
def start(line, x, u, w, h):
    """Hang the line in equilibrium between the ends of u and set it moving with them; the nodes are in w.

    The algorithmic acceleration starts as the true one. Returns the imbalance at rest [N] and whether it is rounding.
    """
    if line.water:
        flow.hear(line, u, w)
    place(line, x, u, w, h, 1, 1)
    residual, settled = equilibrium(line, w)
    place(line, x, u, w, h, 1, 1)
    if line.water:
        flow.sample(line, w, line.t, True)
    set_moving(line, w)
    s = scheme(line.rho_inf, h)
    assemble(line, w, s.c_m, s.c_c)
    for i in range(line.n + 1):
        b = i * SCRATCH
        for c in range(3):
            w[b + A + c] = w[b + ACC + c]
        w[b + T] = w[b + TC] if i < line.n else 0.0
    return residual, settled
