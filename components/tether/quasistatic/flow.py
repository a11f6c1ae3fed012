"""The flow past a node: the current at its depth less the line's own steady velocity."""

from components.compiled import kernel
from components.tether.quasistatic.line import (
    A_POSITION,
    A_VELOCITY,
    B_ACCELERATION,
    B_POSITION,
    B_VELOCITY,
    FREE,
    HAS_CURRENT,
    POINTS,
    PROFILE,
)


@kernel
def current(p, z):
    """Current at depth z [m] and its derivative to z: linear between the table's depths, constant beyond them."""
    count = int(p[POINTS])
    if count == 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    last = PROFILE + 4 * (count - 1)
    row = PROFILE
    while row < last and p[row + 4] <= z:
        row += 4
    if row == last or z <= p[PROFILE]:
        return p[row + 1], p[row + 2], p[row + 3], 0.0, 0.0, 0.0
    per = 1.0 / (p[row + 4] - p[row])
    gx, gy, gz = (p[row + 5] - p[row + 1]) * per, (p[row + 6] - p[row + 2]) * per, (p[row + 7] - p[row + 3]) * per
    h = z - p[row]
    return p[row + 1] + h * gx, p[row + 2] + h * gy, p[row + 3] + h * gz, gx, gy, gz


@kernel
def flow(p, u, share, z):
    """Flow [m/s] past the node at this share of the length and z below end a, and its derivative to z.

    The line moves with its ends, in between by shares; a line with a free end moves with end a.
    """
    ux, uy, uz, gx, gy, gz = current(p, u[A_POSITION + 2] + z)
    free = p[FREE] > 0.0
    b = A_VELOCITY if free else B_VELOCITY
    if p[HAS_CURRENT] > 0.0:
        at = B_POSITION if free else B_ACCELERATION + 3
        ux, uy, uz = ux + u[at], uy + u[at + 1], uz + u[at + 2]
    back = 1.0 - share
    return (
        ux - back * u[A_VELOCITY] - share * u[b],
        uy - back * u[A_VELOCITY + 1] - share * u[b + 1],
        uz - back * u[A_VELOCITY + 2] - share * u[b + 2],
        gx,
        gy,
        gz,
    )
