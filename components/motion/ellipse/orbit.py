"""An orbit whose size grows over a ramp, and its exact derivatives."""

from math import cos, pi, sin

from components.compiled import kernel


@kernel
def growth(t, ramp):
    """r(t), dr/dt [1/s] and its rate [1/s^2]: 10 s^3 - 15 s^4 + 6 s^5, s = t / ramp, of continuous acceleration."""
    s = min(max(t / ramp, 0.0), 1.0)
    return (
        s * s * s * (10.0 + s * (6.0 * s - 15.0)),
        30.0 * s * s * (1.0 - s) * (1.0 - s) / ramp,
        60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (ramp * ramp),
    )


@kernel
def orbit(t, f, ramp):
    """Position, velocity and acceleration of r(t) cos(2 pi f t), then of r(t) sin(2 pi f t), at t [s]."""
    r, dr, ddr = growth(t, ramp)
    omega = 2.0 * pi * f
    c, s = cos(omega * t), sin(omega * t)
    return (
        r * c,
        dr * c - r * omega * s,
        ddr * c - 2.0 * dr * omega * s - r * omega * omega * c,
        r * s,
        dr * s + r * omega * c,
        ddr * s + 2.0 * dr * omega * c - r * omega * omega * s,
    )
