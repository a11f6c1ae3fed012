"""Thrust and power of a propeller by its speed and the water that comes to it, and the speed that gives a thrust."""

from math import sqrt

from components.compiled import kernel

# Numbers of a thruster: kind, x, y [m], heading [rad], rudder angle [rad], T / n|n| ahead and astern [N s^2], power /
# n^3 ahead and astern [W s^3], largest speed [rad/s], loss factor, 2 pi / (J_0 D) [1/m], share of J_0 at which torque
# vanishes, time constants and rates of speed and azimuth.
(KIND, X, Y, HEADING, RUDDER, AHEAD, ASTERN, POWER, POWER_ASTERN, FASTEST, LOSS, SLIP, TORQUE, SPEED_TIME, SPEED_RATE,
 AZIMUTH_TIME, AZIMUTH_RATE) = range(17)  # fmt: skip
NUMBERS = 17
AZIMUTH_KIND, STRAIGHT, RUDDER_KIND = range(3)


@kernel
def speed_for(k, thrust):
    """Shaft speed [rad/s] that gives a thrust [N] in still water, within the largest; negative astern.

    k: (17) a thruster's numbers. A thrust in place is the open water's less the loss.
    """
    if thrust >= 0.0:
        return min(sqrt(thrust / (k[AHEAD] * k[LOSS])), k[FASTEST])
    if k[ASTERN] == 0.0:
        return 0.0
    return -min(sqrt(-thrust / (k[ASTERN] * k[LOSS])), k[FASTEST])


@kernel
def thrust_of(k, n, advance):
    """Thrust [N] at a shaft speed n [rad/s] in water that comes at `advance` [m/s] along the thrust.

    K_T falls in a line from bollard pull to zero at the advance number J_0: T = K n|n| - K (2 pi / (J_0 D)) |n| V_a
    (Fossen 2011, eqs. 9.2 to 9.7; Blanke 1981, the bilinear thruster).
    """
    factor = k[AHEAD] if n >= 0.0 else k[ASTERN]
    return k[LOSS] * factor * (n * abs(n) - k[SLIP] * abs(n) * advance)


@kernel
def power_of(k, n, advance):
    """Power [W] of the shaft, K_Q falling like K_T to zero at its own advance number; no power is won back.

    In bollard pull it is proportional to n^3, and so to T^(3/2).
    """
    factor = k[POWER] if n >= 0.0 else k[POWER_ASTERN]
    load = n * n - k[SLIP] * k[TORQUE] * n * advance
    return max(factor * abs(n) * load, 0.0)
