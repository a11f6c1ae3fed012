"""Lagrange's equations of an allocation: least cost under the balance of forces and under rows that fix projections.

van Daalen et al. 2011, eqs. 13-15, 19, 24 and 29: the cost's Hessian C is 2x2 blocks, so that the system reduces to
one of 3 multipliers for the balance and one more for each fixed projection. Eq. 13 prints + rho_x - y rho_z, which is
R' rho with the moment's row (-y, x).
"""

from math import sqrt

from components.compiled import kernel

# Columns of a table of thrusters: position, coefficient of power, largest thrust; direction and 1 where it cannot turn.
X, Y, A, MOST, EX, EY, IS_FIXED, WIDTH = range(8)
# Columns of a table of rows: thruster, direction (2), value of the projection.
THRUSTER, MX, MY, VALUE, ROW = range(5)


@kernel
def yielding(table, i, soft, stiff, ux, uy):
    """C^-1 of thruster i: (xx, xy, yy); soft along u, stiff across it; one that cannot turn yields along itself."""
    if table[i, IS_FIXED] > 0.0:
        ex, ey = table[i, EX], table[i, EY]
        return soft * ex * ex, soft * ex * ey, soft * ey * ey
    return soft * ux * ux + stiff * uy * uy, (soft - stiff) * ux * uy, soft * uy * uy + stiff * ux * ux


@kernel
def constraint(table, rows, c, i):
    """Row c of (R, M) at thruster i: its two coefficients."""
    if c == 0:
        return 1.0, 0.0
    if c == 1:
        return 0.0, 1.0
    if c == 2:
        return -table[i, Y], table[i, X]
    is_own = rows[c - 3, THRUSTER] == float(i)
    return (rows[c - 3, MX], rows[c - 3, MY]) if is_own else (0.0, 0.0)


@kernel
def eliminate(S, b, size):
    """Solve S z = b in place by Gaussian elimination with row pivots; False where S is singular to rounding."""
    for k in range(size):
        whole = 0.0
        for c in range(k, size):
            whole = max(whole, abs(S[k, c]))
        at = k
        for r in range(k + 1, size):
            if abs(S[r, k]) > abs(S[at, k]):
                at = r
        if not abs(S[at, k]) > 1e-14 * whole:
            return False
        for c in range(size):
            S[k, c], S[at, c] = S[at, c], S[k, c]
        b[k], b[at] = b[at], b[k]
        for r in range(k + 1, size):
            part = S[r, k] / S[k, k]
            for c in range(k, size):
                S[r, c] -= part * S[k, c]
            b[r] -= part * b[k]
    for k in range(size - 1, -1, -1):
        for c in range(k + 1, size):
            b[k] -= S[k, c] * b[c]
        b[k] /= S[k, k]
    return True


@kernel
def balance(table, rows, count, tau, inverse, free, S, b, f):
    """f = free + C^-1 (R' rho + M' mu) with R f = tau and the first `count` rows kept; False where that is singular.

    inverse: (n, 3) C^-1 (xx, xy, yy). free: (n, 2) what f is without multipliers. S, b: scratch.
    """
    n, size = f.shape[0], 3 + count
    for r in range(size):
        b[r] = tau[r] if r < 3 else rows[r - 3, VALUE]
        for c in range(size):
            S[r, c] = 0.0
    for i in range(n):
        for r in range(size):
            ax, ay = constraint(table, rows, r, i)
            if ax == 0.0 and ay == 0.0:
                continue
            b[r] -= ax * free[i, 0] + ay * free[i, 1]
            tx, ty = inverse[i, 0] * ax + inverse[i, 1] * ay, inverse[i, 1] * ax + inverse[i, 2] * ay
            for c in range(size):
                cx, cy = constraint(table, rows, c, i)
                S[r, c] += tx * cx + ty * cy
    if not eliminate(S, b, size):
        return False
    for i in range(n):
        vx = vy = 0.0
        for r in range(size):
            ax, ay = constraint(table, rows, r, i)
            vx += ax * b[r]
            vy += ay * b[r]
        f[i, 0] = free[i, 0] + inverse[i, 0] * vx + inverse[i, 1] * vy
        f[i, 1] = free[i, 1] + inverse[i, 1] * vx + inverse[i, 2] * vy
    return True


@kernel
def least_quadratic(table, rows, count, tau, inverse, free, S, b, f):
    """The f of least sum a |f|^2 (eqs. 13-15, with rows 24): C = 2 a, the paper's a of m = 3/2 kept for m = 2."""
    for i in range(f.shape[0]):
        soft = 0.5 / table[i, A]
        inverse[i, 0], inverse[i, 1], inverse[i, 2] = yielding(table, i, soft, soft, 1.0, 0.0)
        free[i, 0] = free[i, 1] = 0.0
    return balance(table, rows, count, tau, inverse, free, S, b, f)


@kernel
def newton_step(table, rows, count, tau, inverse, free, S, b, f):
    """One of Newton's steps for the least sum a |f|^(3/2) (eqs. 18 and 19, 29 with rows); (done, largest change of f).

    With u = f / |f|: C = 1.5 a |f|^(-1/2) (1 - u u' / 2), so that C f - grad P = -C f. At f = 0 the Hessian has no
    bound: there f stays, where the printed equations give NaN.
    """
    n = f.shape[0]
    for i in range(n):
        T = sqrt(f[i, 0] * f[i, 0] + f[i, 1] * f[i, 1])
        stiff = sqrt(T) / (1.5 * table[i, A])
        ux, uy = (f[i, 0] / T, f[i, 1] / T) if T > 0.0 else (1.0, 0.0)
        inverse[i, 0], inverse[i, 1], inverse[i, 2] = yielding(table, i, 2.0 * stiff, stiff, ux, uy)
        free[i, 0], free[i, 1] = -f[i, 0], -f[i, 1]
    if not balance(table, rows, count, tau, inverse, free, S, b, f):
        for i in range(n):
            f[i, 0], f[i, 1] = -free[i, 0], -free[i, 1]
        return False, 0.0
    change = 0.0
    for i in range(n):
        change = max(change, abs(f[i, 0] + free[i, 0]), abs(f[i, 1] + free[i, 1]))
    return True, change
