"""Writes what observers give, in the order of ship.outputs."""

from components.compiled import kernel
from components.observer.layout import BIAS, ETA, LAST_FIX, LOAD, NU, WAVE

AGE, STATUS = 15, 16


@kernel
def write_estimate(state, kept, t, y):
    """Motion (6), waves (3), slow load (3), wind load (3), and the time since the last fix [s]."""
    for i in range(3):
        y[i], y[3 + i] = state[ETA + i], state[NU + i]
        y[6 + i] = state[WAVE + 2 * i + 1]
        y[9 + i] = state[BIAS + i]
        y[12 + i] = kept[LOAD + i]
    y[AGE] = t - kept[LAST_FIX]


@kernel
def write_reading(y, n, index, status, seen):
    """What became of a reference's value, or of the compass's where index is n, and its innovation."""
    y[STATUS + index] = status
    if index == n:
        y[STATUS + n + 1 + 2 * n] = seen[0]
    else:
        y[STATUS + n + 1 + 2 * index], y[STATUS + n + 2 + 2 * index] = seen[0], seen[1]
