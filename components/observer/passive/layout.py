"""Where the passive observer's numbers lie in p after its header: gains, gates, then those of every observer."""

(CUT_OFF, NOTCH, TO_VELOCITY, TO_SLOW, GATES, GATE_SPEEDS, COMMON) = (0, 3, 6, 9, 12, 15, 18)
