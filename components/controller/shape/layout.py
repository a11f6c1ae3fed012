"""Where the shape controller's numbers, states and scratch lie in its vectors."""

(SEGMENTS, LENGTH, NORMAL, TANGENTIAL, GAIN, MAX_SPEED, DAMPING, HORIZON, KNOTS, STEPS, PASSES, EFFORT,
 TARGET) = range(13)  # fmt: skip
# States: positions of both ends, left first, and their velocities, north and east of each; then the plan's damping and
# the plan, the ends' velocities at its knots.
PLACE, VELOCITY, PLAN_DAMPING, PLAN = 0, 4, 8, 9
EDGE = 4  # ends times coordinates


def law_scratch(n: int) -> int:
    """Angles and wanted rates (n each), drag matrix (n, n), right sides (n, 4), map (n, 4), 4 x 5 system, 4 numbers."""
    return 2 * n + n * n + 2 * EDGE * n + EDGE * (EDGE + 1) + EDGE


def plan_scratch(n: int, knots: int, steps: int) -> int:
    """Angles (n), errors on the way with each knot moved and twice without, normal matrix, step, a plan kept."""
    many = EDGE * knots
    return n + (many + 2) * steps * n + many * many + 2 * many
