"""Newton's method for the places of the nodes and the forces of the segments together, O(n) a step.

Segment j: r_{j+1} - r_j = l0 N_j (1/|N_j| + 1/EA). Node i: N_i - N_{i-1} + F_i = 0, F_i the loads. A sweep from end a
carries an affine law of a node's correction in terms of the next segment's, dr_j = R_j dN_j + rho_j: the flexibility
of all that lies behind (invariant embedding), which stays tame for stiff lines and where shooting would amplify.
"""

from math import isfinite

from components.compiled import kernel
from components.tether.quasistatic.flow import flow
from components.tether.quasistatic.line import DN, DR, F0, OM, PI, RECORD, SAVED, N, P, R, W
from components.tether.quasistatic.loads import add_body_slopes, free_load, node_load, size_of, write_half_slopes
from components.tether.quasistatic.small import apply, multiply, solve

ITERATIONS = 40
# A step that does not lessen the residual is halved at most so often; then the loads have to come on more slowly.
HALVINGS = 8
# Residual below which rounding alone can be what keeps a step from lessening it.
ROUNDED = 1e-9


@kernel
def carry_over_segment(line, w, j, small):
    """Law of node j + 1 in terms of segment j's force, from node j's (in `small`, 9 and 3); the segment's misfit."""
    b, size = j * RECORD, size_of(line, w, j)
    worst = 0.0
    for i in range(3):
        g = w[b + N + i] * (1.0 / size + line.flexibility)
        misfit = w[b + RECORD + R + i] - w[b + R + i] - line.l0 * g
        worst = max(worst, abs(misfit))
        w[b + PI + i] = w[small + 9 + i] - misfit
        for k in range(3):
            same = 1.0 if i == k else 0.0
            bent = (same - (w[b + N + i] / size) * (w[b + N + k] / size)) / size
            w[b + P + 3 * i + k] = w[small + 3 * i + k] + line.l0 * (bent + same * line.flexibility)
    return worst


@kernel
def write_slopes(line, p, u, w, i, share, left, right, by_r, small):
    """Derivatives of node i's load to the forces left and right of it and to its place, times share."""
    vx, vy, vz, gx, gy, gz = flow(p, u, i / line.n, w[i * RECORD + R + 2])
    v, g = (vx, vy, vz), (gx, gy, gz)
    for k in range(9):
        w[by_r + k] = w[right + k] = 0.0
    write_half_slopes(line, w, i - 1, share, v, g, left, by_r, small)
    if i < line.n:
        write_half_slopes(line, w, i, share, v, g, right, by_r, small)
    elif line.free:
        add_body_slopes(line, w, share, v, g, by_r)


@kernel
def carry_over_node(line, p, u, w, i, share, small):
    """Law of segment i - 1's force in terms of segment i's, and node i's in `small`; the node's imbalance."""
    b, o = i * RECORD, (i - 1) * RECORD
    left, right, by_r, free, rows = small + 12, small + 21, small + 30, small + 39, small + 39
    write_slopes(line, p, u, w, i, share, left, right, by_r, free)
    f = node_load(line, p, u, w, i)
    if i == line.n:
        body = free_load(line, p, u, w)
        f = f[0] + body[0], f[1] + body[1], f[2] + body[2]
    c = apply(w, by_r, o + PI)
    worst = 0.0
    multiply(w, small, by_r, o + P, 1.0)
    for k in range(3):
        onward = w[b + N + k] if i < line.n else 0.0
        load = f[k] if share == 1.0 else (1.0 - share) * w[b + F0 + k] + share * f[k]
        missing = onward - w[o + N + k] + load
        worst = max(worst, abs(missing))
        for m in range(3):
            same = 1.0 if k == m else 0.0
            w[rows + 7 * k + m] = w[left + 3 * k + m] + w[small + 3 * k + m] - same
            w[rows + 7 * k + 3 + m] = w[right + 3 * k + m] + (same if i < line.n else 0.0)
        w[rows + 7 * k + 6] = -missing - c[k]
    solve(w, rows, 7)
    for k in range(3):
        w[o + OM + k] = w[rows + 7 * k + 6]
        for m in range(3):
            w[o + W + 3 * k + m] = w[rows + 7 * k + 3 + m]
    multiply(w, small, o + P, o + W, -1.0)
    rho = apply(w, o + P, o + OM)
    for k in range(3):
        w[small + 9 + k] = rho[k] + w[o + PI + k]
    return worst


@kernel
def sweep(line, p, u, w, share):
    """Residual of the line with this share of its loads, relative; leaves the laws for back_substitute."""
    small = small_place(line)
    for k in range(12):
        w[small + k] = 0.0
    misfit, imbalance = 0.0, 0.0
    for i in range(1, line.n + 1):
        misfit = max(misfit, carry_over_segment(line, w, i - 1, small))
        if i < line.n or line.free:
            imbalance = max(imbalance, carry_over_node(line, p, u, w, i, share, small))
    return max(misfit / line.length, imbalance / line.scale)


@kernel
def small_place(line):
    """Where the small matrices stand: behind the records."""
    return (line.n + 1) * RECORD


@kernel
def back_substitute(line, w):
    """Corrections DN and DR of all segments and nodes, from the far end back."""
    last = (line.n - 1) * RECORD
    small = small_place(line)
    if line.free:
        for k in range(3):
            w[last + DN + k] = w[last + OM + k]
    else:  # end b stays: P dN + pi = 0
        for i in range(3):
            for k in range(3):
                w[small + 4 * i + k] = w[last + P + 3 * i + k]
            w[small + 4 * i + 3] = -w[last + PI + i]
        solve(w, small, 4)
        for k in range(3):
            w[last + DN + k] = w[small + 4 * k + 3]
    for j in range(line.n - 1, -1, -1):
        b = j * RECORD
        if j < line.n - 1:
            turned = apply(w, b + W, b + RECORD + DN)
            for k in range(3):
                w[b + DN + k] = w[b + OM + k] - turned[k]
        moved = apply(w, b + P, b + DN)
        for k in range(3):
            w[b + RECORD + DR + k] = moved[k] + w[b + PI + k]


@kernel
def move(line, w, fraction):
    """Add this fraction of the corrections."""
    for i in range(line.n):
        b = i * RECORD
        for k in range(3):
            w[b + N + k] += fraction * w[b + DN + k]
            if i < line.n - 1 or line.free:
                w[b + RECORD + R + k] += fraction * w[b + RECORD + DR + k]


@kernel
def newton(line, p, u, w, share, allowed):
    """(iterations, residual, success) of Newton's method from what is in w, with this share of the loads."""
    residual = sweep(line, p, u, w, share)
    for iteration in range(ITERATIONS):
        if residual <= allowed or not isfinite(residual):
            return iteration, residual, residual <= allowed
        back_substitute(line, w)
        fraction = 1.0
        move(line, w, fraction)
        trial = sweep(line, p, u, w, share)
        halvings = 0
        while not trial <= (1.0 - 0.25 * fraction) * residual and halvings < HALVINGS:
            move(line, w, -0.5 * fraction)
            fraction *= 0.5
            trial = sweep(line, p, u, w, share)
            halvings += 1
        if halvings == HALVINGS:
            move(line, w, -fraction)
            return iteration + 1, residual, residual <= ROUNDED
        residual = trial
    return ITERATIONS, residual, residual <= ROUNDED


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
