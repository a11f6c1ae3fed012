"""Binds the allocator of least power to the contract: demand in newtons in, commands and what they achieve out."""

from math import atan2, inf, isfinite, sqrt

from components.allocator.exact import model
from components.allocator.exact.boards import COLUMNS, SPARE, are_exceeded
from components.allocator.exact.branching import OPEN, choose, search
from components.allocator.exact.commands import write_boards, write_commands, write_still
from components.allocator.exact.convex import allocate_with_boards
from components.allocator.exact.dual import largest
from components.allocator.exact.losses import LOSING, lose
from components.allocator.exact.model import (
    BOARDS,
    COUNT,
    DEMAND,
    FLAGS,
    FORCE,
    LEVER,
    LIMITED,
    LOSES,
    MARGIN,
    MEETS_WATER,
    MISSES,
    NODES,
    PIECES,
    POWER,
    START,
    TABLES,
    WAKE_TIME,
)
from components.allocator.exact.reach import NO_THRUST, NONE, astern, midships, note_factors, reach, settle
from components.allocator.exact.response import E1X, E1Y, KIND, LINE, SET
from components.compiled import kernel
from components.contract import HEADER, Component
from components.matrices import table

MUCH = 1e12  # a demand, in units of all thrusters


@kernel
def lay_out(p):
    """Views of p: numbers, rates (n, 2), first (n + 1,), covers (n, SET), pieces (m, SET), losing (n or 0, LOSING)."""
    q = p[HEADER:]
    n, m = int(q[COUNT]), int(q[PIECES])
    first = TABLES + 2 * n
    covers = first + n + 1
    pieces = covers + n * SET
    losing = pieces + m * SET
    return (
        q,
        table(q, TABLES, n, 2),
        q[first:covers],
        table(q, covers, n, SET),
        table(q, pieces, m, SET),
        table(q, losing, n if q[LOSES] > 0.0 else 0, LOSING),
    )


@kernel
def lay_out_losses(q, w):
    """Views of w's end: water (3,), covers (n, SET) and pieces (m, SET) less the losses."""
    n, m = int(q[COUNT]), int(q[PIECES])
    at = w.shape[0] - 3 - (n + m) * SET
    return w[at : at + 3], table(w, at + 3, n, SET), table(w, at + 3 + n * SET, m, SET)


@kernel
def targets(n, x, w, best_f):
    """Where each thruster would be without limits of rate: w[0:n] azimuth, as it is if at rest; w[n:2n] thrust."""
    for i in range(n):
        fx, fy = best_f[i, 0], best_f[i, 1]
        w[n + i] = sqrt(fx * fx + fy * fy)
        w[i] = atan2(fy, fx) if w[n + i] > 0.0 else x[2 * n + i]


@kernel
def scale(q, u, tau):
    """The demand in units of all thrusters; one so great that only its direction matters is cut to MUCH."""
    tau[0], tau[1], tau[2] = u[0] / q[FORCE], u[1] / q[FORCE], u[2] / (q[FORCE] * q[LEVER])
    size = largest(tau[0], tau[1], tau[2])
    if size > MUCH:
        for c in range(3):
            tau[c] *= MUCH / size


@kernel
def begin(q, tau, price):
    """Prices to begin with."""
    for c in range(3):
        price[c] = q[START + 3 * c] * tau[0] + q[START + 3 * c + 1] * tau[1] + q[START + 3 * c + 2] * tau[2]


@kernel
def take(pieces, first, x, i, f, target, wanted, turn):
    """The state of thruster i from its force in f (n, 2); what has a piece for it goes backwards by negative thrust."""
    n, fx, fy, j, back = f.shape[0], f[i, 0], f[i, 1], int(first[i]), astern(pieces, first, i)
    x[2 * i], x[2 * i + 1] = fx, fy
    line = j if pieces[j, KIND] == LINE else back
    along = fx * pieces[line, E1X] + fy * pieces[line, E1Y] if line != NONE else 0.0
    T = sqrt(fx * fx + fy * fy)
    if line == j:
        x[3 * n + i] = along
        x[2 * n + i] = atan2(pieces[j, E1Y], pieces[j, E1X])
    elif back != NONE and (along < 0.0 or T <= NO_THRUST):
        x[3 * n + i] = along
        x[2 * n + i] = midships(pieces, back, j, x[2 * n + i], along)
    else:
        x[3 * n + i] = T
        x[2 * n + i] = settle(x[2 * n + i], fx, fy, target, wanted, turn)


@kernel
def follow(p, pieces, x, w, sets, tau, price, trial, f, best_f, boards, h, is_limited):
    """Take the commands of the optimum, or of that within reach of the last ones; the weighted miss."""
    q, rates, first, _, whole, _ = lay_out(p)
    n = f.shape[0]
    targets(n, x, w, best_f)
    miss = 0.0
    if is_limited:
        for i in range(n):
            turn, change = rates[i, 0] * h, rates[i, 1] * h
            thrust = x[3 * n + i] / x[x.shape[0] - n + i]
            reach(sets, i, pieces, whole, first, x[2 * n + i], thrust, w[i], turn, change)
        begin(q, tau, price)
        miss = allocate_with_boards(sets, tau, q[MISSES : MISSES + 3], price, trial, f, boards)
    for i in range(n):
        take(pieces, first, x, i, f if is_limited else best_f, w[i], w[n + i], rates[i, 0] * h if is_limited else inf)
    if q[LIMITED] > 0.0:
        note_factors(pieces, whole, first, x, x[x.shape[0] - n :])
    return miss


