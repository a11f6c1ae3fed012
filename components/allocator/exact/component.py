"""Binds the allocator of least power to the contract: demand in newtons in, commands and what they achieve out."""

from math import atan2, inf, isfinite, sqrt

from components.allocator.exact import model
from components.allocator.exact.branching import OPEN, search
from components.allocator.exact.commands import write_commands
from components.allocator.exact.convex import allocate
from components.allocator.exact.model import COUNT, FORCE, LEVER, LIMITED, MARGIN, MISSES, NODES, PIECES, START, TABLES
from components.allocator.exact.reach import reach, settle
from components.allocator.exact.response import E1X, E1Y, KIND, LINE, SET
from components.compiled import kernel
from components.contract import HEADER, Component
from components.matrices import table


@kernel
def lay_out(p):
    """Views of p: numbers, rates (n, 2), first (n + 1,), covers (n, SET), pieces (m, SET)."""
    q = p[HEADER:]
    n, m = int(q[COUNT]), int(q[PIECES])
    first = TABLES + 2 * n
    covers = first + n + 1
    pieces = covers + n * SET
    return (
        q,
        table(q, TABLES, n, 2),
        q[first:covers],
        table(q, covers, n, SET),
        table(q, pieces, m, SET),
    )


@kernel
def targets(n, x, w, best_f):
    """Where each thruster would be without limits of rate: w[0:n] azimuth, as it is if at rest; w[n:2n] thrust."""
    for i in range(n):
        fx, fy = best_f[i, 0], best_f[i, 1]
        w[n + i] = sqrt(fx * fx + fy * fy)
        w[i] = atan2(fy, fx) if w[n + i] > 0.0 else x[2 * n + i]


@kernel
def follow(p, x, w, sets, tau, price, trial, f, best_f, h, is_limited):
    """Take the commands of the optimum, or of that within reach of the last ones; the weighted miss."""
    q, rates, first, _, pieces = lay_out(p)
    n = f.shape[0]
    targets(n, x, w, best_f)
    miss = 0.0
    if is_limited:
        for i in range(n):
            turn, change = rates[i, 0] * h, rates[i, 1] * h
            reach(sets, i, pieces, first, x[2 * n + i], x[3 * n + i], w[i], turn, change)
        for c in range(3):
            price[c] = q[START + 3 * c] * tau[0] + q[START + 3 * c + 1] * tau[1] + q[START + 3 * c + 2] * tau[2]
        miss = allocate(sets, tau, q[MISSES : MISSES + 3], price, trial, f, True)
    for i in range(n):
        force = f if is_limited else best_f
        fx, fy = force[i, 0], force[i, 1]
        j = int(first[i])
        x[2 * i], x[2 * i + 1] = fx, fy
        if pieces[j, KIND] == LINE and first[i + 1] - first[i] == 1.0:
            x[3 * n + i] = fx * pieces[j, E1X] + fy * pieces[j, E1Y]
            x[2 * n + i] = atan2(pieces[j, E1Y], pieces[j, E1X])
        else:
            turn = rates[i, 0] * h if is_limited else inf
            x[2 * n + i] = settle(x[2 * n + i], fx, fy, w[i], w[n + i], turn)
            x[3 * n + i] = sqrt(fx * fx + fy * fy)
    return miss


@kernel
def decide(p, u, x, y, w, h, is_limited):
    """Allocate the demand u; (nodes visited, whether none was left, weighted miss)."""
    q, _, first, covers, pieces = lay_out(p)
    n = covers.shape[0]
    at = 2 * n
    sets = table(w, at, n, SET)
    at += n * SET
    trial, price, tau, best = w[at : at + 9], w[at + 9 : at + 12], w[at + 12 : at + 15], w[at + 15 : at + 20]
    at += 20
    f, best_f = table(w, at, n, 2), table(w, at + 2 * n, n, 2)
    at += 4 * n
    choice = w[at : at + n]
    at += n
    depth = (w.shape[0] - at) // (4 + n)
    stack = table(w, at, depth, 4 + n)
    tau[0], tau[1], tau[2] = u[0] / q[FORCE], u[1] / q[FORCE], u[2] / (q[FORCE] * q[LEVER])
    for c in range(3):
        price[c] = q[START + 3 * c] * tau[0] + q[START + 3 * c + 1] * tau[1] + q[START + 3 * c + 2] * tau[2]
    misses, last = q[MISSES : MISSES + 3], x[4 * n : 5 * n]
    if q[MARGIN] == 0.0:
        for i in range(n):
            last[i] = OPEN
    nodes, is_proven = search(
        covers,
        pieces,
        first,
        tau,
        misses,
        price,
        last,
        q[MARGIN],
        q[NODES],
        sets,
        trial,
        f,
        choice,
        stack,
        best,
        best_f,
    )
    miss = follow(p, x, w, sets, tau, price, trial, f, best_f, h, is_limited)
    write_commands(q, pieces, first, x, y, best_f)
    return nodes, is_proven, miss if is_limited else best[0]


@kernel
def allocate_demand(p, u, x, y, w, h, is_limited):
    """One step; a demand that is no number leaves the commands as they are."""
    q, _, first, covers, pieces = lay_out(p)
    n = covers.shape[0]
    flags = len(y) - 4
    if isfinite(u[0]) and isfinite(u[1]) and isfinite(u[2]):
        nodes, is_proven, miss = decide(p, u, x, y, w, h, is_limited)
        y[flags], y[flags + 1] = 1.0 if miss == 0.0 else 0.0, 0.0
        y[flags + 2], y[flags + 3] = 1.0 if is_proven else 0.0, float(nodes)
        return 0
    write_commands(q, pieces, first, x, y, table(x, 0, n, 2))
    y[flags], y[flags + 1], y[flags + 2], y[flags + 3] = 0.0, 1.0, 0.0, 0.0
    return 0


def init(t_ns, dt_ns, p, u, x, y, w):
    """Begin with the optimum, which no rate keeps it from."""
    n = int(p[HEADER + COUNT])
    for i in range(4 * n):
        x[i] = 0.0
    for i in range(4 * n, 5 * n):
        x[i] = OPEN
    return allocate_demand(p, u, x, y, w, 0.0, False)


def step(t_ns, dt_ns, p, u, x, y, w):
    """Allocate the demand at the step's end."""
    return allocate_demand(p, u, x, y, w, dt_ns * 1e-9, p[HEADER + LIMITED] > 0.0)


COMPONENT = Component(
    name="allocator.exact",
    parameters=model.Exact,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions="Power is that in bollard pull, max_power (T / max_thrust)^(3/2); thrust factors are constant in each "
    "sector. Limits of rate make the reachable forces of a step convex by letting thrust fall along its direction.",
)
