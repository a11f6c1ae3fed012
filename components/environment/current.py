"""A steady current over depth: linear between given levels, constant above the first and below the last."""

from components.compiled import kernel

LEVEL = 4  # numbers of a level: depth [m], velocity (3) [m/s], NED


@kernel
def current(table, at, depth):
    """Velocity (3) [m/s], NED, at a depth [m] below the mean surface.

    table[at]: number of levels; then the levels by increasing depth.
    """
    count = int(table[at])
    k = at + 1
    if depth <= table[k]:
        return table[k + 1], table[k + 2], table[k + 3]
    for _ in range(count - 1):
        below = k + LEVEL
        if depth < table[below]:
            s = (depth - table[k]) / (table[below] - table[k])
            return (
                table[k + 1] + s * (table[below + 1] - table[k + 1]),
                table[k + 2] + s * (table[below + 2] - table[k + 2]),
                table[k + 3] + s * (table[below + 3] - table[k + 3]),
            )
        k = below
    return table[k + 1], table[k + 2], table[k + 3]
