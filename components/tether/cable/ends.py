"""Motion of the line's ends within a step, and the affine force law that an end gives to the body holding it."""

from components.compiled import kernel
from components.tether.cable import banded, block_tridiagonal
from components.tether.cable.line import ACC, FREE, SCRATCH, STATE, D, E, Q, R, V, first_unknown, last_unknown


@kernel
def quintic(p0, v0, a0, p1, v1, a1, h, s):
    """Position, velocity and acceleration at the fraction s of h [s] of the quintic through both instants."""
    e = p1 - p0 - h * (v0 + 0.5 * h * a0)
    f = h * (v1 - v0 - h * a0)
    g = h * h * (a1 - a0)
    c3, c4, c5 = 10.0 * e - 4.0 * f + 0.5 * g, 7.0 * f - 15.0 * e - g, 6.0 * e - 3.0 * f + 0.5 * g
    p = p0 + s * (h * v0 + s * (0.5 * h * h * a0 + s * (c3 + s * (c4 + s * c5))))
    v = v0 + s * (h * a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)) / h)
    a = a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)) / (h * h)
    return p, v, a


@kernel
def hold(w, node, u, k):
    """Put the node where the motion bundle at u[k:] has it."""
    b = node * SCRATCH
    for c in range(3):
        w[b + Q + c], w[b + V + c], w[b + ACC + c] = u[k + c], u[k + 3 + c], u[k + 6 + c]


@kernel
def lead(w, node, x, start, u, k, h, s):
    """Put the node at the fraction s of the way from the state record at x[start:] to the motion bundle at u[k:]."""
    b = node * SCRATCH
    for c in range(3):
        p0, v0, a0 = x[start + Q + c], x[start + V + c], x[start + ACC + c]
        w[b + Q + c], w[b + V + c], w[b + ACC + c] = quintic(p0, v0, a0, u[k + c], u[k + 3 + c], u[k + 6 + c], h, s)


@kernel
def place(line, x, u, w, h, part, parts):
    """Move the driven ends to part/parts of the step of h [s] that ends with the bundles in u."""
    k = 0
    for node in range(0, line.n + 1, line.n):
        if (line.end_a if node == 0 else line.end_b) == FREE:
            continue
        if part == parts:
            hold(w, node, u, k)
        else:
            lead(w, node, x, node * STATE, u, k, h, part / parts)
        k += 9


@kernel
def give_force(w, node, y, k):
    """Write the line's force on what holds the node, from the balance assembled last, to y[k:]."""
    for c in range(3):
        y[k + c] = w[node * SCRATCH + R + c]


@kernel
def give_law(line, w, node, c_q, y, k):
    """Write the end's law about the motion assembled last to y[k:]: force (3), acceleration (3), mass (9, row-major).

    The mass is G = -dF/d acc = c_q S, S the Schur complement of the balance's matrix when all other free nodes are
    eliminated and position and velocity follow the acceleration by the scheme (c_q = dq/d acc); a held other end
    stays at its motion. Uses up the matrix in w.
    """
    first, last = first_unknown(line), last_unknown(line)
    give_force(w, node, y, k)
    if line.band:
        for c in range(3):
            y[k + 3 + c] = w[node * SCRATCH + ACC + c]
        banded.gather(line, w)
        banded.factor(line, w, first, last)
        banded.write_schur(line, w, node, node, c_q, y, k + 6)
        return
    if node == 0:
        block_tridiagonal.eliminate(w, last, last - first + 1, -1)
    else:
        block_tridiagonal.eliminate(w, first, last - first + 1, 1)
    b = node * SCRATCH
    for c in range(3):
        y[k + 3 + c] = w[b + ACC + c]
    k += 6
    y[k], y[k + 4], y[k + 8] = c_q * w[b + D], c_q * w[b + D + 1], c_q * w[b + D + 2]
    y[k + 1] = y[k + 3] = c_q * w[b + D + 3]
    y[k + 2] = y[k + 6] = c_q * w[b + D + 4]
    y[k + 5] = y[k + 7] = c_q * w[b + D + 5]


@kernel
def give_cross(line, w, c_q, y, k):
    """Write -dF_a / d acc_b (9, row-major) to y[k:], from what give_law of end b left in w.

    Eliminating the node i leaves between node 0 and node i + 1 the block -C D_i^-1 E_i, C the one that it had with i.
    """
    if line.band:
        banded.write_schur(line, w, line.n, 0, c_q, y, k)
        return
    xx, yy, zz, xy, xz, yz = w[E], w[E + 1], w[E + 2], w[E + 3], w[E + 4], w[E + 5]
    y[k], y[k + 1], y[k + 2] = c_q * xx, c_q * xy, c_q * xz
    y[k + 3], y[k + 4], y[k + 5] = c_q * xy, c_q * yy, c_q * yz
    y[k + 6], y[k + 7], y[k + 8] = c_q * xz, c_q * yz, c_q * zz
    for i in range(1, line.n):
        g = i * SCRATCH + E
        for row in range(k, k + 9, 3):
            cx, cy, cz = y[row], y[row + 1], y[row + 2]
            for j in range(3):
                y[row + j] = -(cx * w[g + j] + cy * w[g + 3 + j] + cz * w[g + 6 + j])
