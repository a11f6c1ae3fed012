"""Generalised-alpha steps of the line, and the Newton iteration inside them."""

from math import isfinite
from typing import NamedTuple

from components.compiled import kernel
from components.tether.cable import linear, seabed
from components.tether.cable.balance import allowance, assemble, imbalance
from components.tether.cable.line import ACC, DIR, KE, SCRATCH, TC, A, Q, R, T, V, first_unknown, last_unknown

# A Newton step may turn or stretch a segment by this fraction of its length; a longer step is cut down to it.
LONGEST_STEP = 0.5


class Scheme(NamedTuple):
    """Generalised-alpha over h [s]: what a node's motion at the end of the step owes to its start.

    a1 = carry_a a0 + carry_acc acc0 + kappa acc1, q1 = q0 + h v0 + h^2 ((1/2 - beta) a0 + beta a1),
    v1 = v0 + h ((1 - gamma) a0 + gamma a1): a algorithmic, acc true acceleration.
    """

    h: float
    beta: float
    gamma: float
    kappa: float
    carry_a: float
    carry_acc: float
    c_q: float  # dq1 / d acc1 [s^2]
    c_m: float  # d acc1 / dq1 [1/s^2]
    c_c: float  # dv1 / dq1 [1/s]


@kernel
def scheme(rho_inf, h):
    """The scheme of Arnold and Bruels 2007 (Multibody Syst. Dyn. 18) with Chung and Hulbert's coefficients (1993).

    In their form (1 - am) a1 + am a0 = (1 - af) acc1 + af acc0, and the balance holds for acc1 at t1. rho_inf = 0
    gives am = -1, af = 0, gamma = 3/2, beta = 1: stiffly accurate and L-stable, a1 = (acc1 + a0) / 2.
    """
    am = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0)
    af = rho_inf / (rho_inf + 1.0)
    gamma = 0.5 + af - am
    beta = 0.25 * (gamma + 0.5) * (gamma + 0.5)
    kappa = (1.0 - af) / (1.0 - am)
    c_q = h * h * beta * kappa
    return Scheme(h, beta, gamma, kappa, -am / (1.0 - am), af / (1.0 - am), c_q, 1.0 / c_q, gamma / (h * beta))


@kernel
def predict(s, w, first, last):
    """Move the nodes first..last over the step with their acceleration held; A becomes a1 - kappa acc1."""
    for i in range(first, last + 1):
        b = i * SCRATCH
        for c in range(b, b + 3):
            a0 = w[c + A]
            base = s.carry_a * a0 + s.carry_acc * w[c + ACC]
            a1 = base + s.kappa * w[c + ACC]
            w[c + Q] += s.h * (w[c + V] + s.h * ((0.5 - s.beta) * a0 + s.beta * a1))
            w[c + V] += s.h * ((1.0 - s.gamma) * a0 + s.gamma * a1)
            w[c + A] = base


@kernel
def finish(line, s, w):
    """Complete the algorithmic acceleration of all nodes and keep the tension and anchors of the accepted motion."""
    for i in range(line.n + 1):
        b = i * SCRATCH
        for c in range(b, b + 3):
            w[c + A] += s.kappa * w[c + ACC]
    for i in range(line.n):
        w[i * SCRATCH + T] = w[i * SCRATCH + TC]
    if line.anchors:
        seabed.drag_anchors(line, w)


@kernel
def step_length(line, w, first, last):
    """1, or the fraction of the Newton correction in R that turns no segment by more than LONGEST_STEP."""
    worst = 0.0
    for i in range(first - 1, last + 1):
        if i < 0 or i >= line.n:
            continue
        b = i * SCRATCH
        square = 0.0
        for c in range(3):
            d = (w[b + SCRATCH + R + c] if i < last else 0.0) - (w[b + R + c] if i >= first else 0.0)
            square += d * d
        worst = max(worst, square)
    longest = LONGEST_STEP * line.l0
    return 1.0 if worst <= longest * longest else longest / worst**0.5


@kernel
def correct(line, w, first, last, c_m, c_c, fraction):
    """Add the correction in R to position, velocity and acceleration; T becomes the tension that it asks for."""
    lx, ly, lz = 0.0, 0.0, 0.0
    for i in range(line.n + 1):
        b = i * SCRATCH
        dx, dy, dz = 0.0, 0.0, 0.0
        if first <= i <= last:
            dx, dy, dz = fraction * w[b + R], fraction * w[b + R + 1], fraction * w[b + R + 2]
            w[b + Q] += dx
            w[b + Q + 1] += dy
            w[b + Q + 2] += dz
            w[b + V] += c_c * dx
            w[b + V + 1] += c_c * dy
            w[b + V + 2] += c_c * dz
            w[b + ACC] += c_m * dx
            w[b + ACC + 1] += c_m * dy
            w[b + ACC + 2] += c_m * dz
        if i > 0:
            e = b - SCRATCH
            along = w[e + DIR] * (dx - lx) + w[e + DIR + 1] * (dy - ly) + w[e + DIR + 2] * (dz - lz)
            tension = w[e + T] + fraction * (w[e + TC] - w[e + T]) + w[e + KE] * along
            w[e + T] = max(tension, 0.0) if line.tension_only else tension
        lx, ly, lz = dx, dy, dz


@kernel
def newton(line, s, w):
    """Balance the free nodes at the end of the step; leaves the matrix of the last iterate in D and E.

    Returns iterations, largest imbalance [N] and whether that is within the line's tolerance.
    """
    first, last = first_unknown(line), last_unknown(line)
    allowed = allowance(line, w, line.tolerance)
    iterations = 0
    while True:
        assemble(line, w, s.c_m, s.c_c)
        residual = imbalance(line, w, first, last)
        if residual <= allowed:
            return iterations, residual, True
        if iterations == line.max_iterations or not isfinite(residual):
            return iterations, residual, False
        linear.solve(line, w, first, last)
        correct(line, w, first, last, s.c_m, s.c_c, step_length(line, w, first, last))
        iterations += 1
