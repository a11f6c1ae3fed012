"""The line on two meshes, n and 2 n segments: what they differ by is the error of the one and improves the other."""

from math import sqrt

from components.compiled import kernel
from components.tether.quasistatic.arc import arc_size
from components.tether.quasistatic.continuation import SOLVED, from_afar
from components.tether.quasistatic.line import FORCES, KEPT, RECORD, SMALL, N, R, line_of
from components.tether.quasistatic.loads import node_load, size_of, write_first_loads
from components.tether.quasistatic.newton import newton

# Below this share of all force a segment counts as slack.
SLACK = 1e-9


@kernel
def scaled_line(p, u, w, n, dx, dy, dz):
    """The line with n segments, its forces' scale from its loads and its stretch; a scale of 0: nothing loads it."""
    line = line_of(p, n, 0.0, 0.0)
    scale = write_first_loads(line, p, u, w, dx, dy, dz)
    if not line.free:
        scale += max(sqrt(dx * dx + dy * dy + dz * dz) / line.length - 1.0, 0.0) / line.flexibility
    return line_of(p, n, SLACK * scale, scale)


@kernel
def end_forces(line, p, u, w):
    """The line's forces on what holds end a and end b, or hangs at it."""
    ax, ay, az = node_load(line, p, u, w, 0)
    bx, by, bz = node_load(line, p, u, w, line.n)
    last = (line.n - 1) * RECORD + N
    return w[N] + ax, w[N + 1] + ay, w[N + 2] + az, bx - w[last], by - w[last + 1], bz - w[last + 2]


@kernel
def keep(line, p, u, w, every, at):
    """Write place and tension of every so manieth node, and the end forces, to w[at...]."""
    force = end_forces(line, p, u, w)
    count = line.n // every
    for i in range(count + 1):
        b, o = i * every * RECORD, at + KEPT * i
        for k in range(3):
            w[o + k] = w[b + R + k]
        if i == 0:
            w[o + 3] = sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2])
        elif i == count:
            w[o + 3] = sqrt(force[3] * force[3] + force[4] * force[4] + force[5] * force[5])
        else:
            before = b - RECORD + N
            x, y, z = w[b + N] + w[before], w[b + N + 1] + w[before + 1], w[b + N + 2] + w[before + 2]
            w[o + 3] = 0.5 * sqrt(x * x + y * y + z * z)
    for k in range(FORCES):
        w[at + KEPT * (count + 1) + k] = force[k]


@kernel
def halve(n, w):
    """Interpolate the records of n segments to 2 n, from the far end so that nothing is overwritten too early."""
    for i in range(n, -1, -1):
        b, o = i * RECORD, 2 * i * RECORD
        for k in range(3):
            place, force = w[b + R + k], w[b + N + k]
            if i < n:
                w[o + RECORD + R + k] = 0.5 * (place + w[o + 2 * RECORD + R + k])
                w[o + RECORD + N + k] = force
            w[o + R + k], w[o + N + k] = place, force


@kernel
def results(n):
    """Where the coarse mesh's results begin in w, and the fine one's."""
    coarse = (2 * n + 1) * RECORD + SMALL
    return coarse, coarse + KEPT * (n + 1) + FORCES


@kernel
def workspace(n):
    """Length of w."""
    return arc_place(n) + arc_size(2 * n)


@kernel
def arc_place(n):
    """Where the continuation's vectors begin in w."""
    return (2 * n + 1) * RECORD + SMALL + 2 * (KEPT * (n + 1) + FORCES)


@kernel
def resolved(line, w):
    """Whether each segment turns by so little that the error falls with the square of the segments.

    A load f turns a force N by f/N; where that passes half a radian the line has a fold (the bottom of a steep bight).
    """
    least, most = size_of(line, w, 0), 0.0
    for j in range(1, line.n):
        least = min(least, size_of(line, w, j))
        b = j * RECORD + N
        x, y, z = w[b] - w[b - RECORD], w[b + 1] - w[b + 1 - RECORD], w[b + 2] - w[b + 2 - RECORD]
        most = max(most, sqrt(x * x + y * y + z * z))
    return line.n > 1 and most <= 0.5 * least


@kernel
def solve_both(p, u, w, n, dx, dy, dz):
    """(scale of the forces, iterations, residual, success, smooth): results of both meshes in w.

    A scale of 0: nothing loads the line. Where the fine mesh fails its results are the coarse one's. smooth: the coarse
    mesh resolves the shape, so that what the meshes differ by is three times the fine one's error.
    """
    line = scaled_line(p, u, w, n, dx, dy, dz)
    coarse, fine = results(n)
    if line.scale == 0.0:
        return 0.0, 0, 0.0, False, False
    total, residual, solved, smooth = 0, 0.0, False, False
    for mesh in range(2):
        if mesh == 1:
            smooth = resolved(line, w)
            halve(n, w)
            line = line_of(p, 2 * n, line.slack, line.scale)
            iterations, residual, solved = newton(line, p, u, w, 1.0, SOLVED)
            total += iterations
        if not solved:
            iterations, residual, solved = from_afar(line, p, u, w, arc_place(n), dx, dy, dz)
            total += iterations
        if mesh == 0 or solved:
            keep(line, p, u, w, mesh + 1, fine if mesh == 1 else coarse)
        if not solved:
            break
    if not solved:
        for k in range(fine - coarse):
            w[fine + k] = w[coarse + k]
    return line.scale, total, residual, solved, smooth and solved
