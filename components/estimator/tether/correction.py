"""One scalar measurement corrects an estimate."""

from components.compiled import kernel
from components.estimator.tether.layout import STATES


@kernel
def project(cov, row, by):
    """Write by = P row' ."""
    for i in range(STATES):
        total = 0.0
        for j in range(STATES):
            total += cov[i, j] * row[j]
        by[i] = total


@kernel
def product(row, by):
    """The sum of the products of two rows."""
    total = 0.0
    for i in range(STATES):
        total += row[i] * by[i]
    return total


@kernel
def correct(state, cov, by, innovation, variance):
    """Use a measurement with by = P H' and the innovation's variance: one gain, and a symmetric P."""
    for i in range(STATES):
        gain = by[i] / variance
        state[i] += gain * innovation
        for j in range(i + 1):
            cov[i, j] -= gain * by[j]
            cov[j, i] = cov[i, j]
