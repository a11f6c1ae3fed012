"""Turning a direction by an angle, without drifting from length 1."""

from math import cos, sin

from components.compiled import kernel

# Below this angle [rad] the series are exact to rounding.
SMALL = 0.05


@kernel
def rotate(tx, ty, angle):
    """The direction turned by the angle [rad], of length 1 again."""
    q = angle * angle
    if q < SMALL * SMALL:
        s = angle * (1.0 - q * (1.0 / 6.0) * (1.0 - q * (1.0 / 20.0) * (1.0 - q * (1.0 / 42.0))))
        c = 1.0 - 0.5 * q * (1.0 - q * (1.0 / 12.0) * (1.0 - q * (1.0 / 30.0)))
    else:
        s, c = sin(angle), cos(angle)
    x, y = c * tx - s * ty, s * tx + c * ty
    over = 1.5 - 0.5 * (x * x + y * y)
    return x * over, y * over
