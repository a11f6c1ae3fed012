"""Translation of a rigid mass on springs and dampers under a force that may depend on its acceleration."""

from components.compiled import kernel


@kernel
def solve(xx, yy, zz, xy, xz, yz, bx, by, bz):
    """Solution of a symmetric positive definite 3x3 system, by LDL'."""
    l21, l31 = xy / xx, xz / xx
    d2 = yy - l21 * xy
    c32 = yz - l31 * xy
    l32 = c32 / d2
    d3 = zz - l31 * xz - l32 * c32
    by = by - l21 * bx
    z = (bz - l31 * bx - l32 * by) / d3
    y = by / d2 - l32 * z
    return bx / xx - l21 * y - l31 * z, y, z


@kernel
def reach(h):
    """How much position [s^2] and velocity [s] at the end of the step h [s] owe to the acceleration there."""
    return 0.5 * h * h, 0.75 * h


@kernel
def predict(q, v, a, h):
    """Position and velocity after h [s] but for the end's acceleration, whose parts are reach(h).

    Generalised-alpha of Arnold and Bruels (2007) with rho_inf = 0 (beta = 1, gamma = 3/2, a1 = (acc1 + a) / 2), the
    scheme of a bonded line: q1 = q + h v + h^2 acc1 / 2, v1 = v + h a / 4 + 3 h acc1 / 4; a: algorithmic acceleration.
    """
    return q + h * v, v + 0.25 * h * a
