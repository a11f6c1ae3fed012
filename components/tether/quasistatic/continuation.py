"""The line under its true loads, from any start: the loads of a convex problem are exchanged for them by shares.

Drag that turns with depth allows several equilibria. Found is one to which the exchange leads from the only equilibrium
under the first loads: by growing shares where that succeeds, else around turning points (arc.py). Not told is whether
it is stable, nor how many others there are.
"""

from math import sqrt

from components.compiled import kernel
from components.tether.quasistatic.arc import along_arc
from components.tether.quasistatic.line import RECORD, N, with_slack
from components.tether.quasistatic.loads import write_first_loads
from components.tether.quasistatic.newton import newton, restore, save
from components.tether.quasistatic.start import lay_out

# Residual, of the forces' scale and of the length, that counts as solved on the way, and in the end.
ON_THE_WAY, SOLVED = 1e-4, 1e-13
# Least share of the loads that may be exchanged in one go.
LEAST_SHARE = 1e-3
# A fold is rounded over this share of the forces, and narrowed by this factor a step.
WIDEST, NARROWING, LEAST_NARROWING = 0.03, 0.2, 0.95
# The continuation's longest step and the rounding that it begins with, times WIDEST: where it fails others are tried.
LONGEST, BEGINNING = (0.5, 0.1, 0.02), (1.0, 0.1, 10.0)


@kernel
def start(line, p, u, w, dx, dy, dz):
    """The line under its first loads."""
    write_first_loads(line, p, u, w, dx, dy, dz)
    lay_out(line, w, dx, dy, dz)
    for k in range(3):
        w[line.n * RECORD + N + k] = 0.0
    save(line, w)


@kernel
def by_shares(line, p, u, w, dx, dy, dz):
    """(iterations, residual, success): exchange the first loads for the true ones, in one go where that succeeds."""
    start(line, p, u, w, dx, dy, dz)
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
def narrowed(line, p, u, w, rounding):
    """(iterations, residual, success): narrow the rounding of folds from what is solved in w down to the line's own."""
    total, factor, residual = 0, NARROWING, 1.0
    save(line, w)
    while rounding > line.slack:
        goal = max(factor * rounding, line.slack)
        iterations, residual, solved = newton(with_slack(line, goal), p, u, w, 1.0, SOLVED)
        total += iterations
        if solved:
            save(line, w)
            rounding = goal
        else:
            restore(line, w)
            factor = sqrt(factor)
            if factor > LEAST_NARROWING:
                return total, residual, False
    return total, residual, True


@kernel
def from_afar(line, p, u, w, arc, dx, dy, dz):
    """(iterations, residual, success): solve with end b at d, or free, whatever is in w.

    Where a fold (a segment nearly without force) spoils that, the fold is rounded at first and narrowed in steps; where
    the branch turns back it is followed around.
    """
    total, residual, solved = by_shares(line, p, u, w, dx, dy, dz)
    if solved:
        return total, residual, True
    rounding = WIDEST * line.scale
    rounded = with_slack(line, rounding)
    iterations, residual, solved = by_shares(rounded, p, u, w, dx, dy, dz)
    total += iterations
    if solved:
        iterations, residual, solved = narrowed(line, p, u, w, rounding)
        total += iterations
    for attempt in range(2 * len(LONGEST)):
        if not solved:
            longest, by_sign = LONGEST[attempt // 2], attempt % 2 == 0
            rounded = with_slack(line, BEGINNING[attempt // 2] * rounding)
            start(rounded, p, u, w, dx, dy, dz)
            iterations, residual, solved = along_arc(rounded, p, u, w, arc, line.slack, longest, by_sign, SOLVED)
            total += iterations
    return total, residual, solved
