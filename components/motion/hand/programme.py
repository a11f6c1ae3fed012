"""The programme of moves: where the hand means to be, as control points of its spline.

A segment of the programme is ten numbers: its start [ns], its kind, the time of one cycle [s], the time in motion [s]
(whole cycles; then the hand rests at home until the next segment), and two vectors (3,) [m] in NED, along and across.
The programme repeats without end. All times are taken from the integer time, so that nothing accumulates.
"""

from math import cos, floor, pi, sin

from components.compiled import kernel
from components.random import words

SEGMENT = 10
START, KIND, CYCLE, MOVING, ALONG, ACROSS = 0, 1, 2, 3, 4, 7
REST, SWEEP, REVERSAL, CIRCLE, EIGHT = range(5)
TREMOR_STREAM = 0


@kernel
def last_before(p, first, stride, count, t):
    """The last i < count with p[first + i stride] <= t (0 if there is none); those entries ascend."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if p[first + middle * stride] <= t:
            low = middle
        else:
            high = middle
    return low


@kernel
def stroke(kind, s):
    """From 0 to 1 while s goes from 0 to 1: with least jerk (Flash and Hogan 1985, J. Neurosci. 5), or evenly."""
    return s if kind == REVERSAL else s * s * s * (10.0 - s * (15.0 - 6.0 * s))


@kernel
def figure(kind, phi):
    """(along, across) in units of the reach at phi of a cycle, 0 <= phi < 1; every figure starts at (0, 0)."""
    turn = 2.0 * pi * phi
    if kind == CIRCLE:
        return 0.5 * sin(turn), 0.5 * (1.0 - cos(turn))
    if kind == EIGHT:
        return sin(turn), 0.5 * sin(2.0 * turn)
    if phi < 0.25:
        return stroke(kind, 4.0 * phi), 0.0
    if phi < 0.75:
        return 1.0 - 2.0 * stroke(kind, 2.0 * phi - 0.5), 0.0
    return stroke(kind, 4.0 * phi - 3.0) - 1.0, 0.0


@kernel
def meant(p, first, count, tau_ns):
    """Where the hand means to be tau_ns into the programme, from home: (north, east, down) [m]."""
    at = first + SEGMENT * last_before(p, first, SEGMENT, count, tau_ns)
    seconds = (tau_ns - int(p[at + START])) * 1e-9
    if p[at + KIND] == REST or seconds >= p[at + MOVING]:
        return 0.0, 0.0, 0.0
    cycles = seconds / p[at + CYCLE]
    a, b = figure(int(p[at + KIND]), cycles - floor(cycles))
    along, across = at + ALONG, at + ACROSS
    return (
        a * p[along] + b * p[across],
        a * p[along + 1] + b * p[across + 1],
        a * p[along + 2] + b * p[across + 2],
    )


@kernel
def signed(word):
    """A number in (-1, 1) from a 32-bit word."""
    return (float(word) + 0.5) / 2147483648.0 - 1.0  # 2^31


@kernel
def unsteadiness(seed_high, seed_low, j):
    """Three independent numbers, uniform on (-1, 1), of control point j."""
    a, b, c, _ = words(seed_high, seed_low, TREMOR_STREAM, j)
    return signed(a), signed(b), signed(c)
