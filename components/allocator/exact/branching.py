"""Allocation over sets that are not convex, as forbidden zones leave them: branch and bound over convex pieces.

Each thruster may take any one of its pieces. A node of the tree has a piece chosen for some, and a convex cover
of all pieces for the others; its optimum bounds all below it. Where every force happens to lie in a piece of its
thruster, at that piece's power, it is the optimum below the node; else the thruster whose force is farthest from its
pieces is given each of them in turn, the nearest first (Land and Doig 1960, Econometrica 28).
"""

from math import hypot, inf, sqrt

from components.allocator.exact.boards import pin
from components.allocator.exact.convex import allocate
from components.allocator.exact.response import (
    DISC,
    E1X,
    E1Y,
    E2X,
    E2Y,
    KIND,
    LINE,
    MOST,
    MOST_REVERSE,
    SET,
    A,
    is_between,
    total_power,
)
from components.compiled import kernel

OPEN = -1.0  # in place of a piece: none is chosen yet
ROUNDING = 1e-12
SAME_MISS = 1e-7  # misses nearer than this are the same
GAIN = 1e-9  # of power, below which another choice is not looked for


@kernel
def outside(pieces, j, fx, fy):
    """How far the force f is from piece j, counted with what it would cost more there; 0 where it lies in it."""
    T = sqrt(fx * fx + fy * fy)
    if pieces[j, KIND] == DISC:
        return max(T - pieces[j, MOST], 0.0)
    if pieces[j, KIND] == LINE:
        along = fx * pieces[j, E1X] + fy * pieces[j, E1Y]
        along = min(max(along, -pieces[j, MOST_REVERSE]), pieces[j, MOST])
        return hypot(fx - along * pieces[j, E1X], fy - along * pieces[j, E1Y])
    e1x, e1y, e2x, e2y = pieces[j, E1X], pieces[j, E1Y], pieces[j, E2X], pieces[j, E2Y]
    if is_between(fx, fy, e1x, e1y, e2x, e2y):
        return max(T - pieces[j, MOST], 0.0)
    along = max(fx * e1x + fy * e1y, fx * e2x + fy * e2y, 0.0)
    return sqrt(max(T * T - along * along, 0.0))


@kernel
def nearest(cover, pieces, first, i, fx, fy):
    """Distance of thruster i's force from its pieces, more where the cover is cheaper than the piece it lies in."""
    least = inf
    for j in range(int(first[i]), int(first[i + 1])):
        least = min(least, outside(pieces, j, fx, fy) + max(pieces[j, A] / cover[i, A] - 1.0, 0.0))
    return least


@kernel
def choose(sets, cover, pieces, first, choice):
    """Fill the table of sets from the pieces chosen (n,) and the cover of the others."""
    for i in range(choice.shape[0]):
        for c in range(SET):
            sets[i, c] = cover[i, c] if choice[i] == OPEN else pieces[int(choice[i]), c]


@kernel
def undecided(cover, pieces, first, choice, f):
    """The open thruster whose force is farthest from its pieces; -1 where none is outside."""
    worst, at = ROUNDING, -1
    for i in range(choice.shape[0]):
        has_sides = choice[i] == OPEN and first[i + 1] - first[i] > 1.0
        if has_sides and hypot(f[i, 0], f[i, 1]) > ROUNDING:
            far = nearest(cover, pieces, first, i, f[i, 0], f[i, 1])
            if far > worst:
                worst, at = far, i
    return at


@kernel
def is_better(miss, power, best, margin):
    """Whether (miss, power) is below the best found, whose miss or power it must undercut by the part `margin`."""
    if miss < best[0] * (1.0 - margin) - SAME_MISS:
        return True
    return miss <= best[0] + SAME_MISS and power < best[1] * (1.0 - margin)


@kernel
def keep(miss, power, choice, price, f, best, best_choice, best_f):
    """Note the best found: best (5) holds its miss, power and prices."""
    best[0], best[1] = miss, power
    for c in range(3):
        best[2 + c] = price[c]
    for i in range(choice.shape[0]):
        best_choice[i] = choice[i]
        best_f[i, 0], best_f[i, 1] = f[i, 0], f[i, 1]


@kernel
def push(stack, top, choice, price, miss, thruster, piece):
    """Put a node on the stack: prices (3), bound of the miss, choices (n)."""
    for c in range(3):
        stack[top, c] = price[c]
    stack[top, 3] = miss
    for i in range(choice.shape[0]):
        stack[top, 4 + i] = choice[i]
    if thruster >= 0:
        stack[top, 4 + thruster] = piece


@kernel
def branch(stack, top, pieces, first, i, choice, price, miss, f):
    """Push a child for each piece of thruster i, the nearest last, so that it is taken first; the new top."""
    a, b = int(first[i]), int(first[i + 1])
    least, near = inf, a
    for j in range(a, b):
        far = outside(pieces, j, f[i, 0], f[i, 1])
        if far < least:
            least, near = far, j
    for j in range(a, b):
        if j != near:
            push(stack, top, choice, price, miss, i, float(j))
            top += 1
    push(stack, top, choice, price, miss, i, float(near))
    return top + 1


@kernel
def begin(stack, price, last, choice):
    """Put the root on the stack, and above it the last choice if there is one; (top, whether there is)."""
    has_last = False
    for i in range(choice.shape[0]):
        choice[i] = OPEN
        has_last = has_last or last[i] != OPEN
    push(stack, 0, choice, price, 0.0, -1, OPEN)
    if has_last:
        push(stack, 1, last, price, 0.0, -1, OPEN)
        return 2, True
    return 1, False


@kernel
def search(
    cover, pieces, first, tau, misses, price, last, margin, most, boards, sets, trial, f, choice, stack, best, best_f
):
    """The best allocation over all choices of pieces; (nodes visited, whether none was left).

    last: (n,) the choice to keep unless another misses less or needs less power by the part `margin`, OPEN for none;
    then the choice found. price (3): a start, and the result. most: nodes that may be visited, after the first choice
    is found, which takes n + 2 at most. boards: rows of boards.py, none where their power does not matter.
    sets (n, SET), trial (9), f (n, 2), choice (n), stack (*, 4 + n): scratch.
    best: (5) miss, power, prices; best_f: (n, 2) forces.
    """
    visited = 0
    best[0], best[1] = inf, inf
    top, has_last = begin(stack, price, last, choice)
    while top > 0 and (visited < most or best[0] == inf):
        top -= 1
        if stack[top, 3] > best[0] + SAME_MISS:
            continue
        visited += 1
        for c in range(3):
            price[c] = stack[top, c]
        for i in range(choice.shape[0]):
            choice[i] = stack[top, 4 + i]
        choose(sets, cover, pieces, first, choice)
        pin(sets, boards)
        miss = allocate(sets, tau, misses, price, trial, f, boards, stack[top, 3] == 0.0)
        power = total_power(sets, f)
        if not is_better(miss, power, best, margin if has_last else GAIN):
            continue
        i = undecided(cover, pieces, first, choice, f)
        if i < 0:
            keep(miss, power, choice, price, f, best, last, best_f)
        else:
            top = branch(stack, top, pieces, first, i, choice, price, miss, f)
    for c in range(3):
        price[c] = best[2 + c]
    return visited, top == 0
