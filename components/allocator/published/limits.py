"""The loop over limits of van Daalen et al. 2011 as printed: rows are added for thrusters beyond them, never removed.

Eqs. 23 to 28. A row fixes only the projection of a thruster's force on the direction that it had (24, 27), so that the
force may still be longer than the largest thrust, or lie in a zone; nothing tests the multipliers' signs. That is the
method, not a slip here. Of the iterates the one with the best yaw moment is kept where the demand cannot be met.
"""

from math import atan2, cos, hypot, pi, sin

from components.allocator.lagrange import MOST, MX, MY, THRUSTER, VALUE, X, Y, least_quadratic
from components.compiled import kernel

# A table of forbidden zones has the rows: thruster, first azimuth, width [rad].
SLACK = 1e-9  # by which a thrust may be over its limit, or an azimuth in a zone [rad], and count as within


@kernel
def zone_of(zones, i, azimuth):
    """The row of the zone that has thruster i's azimuth inside; -1 where none has."""
    for z in range(zones.shape[0]):
        into = (azimuth - zones[z, 1]) % (2.0 * pi)
        if zones[z, 0] == float(i) and SLACK < into < zones[z, 2] - SLACK:
            return z
    return -1


@kernel
def edge_of(zones, z, azimuth, before):
    """The zone's edge nearer to the azimuth, or the one on which the thruster was a step before."""
    low, high = zones[z, 1], zones[z, 1] + zones[z, 2]
    for edge in (low, high):
        if abs((before - edge + pi) % (2.0 * pi) - pi) < 1e-6:
            return edge
    return low if (azimuth - low) % (2.0 * pi) < 0.5 * zones[z, 2] else high


@kernel
def limit(table, zones, rows, count, x, f):
    """Add a row for each thruster that has none and is beyond a limit; how many rows there are then."""
    for i in range(f.shape[0]):
        if has_row(rows, count, i):
            continue
        T, azimuth = hypot(f[i, 0], f[i, 1]), atan2(f[i, 1], f[i, 0])
        most = table[i, MOST]
        z = zone_of(zones, i, azimuth) if T > 0.0 else -1
        if z >= 0:
            edge = edge_of(zones, z, azimuth, x[i])
            mx, my, value = cos(edge), sin(edge), min(T, most)
        elif most * (1.0 + SLACK) < T:
            mx, my, value = f[i, 0] / T, f[i, 1] / T, most
        else:
            continue
        rows[count, THRUSTER], rows[count, MX], rows[count, MY], rows[count, VALUE] = float(i), mx, my, value
        count += 1
    return count


@kernel
def has_row(rows, count, i):
    """Whether thruster i is in the set J."""
    found = False
    for c in range(count):
        found = found or rows[c, THRUSTER] == float(i)
    return found


@kernel
def yaw_miss(table, tau, f):
    """|M_z - that required| of the forces cut to what the thrusters have."""
    moment = -tau[2]
    for i in range(f.shape[0]):
        T = hypot(f[i, 0], f[i, 1])
        part = min(1.0, table[i, MOST] / T) if T > 0.0 else 1.0
        moment += part * (table[i, X] * f[i, 1] - table[i, Y] * f[i, 0])
    return abs(moment)


@kernel
def loop(table, zones, rows, tau, x, inverse, free, S, b, f, best):
    """Forces f (n, 2) of the last iterate that could be solved for; (rows, whether the loop came to its end)."""
    if not least_quadratic(table, rows, 0, tau, inverse, free, S, b, f):
        for i in range(f.shape[0]):
            f[i, 0] = f[i, 1] = 0.0
        return 0, False
    count, least = 0, yaw_miss(table, tau, f)
    copy(f, best)
    while True:
        more = limit(table, zones, rows, count, x, f)
        if more == count:
            return count, True
        if not least_quadratic(table, rows, more, tau, inverse, free, S, b, f):
            copy(best, f)
            return count, False
        count = more
        miss = yaw_miss(table, tau, f)
        if miss <= least:
            least = miss
            copy(f, best)


@kernel
def copy(source, target):
    """Forces from one table to another."""
    for i in range(source.shape[0]):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]
