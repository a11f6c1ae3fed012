"""The pieces of a course: polynomials of degree five, the first of which begins at minus infinity."""

from components.compiled import kernel
from components.motion.hand.programme import last_before
from components.motion.hand.track import PIECE, quintic


@kernel
def at_time(t_ns, p, first, count, y):
    """Write position, velocity and acceleration of the course at t_ns from its pieces in p."""
    # The first piece and the second share their start; before it the first holds.
    i = 0 if t_ns < int(p[first]) else last_before(p, first, PIECE, count, t_ns)
    at = first + PIECE * i
    seconds = (t_ns - int(p[at])) * 1e-9
    for axis in range(3):
        y[axis], y[3 + axis], y[6 + axis] = quintic(p, at + 1 + 6 * axis, seconds)
