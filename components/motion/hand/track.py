"""A tabulated track: one polynomial of degree five a piece, joined smoothly to the fourth derivative.

A piece is its start [ns] and three times six coefficients, ascending, of the local time in seconds.
"""

from components.compiled import kernel

PIECE = 19


@kernel
def quintic(p, at, s):
    """(position, velocity, acceleration) of the polynomial with the coefficients p[at : at + 6] at s."""
    position = p[at + 5]
    velocity = 5.0 * p[at + 5]
    acceleration = 20.0 * p[at + 5]
    for k in range(4, -1, -1):
        position = position * s + p[at + k]
        if k >= 1:
            velocity = velocity * s + k * p[at + k]
        if k >= 2:
            acceleration = acceleration * s + k * (k - 1) * p[at + k]
    return position, velocity, acceleration
