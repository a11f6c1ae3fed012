"""Where the line breaks: once; what would break it again is told."""

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


@kernel
def again(line, w):
    """How far a broken line is beyond breaking again: its largest tension over the load, 2 if an event cuts elsewhere.

    One segment is all that it can lose.
    """
    if line.event_cut > 0 and line.event_cut != line.cut + 1:
        return 2.0
    largest = 0.0
    if line.breaking_load > 0.0:
        for i in range(line.n):
            largest = max(largest, w[i * SCRATCH + TC])
        largest /= line.breaking_load
    return largest
