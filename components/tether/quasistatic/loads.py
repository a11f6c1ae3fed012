"""The loads lumped at the nodes, and their derivatives to the segments' forces and to the depth."""

from math import sqrt

from components.compiled import kernel
from components.tether.quasistatic.drag import drag, write_slopes
from components.tether.quasistatic.flow import flow
from components.tether.quasistatic.line import F0, RECORD, N, R


@kernel
def size_of(line, w, j):
    """|N| of segment j, rounded where it is slack."""
    b = j * RECORD + N
    return sqrt(w[b] * w[b] + w[b + 1] * w[b + 1] + w[b + 2] * w[b + 2] + line.slack * line.slack)


@kernel
def half_load(line, w, j, vx, vy, vz):
    """Load of half of segment j on a node that the flow v passes."""
    b, size, half = j * RECORD + N, size_of(line, w, j), 0.5 * line.l0
    fx, fy, fz = drag(vx, vy, vz, w[b] / size, w[b + 1] / size, w[b + 2] / size, line.drag_n, line.drag_t)
    return half * fx, half * fy, half * (fz + line.weight)


@kernel
def body_load(line, vx, vy, vz):
    """Weight and drag of what hangs at a free end."""
    speed = line.body_drag * sqrt(vx * vx + vy * vy + vz * vz)
    return speed * vx, speed * vy, speed * vz + line.body_weight


@kernel
def node_load(line, p, u, w, i):
    """All load on node i but a body's."""
    vx, vy, vz, _, _, _ = flow(p, u, i / line.n, w[i * RECORD + R + 2])
    fx, fy, fz = 0.0, 0.0, 0.0
    for j in range(max(i - 1, 0), min(i, line.n - 1) + 1):
        hx, hy, hz = half_load(line, w, j, vx, vy, vz)
        fx, fy, fz = fx + hx, fy + hy, fz + hz
    return fx, fy, fz


@kernel
def free_load(line, p, u, w):
    """Load of the body at a free end."""
    vx, vy, vz, _, _, _ = flow(p, u, 1.0, w[line.n * RECORD + R + 2])
    return body_load(line, vx, vy, vz)


@kernel
def write_half_slopes(line, w, j, share, v, g, by_N, by_r, small):
    """Derivative of half of segment j's load, times share: to N_j, written at by_N; to the node's place, added at by_r.

    v, g: flow and its derivative to z. by_r gets its third column only. small: 18 free places in w.
    """
    b, size, half = j * RECORD + N, size_of(line, w, j), 0.5 * line.l0 * share
    t = (w[b] / size, w[b + 1] / size, w[b + 2] / size)
    write_slopes(w, small, small + 9, v[0], v[1], v[2], t[0], t[1], t[2], line.drag_n, line.drag_t)
    for i in range(3):
        row = small + 9 + 3 * i
        along = w[row] * t[0] + w[row + 1] * t[1] + w[row + 2] * t[2]
        for k in range(3):
            w[by_N + 3 * i + k] = half * (w[row + k] - along * t[k]) / size
        row = small + 3 * i
        w[by_r + 3 * i + 2] += half * (w[row] * g[0] + w[row + 1] * g[1] + w[row + 2] * g[2])


@kernel
def add_body_slopes(line, w, share, v, g, by_r):
    """Add the derivative of the body's drag to its place, times share."""
    speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if speed == 0.0:
        return
    rate = (v[0] * g[0] + v[1] * g[1] + v[2] * g[2]) / speed
    for i in range(3):
        w[by_r + 3 * i + 2] += share * line.body_drag * (speed * g[i] + rate * v[i])


@kernel
def write_first_loads(line, p, u, w, dx, dy, dz):
    """Loads to begin with, F0: drag as if the flow were across everywhere, at the depths of the straight line to d.

    Returns the sum of their sizes [N]; they do not depend on the shape, so that the first problem is convex.
    """
    total = 0.0
    for i in range(line.n + 1):
        share = i / line.n
        vx, vy, vz, _, _, _ = flow(p, u, share, share * dz)
        speed = line.drag_n * sqrt(vx * vx + vy * vy + vz * vz)
        part = line.l0 * (0.5 if i == 0 or i == line.n else 1.0)
        b = i * RECORD + F0
        w[b], w[b + 1], w[b + 2] = part * speed * vx, part * speed * vy, part * (speed * vz + line.weight)
        if line.free and i == line.n:
            hx, hy, hz = body_load(line, vx, vy, vz)
            w[b], w[b + 1], w[b + 2] = w[b] + hx, w[b + 1] + hy, w[b + 2] + hz
        total += sqrt(w[b] * w[b] + w[b + 1] * w[b + 1] + w[b + 2] * w[b + 2])
    return total
