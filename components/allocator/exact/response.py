"""What one thruster gives for a price on its force: the force f that maximises v . f - k a |f|^(3/2) in a convex set.

v is what a unit of force is worth in each direction, a |f|^(3/2) the power in bollard pull (van Daalen et al. 2011,
eqs. 4 and 5, m = 3/2), k the weight of power. The maximum is the convex conjugate of the power; its gradient in v is
the force, its Hessian how the force follows v.
"""

from math import inf, sqrt

from components.compiled import kernel

# What a row of a table of convex sets says. Two directions e1, e2 (clockwise from e1 to e2, at most half a turn apart).
# a: coefficient of power, forward and, for a LINE, in reverse; X, Y: position of the thruster.
# DISC: |f| <= MOST. SECTOR: of it between e1 and e2. LINE: along e1, from -MOST_REVERSE to MOST, either of which may be
# negative. SLICE: a SECTOR, less than half a turn, of which f . e0 >= LEAST. BOARD: the switchboard, or UNFED.
KIND, E1X, E1Y, E2X, E2Y, MOST, A, MOST_REVERSE, A_REVERSE, X, Y, E0X, E0Y, LEAST, BOARD, SET = range(16)
NOTHING, DISC, SECTOR, LINE, SLICE = 0.0, 1.0, 2.0, 3.0, 4.0
UNFED = -1.0  # by any switchboard whose power is limited


@kernel
def magnitude(s, most, ka):
    """The thrust T in [0, most] that maximises s T - ka T^(3/2), and dT/ds."""
    root = s / (1.5 * ka)
    T = root * root
    if most > T:
        return T, 2.0 * root / (1.5 * ka)
    return most, 0.0


@kernel
def along(s, ex, ey, most, a, k):
    """Response along the direction e only: force, Hessian (xx, xy, yy), power, conjugate."""
    if s <= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    T, slope = magnitude(s, most, k * a)
    power = a * T * sqrt(T)
    return T * ex, T * ey, slope * ex * ex, slope * ex * ey, slope * ey * ey, power, s * T - k * power


@kernel
def around(vx, vy, most, a, k):
    """Response in any direction: that of v itself; force, Hessian, power, conjugate."""
    s = sqrt(vx * vx + vy * vy)
    if s == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ex, ey = vx / s, vy / s
    T, slope = magnitude(s, most, k * a)
    power, turn = a * T * sqrt(T), T / s
    xx, xy, yy = slope * ex * ex + turn * ey * ey, (slope - turn) * ex * ey, slope * ey * ey + turn * ex * ex
    return T * ex, T * ey, xx, xy, yy, power, s * T - k * power


@kernel
def is_between(vx, vy, e1x, e1y, e2x, e2y):
    """Whether v lies in the cone from e1 clockwise to e2 (y starboard, so clockwise is from x to y)."""
    return e1x * vy - e1y * vx >= 0.0 and vx * e2y - vy * e2x >= 0.0


@kernel
def both_ways(s, ex, ey, most, a, most_reverse, a_reverse, k):
    """Response along the line of e, backwards where s = v . e is negative, within [-most_reverse, most]."""
    sign = 1.0 if s > 0.0 else -1.0
    T, slope = magnitude(abs(s), inf, k * (a if s > 0.0 else a_reverse))
    f = sign * T
    if f > most or f < -most_reverse:
        f, slope = min(max(f, -most_reverse), most), 0.0
    T = abs(f)
    power = (a if f > 0.0 else a_reverse) * T * sqrt(T)
    return f * ex, f * ey, slope * ex * ex, slope * ex * ey, slope * ey * ey, power, s * f - k * power


