"""Products and solutions with 3 by 3 matrices that stand by rows in the scratch vector."""

from components.compiled import kernel


@kernel
def multiply(w, out, a, b, sign):
    """out = sign a b; out overlaps neither."""
    for i in range(3):
        for j in range(3):
            w[out + 3 * i + j] = sign * (
                w[a + 3 * i] * w[b + j] + w[a + 3 * i + 1] * w[b + 3 + j] + w[a + 3 * i + 2] * w[b + 6 + j]
            )


@kernel
def apply(w, m, v):
    """The matrix at m times the vector at v."""
    x, y, z = w[v], w[v + 1], w[v + 2]
    return (
        w[m] * x + w[m + 1] * y + w[m + 2] * z,
        w[m + 3] * x + w[m + 4] * y + w[m + 5] * z,
        w[m + 6] * x + w[m + 7] * y + w[m + 8] * z,
    )


@kernel
def solve(w, at, width):
    """Gaussian elimination of three rows of `width` at w[at]: the columns behind the third become M^-1 B."""
    for k in range(3):
        best = k
        for i in range(k + 1, 3):
            if abs(w[at + i * width + k]) > abs(w[at + best * width + k]):
                best = i
        if best != k:
            for j in range(k, width):
                a, b = at + k * width + j, at + best * width + j
                w[a], w[b] = w[b], w[a]
        inverse = 1.0 / w[at + k * width + k]
        for j in range(k, width):
            w[at + k * width + j] *= inverse
        for i in range(3):
            if i != k:
                factor = w[at + i * width + k]
                for j in range(k, width):
                    w[at + i * width + j] -= factor * w[at + k * width + j]
