"""Forces on the nodes of a lumped-mass line and the matrix of their linearised balance."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable import bending, clumps, flow, seabed
from components.tether.cable.drag import morison
from components.tether.cable.line import ACC, ASKED, DIR, KE, SCRATCH, TC, WATER, D, E, Q, R, T, V
from components.tether.cable.part import part, whole

# Softens a segment's length so that one squeezed to a point has a tangent (zero) and no NaN; times l0, squared.
POINT = 1e-16
EPSILON = 2.0**-52
# Penalty of an inextensible part over the inertia in the time scheme, c_c^2 m, of a line whose n parts all swing to and
# fro along it, n^2 times their own: an iteration leaves about 1 % of the stretch.
OUTWEIGH = 100.0


@kernel
def axial(stretch, rate, last, s, c_c):
    """Tension [N] and its slope [N/m] of the part s at the elongation l - l0 [m] and its rate [m/s].

    T = EA (e + tau de/dt), e = (l - l0) / l0 (Kelvin-Voigt); a line that takes no compression has max(0, T). While
    the last linear solution has the segment taut (last > 0, its tension), the law is taken as linear (so T may come
    out negative, which `imbalance` counts): the active set of a primal-dual method, with the tension as multiplier.
    """
    tension = s.k * (stretch + s.tau * rate)
    if s.tension_only and tension <= 0.0 and not last > 0.0:
        return 0.0, 0.0
    return tension, s.k * (1.0 + s.tau * c_c)


@kernel
def multiplier(stretch, last, n, s, c_c):
    """Tension [N], what the stretch asks on top of it [N], and the penalty [N/m] of a part of n inextensible ones.

    The method of multipliers (Hestenes 1969): each linear solution takes last + k stretch for the next `last`, so that
    it comes to rest only where the stretch is nothing, whatever the penalty k; the faster, the more k outweighs the
    inertia of a short step. The force is `last` alone: k would magnify the rounding of a length. At an instant
    (c_c = 0), where only accelerations are sought, the tension stays near the last.
    """
    k = s.k + OUTWEIGH * n * n * c_c * c_c * (s.mass + s.added_n)
    if s.tension_only and last + k * stretch <= 0.0 and not last > 0.0:
        return 0.0, 0.0, 0.0
    return last, k * stretch, k


@kernel
def half_segment(vx, vy, vz, ax, ay, az, tx, ty, tz, s, c_m, c_c):
    """What half the segment s gives to its end node: f - M a without tension (3), and c_m M + c_c C (6).

    v: velocity through the water. M = m + rho V (Ca_n (I - t t') + Ca_t t t'), C the drag's damping matrix;
    order xx, yy, zz, xy, xz, yz.
    """
    fx, fy, fz, cxx, cyy, czz, cxy, cxz, cyz = morison(vx, vy, vz, tx, ty, tz, s.drag_n, s.drag_t)
    m = s.mass + s.added_n
    d = s.added_t - s.added_n
    f = d * (tx * ax + ty * ay + tz * az)
    i, j = c_m * m, c_m * d
    return (
        fx - m * ax - f * tx,
        fy - m * ay - f * ty,
        fz - m * az - f * tz + s.weight,
        i + j * tx * tx + c_c * cxx,
        i + j * ty * ty + c_c * cyy,
        i + j * tz * tz + c_c * czz,
        j * tx * ty + c_c * cxy,
        j * tx * tz + c_c * cxz,
        j * ty * tz + c_c * cyz,
    )


@kernel
def fill(line, w, c_m, c_c, special):
    """What all segments give: tension, weight, inertia and drag. special: None, or p where `line.special` asks for it.

    Where it is None the compiler leaves out what only special lines need.
    """
    rx, ry, rz = 0.0, 0.0, 0.0
    dxx, dyy, dzz, dxy, dxz, dyz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s = whole(line)
    for i in range(line.n):
        if special is not None:
            s = part(line, i)
        b = i * SCRATCH
        o = b + SCRATCH
        ux, uy, uz = w[b + V], w[b + V + 1], w[b + V + 2]
        vx, vy, vz = w[o + V], w[o + V + 1], w[o + V + 2]
        ex, ey, ez = w[o + Q] - w[b + Q], w[o + Q + 1] - w[b + Q + 1], w[o + Q + 2] - w[b + Q + 2]
        length = sqrt(ex * ex + ey * ey + ez * ez + POINT * s.l0 * s.l0)
        inverse = 1.0 / length
        if i == line.cut:
            inverse = 0.0  # two stubs, which are taken to lie across whatever they meet
        tx, ty, tz = ex * inverse, ey * inverse, ez * inverse
        rate = tx * (vx - ux) + ty * (vy - uy) + tz * (vz - uz)
        tension, slope = axial(length - s.l0, rate, w[b + T], s, c_c)
        if special is not None and s.inextensible:
            tension, asked, slope = multiplier(length - s.l0, w[b + T], line.n, s, c_c)
            w[b + ASKED] = asked if i != line.cut else 0.0
        if i == line.cut:
            tension, slope = 0.0, 0.0
        g = max(w[b + T], 0.0) * inverse
        a = slope - g
        kxx, kyy, kzz = g + a * tx * tx, g + a * ty * ty, g + a * tz * tz
        kxy, kxz, kyz = a * tx * ty, a * tx * tz, a * ty * tz
        if special is not None and line.water:
            m = line.water + WATER * i
            ux, uy, uz = ux - w[m], uy - w[m + 1], uz - w[m + 2]
            vx, vy, vz = vx - w[m + WATER], vy - w[m + WATER + 1], vz - w[m + WATER + 2]
        fx, fy, fz, mxx, myy, mzz, mxy, mxz, myz = half_segment(
            ux, uy, uz, w[b + ACC], w[b + ACC + 1], w[b + ACC + 2], tx, ty, tz, s, c_m, c_c
        )
        w[b + R], w[b + R + 1], w[b + R + 2] = rx + fx + tension * tx, ry + fy + tension * ty, rz + fz + tension * tz
        w[b + D], w[b + D + 1], w[b + D + 2] = dxx + mxx + kxx, dyy + myy + kyy, dzz + mzz + kzz
        w[b + D + 3], w[b + D + 4], w[b + D + 5] = dxy + mxy + kxy, dxz + mxz + kxz, dyz + myz + kyz
        w[b + E], w[b + E + 1], w[b + E + 2] = -kxx, -kyy, -kzz
        w[b + E + 3], w[b + E + 4], w[b + E + 5] = -kxy, -kxz, -kyz
        w[b + TC], w[b + KE] = tension, slope
        w[b + DIR], w[b + DIR + 1], w[b + DIR + 2] = tx, ty, tz
        fx, fy, fz, mxx, myy, mzz, mxy, mxz, myz = half_segment(
            vx, vy, vz, w[o + ACC], w[o + ACC + 1], w[o + ACC + 2], tx, ty, tz, s, c_m, c_c
        )
        rx, ry, rz = fx - tension * tx, fy - tension * ty, fz - tension * tz
        dxx, dyy, dzz = mxx + kxx, myy + kyy, mzz + kzz
        dxy, dxz, dyz = mxy + kxy, mxz + kxz, myz + kyz
    b = line.n * SCRATCH
    w[b + R], w[b + R + 1], w[b + R + 2] = rx, ry, rz
    w[b + D], w[b + D + 1], w[b + D + 2] = dxx, dyy, dzz
    w[b + D + 3], w[b + D + 4], w[b + D + 5] = dxy, dxz, dyz


@kernel
def assemble(line, w, c_m, c_c):
    """Fill R, D, E, TC, KE and DIR of all nodes from their position, velocity, acceleration and T.

    Each term that is on adds its own. R = f - M a: what is missing to balance at a free node, and at a held one the
    line's force on its holder [N].
    D, E: the blocks of c_m M + c_c C + K = -dR/dq, with c_m = da/dq and c_c = dv/dq of the time scheme. Left out
    are the turning of the tangent in drag, added mass and damping, which would spoil the symmetry and are small
    over a step. K takes its geometric part from T, not from TC: T is the tension that the last linear solution
    asked for, free of the second-order strain that a large rotation leaves in TC, so that Newton on a stiff line
    converges as it would with the tension as a separate unknown (Magisano, Leonetti and Garcea 2017, on the mixed
    Newton iteration), at no cost.
    """
    if line.special:
        fill(line, w, c_m, c_c, line.table)
    else:
        fill(line, w, c_m, c_c, None)
    if line.waves:
        flow.push(line, w)
    if line.clumps:
        clumps.add(line, w, c_m, c_c)
    if line.bed:
        seabed.add(line, w, c_c)
    if line.band:
        bending.add(line, w, c_c)


@kernel
def tighten(line, w):
    """Add to R what the stretch of an inextensible line asks, for the next linear solution."""
    if line.inextensible:
        for i in range(line.n):
            b = i * SCRATCH
            o = b + SCRATCH
            for c in range(3):
                w[b + R + c] += w[b + ASKED] * w[b + DIR + c]
                w[o + R + c] -= w[b + ASKED] * w[b + DIR + c]


@kernel
def imbalance(line, w, first, last):
    """Largest component of R over the free nodes, or compression of a line that takes none [N]; NaN if any is NaN.

    Of an inextensible line also its stiffness at rest times the stretch that is left; of one on the bed what a stick
    holds beyond friction.
    """
    worst = 0.0
    for i in range(first, last + 1):
        for c in range(3):
            r = abs(w[i * SCRATCH + R + c])
            if not r <= worst:
                worst = r
                if r != r:
                    return r
    if line.tension_only:
        for i in range(line.n):
            worst = max(worst, -w[i * SCRATCH + TC])
    if line.inextensible:
        for i in range(line.n):
            if w[i * SCRATCH + KE] > 0.0:
                worst = max(worst, line.k * abs(w[i * SCRATCH + ASKED]) / w[i * SCRATCH + KE])
    return max(worst, seabed.overdrawn(line, w))


@kernel
def allowance(line, w, tolerance):
    """Imbalance [N] to put up with: the tolerance times dry weight plus largest tension, and rounding in the lengths.

    The tension is the last linear solution's. A position of size |q| is known to |q| EPSILON, a tension to k times it.
    """
    tension, reach = 0.0, 0.0
    for i in range(line.n):
        b = i * SCRATCH
        tension = max(tension, abs(w[b + T]))
        reach = max(reach, abs(w[b + Q]), abs(w[b + Q + 1]), abs(w[b + Q + 2]))
    return tolerance * (line.dry_weight + tension) + 4.0 * EPSILON * line.k * reach
