"""Pseudo-arclength continuation from the first loads to the true ones: around the turning points of the solution.

The loads are bounded, and the first problem has one solution, so a branch from that one leads to the true problem
(Leray-Schauder), though not by ever growing shares. Keller 1977, Numerical solution of bifurcation and nonlinear
eigenvalue problems: predictor along the tangent, corrector across it. At a kink (where a node passes a depth of the
current's table) the branch may turn back sharply; the determinant's sign tells the way on (Allgower and Georg 1990,
Numerical continuation methods, ch. 2 and 12). That rule alone turns back where two branches cross, as symmetric lines'
do, and the rule of the least angle alone where a step has changed branches: each is tried.
"""

from math import isfinite, sqrt

from components.compiled import kernel
from components.tether.quasistatic.line import with_slack
from components.tether.quasistatic.newton import ROUNDED, restore, save
from components.tether.quasistatic.pivoted import (
    RATE,
    STEP,
    WIDTH,
    move_by,
    solve_rows,
    unknowns,
    write_matrix,
    write_residual,
)

# Least step, and how far a kink is crossed: the root of the sum of the squares of all unknowns'
# changes over the segments, and of the way's.
SHORTEST, CROSSING = 1e-7, 1e-6
STEPS, CORRECTIONS, KINKS, FINISH, BACK = 2000, 8, 3, 30, -0.5
# A correction has to lessen the residual to this; steps grow and shrink by these factors.
CONTRACTION, GROWTH, SHRINKING = 0.5, 1.6, 0.4
# Residual that counts as solved on the way; difference of the way by which its derivative is taken.
CLOSE, NEAR = 1e-9, 1e-5


@kernel
def arc_size(n):
    """Length of the rows and of the tangent for n segments."""
    return 6 * n * (WIDTH + 1)


@kernel
def on_way(line, slack, way):
    """The line, and the share of its loads, at this point of the way.

    From 0 to 1 the true loads replace the first, on a line whose folds are rounded by its own slack; from 1 to 2 that
    narrows to `slack`, by equal factors.
    """
    if way <= 1.0:
        return line, way
    return with_slack(line, line.slack * (slack / line.slack) ** (way - 1.0)), 1.0


@kernel
def solve_at(line, slack, p, u, w, arc, way):
    """(residual, sign of the determinant): Newton's step, and the solution's rate along the way, in the rows."""
    here, share = on_way(line, slack, way)
    there, further = on_way(line, slack, way + NEAR)
    residual = write_residual(here, p, u, w, share, arc, STEP)
    write_residual(there, p, u, w, further, arc, RATE)
    m = unknowns(line)
    for row in range(m):
        o = arc + row * WIDTH
        w[o + RATE] = (w[o + RATE] - w[o + STEP]) / NEAR
    write_matrix(here, p, u, w, share, arc)
    return residual, solve_rows(w, arc, m)


@kernel
def product(line, w, a, b):
    """Inner product over the segments of two vectors (first place, stride)."""
    total = 0.0
    for row in range(unknowns(line)):
        total += w[a[0] + row * a[1]] * w[b[0] + row * b[1]]
    return total / line.n


@kernel
def take(line, w, arc, unit):
    """Make `unit` times the rate the tangent."""
    m = unknowns(line)
    tangent = arc + m * WIDTH
    for row in range(m):
        w[tangent + row] = unit * w[arc + row * WIDTH + RATE]


@kernel
def onwards(line, slack, p, u, w, arc, way, along, first):
    """(component along the way, determinant's sign) of the next tangent at a solution.

    It is within a right angle of the last one; or, if the sign at the start is given (first, not 0), by that sign.
    """
    _, sign = solve_at(line, slack, p, u, w, arc, way)
    rate, tangent = (arc + RATE, WIDTH), (arc + unknowns(line) * WIDTH, 1)
    unit = 1.0 / sqrt(1.0 + product(line, w, rate, rate))
    if first * sign < 0.0 or (first == 0.0 and along + product(line, w, rate, tangent) < 0.0):
        unit = -unit
    take(line, w, arc, unit)
    return unit, sign


