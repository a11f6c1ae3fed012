"""Writes the outputs of the allocators without the exact method from their forces."""

from math import atan2, pi, sqrt

from components.allocator.lagrange import EX, EY, IS_FIXED, MOST, A, X, Y
from components.compiled import kernel


@kernel
def write_commands(table, f, x, y, converged):
    """Outputs of plain.outputs from f (n, 2) [N]; x (n,): the azimuths, which without force stay as they are."""
    n = f.shape[0]
    fx = fy = moment = overload = 0.0
    for i in range(n):
        T = sqrt(f[i, 0] * f[i, 0] + f[i, 1] * f[i, 1])
        y[2 * n + i] = table[i, A] * T * sqrt(T)
        overload = max(overload, T / table[i, MOST])
        if table[i, IS_FIXED] > 0.0:
            x[i] = atan2(table[i, EY], table[i, EX])
            T = f[i, 0] * table[i, EX] + f[i, 1] * table[i, EY]
        elif T > 0.0:
            x[i] += (atan2(f[i, 1], f[i, 0]) - x[i] + pi) % (2.0 * pi) - pi
        y[i], y[n + i] = T, x[i]
        fx += f[i, 0]
        fy += f[i, 1]
        moment += table[i, X] * f[i, 1] - table[i, Y] * f[i, 0]
    y[3 * n], y[3 * n + 1], y[3 * n + 2], y[3 * n + 3], y[3 * n + 4] = fx, fy, moment, converged, overload
