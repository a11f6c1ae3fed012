"""Morison drag on a slender element: quadratic across and along, taken apart by the tangent."""

from math import sqrt

from components.compiled import kernel

# Added to |v_n|^2 so that still water divides by no zero; far below the square of any velocity [m^2/s^2].
STILL = 1e-60


@kernel
def morison(vx, vy, vz, tx, ty, tz, c_n, c_t):
    """Drag and its damping matrix for velocity v through the fluid and unit tangent t.

    f = -c_n |v_n| v_n - c_t |v_t| v_t with v_t = (v . t) t, v_n = v - v_t: Morison et al. 1950, the drag term, split
    into its components across and along a cylinder as is usual for mooring lines; c_n = rho d C_n / 2 and
    c_t = rho pi d C_t / 2 per length (the wetted surface for the tangential one).
    Returns fx, fy, fz [N] and -df/dv at constant t: xx, yy, zz, xy, xz, yz [N s/m], symmetric positive semidefinite.
    """
    s = vx * tx + vy * ty + vz * tz
    nx, ny, nz = vx - s * tx, vy - s * ty, vz - s * tz
    across = sqrt(nx * nx + ny * ny + nz * nz + STILL)
    along = c_t * abs(s)
    b = c_n * across
    g = c_n / across
    e = 2.0 * along - b
    return (
        -b * nx - along * s * tx,
        -b * ny - along * s * ty,
        -b * nz - along * s * tz,
        b + e * tx * tx + g * nx * nx,
        b + e * ty * ty + g * ny * ny,
        b + e * tz * tz + g * nz * nz,
        e * tx * ty + g * nx * ny,
        e * tx * tz + g * nx * nz,
        e * ty * tz + g * ny * nz,
    )