@kernel
def across(line, slack, p, u, w, arc, way, along, sign):
    """The same behind a kink just ahead: along a branch the determinant's sign times the component stays."""
    move_by(line, w, arc + unknowns(line) * WIDTH, 1, CROSSING)
    _, other = solve_at(line, slack, p, u, w, arc, way + CROSSING * along)
    rate = arc + RATE, WIDTH
    unit = 1.0 / sqrt(1.0 + product(line, w, rate, rate))
    if other * along * sign < 0.0:
        unit = -unit
    take(line, w, arc, unit)
    restore(line, w)
    return unit, other


@kernel
def correct(line, slack, p, u, w, arc, way, along, step):
    """(iterations, way, success): back to the branch across the tangent, by less than the step made along it."""
    newton, rate, tangent = (arc + STEP, WIDTH), (arc + RATE, WIDTH), (arc + unknowns(line) * WIDTH, 1)
    last = 1e300
    for iteration in range(CORRECTIONS):
        residual, _ = solve_at(line, slack, p, u, w, arc, way)
        if residual <= CLOSE:
            return iteration, way, True
        if not isfinite(residual) or residual > CONTRACTION * last:
            return iteration, way, False
        last = residual
        change = -product(line, w, newton, tangent) / (along + product(line, w, rate, tangent))
        square = product(line, w, newton, newton) + 2.0 * change * product(line, w, newton, rate)
        square += change * change * (1.0 + product(line, w, rate, rate))
        if not square <= step * step:
            return iteration, way, False
        move_by(line, w, newton[0], WIDTH, 1.0)
        move_by(line, w, rate[0], WIDTH, change)
        way += change
    return CORRECTIONS, way, False


@kernel
def finish(line, slack, p, u, w, arc, allowed):
    """(iterations, residual, success): Newton's method at the end of the way."""
    best = 1e300
    for iteration in range(FINISH):
        residual, _ = solve_at(line, slack, p, u, w, arc, 2.0)
        if residual <= allowed or not residual < best:
            return iteration, residual, residual <= ROUNDED
        best = residual
        move_by(line, w, arc + STEP, WIDTH, 1.0)
    return FINISH, residual, residual <= ROUNDED


@kernel
def along_arc(line, p, u, w, arc, slack, longest, by_sign, allowed):
    """(iterations, residual, success) from the line under its first loads, which is in w, to the true ones and `slack`.

    longest: step; by_sign: whether the determinant tells the direction everywhere, not only behind a kink.
    """
    way, step, along, kinks, total = 0.0, 0.1 * longest, 1.0, 0, 0
    tangent = arc + unknowns(line) * WIDTH
    for row in range(unknowns(line)):
        w[tangent + row] = 0.0
    iterations, way, solved = correct(line, slack, p, u, w, arc, way, along, longest)
    save(line, w)
    along, sign = onwards(line, slack, p, u, w, arc, way, along, 0.0)
    first = sign if by_sign else 0.0
    for _ in range(STEPS):
        move_by(line, w, tangent, 1, step)
        iterations, reached, solved = correct(line, slack, p, u, w, arc, way + step * along, along, step)
        total += iterations + 1
        if solved and reached >= 2.0:
            more, residual, solved = finish(line, slack, p, u, w, arc, allowed)
            total += more
            if solved:
                return total, residual, True
        if solved:
            save(line, w)
            way, kinks = reached, 0
            along, sign = onwards(line, slack, p, u, w, arc, way, along, first)
            step = min(longest, GROWTH * step) if iterations < 5 else step
        else:
            restore(line, w)
            step *= SHRINKING
            if step < SHORTEST:
                kinks += 1
                if kinks > KINKS:
                    break
                along, sign = across(line, slack, p, u, w, arc, way, along, sign)
                step = 4.0 * CROSSING
        if way < BACK:
            break
    return total, 2.0 - way, False
