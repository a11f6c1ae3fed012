"""Static equilibrium of the discrete line: its end force by a convex search, its nodes by a damped Newton iteration."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable import block_tridiagonal
from components.tether.cable.balance import allowance, assemble, imbalance
from components.tether.cable.block_tridiagonal import backsolve, factor
from components.tether.cable.dynamics import correct, step_length
from components.tether.cable.line import FREE, SCRATCH, STATE, Q, T, first_unknown, last_unknown

# Below this fraction of the line's weight a segment counts as slack: the kink of |T| at T = 0 is rounded over it.
SLACK = 1e-9
# The convex search ends when the far end is met to this fraction of the length; the Newton iteration does the rest.
GAP, COARSE_GAP = 1e-10, 1e-3
SEARCH_ITERATIONS, NEWTON_ITERATIONS = 300, 200
# Pseudo-time continuation: the pseudo-stiffness over the axial one is held between these bounds, in proportion to the
# imbalance; the lower bound keeps nodes between two slack segments from leaving a zero pivot.
LEAST_SHIFT, LARGEST_SHIFT = 1e-14, 1e-4
# An iteration that no longer gains has come to rounding if the imbalance is below this fraction of weight and tension.
ROUNDED = 1e-8
# Tension of a weightless free line: only its direction counts [N].
NOTHING = 1e-30


@kernel
def complementary_energy(fx, fy, fz, line, slack, dx, dy, dz):
    """Complementary energy at the first segment's tension vector f, its gradient (3) and its Hessian (6).

    In equilibrium the tension vector of segment j is f - j w (0, 0, 1), w a segment's weight, whatever the shape.
    The energy, sum of l0 sqrt(T_j^2 + slack^2) + T_j^2 / (2 k) less f . d with d the vector between the ends, is
    strictly convex, and its gradient is the sum of the segments' vectors less d (the dual of the potential energy
    of a line that takes tension only).
    """
    flexible = 1.0 / line.k
    energy, gx, gy, gz = -(fx * dx + fy * dy + fz * dz), -dx, -dy, -dz
    hxx, hyy, hzz, hxy, hxz, hyz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(line.n):
        tz = fz - 2.0 * j * line.weight
        square = fx * fx + fy * fy + tz * tz
        size = sqrt(square + slack * slack)
        a = line.l0 / size
        b = a / (size * size)
        a += flexible
        energy += line.l0 * size + 0.5 * flexible * square
        gx, gy, gz = gx + a * fx, gy + a * fy, gz + a * tz
        hxx, hyy, hzz = hxx + a - b * fx * fx, hyy + a - b * fy * fy, hzz + a - b * tz * tz
        hxy, hxz, hyz = hxy - b * fx * fy, hxz - b * fx * tz, hyz - b * fy * tz
    return energy, gx, gy, gz, hxx, hyy, hzz, hxy, hxz, hyz


@kernel
def first_tension(line, dx, dy, dz):
    """Tension vector [N] of the first segment when both ends are held d = (dx, dy, dz) apart, NED [m]; and the slack.

    Newton on the complementary energy with a halving line search. The rounding of the kink is narrowed in steps: at
    once it would leave Newton nothing to follow.
    """
    scale = max(2.0 * line.n * abs(line.weight), SLACK * line.k * line.l0)
    slack = 0.1 * scale
    fx, fy, fz = 0.0, 0.0, line.n * line.weight
    for _ in range(SEARCH_ITERATIONS):
        energy, gx, gy, gz, hxx, hyy, hzz, hxy, hxz, hyz = complementary_energy(fx, fy, fz, line, slack, dx, dy, dz)
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
            trial = complementary_energy(fx - step * px, fy - step * py, fz - step * pz, line, slack, dx, dy, dz)[0]
            if trial <= energy - 1e-4 * step * slope:
                break
            step *= 0.5
        fx, fy, fz = fx - step * px, fy - step * py, fz - step * pz
    return fx, fy, fz, slack


@kernel
def hanging_tension(line):
    """Vertical tension [N] of the first segment of a line with one free end, whose last node weighs half a segment."""
    fz = -line.weight if line.end_a == FREE else (2.0 * line.n - 1.0) * line.weight
    if line.weight == 0.0:
        return -NOTHING if line.end_a == FREE else NOTHING
    return fz


@kernel
def lay_out(line, w, fx, fy, fz, slack):
    """Place the nodes along the tension vectors, from the end that is held; T takes the tensions."""
    for k in range(line.n):
        j = line.n - 1 - k if line.end_a == FREE else k
        tz = fz - 2.0 * j * line.weight
        square = fx * fx + fy * fy + tz * tz
        g = line.l0 / sqrt(square + slack * slack) + 1.0 / line.k
        near, far = j * SCRATCH, (j + 1) * SCRATCH
        if line.end_a == FREE:
            near, far, g = far, near, -g
        w[far + Q] = w[near + Q] + g * fx
        w[far + Q + 1] = w[near + Q + 1] + g * fy
        w[far + Q + 2] = w[near + Q + 2] + g * tz
        w[j * SCRATCH + T] = sqrt(square)


@kernel
def settle(line, w):
    """Newton with pseudo-time continuation from the nodes in w, to rounding: largest imbalance [N], and success."""
    first, last = first_unknown(line), last_unknown(line)
    unit = line.k / (line.mass + line.added_n)
    shift, least = LARGEST_SHIFT, -1.0
    for _ in range(NEWTON_ITERATIONS):
        assemble(line, w, shift * unit, 0.0)
        residual = imbalance(line, w, first, last)
        stalled = least >= 0.0 and residual >= 0.5 * least
        if residual == 0.0 or (residual <= allowance(line, w, ROUNDED) and stalled):
            return residual, True
        least = residual if least < 0.0 else min(least, residual)
        block_tridiagonal.solve(w, first, last)
        correct(line, w, first, last, 0.0, 0.0, step_length(line, w, first, last))
        shift = min(max(residual / allowance(line, w, 1.0) * LARGEST_SHIFT, LEAST_SHIFT), LARGEST_SHIFT)
    return residual, residual <= allowance(line, w, ROUNDED)


@kernel
def equilibrium(line, w):
    """Bring all nodes to rest in static equilibrium; the held ends' positions are in w.

    Returns the largest imbalance [N] and whether that is at rounding level.
    """
    a, b = Q, line.n * SCRATCH + Q
    ax, ay, az, bx, by, bz = w[a], w[a + 1], w[a + 2], w[b], w[b + 1], w[b + 2]
    for i in range(line.n + 1):
        for c in range(STATE):
            w[i * SCRATCH + c] = 0.0
    w[a], w[a + 1], w[a + 2], w[b], w[b + 1], w[b + 2] = ax, ay, az, bx, by, bz
    if first_unknown(line) == 1 and last_unknown(line) == line.n - 1:
        fx, fy, fz, slack = first_tension(line, bx - ax, by - ay, bz - az)
        lay_out(line, w, fx, fy, fz, slack)
        w[b], w[b + 1], w[b + 2] = bx, by, bz
    else:
        lay_out(line, w, 0.0, 0.0, hanging_tension(line), 0.0)
    return settle(line, w)
