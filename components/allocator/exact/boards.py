"""Switchboards with limited power, in the dual of an allocation: each weighs its thrusters' power by one number more.

Under sum P_i <= S_b over the thrusters of board b the dual has a weight kappa_b >= k of that power in place of k:
psi = sum phi_i(v_i; kappa_b) + sum (kappa_b - k) S_b + ... (dual.py), convex in the prices and the weights together.
For given prices the least over kappa_b has one unknown: the root of P_b(kappa_b) = S_b, or k where P_b(k) <= S_b. It is
taken out so, and the search keeps its three unknowns. The response depends on v / kappa only, so that with
c_b = sum B_i' H_i v_i and d_b = sum v_i' H_i v_i, H_i = d f_i / d v_i, the Hessian loses c_b c_b' / d_b.
"""

from math import inf, sqrt

from components.allocator.exact.response import (
    A_REVERSE,
    BOARD,
    E0X,
    E0Y,
    E1X,
    E1Y,
    KIND,
    LEAST,
    LINE,
    MOST,
    MOST_REVERSE,
    NOTHING,
    SLICE,
    UNFED,
    A,
    X,
    Y,
    coefficient,
    response,
)
from components.compiled import kernel

# Columns of a table of boards: power it may give, weight of its thrusters' power, size of the prices at which that was
# found, c (3) and d.
SPARE, WEIGHT, SIZE, CX, CY, CZ, D, COLUMNS = range(8)
STEPS = 60  # for a weight: a root of a function in pieces, most of which are straight, takes one or two
PRECISE = 4e-15  # of the spare power, to which it is drawn
IDLE = 1e-15  # of all thrusters' power: less than this above the least is no power to allocate


@kernel
def draw(sets, b, lx, ly, lz, weight, boards):
    """Power that board b's thrusters draw at these prices and this weight; c and d go to its row."""
    power = cx = cy = cz = d = 0.0
    for i in range(sets.shape[0]):
        if sets[i, BOARD] == b:
            x, y = sets[i, X], sets[i, Y]
            vx, vy = lx - y * lz, ly + x * lz
            _, _, hxx, hxy, hyy, own, _ = response(sets, i, vx, vy, weight)
            hx, hy = hxx * vx + hxy * vy, hxy * vx + hyy * vy
            power += own
            cx += hx
            cy += hy
            cz += x * hy - y * hx
            d += vx * hx + vy * hy
    boards[b, CX], boards[b, CY], boards[b, CZ], boards[b, D] = cx, cy, cz, d
    return power


@kernel
def weigh(sets, b, lx, ly, lz, k, boards):
    """Find the weight of board b's power at these prices, from that in its row on, grown like the prices have.

    In z = kappa^-3 the power of a thruster is a straight line up to its largest, so that Newton's method is exact in
    each piece; a bracket of the root holds it where it is not (SLICE, and thrusters all at their limits).
    """
    size, spare = max(abs(lx), abs(ly), abs(lz)), boards[b, SPARE]
    weight = max(boards[b, WEIGHT] * size / boards[b, SIZE], k) if boards[b, SIZE] > 0.0 else k
    low, high, last = 0.0, inf, k**-3.0
    for _ in range(STEPS):
        excess = draw(sets, b, lx, ly, lz, weight, boards) - spare
        if (excess <= 0.0 and weight <= k) or abs(excess) <= PRECISE * spare:
            break
        z = weight**-3.0
        slope = boards[b, D] * weight * weight / 3.0
        low, high = (low, z) if excess > 0.0 else (z, high)
        found = z - excess / slope if slope > 0.0 else inf
        if not low < found < high:
            found = inf if high == inf else 1e-3 * high if low == 0.0 else sqrt(low * high)
        if found == z:
            break
        weight = k if found >= last else found ** (-1.0 / 3.0)
    boards[b, WEIGHT], boards[b, SIZE] = weight, size
    return weight


@kernel
def weigh_all(sets, k, lx, ly, lz, boards):
    """Find the weights at these prices; what they add to psi."""
    added = 0.0
    for b in range(boards.shape[0]):
        weight = weigh(sets, b, lx, ly, lz, k, boards)
        if weight > k:
            added += (weight - k) * boards[b, SPARE]
    return added


@kernel
def start(boards):
    """Let the weights be found anew."""
    for b in range(boards.shape[0]):
        boards[b, WEIGHT] = boards[b, SIZE] = 0.0


@kernel
def are_exceeded(sets, f, boards):
    """Whether the forces f (n, 2) draw more from a board than it has."""
    for b in range(boards.shape[0]):
        power = 0.0
        for i in range(f.shape[0]):
            if sets[i, BOARD] == b:
                T = sqrt(f[i, 0] * f[i, 0] + f[i, 1] * f[i, 1])
                power += coefficient(sets, i, f[i, 0], f[i, 1]) * T * sqrt(T)
        if power > boards[b, SPARE]:
            return True
    return False


@kernel
def least_thrust(sets, i):
    """Of row i, signed for a LINE: a rate may keep it from giving none."""
    if sets[i, KIND] == LINE:
        return min(max(0.0, -sets[i, MOST_REVERSE]), sets[i, MOST])
    return sets[i, LEAST] if sets[i, KIND] == SLICE else 0.0


@kernel
def pin(sets, boards):
    """Let thrusters give the least thrust they can where their board has no more than that takes.

    The rates of thrust are the thrusters' own: power then falls as fast as they let it.
    """
    for b in range(boards.shape[0]):
        least = 0.0
        for i in range(sets.shape[0]):
            if sets[i, BOARD] == b:
                T = least_thrust(sets, i)
                is_reverse = sets[i, KIND] == LINE and T < 0.0
                least += (sets[i, A_REVERSE] if is_reverse else sets[i, A]) * abs(T) * sqrt(abs(T))
        if boards[b, SPARE] - least <= IDLE:
            for i in range(sets.shape[0]):
                if sets[i, BOARD] == b:
                    hold(sets, i, least_thrust(sets, i))


@kernel
def hold(sets, i, thrust):
    """Row i becomes this thrust alone, and is fed by no board that could be asked for less."""
    if sets[i, KIND] == SLICE:
        sets[i, E1X], sets[i, E1Y] = sets[i, E0X], sets[i, E0Y]
    sets[i, KIND] = NOTHING if thrust == 0.0 else LINE
    sets[i, MOST], sets[i, MOST_REVERSE] = thrust, -thrust
    sets[i, BOARD] = UNFED
