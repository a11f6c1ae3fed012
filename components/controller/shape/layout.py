"""Where the shape controller's numbers, states and scratch lie in its vectors."""

SEGMENTS, LENGTH, NORMAL, TANGENTIAL, GAIN, MAX_SPEED, DAMPING, TARGET = range(8)
# States: positions of both ends, left first, and their velocities; north and east of each.
PLACE, VELOCITY, STATES = 0, 4, 8
EDGE = 4  # ends times coordinates


def scratch(n: int) -> int:
    """Angles and wanted rates (n each), drag matrix (n, n), right sides (n, 4), map (n, 4), 4 x 5 system, 4 numbers."""
    return 2 * n + n * n + 2 * EDGE * n + EDGE * (EDGE + 1) + EDGE
