"""Drag of a rigid segment whose velocity is linear along it, as forces on its two nodes, and their slopes.

The forces on the nodes are the segment's load against the shape functions 1 - xi and xi, so that sum and moment are the
integrals (14) of Bhattacharya et al. 2011 (there the lever arm is the offset along the segment).
"""

from components.compiled import kernel

# Speed below which quadratic drag has the slope of this speed, so that a line at rest is not without resistance [m/s].
SLOPE_SPEED = 1e-4


@kernel
def square(a, b):
    """Integrals of |u| u against 1 - xi and xi over 0..1, u going linearly from a to b, exact also where it turns."""
    if a * b >= 0.0:
        sign = 1.0 if a + b > 0.0 else -1.0
        return sign * (3.0 * a * a + 2.0 * a * b + b * b) / 12.0, sign * (a * a + 2.0 * a * b + 3.0 * b * b) / 12.0
    sign = 1.0 if a > 0.0 else -1.0
    p = a / (a - b)
    q = 1.0 - p
    before, after = sign * a * a * p / 12.0, sign * b * b * q / 12.0
    return before * (3.0 + q) - after * q, before * p - after * (3.0 + p)


@kernel
def square_slopes(a, b):
    """Derivatives of `square`: of the first by a, of either by the other's end, of the second by b."""
    p = 1.0
    if a * b < 0.0:
        p = a / (a - b)
    q = 1.0 - p
    a, b = abs(a), abs(b)
    if q == 0.0:
        return (3.0 * a + b) / 6.0, (a + b) / 6.0, (a + 3.0 * b) / 6.0
    return (
        (a * p * (3.0 + 2.0 * q + q * q) + b * q * q * q) / 6.0,
        (a * p * p * (1.0 + q) + b * q * q * (1.0 + p)) / 6.0,
        (a * p * p * p + b * q * (3.0 + 2.0 * p + p * p)) / 6.0,
    )


@kernel
def quadratic(chain, v_ta, v_tb, v_na, v_nb):
    """Quadratic drag on a segment: (t, n) of its sum, n of that at the second node, and the impedances by velocity.

    These are that of the whole along t, and of the nodes across: aa, ab, bb.
    """
    k, v_t = chain.k_S * chain.l0, 0.5 * (v_ta + v_tb)
    first, second = square(v_na, v_nb)
    aa, ab, bb = square_slopes(v_na, v_nb)
    along = chain.k_V * chain.l0
    return (
        -along * abs(v_t) * v_t,
        -k * (first + second),
        -k * second,
        2.0 * along * (abs(v_t) + SLOPE_SPEED),
        k * (aa + 2.0 / 3.0 * SLOPE_SPEED),
        k * (ab + 1.0 / 3.0 * SLOPE_SPEED),
        k * (bb + 2.0 / 3.0 * SLOPE_SPEED),
    )
