"""The line between the ship's hook and end b, at rest in the current as estimated, and how its tensions change."""

from math import isfinite, sqrt

from components.compiled import kernel
from components.estimator.tether.layout import (
    ENDS,
    FOLLOWED,
    IS_KNOWN,
    LARGEST,
    LINE,
    SHAPE,
    SLOPE,
    SLOPES,
    STORED,
    TENSIONS,
    C,
    R,
    mesh_at,
    results_at,
)
from components.tether.quasistatic.continuation import by_shares
from components.tether.quasistatic.line import (
    A_POSITION,
    B_VELOCITY,
    FLEXIBILITY,
    KEPT,
    LENGTH,
    POINTS,
    PROFILE,
    RECORD,
    SEGMENTS,
    N,
)
from components.tether.quasistatic.line import R as PLACE
from components.tether.quasistatic.mesh import keep, scaled_line
from components.tether.quasistatic.newton import newton

# Residual of the line that counts as solved, far below what the tension's slopes are taken from; the changes for these.
SOLVED, NUDGE, DRIFT = 1e-11, 0.01, 0.001
SHORTEST = 1e-3  # line that is paid out [m], below which it has no shape


@kernel
def put(p, u, state, hook, kept, w):
    """Write for the line's kernels: ends, velocity that it follows, length paid out, estimated current."""
    for i in range(18):
        w[ENDS + i] = 0.0
    w[ENDS + A_POSITION], w[ENDS + A_POSITION + 1], w[ENDS + A_POSITION + 2] = hook
    points = int(p[POINTS])
    for i in range(PROFILE + 4 * points):
        w[LINE + i] = p[i]
    w[LINE + LENGTH] = p[LENGTH] - u[STORED]
    for k in range(3):
        w[ENDS + B_VELOCITY + k] = kept[FOLLOWED + k]
    stream(p, w, state[C], state[C + 1])


@kernel
def stream(p, w, along, across):
    """Write the current with this offset along and across it."""
    points = int(p[POINTS])
    for i in range(points):
        at, way = PROFILE + 4 * i, PROFILE + 4 * points + 2 * i
        north, east = p[way], p[way + 1]
        w[LINE + at + 1] = p[at + 1] + north * along - east * across
        w[LINE + at + 2] = p[at + 2] + east * along + north * across


@kernel
def load(kept, mesh, n):
    """Take the line as it was last, to begin with."""
    for i in range(n + 1):
        b, o = i * RECORD, SHAPE + 6 * i
        for k in range(3):
            mesh[b + PLACE + k], mesh[b + N + k] = kept[o + k], kept[o + 3 + k]


@kernel
def store(kept, mesh, n):
    """Keep the line's places and forces."""
    for i in range(n + 1):
        b, o = i * RECORD, SHAPE + 6 * i
        for k in range(3):
            kept[o + k], kept[o + 3 + k] = mesh[b + PLACE + k], mesh[b + N + k]


@kernel
def reach_to(mesh, n, dx, dy, dz):
    """Put end b at d from end a, and the nodes in between by shares, so that a shape is kept as well as can be."""
    b = n * RECORD + PLACE
    ex, ey, ez = dx - mesh[b], dy - mesh[b + 1], dz - mesh[b + 2]
    for i in range(1, n + 1):
        o, share = i * RECORD + PLACE, i / n
        mesh[o], mesh[o + 1], mesh[o + 2] = mesh[o] + share * ex, mesh[o + 1] + share * ey, mesh[o + 2] + share * ez
    mesh[b], mesh[b + 1], mesh[b + 2] = dx, dy, dz


@kernel
def solve_line(q, p, state, hook, kept, w):
    """(the line, whether it is in balance): between the hook and end b, from its last shape if that leads there."""
    n, points = int(p[SEGMENTS]), int(p[POINTS])
    line, ends, mesh = w[LINE : LINE + PROFILE + 4 * points], w[ENDS : ENDS + 18], w[mesh_at(points) :]
    dx, dy, dz = state[R] - hook[0], state[R + 1] - hook[1], state[R + 2] - hook[2]
    length, distance = line[LENGTH], sqrt(dx * dx + dy * dy + dz * dz)
    sane = length > SHORTEST and distance <= length * (1.0 + q[LARGEST] * p[FLEXIBILITY])
    balance = scaled_line(line, ends, mesh, n, dx, dy, dz)
    solved = False
    if sane and balance.scale > 0.0:
        if kept[IS_KNOWN] > 0.0:
            load(kept, mesh, n)
            reach_to(mesh, n, dx, dy, dz)
            _, _, solved = newton(balance, line, ends, mesh, 1.0, SOLVED)
        if not solved:
            _, _, solved = by_shares(balance, line, ends, mesh, dx, dy, dz)
    return balance, solved


@kernel
def tensions_at_ends(balance, line, ends, mesh, n):
    """Tension at end a and at end b [N]; places and tensions of all nodes behind the records."""
    at = results_at(n)
    keep(balance, line, ends, mesh, 1, at)
    return mesh[at + 3], mesh[at + KEPT * n + 3]


@kernel
def nudged(balance, p, state, kept, column, w):
    """(both ends' tensions, success) with one coordinate of end b, or one of the current's offset, a little changed."""
    n, points = int(p[SEGMENTS]), int(p[POINTS])
    line, ends, mesh = w[LINE : LINE + PROFILE + 4 * points], w[ENDS : ENDS + 18], w[mesh_at(points) :]
    if column < 3:
        mesh[n * RECORD + PLACE + column] += NUDGE
    else:
        stream(p, w, state[C] + (DRIFT if column == 3 else 0.0), state[C + 1] + (DRIFT if column == 4 else 0.0))
    _, _, solved = newton(balance, line, ends, mesh, 1.0, SOLVED)
    a, b = tensions_at_ends(balance, line, ends, mesh, n)
    stream(p, w, state[C], state[C + 1])
    load(kept, mesh, n)
    return a, b, solved


@kernel
def hang(q, p, u, state, hook, sloped, kept, w):
    """Whether the line was found: its shape, both ends' tensions and, if asked for, their slopes are kept then."""
    n, points = int(p[SEGMENTS]), int(p[POINTS])
    line, ends, mesh = w[LINE : LINE + PROFILE + 4 * points], w[ENDS : ENDS + 18], w[mesh_at(points) :]
    put(p, u, state, hook, kept, w)
    balance, solved = solve_line(q, p, state, hook, kept, w)
    if not solved:
        return False
    a, b = tensions_at_ends(balance, line, ends, mesh, n)
    store(kept, mesh, n)
    kept[TENSIONS], kept[TENSIONS + 1] = a, b
    if sloped:
        for column in range(SLOPE):
            other_a, other_b, solved = nudged(balance, p, state, kept, column, w)
            step = NUDGE if column < 3 else DRIFT
            if not (solved and isfinite(other_a) and isfinite(other_b)):
                other_a, other_b = a, b
            kept[SLOPES + column], kept[SLOPES + SLOPE + column] = (other_a - a) / step, (other_b - b) / step
    kept[IS_KNOWN] = 1.0
    return True
