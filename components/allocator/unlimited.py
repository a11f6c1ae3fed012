"""What the allocations without limits have in common: their scratch and the quadratic optimum."""

from components.allocator.lagrange import ROW, WIDTH, least_quadratic
from components.allocator.plain import Plain
from components.compiled import kernel
from components.contract import HEADER, Sizes
from components.matrices import table


@kernel
def lay_out(p, w):
    """Views: thrusters (n, WIDTH); forces (n, 2), C^-1 (n, 3), free forces (n, 2), S (3, 3), b (3,), no rows."""
    n = int(p[HEADER])
    return (
        table(p, HEADER + 1, n, WIDTH),
        table(w, 0, n, 2),
        table(w, 2 * n, n, 3),
        table(w, 5 * n, n, 2),
        table(w, 7 * n, 3, 3),
        w[7 * n + 9 : 7 * n + 12],
        table(w, 0, 0, ROW),
    )


@kernel
def solve_quadratic(p, u, w):
    """Leave the forces of least_quadratic in w; False, and none, where it is singular."""
    thrusters, f, inverse, free, S, b, rows = lay_out(p, w)
    is_solved = least_quadratic(thrusters, rows, 0, u, inverse, free, S, b, f)
    if not is_solved:
        for i in range(f.shape[0]):
            f[i, 0] = f[i, 1] = 0.0
    return is_solved


def sizes(plain: Plain) -> Sizes:
    """The azimuths; forces, their Hessian and the system of three multipliers as scratch."""
    n = len(plain.thrusters)
    return Sizes(state=n, workspace=7 * n + 12)
