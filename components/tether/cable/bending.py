"""Bending stiffness without rotations: moments from the angle between neighbouring segments."""

from components.compiled import kernel
from components.tether.cable.line import BAND, DIR, FREE, SCRATCH, D, E, Q, R, V
from components.tether.cable.part import part


@kernel
def across(tx, ty, tz):
    """I - t t': xx, yy, zz, xy, xz, yz."""
    return 1.0 - tx * tx, 1.0 - ty * ty, 1.0 - tz * tz, -tx * ty, -tx * tz, -ty * tz


@kernel
def stretched(line, w, i):
    """Reciprocal of the present length of segment i [1/m]; its softening at a point is balance.fill's."""
    s, b = part(line, i), i * SCRATCH
    o = b + SCRATCH
    along = 0.0
    for c in range(3):
        along += w[b + DIR + c] * (w[o + Q + c] - w[b + Q + c])
    return 1.0 / max(along, 1e-8 * s.l0)


@kernel
def joint(line, i):
    """B = EI / l [N m] of the node i between two segments, l the length of line that bends there."""
    before, after = part(line, i - 1), part(line, i)
    return (before.stiff * before.l0 + after.stiff * after.l0) / (before.l0 + after.l0) ** 2 * 2.0


@kernel
def add(line, w, c_c):
    """Add to R the shear forces of the moments, and write their stiffness to the band (that of clamps to D and E).

    The energy of a node is B (1 - t0 . t1) = B |t1 - t0|^2 / 2, t the unit tangents of its segments: EI kappa^2 / 2
    per length with kappa = 2 sin(theta / 2) / l, of second order in l. Forces are its exact gradient, and those of
    the same damping time as the tension's; the stiffness is that of Gauss and Newton, J' B J with J = d(t1 - t0)/dq,
    which is never negative and leaves out only what is of second order in the angle.
    """
    for k in range(line.band, line.band + BAND * (line.n + 1)):
        w[k] = 0.0
    for i in range(1, line.n):
        if line.cut != i - 1 and line.cut != i:
            bend(line, w, i, joint(line, i), c_c)
    if line.end_a != FREE and line.cut != 0:
        clamp(line, w, 0, line.clamps, c_c)
    if line.end_b != FREE and line.cut != line.n - 1:
        clamp(line, w, line.n - 1, line.clamps + 3, c_c)


@kernel
def bend(line, w, i, stiffness, c_c):
    """Add the moment of node i, of stiffness B [N m]."""
    b = i * SCRATCH
    a, o = b - SCRATCH, b + SCRATCH
    g0, g1 = stretched(line, w, i - 1), stretched(line, w, i)
    x0, y0, z0 = w[a + DIR], w[a + DIR + 1], w[a + DIR + 2]
    x1, y1, z1 = w[b + DIR], w[b + DIR + 1], w[b + DIR + 2]
    cosine = x0 * x1 + y0 * y1 + z0 * z1
    # d/dt of t1 - t0 times the damping time, added to t1 - t0
    ux, uy, uz = g0 * (w[b + V] - w[a + V]), g0 * (w[b + V + 1] - w[a + V + 1]), g0 * (w[b + V + 2] - w[a + V + 2])
    vx, vy, vz = g1 * (w[o + V] - w[b + V]), g1 * (w[o + V + 1] - w[b + V + 1]), g1 * (w[o + V + 2] - w[b + V + 2])
    s0, s1 = x0 * ux + y0 * uy + z0 * uz, x1 * vx + y1 * vy + z1 * vz
    kx = x1 - x0 + line.tau * (vx - s1 * x1 - ux + s0 * x0)
    ky = y1 - y0 + line.tau * (vy - s1 * y1 - uy + s0 * y0)
    kz = z1 - z0 + line.tau * (vz - s1 * z1 - uz + s0 * z0)
    d0, d1 = kx * x0 + ky * y0 + kz * z0, kx * x1 + ky * y1 + kz * z1
    f0, f1 = stiffness * g0, stiffness * g1
    ax, ay, az = -f0 * (kx - d0 * x0), -f0 * (ky - d0 * y0), -f0 * (kz - d0 * z0)
    cx, cy, cz = -f1 * (kx - d1 * x1), -f1 * (ky - d1 * y1), -f1 * (kz - d1 * z1)
    w[a + R], w[a + R + 1], w[a + R + 2] = w[a + R] + ax, w[a + R + 1] + ay, w[a + R + 2] + az
    w[b + R], w[b + R + 1], w[b + R + 2] = w[b + R] - ax - cx, w[b + R + 1] - ay - cy, w[b + R + 2] - az - cz
    w[o + R], w[o + R + 1], w[o + R + 2] = w[o + R] + cx, w[o + R + 1] + cy, w[o + R + 2] + cz
    grip = stiffness * (1.0 + line.tau * c_c)
    for r in range(3):
        for c in range(3):
            t0, t1 = w[a + DIR + r], w[b + DIR + c]
            unit = 1.0 if r == c else 0.0
            p0 = grip * g0 * g0 * (unit - t0 * w[a + DIR + c])
            p1 = grip * g1 * g1 * (unit - w[b + DIR + r] * t1)
            far = grip * g0 * g1 * (unit - t0 * w[a + DIR + c] - w[b + DIR + r] * t1 + cosine * t0 * t1)
            turned = (
                grip
                * g0
                * g1
                * (unit - w[a + DIR + c] * t0 - w[b + DIR + r] * t1 + cosine * w[a + DIR + c] * w[b + DIR + r])
            )
            put(line, w, i - 1, 0, r, c, p0)
            put(line, w, i - 1, 1, r, c, -p0 - far)
            put(line, w, i - 1, 2, r, c, far)
            put(line, w, i, 0, r, c, p0 + p1 + far + turned)
            put(line, w, i, 1, r, c, -p1 - far)
            put(line, w, i + 1, 0, r, c, p1)


