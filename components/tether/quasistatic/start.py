"""The line under loads that do not depend on its shape: a convex problem in one force vector, solved from anywhere."""

from math import sqrt

from components.compiled import kernel
from components.tether.quasistatic.line import F0, RECORD, N, P, R
from components.tether.quasistatic.loads import size_of
from components.tether.quasistatic.small import solve

# The kink of |N| is rounded over this share of the forces at first, and over the line's own `slack` in the end.
FIRST_ROUNDING, NARROWING = 0.1, 0.1
# Misses of end b, in lengths, at which the rounding is narrowed, and at which the search ends; Newton does the rest.
COARSE_GAP, GAP = 1e-3, 1e-6
ITERATIONS = 300
# Sufficient decrease and least fraction of a step in the search along it.
DECREASE, SHORTEST = 1e-4, 1e-12


@kernel
def complementary_energy(line, w, x, y, z, slack, dx, dy, dz):
    """Complementary energy [J] of the line for the first segment's force; gradient and Hessian by rows in w[P...].

    sum of l0 sqrt(N_j^2 + slack^2) + l0 N_j^2 / 2 EA, less N_0 . d: strictly convex, its gradient is end b's place
    less d, the dual of the potential energy.
    """
    for k in range(12):
        w[P + k] = 0.0
    energy = -(x * dx + y * dy + z * dz)
    for j in range(line.n):
        if j > 0:
            b = j * RECORD + F0
            x, y, z = x - w[b], y - w[b + 1], z - w[b + 2]
        square = x * x + y * y + z * z
        size = sqrt(square + slack * slack)
        energy += line.l0 * (size + 0.5 * line.flexibility * square)
        f = (x, y, z)
        for i in range(3):
            w[P + 4 * i + 3] += line.l0 * f[i] * (1.0 / size + line.flexibility)
            for k in range(3):
                w[P + 4 * i + k] -= line.l0 * (f[i] / size) * (f[k] / size) / size
            w[P + 5 * i] += line.l0 * (1.0 / size + line.flexibility)
    w[P + 3], w[P + 7], w[P + 11] = w[P + 3] - dx, w[P + 7] - dy, w[P + 11] - dz
    return energy


@kernel
def first_force(line, w, dx, dy, dz):
    """Force of the first segment when end b is held at d from end a: Newton with a halving search."""
    x, y, z = 0.0, 0.0, 0.0
    for i in range(1, line.n):
        b = i * RECORD + F0
        x, y, z = x + 0.5 * w[b], y + 0.5 * w[b + 1], z + 0.5 * w[b + 2]
    slack = FIRST_ROUNDING * line.scale
    stalled = False
    for _ in range(ITERATIONS):
        energy = complementary_energy(line, w, x, y, z, slack, dx, dy, dz)
        gx, gy, gz = w[P + 3], w[P + 7], w[P + 11]
        narrowest = slack <= line.slack
        gap = (GAP if narrowest else COARSE_GAP) * line.length
        if stalled or sqrt(gx * gx + gy * gy + gz * gz) <= gap:
            if narrowest:
                break
            stalled = False
            slack = max(NARROWING * slack, line.slack)
            continue
        solve(w, P, 4)
        sx, sy, sz = w[P + 3], w[P + 7], w[P + 11]
        step, slope = 1.0, sx * gx + sy * gy + sz * gz
        while step > SHORTEST:
            trial = complementary_energy(line, w, x - step * sx, y - step * sy, z - step * sz, slack, dx, dy, dz)
            if trial <= energy - DECREASE * step * slope:
                break
            step *= 0.5
        stalled = step <= SHORTEST  # the energy is flat to rounding
        x, y, z = x - step * sx, y - step * sy, z - step * sz
    return x, y, z


@kernel
def lay_out(line, w, dx, dy, dz):
    """Forces and places of the line under its loads F0, end b held at d or free."""
    x, y, z = 0.0, 0.0, 0.0
    if line.free:
        for i in range(1, line.n + 1):
            b = i * RECORD + F0
            x, y, z = x + w[b], y + w[b + 1], z + w[b + 2]
    else:
        x, y, z = first_force(line, w, dx, dy, dz)
    for c in range(3):
        w[R + c] = 0.0
    for j in range(line.n):
        b = j * RECORD
        if j > 0:
            x, y, z = x - w[b + F0], y - w[b + F0 + 1], z - w[b + F0 + 2]
        w[b + N], w[b + N + 1], w[b + N + 2] = x, y, z
        g = line.l0 * (1.0 / size_of(line, w, j) + line.flexibility)
        o = b + RECORD + R
        w[o], w[o + 1], w[o + 2] = w[b + R] + g * x, w[b + R + 1] + g * y, w[b + R + 2] + g * z
    if not line.free:
        o = line.n * RECORD + R
        w[o], w[o + 1], w[o + 2] = dx, dy, dz
