"""Where an estimator's outputs lie in y, for a chain of n bars; see line.outputs."""

from typing import NamedTuple

from components.compiled import kernel


class Outputs(NamedTuple):
    """Index of each output's first number, `deviation.` as d_."""

    nodes: int
    angle: int
    rate: int
    moment: int
    tension: int
    end: int
    d_nodes: int
    d_angle: int
    d_rate: int
    d_moment: int
    d_tension: int
    d_end: int
    innovation: int


@kernel
def outputs_of(n):
    """For n bars; behind the innovations come freedom, NIS, logarithm of the density, and what was used."""
    a, b = 3 * n + 3, 9 * n + 6
    return Outputs(
        0, a, a + n, a + 2 * n, a + 3 * n, a + 4 * n, a + 4 * n + 1, b, b + n, b + 2 * n, b + 3 * n, b + 4 * n,
        b + 4 * n + 1,
    )  # fmt: skip