@kernel
def put(line, w, node, ahead, r, c, value):
    """Add to the entry (r, c) of the band's block between a node and the one `ahead` of it; its upper part is kept."""
    if ahead > 0 or c >= r:
        w[line.band + BAND * node + 9 * r + 3 * ahead + c - r] += value


@kernel
def clamp(line, w, i, at, c_c):
    """Add the moment of a clamped end in segment i; at: place in p of the line's direction there.

    Half a segment bends between the end and the segment's tangent: B = 2 EI / l.
    """
    cx, cy, cz = line.table[at], line.table[at + 1], line.table[at + 2]
    if cx == 0.0 and cy == 0.0 and cz == 0.0:
        return
    s, b = part(line, i), i * SCRATCH
    o, g = b + SCRATCH, stretched(line, w, i)
    stiffness = 2.0 * s.stiff / s.l0
    tx, ty, tz = w[b + DIR], w[b + DIR + 1], w[b + DIR + 2]
    vx, vy, vz = g * (w[o + V] - w[b + V]), g * (w[o + V + 1] - w[b + V + 1]), g * (w[o + V + 2] - w[b + V + 2])
    kx, ky, kz = cx - line.tau * vx, cy - line.tau * vy, cz - line.tau * vz
    d = kx * tx + ky * ty + kz * tz
    fx, fy, fz = stiffness * g * (kx - d * tx), stiffness * g * (ky - d * ty), stiffness * g * (kz - d * tz)
    w[b + R], w[b + R + 1], w[b + R + 2] = w[b + R] - fx, w[b + R + 1] - fy, w[b + R + 2] - fz
    w[o + R], w[o + R + 1], w[o + R + 2] = w[o + R] + fx, w[o + R + 1] + fy, w[o + R + 2] + fz
    grip = stiffness * g * g * (1.0 + line.tau * c_c)
    xx, yy, zz, xy, xz, yz = across(tx, ty, tz)
    for k in (b + D, o + D):
        w[k], w[k + 1], w[k + 2] = w[k] + grip * xx, w[k + 1] + grip * yy, w[k + 2] + grip * zz
        w[k + 3], w[k + 4], w[k + 5] = w[k + 3] + grip * xy, w[k + 4] + grip * xz, w[k + 5] + grip * yz
    k = b + E
    w[k], w[k + 1], w[k + 2] = w[k] - grip * xx, w[k + 1] - grip * yy, w[k + 2] - grip * zz
    w[k + 3], w[k + 4], w[k + 5] = w[k + 3] - grip * xy, w[k + 4] - grip * xz, w[k + 5] - grip * yz
