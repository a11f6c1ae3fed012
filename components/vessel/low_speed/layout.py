"""Where a vessel's numbers are: in its parameters after the header, in its inputs and in its scratch."""

from components.compiled import kernel

MASS, DAMPING, WINDAGE, START, HOOKS, MAX_SPEED, SWITCHES, COUNT, STRIPS = 0, 5, 20, 28, 34, 40, 41, 50, 51
# Switches, in the order of the inputs that they turn on; WAVES is the number of components.
THRUST, WIND, CURRENT, WAVES, LOAD, FORCE_A, FORCE_B, LAW_A, LAW_B = range(9)
_WIDTHS = (3, 3, 3, 5, 3, 3, 3, 15, 15)
# Scratch: trial motion, balance (4), its slope (4, 7) and that to velocity (4, 4), a hook's slope (3, 4), the sea's
# response and a cell of its table, the hooks' offsets (9 each), current (3), steady loads (3), wind load (3).
TRIAL, BALANCE, SLOPE, BY_VELOCITY, BY_HOOK, RESPONSE, CELL, POINT_A, POINT_B, WATER, STEADY, WIND_LOAD, WORKSPACE = (
    0, 10, 14, 42, 58, 70, 91, 106, 115, 124, 127, 130, 133
)  # fmt: skip


@kernel
def place(q, which):
    """Where the input `which` begins, -1 where it is off."""
    if q[SWITCHES + which] == 0.0:
        return -1
    at = 0
    for i in range(which):
        at += int(q[SWITCHES + i]) * _WIDTHS[i]
    return at
