"""Where the line breaks."""

from components.compiled import kernel
from components.tether.cable.line import SCRATCH, TC


@kernel
def overloaded(line, w):
    """The segment whose tension exceeds the breaking load most, -1 if none does or the line never breaks."""
    segment, largest = -1, line.breaking_load
    if largest > 0.0:
        for i in range(line.n):
            if w[i * SCRATCH + TC] > largest:
                segment, largest = i, w[i * SCRATCH + TC]
    return segment
