"""What the load cell at the ship says, and what is known of the tension at both ends.

The tension of the line at rest is only its mean: the ship's heave swings it, and the swing runs along the line faster
than the filter steps. So one Ornstein-Uhlenbeck process is added at both ends alike.
"""

from math import isfinite, sqrt

from components.compiled import kernel
from components.correction import correct, project
from components.estimator.tether.layout import (
    CELL,
    CELL_TIME,
    GATE,
    HAS_CELL,
    ROWS,
    SLOPE,
    SLOPES,
    STATES,
    TENSION,
    TENSIONS,
    TRANSFER,
    C,
    D,
    R,
)
from components.estimator.tether.usbl import LOST, USED, WILD


@kernel
def write_row(kept, end, row):
    """Write the slope of the tension at end a (0) or b (1) to the estimate."""
    for i in range(STATES):
        row[i] = 0.0
    at = SLOPES + SLOPE * end
    for k in range(3):
        row[R + k] = kept[at + k]
    row[C], row[C + 1], row[D] = kept[at + 3], kept[at + 4], 1.0


@kernel
def use_cell(q, u, t, h, state, cov, kept, w):
    """(what became of the value, its NIS): use it if it is of this step and within the gate."""
    if not (u[HAS_CELL] > 0.0 and isfinite(u[TENSION]) and abs(t - u[CELL_TIME]) < 0.5 * h):
        return LOST, 0.0
    row, by = w[ROWS : ROWS + STATES], w[ROWS + STATES : ROWS + 2 * STATES]
    write_row(kept, 0, row)
    innovation = u[TENSION] - kept[TENSIONS] - state[D]
    variance = project(cov, row, by) + q[CELL]
    nis = innovation * innovation / variance
    if not nis <= q[GATE]:
        return WILD, nis
    correct(state, cov, by, innovation, variance)
    return USED, nis


@kernel
def deviation(q, cov, kept, end, w):
    """Standard deviation [N] of the tension at end a (0) or b (1)."""
    row, by = w[ROWS : ROWS + STATES], w[ROWS + STATES : ROWS + 2 * STATES]
    write_row(kept, end, row)
    return sqrt(max(project(cov, row, by), 0.0) + (q[TRANSFER] if end == 1 else 0.0))
