"""A first guess of a line that rests on the seabed: two catenaries and what lies between them."""

from math import asinh, hypot, sqrt

from components.compiled import kernel
from components.tether.cable.line import FREE, SCRATCH, Q, T
from components.tether.cable.part import part

# Bisections of the horizontal tension: more than a double has bits.
BISECTIONS = 200


@kernel
def extent(c, s):
    """Horizontal extent [m] of an inextensible line of length s that rises from a level touch; c = H / w [m]."""
    return c * asinh(s / c) if c > 0.0 else 0.0


@kernel
def hanging(c, height):
    """Length [m] that hangs from a height [m] to a level touch."""
    return sqrt(height * (height + 2.0 * c))


@kernel
def parameter(length, h, p_a, p_b):
    """H / w [m] of an inextensible line with its ends p_a, p_b above the bed and h apart on it; 0 if there is slack.

    Irvine 1981, section 1.2, on a frictionless bed.
    """
    if h <= length - p_a - p_b:
        return 0.0
    low, high = 0.0, length + h
    for _ in range(BISECTIONS):
        c = 0.5 * (low + high)
        s_a, s_b = hanging(c, p_a), hanging(c, p_b)
        if length - s_a - s_b + extent(c, s_a) + extent(c, s_b) < h:
            low = c
        else:
            high = c
    return 0.5 * (low + high)


@kernel
def below_bed(line, w):
    """Whether a node is below the bed."""
    deepest = w[Q + 2]
    for i in range(1, line.n + 1):
        deepest = max(deepest, w[i * SCRATCH + Q + 2])
    return deepest > line.bed_depth


@kernel
def lay_on_bed(line, w, weight, north, east):
    """Place the nodes on the catenaries and on the bed between; a free end lies in the direction (north, east).

    weight: of the whole line in the fluid [N].
    """
    length = 0.0
    for i in range(line.n):
        length += part(line, i).l0
    a, b = Q, line.n * SCRATCH + Q
    if line.end_a == FREE:
        a = b
    if line.end_b == FREE:
        b = a
    free = line.end_a == FREE or line.end_b == FREE
    p_a = max(line.bed_depth - w[a + 2], 0.0)
    p_b = 0.0 if free else max(line.bed_depth - w[b + 2], 0.0)
    x0, y0, z0 = w[a], w[a + 1], line.bed_depth
    h = hypot(w[b] - x0, w[b + 1] - y0)
    if free:
        h = max(length - p_a, 0.0)
    elif h > 0.0:
        north, east = (w[b] - x0) / h, (w[b + 1] - y0) / h
    c = parameter(length, h, p_a, p_b)
    s_a, s_b = hanging(c, p_a), hanging(c, p_b)
    x_a, x_b = extent(c, s_a), extent(c, s_b)
    lying = length - s_a - s_b
    s = 0.0
    for k in range(line.n + 1):
        i = line.n - k if line.end_a == FREE else k
        if s < s_a:
            x, z = x_a - extent(c, s_a - s), z0 - (hypot(c, s_a - s) - c)
        elif s <= length - s_b:
            x, z = x_a + (h - x_a - x_b) * (s - s_a) / lying if lying > 0.0 else x_a, z0 + line.bed_onset
        else:
            r = s - (length - s_b)
            x, z = h - x_b + extent(c, r), z0 - (hypot(c, r) - c)
        o = i * SCRATCH
        if 0 < k < line.n or (k == line.n and free):
            w[o + Q], w[o + Q + 1], w[o + Q + 2] = x0 + x * north, y0 + x * east, z
        if i < line.n:
            w[o + T] = weight / length * (c + max(z0 - z, 0.0))
        if k < line.n:
            s += part(line, line.n - 1 - k if line.end_a == FREE else k).l0
