"""Impacts of segments that draw taut, where the sub-step is too long to show their tension."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable.line import DIR, SCRATCH, STATE, T, V


@kernel
def impact(line, s, w, old, start):
    """Largest tension [N] of an impact in the sub-step that began with old[start:], if it does not resolve impacts.

    A bar that moves at the speed v and is held at one end pulls with sqrt(EA m) v (Timoshenko and Goodier 1970, Theory
    of Elasticity, art. 167), and with less where the holder yields. The wave comes through a segment in l0 / c,
    c = sqrt(EA / m): a step no longer than that shows the tension.
    """
    mass = 2.0 * (line.mass + line.added_t)
    if not line.tension_only or s.h * s.h * line.k <= mass:
        return 0.0
    fastest = 0.0
    for i in range(line.n):
        if old[start + i * STATE + T] <= 0.0 and w[i * SCRATCH + T] > 0.0:
            b, o = i * SCRATCH + DIR, start + i * STATE + V
            speed = 0.0
            for c in range(3):
                speed += w[b + c] * (old[o + STATE + c] - old[o + c])
            fastest = max(fastest, speed)
    return sqrt(line.k * mass) * fastest
