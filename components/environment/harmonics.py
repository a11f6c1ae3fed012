"""Sums of harmonics whose frequencies lie anywhere in their bins, so that they do not repeat."""

from math import cos, pi

from components.compiled import kernel
from components.random import uniform


@kernel
def draw(low, high, seed_high, seed_low, stream):
    """A frequency between low and high, and a phase [rad]; both uniform."""
    a, b = uniform(seed_high, seed_low, stream, 0)
    return low + a * (high - low), 2.0 * pi * b


@kernel
def total(amplitudes, frequencies, phases, n, t):
    """Sum of a cos(omega t + phase) of n harmonics; frequencies [rad/s], t [s]."""
    found = 0.0
    for i in range(n):
        found += amplitudes[i] * cos(frequencies[i] * t + phases[i])
    return found
