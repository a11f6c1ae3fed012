"""The linear solution of the line's balance, by the elimination that its terms allow."""

from components.compiled import kernel
from components.tether.cable import banded, block_tridiagonal


@kernel
def solve(line, w, first, last):
    """Overwrite R of the nodes first..last by the solution; the neighbours outside keep their place (zero)."""
    if line.band:
        banded.solve(line, w, first, last)
    else:
        block_tridiagonal.solve(w, first, last)
