"""Uniform quintic B-spline: a point among six control points, with its velocity and acceleration.

Continuous to the fourth derivative, inside the convex hull of the control points, and a low-pass filter of them: a
control signal of frequency f passes with the amplitude (sin(pi f h)/(pi f h))^6, h being the spacing of the knots.
Schoenberg 1946, Quart. Appl. Math. 4, 45-99; derivatives as splines of the control points' differences, de Boor 1978.
"""

from components.compiled import kernel

CONTROLS = 6  # control points that a point of the spline depends on


@kernel
def position(c0, c1, c2, c3, c4, c5, f):
    """The spline at fraction f of its knot interval, 0 <= f < 1."""
    g = 1.0 - f
    f2, g2 = f * f, g * g
    outer = c0 * g * g2 * g2 + c5 * f * f2 * f2
    inner = c2 * (66.0 - f2 * (60.0 - f2 * (30.0 - 10.0 * f))) + c3 * (66.0 - g2 * (60.0 - g2 * (30.0 - 10.0 * g)))
    late = c4 * (1.0 + f * (5.0 + f * (10.0 + f * (10.0 + f * (5.0 - 5.0 * f)))))
    early = c1 * (1.0 + g * (5.0 + g * (10.0 + g * (10.0 + g * (5.0 - 5.0 * g)))))
    return (outer + early + inner + late) / 120.0


@kernel
def velocity(c0, c1, c2, c3, c4, c5, f):
    """The derivative of position() to f: a quartic spline of the first differences."""
    g = 1.0 - f
    f2, g2 = f * f, g * g
    outer = (c1 - c0) * g2 * g2 + (c5 - c4) * f2 * f2
    early = (c2 - c1) * (1.0 + g * (4.0 + g * (6.0 + g * (4.0 - 4.0 * g))))
    late = (c4 - c3) * (1.0 + f * (4.0 + f * (6.0 + f * (4.0 - 4.0 * f))))
    middle = (c3 - c2) * (11.0 + f * (12.0 - f * (6.0 + f * (12.0 - 6.0 * f))))
    return (outer + early + middle + late) / 24.0


@kernel
def acceleration(c0, c1, c2, c3, c4, c5, f):
    """The second derivative of position() to f: a cubic spline of the second differences."""
    g = 1.0 - f
    outer = (c2 - 2.0 * c1 + c0) * g * g * g + (c5 - 2.0 * c4 + c3) * f * f * f
    early = (c3 - 2.0 * c2 + c1) * (1.0 + 3.0 * g * (1.0 + g * (1.0 - g)))
    late = (c4 - 2.0 * c3 + c2) * (1.0 + 3.0 * f * (1.0 + f * (1.0 - f)))
    return (outer + early + late) / 6.0