@kernel
def within(sets, i, vx, vy, k):
    """Response in the sector of row i: around where v points into it, else along the edge nearer to v."""
    e1x, e1y, e2x, e2y = sets[i, E1X], sets[i, E1Y], sets[i, E2X], sets[i, E2Y]
    if is_between(vx, vy, e1x, e1y, e2x, e2y):
        return around(vx, vy, sets[i, MOST], sets[i, A], k)
    s1, s2 = vx * e1x + vy * e1y, vx * e2x + vy * e2y
    if s2 > s1:
        return along(s2, e2x, e2y, sets[i, MOST], sets[i, A], k)
    return along(s1, e1x, e1y, sets[i, MOST], sets[i, A], k)


@kernel
def across(sets, i, vx, vy, k):
    """Response on the line f . e0 = LEAST inside the sector of row i, at f = LEAST e0 + z n.

    d/dz of k a (l^2 + z^2)^(3/4), l = LEAST, is 1.5 k a z (l^2 + z^2)^(-1/4), which with m = (z / l)^2 makes the
    optimum m^2 = g^4 (1 + m), g = v . n / (1.5 k a sqrt(l)).
    """
    ex, ey, least, a = sets[i, E0X], sets[i, E0Y], sets[i, LEAST], sets[i, A]
    nx, ny = -ey, ex
    s = vx * nx + vy * ny
    g = s / (1.5 * k * a * sqrt(least))
    g4 = g * g * g * g
    z = least * sqrt(0.5 * (g4 + sqrt(g4 * (g4 + 4.0))))
    z = z if s > 0.0 else -z
    widest = sqrt(max(sets[i, MOST] * sets[i, MOST] - least * least, 0.0))
    low = max(least * (sets[i, E1X] * nx + sets[i, E1Y] * ny) / (sets[i, E1X] * ex + sets[i, E1Y] * ey), -widest)
    high = min(least * (sets[i, E2X] * nx + sets[i, E2Y] * ny) / (sets[i, E2X] * ex + sets[i, E2Y] * ey), widest)
    is_free = low < z < high
    z = min(max(z, low), high)
    square = least * least + z * z
    root = sqrt(sqrt(square))
    slope = square * root / (1.5 * k * a * (least * least + 0.5 * z * z)) if is_free else 0.0
    fx, fy, power = least * ex + z * nx, least * ey + z * ny, a * root * root * root
    return fx, fy, slope * nx * nx, slope * nx * ny, slope * ny * ny, power, vx * fx + vy * fy - k * power


@kernel
def response(sets, i, vx, vy, k):
    """Of the thruster in row i: force (x, y), Hessian (xx, xy, yy), power, conjugate."""
    kind = sets[i, KIND]
    if kind == DISC:
        return around(vx, vy, sets[i, MOST], sets[i, A], k)
    if kind == SECTOR:
        return within(sets, i, vx, vy, k)
    if kind == LINE:
        ex, ey = sets[i, E1X], sets[i, E1Y]
        most, back = sets[i, MOST], sets[i, MOST_REVERSE]
        return both_ways(vx * ex + vy * ey, ex, ey, most, sets[i, A], back, sets[i, A_REVERSE], k)
    if kind == SLICE:
        found = within(sets, i, vx, vy, k)
        if found[0] * sets[i, E0X] + found[1] * sets[i, E0Y] >= sets[i, LEAST]:
            return found
        return across(sets, i, vx, vy, k)
    return along(0.0, 1.0, 0.0, 0.0, 1.0, k)


@kernel
def coefficient(sets, i, fx, fy):
    """Of the power of the force f in row i."""
    is_reverse = sets[i, KIND] == LINE and fx * sets[i, E1X] + fy * sets[i, E1Y] < 0.0
    return sets[i, A_REVERSE] if is_reverse else sets[i, A]


@kernel
def total_power(sets, f):
    """Of all thrusters at the forces f (n, 2)."""
    total = 0.0
    for i in range(f.shape[0]):
        T = sqrt(f[i, 0] * f[i, 0] + f[i, 1] * f[i, 1])
        total += coefficient(sets, i, f[i, 0], f[i, 1]) * T * sqrt(T)
    return total
