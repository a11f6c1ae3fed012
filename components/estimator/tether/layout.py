"""Where the filter's numbers, inputs, states and scratch lie in its vectors.

p begins as a quasi-static line's does (components/tether/quasistatic/line.py), so that a copy of it, with the length
paid out and the current as estimated, goes to that line's kernels. Behind its table of currents come, for each depth,
north and east of an offset along it of 1 m/s, then the filter's own numbers.
"""

from components.compiled import kernel
from components.contract import HEADER
from components.tether.quasistatic.line import FORCES, KEPT, POINTS, PROFILE, RECORD, SEGMENTS, SMALL

# How many numbers the line has before its table of currents. Own numbers: variances and times, the places of hook and
# transceiver in the hull (3 each), the start (3).
LINE_NUMBERS = PROFILE - HEADER
(AGITATION, CELL, RANGE, ANGLE, ANGLE_BIAS, ANGLE_TIME, ALONG, ACROSS, CURRENT_TIME, SWING, SWING_TIME, TRANSFER, GATE,
 LONGEST_AGE, LARGEST, PLACED, MOVING, FOLLOWING_TIME) = range(18)  # fmt: skip
HOOK, TRANSCEIVER, START = 18, 21, 24

# Inputs.
POSITION, HEADING, WAVE, WAVE_HEADING, ROLL_PITCH, HEAVE, HAS_MRU = 0, 2, 3, 5, 6, 8, 9
REACH, HAS_USBL, USBL_TIME, TENSION, HAS_CELL, CELL_TIME, STORED = 10, 13, 14, 15, 16, 17, 18

# The estimate: place and velocity of end b (3 each), offset of the current along and across the assumed one, slow
# errors of the angles (2), swing of the tension. Behind it and its covariance: what is kept of the line (both ends'
# tensions, their slopes to place and current, 5 each, and whether there are any), the last USBL time, refusals in a
# row, the velocity of end b that the line follows (3), poses seen, poses (6 each) in a ring, then the line's places and
# forces (6 a node).
R, V, C, B, D, STATES = 0, 3, 6, 8, 10, 11
COVARIANCE, KEPT_LINE = STATES, STATES + STATES * STATES
TENSIONS, SLOPES, SLOPE, IS_KNOWN, SEEN, REFUSED, FOLLOWED, POSES, RING = 0, 2, 5, 12, 13, 14, 15, 18, 19
MEMORY, POSE = 64, 6
SHAPE = RING + MEMORY * POSE

# Scratch: two rows of the filter, its estimate and covariance on trial, the ends of the line, its p, its records.
ROWS, TRIAL, ENDS = 0, 2 * STATES, 3 * STATES + STATES * STATES
LINE = ENDS + 18


@kernel
def segments_of(p):
    """Number of the line's segments."""
    return int(p[SEGMENTS])


@kernel
def own_at(p):
    """Where the filter's own numbers begin in p."""
    return PROFILE + 6 * int(p[POINTS])


@kernel
def mesh_at(points):
    """Where the line's records begin in the scratch vector."""
    return LINE + PROFILE + 4 * points


@kernel
def results_at(n):
    """Where the line's places and tensions stand behind its records."""
    return (n + 1) * RECORD + SMALL


@kernel
def state_size(n):
    """Length of the state with n segments."""
    return KEPT_LINE + SHAPE + 6 * (n + 1)


@kernel
def workspace(n, points):
    """Length of the scratch vector with n segments and a table of so many currents."""
    return mesh_at(points) + results_at(n) + KEPT * (n + 1) + FORCES
