"""The start of a line, at rest or moving with its ends; the acceleration that its balance asks for at an instant."""

from components.compiled import kernel
from components.tether.cable import balance, flow, linear
from components.tether.cable.dynamics import scheme
from components.tether.cable.ends import place
from components.tether.cable.line import ACC, SCRATCH, TC, A, R, T, V, first_unknown, last_unknown
from components.tether.cable.statics import equilibrium

# Reciprocal of a time so short that a node's acceleration owes nothing to its neighbours' reaction [1/s^2].
INSTANT = 1e30


@kernel
def accelerate(line, w):
    """Give the free nodes the acceleration that their own balance asks for, true and algorithmic."""
    first, last = first_unknown(line), last_unknown(line)
    if first > last:
        return
    balance.assemble(line, w, INSTANT, 0.0)
    linear.solve(line, w, first, last)
    for i in range(first, last + 1):
        for c in range(3):
            w[i * SCRATCH + ACC + c] += INSTANT * w[i * SCRATCH + R + c]
            w[i * SCRATCH + A + c] = w[i * SCRATCH + ACC + c]


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
    if moving > 0.0:
        accelerate(line, w)


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
    balance.assemble(line, w, s.c_m, s.c_c)
    for i in range(line.n + 1):
        b = i * SCRATCH
        for c in range(3):
            w[b + A + c] = w[b + ACC + c]
        w[b + T] = w[b + TC] if i < line.n else 0.0
    return residual, settled
