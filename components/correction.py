"""One scalar measurement corrects an estimate (n,) and its covariance (n, n), by Kalman's gain."""

from components.compiled import kernel


@kernel
def product(row, by):
    """The sum of the products of two rows (n,)."""
    total = 0.0
    for i in range(len(by)):
        total += row[i] * by[i]
    return total


@kernel
def project(cov, row, by):
    """Write by = P row' (n,); returns row P row'."""
    for i in range(len(by)):
        by[i] = product(cov[i], row)
    return product(row, by)


@kernel
def correct(state, cov, by, innovation, variance):
    """Use a measurement with by = P H' (n,) and the innovation's variance: one gain, and a symmetric P."""
    for i in range(len(by)):
        gain = by[i] / variance
        state[i] += gain * innovation
        for j in range(i + 1):
            cov[i, j] -= gain * by[j]
            cov[j, i] = cov[i, j]
