"""Where the filter's numbers lie in p after its header: variances, then those of every observer."""

(WHITE, SLOW, WAVES, PLACED, MOVING, COMPASS_NOISE, GATE, COMMON) = (0, 9, 12, 15, 18, 21, 22, 23)
