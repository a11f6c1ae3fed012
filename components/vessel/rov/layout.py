"""Where an ROV's numbers are: in its parameters after the header, in its inputs and in its scratch."""

from components.compiled import kernel

MASS, LINEAR, QUADRATIC, SINKS, START, HOOK, MAX_SPEED, SWITCHES = 0, 5, 9, 13, 14, 22, 25, 26
# Switches, in the order of the inputs that they turn on.
THRUST, CURRENT, FORCE, LAW = range(4)
_WIDTHS = (4, 3, 3, 15)
# Scratch: trial motion, balance (4), its slope (4, 7) and that to velocity (4, 4), the hook's slope (3, 4), its offset
# (9), current (3).
TRIAL, BALANCE, SLOPE, BY_VELOCITY, BY_HOOK, POINT, WATER, WORKSPACE = 0, 10, 14, 42, 58, 70, 79, 82


@kernel
def place(q, which):
    """Where the input `which` begins, -1 where it is off."""
    if q[SWITCHES + which] == 0.0:
        return -1
    at = 0
    for i in range(which):
        at += int(q[SWITCHES + i]) * _WIDTHS[i]
    return at
