"""The line under its true loads, from any start: the loads of a convex problem are exchanged for them by shares."""

from components.compiled import kernel
from components.tether.quasistatic.line import RECORD, SAVED, N, R, with_slack
from components.tether.quasistatic.loads import write_first_loads
from components.tether.quasistatic.newton import newton
from components.tether.quasistatic.start import lay_out

# Residual, of the forces' scale and of the length, that counts as solved on the way, and in the end.
ON_THE_WAY, SOLVED = 1e-4, 1e-13
# Least share of the loads that may be exchanged in one go.
LEAST_SHARE = 1e-3
# A fold is rounded over this share of the forces, and narrowed by this factor a step.
WIDEST, NARROWING = 0.03, 0.2


@kernel
def save(line, w):
    """Keep places and forces."""
    for i in range(line.n + 1):
        b = i * RECORD
        for k in range(3):
            w[b + SAVED + k], w[b + SAVED + 3 + k] = w[b + R + k], w[b + N + k]


@kernel
def restore(line, w):
    """Go back to the places and forces kept."""
    for i in range(line.n + 1):
        b = i * RECORD
        for k in range(3):
            w[b + R + k], w[b + N + k] = w[b + SAVED + k], w[b + SAVED + 3 + k]


@kernel
def by_shares(line, p, u, w, dx, dy, dz):
    """(iterations, residual, success): exchange the first loads for the true ones, in one go where that succeeds."""
    write_first_loads(line, p, u, w, dx, dy, dz)
    lay_out(line, w, dx, dy, dz)
    for k in range(3):
        w[line.n * RECORD + N + k] = 0.0
    save(line, w)
    total, share, step, residual = 0, 0.0, 1.0, 1.0
    while share < 1.0:
        goal = min(1.0, share + step)
        iterations, residual, solved = newton(line, p, u, w, goal, SOLVED if goal == 1.0 else ON_THE_WAY)
        total += iterations
        if solved:
            save(line, w)
            share = goal
            step *= 2.0
        else:
            restore(line, w)
            step = 0.5 * min(step, 1.0 - share)
            if step < LEAST_SHARE:
                return total, residual, False
    return total, residual, True


@kernel
def from_afar(line, p, u, w, dx, dy, dz):
    """(iterations, residual, success): solve with end b at d, or free, whatever is in w.

    Where a fold (a segment nearly without force) spoils that, the fold is rounded at first and narrowed in steps.
    """
    total, residual, solved = by_shares(line, p, u, w, dx, dy, dz)
    if solved:
        return total, residual, True
    rounding = WIDEST * line.scale
    iterations, residual, solved = by_shares(with_slack(line, rounding), p, u, w, dx, dy, dz)
    total += iterations
    while solved and rounding > line.slack:
        rounding = max(NARROWING * rounding, line.slack)
        iterations, residual, solved = newton(with_slack(line, rounding), p, u, w, 1.0, SOLVED)
        total += iterations
    return total, residual, solved
