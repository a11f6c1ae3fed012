"""A quantity that follows a command to first order, no faster than its rate allows."""

from math import exp, floor, pi

from components.compiled import kernel


@kernel
def follow(value, command, time_constant, rate, h):
    """Value after h [s]: v' = (command - value) / time_constant within +- rate; the exact solution for any h."""
    gap = command - value
    slow = rate * time_constant if time_constant > 0.0 else 0.0  # a smaller gap is closed at less than the rate
    left = h
    if abs(gap) > slow:
        needed = (abs(gap) - slow) / rate
        if needed >= left:
            return value + (rate * left if gap > 0.0 else -rate * left)
        left -= needed
        gap = slow if gap > 0.0 else -slow
    if time_constant == 0.0:
        return command
    return command - gap * exp(-left / time_constant)


@kernel
def shortest(azimuth, command):
    """The command [rad], whole turns added, that is nearest to the azimuth."""
    turns = (azimuth - command) / (2.0 * pi)
    return command + 2.0 * pi * floor(turns + 0.5)
