"""An allocation over convex sets: the demand met at the least power, or, where it cannot be, missed by the least.

Worst case: 21 searches of 60 steps of Newton's method, each with 40 halvings at most, and in every one of these 60
trials of each board's weight. A step of the component takes `most_nodes` such problems at most, twice that with boards
at their limits.
"""

from math import sqrt

from components.allocator.exact.boards import CX, CY, CZ, WEIGHT, D, are_exceeded, pin, start
from components.allocator.exact.dual import CONVERGED, direction, evaluate, largest, newton, solve, weight_of
from components.allocator.exact.response import BOARD, X, Y, response
from components.compiled import kernel

# All forces are in units of the sum of largest thrusts, powers of that of largest powers: numbers of order one.
EXACT = 2e-16  # of the demand, to which it is met
FAR = 1e6  # a price of thrust that no feasible demand but one at the very border has
FIRST, FACTOR, LAST = 0.1, 0.1, 1e-17  # weight of power against the miss
MET = 1e-9  # a miss below this is none
SURE, SMALL = 1e-7, 1e-2  # by what part of the miss the weight of power may change it, and of how small a one
STEPS = 60


@kernel
def allocate_with_boards(sets, tau, misses, price, trial, f, boards):
    """`allocate` without the limits of boards, which is the optimum where it keeps them; else with them."""
    miss = allocate(sets, tau, misses, price, trial, f, boards[:0], True)
    if not are_exceeded(sets, f, boards):
        return miss
    pin(sets, boards)
    return allocate(sets, tau, misses, price, trial, f, boards, miss == 0.0)


@kernel
def allocate(sets, tau, misses, price, trial, f, boards, may_be_met):
    """Forces f (n, 2) and the weighted miss |W (B f - tau)|, 0 where the demand is met.

    price (3): a start, and the result. misses: (3,) 1 / W^2. The least miss comes first, and the least power among
    those. trial: (9,) scratch. boards: rows of boards.py, none where their power does not matter. may_be_met: False
    where it is known that the demand cannot be met.
    """
    start(boards)
    trial[3] = trial[4] = trial[5] = 0.0
    none, precise = trial[3:6], EXACT * largest(tau[0], tau[1], tau[2])
    if may_be_met and newton(sets, tau, 1.0, none, price, trial, f, boards, precise, FAR, STEPS) == CONVERGED:
        polish(sets, tau, 1.0, none, price, f, boards)
        return 0.0
    miss, k = soften(sets, tau, misses, price, trial, f, boards)
    if miss > MET:
        return miss
    for j in range(3):
        trial[6 + j] = price[j]
        price[j] /= k
    if newton(sets, tau, 1.0, none, price, trial, f, boards, precise, 1e12, STEPS) == CONVERGED:
        polish(sets, tau, 1.0, none, price, f, boards)
        return 0.0
    newton(sets, tau, k, misses, trial[6:9], trial, f, boards, 1e-13, 1e300, STEPS)
    return miss


@kernel
def polish(sets, tau, k, r, price, f, boards):
    """Take from the forces what is left of the balance, which the rounding of prices does not allow to be zero.

    Along a step of the prices the weight of a board at its limit changes by c . step / d of itself, so that its
    thrusters' powers keep their sum.
    """
    _, gx, gy, gz, xx, xy, xz, yy, yz, zz = evaluate(sets, tau, k, r, price, f, boards)
    dx, dy, dz = direction(gx, gy, gz, xx, xy, xz, yy, yz, zz)
    for i in range(f.shape[0]):
        x, y = sets[i, X], sets[i, Y]
        vx, vy, weight = price[0] - y * price[2], price[1] + x * price[2], weight_of(sets, i, k, boards)
        _, _, hxx, hxy, hyy, _, _ = response(sets, i, vx, vy, weight)
        part = weighed(sets, i, k, boards, dx, dy, dz)
        vx, vy = dx - y * dz - part * vx, dy + x * dz - part * vy
        f[i, 0] += hxx * vx + hxy * vy
        f[i, 1] += hxy * vx + hyy * vy


@kernel
def weighed(sets, i, k, boards, dx, dy, dz):
    """By what part the weight of thruster i's power changes with a step of the prices."""
    if boards.shape[0] == 0 or sets[i, BOARD] < 0.0:
        return 0.0
    b = int(sets[i, BOARD])
    is_active = boards[b, WEIGHT] > k and boards[b, D] > 0.0
    return (boards[b, CX] * dx + boards[b, CY] * dy + boards[b, CZ] * dz) / boards[b, D] if is_active else 0.0


@kernel
def soften(sets, tau, misses, price, trial, f, boards):
    """The demand as a wish: the miss and the weight of power at which it is the least one; price: of the miss.

    The weight k of power goes down until it can change the miss R by no more than SURE: of the optima of
    k P + R^2 / 2 at k and at 0, R_k^2 - R_0^2 <= 2 k (P_0 - P_k) <= 2 k, so that R_k - R_0 <= k / R_k.
    """
    for j in range(3):
        price[j] = tau[j] / misses[j] * 1e-3
    k, miss = FIRST, 0.0
    while True:
        newton(sets, tau, k, misses, price, trial, f, boards, max(1e-3 * miss, precision(miss, k)), 1e300, STEPS)
        miss = sqrt(misses[0] * price[0] ** 2 + misses[1] * price[1] ** 2 + misses[2] * price[2] ** 2)
        if k <= SURE * miss * max(miss, SMALL) or miss < MET or k <= LAST:
            newton(sets, tau, k, misses, price, trial, f, boards, precision(miss, k), 1e300, STEPS)
            return missed(sets, tau, misses, f), k
        follow(sets, tau, misses, price, f, boards, k, (FACTOR - 1.0) * k)
        k *= FACTOR


@kernel
def precision(miss, k):
    """To which the gradient can be brought: prices are of the miss's size, and the response has a slope of 1 / k."""
    return 1e-13 + 1e-15 * miss / k


@kernel
def missed(sets, tau, misses, f):
    """|W (B f - tau)|."""
    rx, ry, rz = -tau[0], -tau[1], -tau[2]
    for i in range(f.shape[0]):
        rx += f[i, 0]
        ry += f[i, 1]
        rz += sets[i, X] * f[i, 1] - sets[i, Y] * f[i, 0]
    return sqrt(rx * rx / misses[0] + ry * ry / misses[1] + rz * rz / misses[2])


@kernel
def follow(sets, tau, r, price, f, boards, k, change):
    """Take the price at the optimum for k along to that for k + change, to first order.

    The response depends on v / k only, so that d f / d k = -(d f / d v) v / k, and with the Hessian H of psi and
    R = diag(r): d lambda / d k = (lambda - H^-1 R lambda) / k. It holds with boards at their limit too, whose part of
    the Hessian times lambda is nothing: prices and weight grown alike leave the forces as they are.
    """
    _, _, _, _, xx, xy, xz, yy, yz, zz = evaluate(sets, tau, k, r, price, f, boards)
    dx, dy, dz = solve(xx, xy, xz, yy, yz, zz, r[0] * price[0], r[1] * price[1], r[2] * price[2])
    part = change / k
    price[0] += part * (price[0] - dx)
    price[1] += part * (price[1] - dy)
    price[2] += part * (price[2] - dz)
