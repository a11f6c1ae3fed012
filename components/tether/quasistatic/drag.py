"""Morison drag of a flow on a slender element, and how it changes with the flow and with the element's direction."""

from math import sqrt

from components.compiled import kernel

# Added to |v_n|^2 so that still water divides by no zero; far below the square of any velocity [m^2/s^2].
STILL = 1e-60


@kernel
def drag(vx, vy, vz, tx, ty, tz, c_n, c_t):
    """Force per length of the flow v past the tangent t: c_n |v_n| v_n + c_t |v_t| v_t.

    v_t = (v . t) t and v_n = v - v_t; Morison et al. 1950, the drag term, split across and along as usual for mooring
    lines. c_n = rho d C_n / 2, c_t = rho pi d C_t / 2 (on the wetted surface).
    """
    s = vx * tx + vy * ty + vz * tz
    nx, ny, nz = vx - s * tx, vy - s * ty, vz - s * tz
    across = c_n * sqrt(nx * nx + ny * ny + nz * nz + STILL)
    along = c_t * abs(s) * s
    return across * nx + along * tx, across * ny + along * ty, across * nz + along * tz


@kernel
def write_slopes(w, by_v, by_t, vx, vy, vz, tx, ty, tz, c_n, c_t):
    """Write the drag's derivatives to v and to t, (3, 3) each by rows, at by_v and by_t in w."""
    s = vx * tx + vy * ty + vz * tz
    v, t = (vx, vy, vz), (tx, ty, tz)
    n = (vx - s * tx, vy - s * ty, vz - s * tz)
    size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + STILL)
    n_t = n[0] * tx + n[1] * ty + n[2] * tz
    across, along = c_n * size, c_t * abs(s)
    for i in range(3):
        for j in range(3):
            same = 1.0 if i == j else 0.0
            turn = s * n[j] + n_t * v[j]  # -|v_n| d|v_n|/dt
            k = 3 * i + j
            w[by_t + k] = (2.0 * along - across) * t[i] * v[j] + (along - across) * s * same - c_n * n[i] * turn / size
            stretch = n[j] - n_t * t[j]  # |v_n| d|v_n|/dv
            w[by_v + k] = across * (same - t[i] * t[j]) + c_n * n[i] * stretch / size + 2.0 * along * t[i] * t[j]
