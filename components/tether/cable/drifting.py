"""The way of a line into its equilibrium in a current: viscous steps from rest, each longer than the last."""

from math import isfinite, sqrt

from components.compiled import kernel
from components.tether.cable import turning
from components.tether.cable.balance import allowance, assemble, imbalance, tighten
from components.tether.cable.dynamics import correct, scheme, step_length
from components.tether.cable.flow import sample
from components.tether.cable.line import ACC, SCRATCH, TC, A, Q, T, V, first_unknown, last_unknown

STEPS, ITERATIONS = 400, 20
# Each step's length over the last one's, where Newton meets it easily, and where it fails; at first the time in which
# the current passes a segment.
LONGER, SHORTER = 2.0, 0.25
EASY = 8
# A step needs no more than a rough balance, relative to weight plus tension.
ROUGH = 1e-4
# At rest: a step as long as the current needs for the whole line moves no node by more than this part of a segment.
REST = 1e-2


@kernel
def keep_place(line, w):
    """Stop the nodes, and note in A where they are."""
    for i in range(line.n + 1):
        b = i * SCRATCH
        for c in range(b, b + 3):
            w[c + A] = w[c + Q]
            w[c + V] = w[c + ACC] = 0.0


@kernel
def return_to_place(line, w):
    """Put the nodes back where they were noted, with the tension that they have there."""
    for i in range(line.n + 1):
        b = i * SCRATCH
        for c in range(b, b + 3):
            w[c + Q] = w[c + A]
            w[c + V] = w[c + ACC] = 0.0
    assemble(line, w, 0.0, 0.0)
    for i in range(line.n):
        w[i * SCRATCH + T] = max(w[i * SCRATCH + TC], 0.0)


@kernel
def farthest(line, w):
    """The longest way of a node from where it was noted [m]."""
    most = 0.0
    for i in range(line.n + 1):
        square = 0.0
        for c in range(3):
            d = w[i * SCRATCH + Q + c] - w[i * SCRATCH + A + c]
            square += d * d
        most = max(most, square)
    return sqrt(most)


@kernel
def step_from_rest(line, w, h):
    """One step of h [s] from rest: Newton iterations, and whether they met the balance."""
    s = scheme(0.0, h)
    first, last = first_unknown(line), last_unknown(line)
    for iteration in range(ITERATIONS):
        sample(line, w, line.t, False)
        assemble(line, w, s.c_m, s.c_c)
        residual = imbalance(line, w, first, last)
        if residual <= allowance(line, w, ROUGH):
            return iteration, True
        if not isfinite(residual):
            break
        tighten(line, w)
        turning.solve(line, w, first, last)
        correct(line, w, first, last, s.c_m, s.c_c, step_length(line, w, first, last))
    return ITERATIONS, False


@kernel
def go_with(line, w, speed):
    """Let the line go with the current of this speed [m/s] until it rests."""
    h = line.l0 / speed
    for _ in range(STEPS):
        keep_place(line, w)
        iterations, met = step_from_rest(line, w, h)
        if not met:
            return_to_place(line, w)
            h *= SHORTER
        elif farthest(line, w) <= REST * line.l0 and h * speed >= line.n * line.l0:
            break
        elif iterations <= EASY:
            h *= LONGER
    keep_place(line, w)
    for i in range((line.n + 1) * 3):
        w[i // 3 * SCRATCH + A + i % 3] = 0.0
