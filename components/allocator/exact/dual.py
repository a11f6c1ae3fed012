"""The dual of an allocation over convex sets: three prices, one each of surge, sway and yaw, found by Newton's method.

Primal: minimise k sum a_i |f_i|^(3/2) + |W (B f - tau)|^2 / 2 over f_i in convex sets, or, with r = 0, under B f = tau.
Dual: minimise psi(lambda) = sum phi_i(B_i' lambda) + sum r_j lambda_j^2 / 2 - lambda . tau, with r_j = 1 / W_j^2; phi_i
and its derivatives are `response`'s. psi is convex with a continuous gradient B f + r lambda - tau and a Hessian that
jumps only where a thruster saturates or comes to an edge: a semismooth Newton method with a line search (Qi and Sun
1993, Mathematical Programming 58). Switchboards with limited power weigh k for their own thrusters: see boards.
"""

from components.allocator.exact.boards import CX, CY, CZ, WEIGHT, D, weigh_all
from components.allocator.exact.response import BOARD, X, Y, response
from components.compiled import kernel

CONVERGED, STUCK, FAR, LONG = range(4)
HALVINGS = 40
NEAR = 1e-10  # of the demand: a gradient below it that Newton's step does not halve is one of rounding
EVER = 1e9
SAME = 1e-12  # of psi and its linear part: values nearer than this are the same, and the gradient tells


@kernel
def solve(xx, xy, xz, yy, yz, zz, bx, by, bz):
    """Solution of a symmetric 3x3 system, by LDL'."""
    l1, l2 = xy / xx, xz / xx
    d1, c = yy - l1 * xy, yz - l1 * xz
    l3 = c / d1
    d2 = zz - l2 * xz - l3 * c
    by = by - l1 * bx
    z = (bz - l2 * bx - l3 * by) / d2
    y = by / d1 - l3 * z
    return bx / xx - l1 * y - l2 * z, y, z


@kernel
def weight_of(sets, i, k, boards):
    """Of thruster i's power."""
    if boards.shape[0] > 0 and sets[i, BOARD] >= 0.0:
        return boards[int(sets[i, BOARD]), WEIGHT]
    return k


@kernel
def evaluate(sets, tau, k, r, price, f, boards):
    """psi, its gradient (3) and its Hessian (xx, xy, xz, yy, yz, zz); the forces go to f (n, 2)."""
    lx, ly, lz = price[0], price[1], price[2]
    added = weigh_all(sets, k, lx, ly, lz, boards) if boards.shape[0] > 0 else 0.0
    psi = 0.5 * (r[0] * lx * lx + r[1] * ly * ly + r[2] * lz * lz) - lx * tau[0] - ly * tau[1] - lz * tau[2]
    gx, gy, gz = r[0] * lx - tau[0], r[1] * ly - tau[1], r[2] * lz - tau[2]
    xx, yy, zz, xy, xz, yz = r[0], r[1], r[2], 0.0, 0.0, 0.0
    for i in range(f.shape[0]):
        x, y = sets[i, X], sets[i, Y]
        fx, fy, hxx, hxy, hyy, _, phi = response(sets, i, lx - y * lz, ly + x * lz, weight_of(sets, i, k, boards))
        f[i, 0], f[i, 1] = fx, fy
        psi += phi
        gx += fx
        gy += fy
        gz += x * fy - y * fx
        tx, ty = x * hxy - y * hxx, x * hyy - y * hxy
        xx += hxx
        xy += hxy
        yy += hyy
        xz += tx
        yz += ty
        zz += x * ty - y * tx
    for b in range(boards.shape[0]):
        if boards[b, WEIGHT] > k and boards[b, D] > 0.0:
            cx, cy, cz, d = boards[b, CX], boards[b, CY], boards[b, CZ], boards[b, D]
            xx -= cx * cx / d
            xy -= cx * cy / d
            xz -= cx * cz / d
            yy -= cy * cy / d
            yz -= cy * cz / d
            zz -= cz * cz / d
    return psi + added, gx, gy, gz, xx, xy, xz, yy, yz, zz


