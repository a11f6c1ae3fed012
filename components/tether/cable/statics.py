"""Static equilibrium of the discrete line: its end force by a convex search, its nodes by a damped Newton iteration."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable import linear, seabed, turning
from components.tether.cable.balance import allowance, assemble, imbalance, tighten
from components.tether.cable.block_tridiagonal import backsolve, factor
from components.tether.cable.drifting import go_with
from components.tether.cable.dynamics import correct, step_length
from components.tether.cable.flow import sample
from components.tether.cable.line import FREE, SCRATCH, STATE, WATER, Q, T, first_unknown, last_unknown
from components.tether.cable.part import PART, hung, part
from components.tether.cable.touchdown import below_bed, lay_on_bed

# Below this fraction of the line's weight a segment counts as slack: the kink of |T| at T = 0 is rounded over it.
SLACK = 1e-9
# A tension of so many times that is the rounding's, not the segment's.
LOOSE = 10.0
# The convex search ends when the far end is met to this fraction of the length; the Newton iteration does the rest.
GAP, COARSE_GAP = 1e-10, 1e-3
SEARCH_ITERATIONS, NEWTON_ITERATIONS = 300, 200
# With a current, a bed or bending the search gives no more than a first guess, and Newton takes its time.
GUESSED_ITERATIONS = 1000
# The pseudo-stiffness is then referred to at most so many times the line's weight over a segment's length.
GUESSED_STIFFNESS = 1e3
# Pseudo-time continuation: the pseudo-stiffness over the axial one is held between these bounds, in proportion to the
# imbalance; the lower bound keeps nodes between two slack segments from leaving a zero pivot.
LEAST_SHIFT, LARGEST_SHIFT = 1e-14, 1e-4
# An iteration that no longer gains has come to rounding if the imbalance is below this fraction of weight and tension.
ROUNDED = 1e-8
# A segment shorter than this fraction of its length is squeezed to a point.
SQUEEZED = 1e-3
# Tension of a weightless free line: only its direction counts [N].
NOTHING = 1e-30


@kernel
def complementary_energy(fx, fy, fz, line, slack, dx, dy, dz, qx, qy):
    """Complementary energy at the first segment's tension vector f, its gradient (3) and its Hessian (6).

    In equilibrium the tension vector of segment j is f less what hangs before it, whatever the shape: the weight of
    the nodes 1..j and j times (qx, qy), the water's drag on a segment at its first guess [N].
    The energy, sum of l0 sqrt(T_j^2 + slack^2) + T_j^2 / (2 k) less f . d with d the vector between the ends, is
    strictly convex, and its gradient is the sum of the segments' vectors less d (the dual of the potential energy
    of a line that takes tension only).
    """
    energy, gx, gy, gz = -(fx * dx + fy * dy + fz * dz), -dx, -dy, -dz
    hxx, hyy, hzz, hxy, hxz, hyz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(line.n):
        s = part(line, j)
        flexible = 1.0 / s.k
        tx, ty, tz = fx - j * qx, fy - j * qy, fz - hung(line, j)
        square = tx * tx + ty * ty + tz * tz
        size = sqrt(square + slack * slack)
        a = s.l0 / size
        b = a / (size * size)
        a += flexible
        energy += s.l0 * size + 0.5 * flexible * square
        gx, gy, gz = gx + a * tx, gy + a * ty, gz + a * tz
        hxx, hyy, hzz = hxx + a - b * tx * tx, hyy + a - b * ty * ty, hzz + a - b * tz * tz
        hxy, hxz, hyz = hxy - b * tx * ty, hxz - b * tx * tz, hyz - b * ty * tz
    return energy, gx, gy, gz, hxx, hyy, hzz, hxy, hxz, hyz


@kernel
def first_tension(line, dx, dy, dz, qx, qy):
    """Tension vector [N] of the first segment when both ends are held d = (dx, dy, dz) apart, NED [m]; and the slack.

    Newton on the complementary energy with a halving line search. The rounding of the kink is narrowed in steps: at
    once it would leave Newton nothing to follow.
    """
    load = 2.0 * line.n * abs(line.weight) if line.parts == 0 else abs(hung(line, line.n))
    scale = max(load + line.n * (abs(qx) + abs(qy)), SLACK * line.k * line.l0)
    slack = 0.1 * scale
    fx, fy, fz = 0.5 * line.n * qx, 0.5 * line.n * qy, 0.5 * hung(line, line.n)
    for _ in range(SEARCH_ITERATIONS):
        energy, gx, gy, gz, hxx, hyy, hzz, hxy, hxz, hyz = complementary_energy(
            fx, fy, fz, line, slack, dx, dy, dz, qx, qy
        )
        narrowest = slack <= SLACK * scale
        if sqrt(gx * gx + gy * gy + gz * gz) <= (GAP if narrowest else COARSE_GAP) * line.n * line.l0:
            if narrowest:
                break
            slack = max(0.1 * slack, SLACK * scale)
            continue
        l21, l31, l32, i1, i2, i3 = factor(hxx, hyy, hzz, hxy, hxz, hyz)
        px, py, pz = backsolve(l21, l31, l32, i1, i2, i3, gx, gy, gz)
        step, slope = 1.0, px * gx + py * gy + pz * gz
        while step > 1e-18:
            trial = complementary_energy(
                fx - step * px, fy - step * py, fz - step * pz, line, slack, dx, dy, dz, qx, qy
            )[0]
            if trial <= energy - 1e-4 * step * slope:
                break
            step *= 0.5
        fx, fy, fz = fx - step * px, fy - step * py, fz - step * pz
    return fx, fy, fz, slack


@kernel
def hanging_tension(line, qx, qy):
    """Tension vector (3) [N] of the first segment of a line with one free end, where half a segment hangs."""
    if line.end_a == FREE:
        fz = -line.weight if line.parts == 0 else -line.table[line.parts + PART * line.n]
        fx, fy = -0.5 * qx, -0.5 * qy
    else:
        fz = (2.0 * line.n - 1.0) * line.weight if line.parts == 0 else hung(line, line.n)
        fx, fy = (line.n - 0.5) * qx, (line.n - 0.5) * qy
    if fx == 0.0 and fy == 0.0 and fz == 0.0:
        fz = -NOTHING if line.end_a == FREE else NOTHING
    return fx, fy, fz


@kernel
def lay_out(line, w, fx, fy, fz, slack, qx, qy):
    """Place the nodes along the tension vectors, from the end that is held; T takes the tensions."""
    for k in range(line.n):
        j = line.n - 1 - k if line.end_a == FREE else k
        s = part(line, j)
        tx, ty, tz = fx - j * qx, fy - j * qy, fz - hung(line, j)
        square = tx * tx + ty * ty + tz * tz
        g = s.l0 / sqrt(square + slack * slack) + 1.0 / s.k
        near, far = j * SCRATCH, (j + 1) * SCRATCH
        if line.end_a == FREE:
            near, far, g = far, near, -g
        w[far + Q] = w[near + Q] + g * tx
        w[far + Q + 1] = w[near + Q + 1] + g * ty
        w[far + Q + 2] = w[near + Q + 2] + g * tz
        tension = sqrt(square)
        w[j * SCRATCH + T] = tension if tension > LOOSE * slack else 0.0


@kernel
def settle(line, w):
    """Newton with pseudo-time continuation from the nodes in w, to rounding: largest imbalance [N], and success."""
    first, last = first_unknown(line), last_unknown(line)
    stiffness, iterations = line.k, NEWTON_ITERATIONS
    if line.special or line.bed or line.band:
        stiffness = min(stiffness, GUESSED_STIFFNESS * line.dry_weight / line.l0)
        iterations = GUESSED_ITERATIONS
    unit = stiffness / (line.mass + line.added_n)
    shift, least = LARGEST_SHIFT, -1.0
    for _ in range(iterations):
        if line.water:
            sample(line, w, line.t, False)
        assemble(line, w, shift * unit, 0.0)
        residual = imbalance(line, w, first, last)
        stalled = least >= 0.0 and residual >= 0.5 * least
        if residual == 0.0 or (residual <= allowance(line, w, ROUNDED) and stalled):
            return residual, True
        least = residual if least < 0.0 else min(least, residual)
        tighten(line, w)
        if line.full:
            turning.solve(line, w, first, last)
        else:
            linear.solve(line, w, first, last)
        correct(line, w, first, last, 0.0, 0.0, step_length(line, w, first, last))
        shift = min(max(residual / allowance(line, w, 1.0) * LARGEST_SHIFT, LEAST_SHIFT), LARGEST_SHIFT)
    return residual, residual <= allowance(line, w, ROUNDED)


@kernel
def drift(line, w):
    """Mean drag (2) of the current on a segment that lies across it [N], on the straight line; its speed [m/s]."""
    qx, qy, fastest = 0.0, 0.0, 0.0
    sample(line, w, line.t, False)
    for i in range(line.n):
        k, d = line.water + WATER * i, part(line, i).drag_n
        for node in range(k, k + 2 * WATER, WATER):
            speed = sqrt(w[node] * w[node] + w[node + 1] * w[node + 1])
            qx += d * speed * w[node] / line.n
            qy += d * speed * w[node + 1] / line.n
            fastest = max(fastest, speed)
    return qx, qy, fastest


@kernel
def straighten(line, w):
    """Put the nodes on the straight line between the ends; from a held end down where the other is free."""
    a, b = Q, line.n * SCRATCH + Q
    for i in range(1, line.n):
        for c in range(3):
            w[i * SCRATCH + Q + c] = w[a + c] + (w[b + c] - w[a + c]) * i / line.n
    if line.end_a == FREE or line.end_b == FREE:
        held = b if line.end_a == FREE else a
        for i in range(line.n + 1):
            far = line.n - i if line.end_a == FREE else i
            for c in range(3):
                w[i * SCRATCH + Q + c] = w[held + c]
            w[i * SCRATCH + Q + 2] += far * line.l0


@kernel
def open_folds(line, w):
    """Lay level what the first guess squeezes to a point, the middle of a line with both ends in one place.

    In a line that takes compression it would stay there: a point has no direction in which to push.
    """
    for i in range(1, line.n - 1):
        b, l0 = i * SCRATCH, part(line, i).l0
        o = b + SCRATCH
        x, y, z = w[o + Q] - w[b + Q], w[o + Q + 1] - w[b + Q + 1], w[o + Q + 2] - w[b + Q + 2]
        if sqrt(x * x + y * y + z * z) < SQUEEZED * l0:
            w[b + Q] -= 0.5 * l0
            w[o + Q] += 0.5 * l0
            w[b + T] = 0.0


@kernel
def equilibrium(line, w):
    """Bring all nodes to rest in static equilibrium with the current; the held ends' positions are in w.

    Returns the largest imbalance [N] and whether that is at rounding level.
    """
    a, b = Q, line.n * SCRATCH + Q
    ax, ay, az, bx, by, bz = w[a], w[a + 1], w[a + 2], w[b], w[b + 1], w[b + 2]
    for i in range(line.n + 1):
        for c in range(STATE):
            w[i * SCRATCH + c] = 0.0
    w[a], w[a + 1], w[a + 2], w[b], w[b + 1], w[b + 2] = ax, ay, az, bx, by, bz
    qx, qy, speed = 0.0, 0.0, 0.0
    if line.anchors:
        seabed.loosen(line, w)
    if line.water:
        straighten(line, w)
        qx, qy, speed = drift(line, w)
    if first_unknown(line) == 1 and last_unknown(line) == line.n - 1:
        fx, fy, fz, slack = first_tension(line, bx - ax, by - ay, bz - az, qx, qy)
        lay_out(line, w, fx, fy, fz, slack, qx, qy)
        w[b], w[b + 1], w[b + 2] = bx, by, bz
    else:
        fx, fy, fz = hanging_tension(line, qx, qy)
        lay_out(line, w, fx, fy, fz, 0.0, qx, qy)
    if line.bed and below_bed(line, w):
        size = sqrt(qx * qx + qy * qy)
        north, east = (qx / size, qy / size) if size > 0.0 else (1.0, 0.0)
        lay_on_bed(line, w, abs(hung(line, line.n)), north, east)
    if not line.tension_only:
        open_folds(line, w)
    if speed > 0.0:
        go_with(line, w, speed)
    residual, settled = settle(line, w)
    if line.anchors:
        seabed.drag_anchors(line, w)
    return residual, settled