@kernel
def decide(p, covers, pieces, u, x, y, w, h, is_limited):
    """Allocate the demand u; (nodes visited, whether none was left, weighted miss).

    The search is made without the boards first: an optimum of it that keeps their limits is the optimum.
    """
    q, _, first, _, _, _ = lay_out(p)
    n, count = covers.shape[0], int(q[BOARDS])
    at = 2 * n
    sets = table(w, at, n, SET)
    at += n * SET
    trial, price, tau, best = w[at : at + 9], w[at + 9 : at + 12], w[at + 12 : at + 15], w[at + 15 : at + 20]
    at += 20
    f, best_f = table(w, at, n, 2), table(w, at + 2 * n, n, 2)
    at += 4 * n
    choice, kept = w[at : at + n], w[at + n : at + 2 * n]
    at += 2 * n
    boards = table(w, at, count, COLUMNS)
    at += count * COLUMNS
    end = w.shape[0] - (3 + (n + pieces.shape[0]) * SET if q[LOSES] > 0.0 else 0)
    stack = table(w, at, (end - at) // (4 + n), 4 + n)
    scale(q, u, tau)
    begin(q, tau, price)
    misses, last = q[MISSES : MISSES + 3], x[4 * n : 5 * n]
    for b in range(count):
        boards[b, SPARE] = min(u[DEMAND + b] / q[POWER], 2.0)  # of all thrusters' power: no limit at all
    for i in range(n):
        last[i] = OPEN if q[MARGIN] == 0.0 else last[i]
        kept[i] = last[i]
    margin, most, none = q[MARGIN], q[NODES], boards[:0]
    nodes, is_proven = search(
        covers, pieces, first, tau, misses, price, last, margin, most, none, sets, trial, f, choice, stack, best, best_f
    )
    if count > 0:
        choose(sets, covers, pieces, first, last)
        if are_exceeded(sets, best_f, boards):
            for i in range(n):
                last[i] = kept[i]
            more, is_proven = search(
                covers, pieces, first, tau, misses, price, last, margin, most, boards, sets, trial, f, choice, stack,
                best, best_f,
            )  # fmt: skip
            nodes += more
    miss = follow(p, pieces, x, w, sets, tau, price, trial, f, best_f, boards, h, is_limited)
    write_commands(q, pieces, first, x, y, best_f)
    return nodes, is_proven, miss if is_limited else best[0]


@kernel
def is_sound(q, u):
    """Whether all inputs are numbers, and no spare power is negative; one without end is no limit."""
    boards = int(q[BOARDS])
    for c in range(u.shape[0]):
        if DEMAND <= c < DEMAND + boards:
            if not u[c] >= 0.0:
                return False
        elif not isfinite(u[c]):
            return False
    return True


@kernel
def allocate_demand(p, u, x, y, w, h, is_limited, is_losing):
    """One step; inputs that are no numbers leave the commands as they are."""
    q, _, first, covers, pieces, losing = lay_out(p)
    n = covers.shape[0]
    flags = y.shape[0] - FLAGS
    if is_sound(q, u):
        if is_losing:
            water, own_covers, own_pieces = lay_out_losses(q, w)
            wakes = x[x.shape[0] - 2 * n : x.shape[0] - n]
            at = DEMAND + int(q[BOARDS])
            for c in range(3):
                water[c] = u[at + c] * (q[LEVER] if c == 2 else 1.0) if q[MEETS_WATER] > 0.0 else 0.0
            part = h / q[WAKE_TIME] if h > 0.0 else inf
            lose(covers, pieces, first, losing, water, x, wakes, own_covers, own_pieces, part)
            nodes, is_proven, miss = decide(p, own_covers, own_pieces, u, x, y, w, h, is_limited)
            write_still(q, pieces, first, losing, water, wakes, x, y)
            write_boards(q, pieces, first, u, y)
        else:
            nodes, is_proven, miss = decide(p, covers, pieces, u, x, y, w, h, is_limited)
            write_boards(q, pieces, first, u, y)
        for c in range(flags):
            x[5 * n + c] = y[c]
        y[flags], y[flags + 1] = 1.0 if miss == 0.0 else 0.0, 0.0
        y[flags + 2], y[flags + 3] = 1.0 if is_proven else 0.0, float(nodes)
        return 0
    for c in range(flags):
        y[c] = x[5 * n + c]
    y[flags], y[flags + 1], y[flags + 2], y[flags + 3] = 0.0, 1.0, 0.0, 0.0
    return 0


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the optimum, which no rate keeps it from, and losses, wakes grown, at the azimuths of that without."""
    n = int(p[HEADER + COUNT])
    for i in range(x.shape[0]):
        x[i] = OPEN if 4 * n <= i < 5 * n else 0.0
    for i in range(x.shape[0] - 2 * n, x.shape[0]):
        x[i] = 1.0
    allocate_demand(p, u, x, y, w, 0.0, False, False)
    if p[HEADER + LOSES] > 0.0:
        for i in range(4 * n, 5 * n):
            x[i] = OPEN
        allocate_demand(p, u, x, y, w, 0.0, False, True)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """Allocate the demand at the step's end."""
    return allocate_demand(p, u, x, y, w, dt_ns * 1e-9, p[HEADER + LIMITED] > 0.0, p[HEADER + LOSES] > 0.0)


COMPONENT = Component(
    name="allocator.exact",
    parameters=model.Exact,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    defaults=model.defaults,
    assumptions="Power is that in bollard pull, max_power (T / max_thrust)^(3/2); thrust factors are constant in each "
    "sector, those of moving water and wakes too, which are taken at the last azimuths and full shaft speed. Limits of "
    "rate make the reachable forces of a step convex by letting thrust fall along its direction; a board's power falls "
    "no faster than they let it.",
)