@kernel
def largest(a, b, c):
    """Of three absolute values."""
    return max(abs(a), abs(b), abs(c))


@kernel
def direction(gx, gy, gz, xx, xy, xz, yy, yz, zz):
    """Newton's step; with the Hessian made definite where it is not."""
    trace, size = xx + yy + zz, largest(gx, gy, gz)
    shift = 1e-15 * trace
    for _ in range(4):
        dx, dy, dz = solve(xx + shift, xy, xz, yy + shift, yz, zz + shift, -gx, -gy, -gz)
        if dx * gx + dy * gy + dz * gz < 0.0:
            return dx, dy, dz
        shift = max(1e4 * shift, 1e-6 * (trace + size))
    return -gx, -gy, -gz


@kernel
def rounding(sets, f):
    """Of a sum of forces and moments of this size."""
    total = 0.0
    for i in range(f.shape[0]):
        total += (abs(f[i, 0]) + abs(f[i, 1])) * (1.0 + abs(sets[i, X]) + abs(sets[i, Y]))
    return 4e-16 * total


@kernel
def is_beyond(price, tau, gx, gy, gz, xx, xy, xz, yy, yz, zz):
    """Whether psi falls along the prices as they are, and bends so little that its least is EVER times as far.

    There all thrusters are at their limits or their boards', and the demand is farther than they reach.
    """
    x, y, z = price[0], price[1], price[2]
    slope = x * gx + y * gy + z * gz
    bend = x * (xx * x + 2.0 * (xy * y + xz * z)) + y * (yy * y + 2.0 * yz * z) + zz * z * z
    return slope < -NEAR * largest(x, y, z) * largest(tau[0], tau[1], tau[2]) and bend <= -slope / EVER


@kernel
def newton(sets, tau, k, r, price, trial, f, boards, tolerance, far, most):
    """Minimise psi from `price` on; CONVERGED where no component of the gradient is above the tolerance.

    STUCK: no step is downhill in float64. FAR: a price went beyond `far`, or would. LONG: not in `most` steps.
    """
    psi, gx, gy, gz, xx, xy, xz, yy, yz, zz = evaluate(sets, tau, k, r, price, f, boards)
    near = NEAR * largest(tau[0], tau[1], tau[2])
    for _ in range(most):
        size = largest(gx, gy, gz)
        if size <= tolerance or (size <= near and size <= rounding(sets, f)):
            return CONVERGED
        if far < 1e300 and is_beyond(price, tau, gx, gy, gz, xx, xy, xz, yy, yz, zz):
            return FAR
        dx, dy, dz = direction(gx, gy, gz, xx, xy, xz, yy, yz, zz)
        slope, reach, before, is_down = dx * gx + dy * gy + dz * gz, 1.0, psi, False
        alike = psi + SAME * (abs(psi) + largest(price[0], price[1], price[2]) * largest(tau[0], tau[1], tau[2]))
        for _ in range(HALVINGS):
            trial[0], trial[1], trial[2] = price[0] + reach * dx, price[1] + reach * dy, price[2] + reach * dz
            psi, gx, gy, gz, xx, xy, xz, yy, yz, zz = evaluate(sets, tau, k, r, trial, f, boards)
            is_down = psi <= before + 1e-4 * reach * slope or (psi <= alike and largest(gx, gy, gz) < 0.5 * size)
            if is_down:
                break
            reach *= 0.5
        if not is_down:
            evaluate(sets, tau, k, r, price, f, boards)
            return CONVERGED if size <= near or size <= 10.0 * rounding(sets, f) else STUCK
        price[0], price[1], price[2] = trial[0], trial[1], trial[2]
        if size <= near and largest(gx, gy, gz) >= 0.5 * size:
            return CONVERGED
        if largest(price[0], price[1], price[2]) > far:
            return FAR
    return LONG
