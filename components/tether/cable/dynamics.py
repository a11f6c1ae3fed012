"""Generalised-alpha steps of the line, and the Newton iteration inside them."""

from math import inf, isfinite, sqrt
from typing import NamedTuple

from components.compiled import kernel
from components.tether.cable import linear, seabed
from components.tether.cable.balance import allowance, imbalance, tighten
from components.tether.cable.line import ACC, ASKED, DIR, KE, SCRATCH, TC, A, Q, R, T, V, first_unknown, last_unknown
from components.tether.cable.part import part
from components.tether.cable.winch import assemble

# Newton may go round between slack and taut, stick and slip, on the bed and off it: where the imbalance has been no
# less than its least for so many steps, it takes half steps and whole ones in turn, so many of each.
PATIENCE = 6
# In so many steps it draws whole lengths of slack line taut at once, with a tension that is hardly one [N].
DRAWS, BARELY = 4, 1e-290
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
    lead: float  # the algorithmic acceleration is the true one so much later [s]
    error: float  # of q1, over the change of the true acceleration [s^2]


@kernel
def scheme(rho_inf, h):
    """The scheme of Arnold and Bruels 2007 (Multibody Syst. Dyn. 18) with Chung and Hulbert's coefficients (1993).

    In their form (1 - am) a1 + am a0 = (1 - af) acc1 + af acc0, and the balance holds for acc1 at t1. rho_inf = 0
    gives am = -1, af = 0, gamma = 3/2, beta = 1: stiffly accurate and L-stable, a1 = (acc1 + a0) / 2. Where the
    acceleration changes at the rate j, a = acc + (am - af) h j solves theirs, so that q1 is wrong by
    (beta - 1/6 + (am - af) / 2) h^3 j (after Zienkiewicz and Xie 1991, Earthq. Eng. Struct. Dyn. 20, for Newmark's).
    """
    am = (2.0 * rho_inf - 1.0) / (rho_inf + 1.0)
    af = rho_inf / (rho_inf + 1.0)
    gamma = 0.5 + af - am
    beta = 0.25 * (gamma + 0.5) * (gamma + 0.5)
    kappa = (1.0 - af) / (1.0 - am)
    c_q = h * h * beta * kappa
    lead = (am - af) * h
    error = h * h * (beta - 1.0 / 6.0 + 0.5 * (am - af))
    carry_a, carry_acc = -am / (1.0 - am), af / (1.0 - am)
    return Scheme(h, beta, gamma, kappa, carry_a, carry_acc, c_q, 1.0 / c_q, gamma / (h * beta), lead, error)


@kernel
def soften(line, s, w, first, last):
    """Overwrite the vectors in R by what stiffness lets through of them: (c_m M + c_c C + K)^-1 c_m M R.

    Axial waves shorter than the step change a node's acceleration much, its position hardly. Needs the matrix that was
    assembled last, and uses it up. Hairer and Wanner 1996, Solving ODEs II, eq. IV.8.20, filter errors in this way.
    """
    for i in range(first, last + 1):
        mass = 0.0
        for j in range(max(i - 1, 0), min(i + 1, line.n)):
            mass += part(line, j).mass + part(line, j).added_n
        for c in range(i * SCRATCH + R, i * SCRATCH + R + 3):
            w[c] *= s.c_m * mass
    linear.solve(line, w, first, last)


@kernel
def align(line, s, lead, w):
    """Shift the free nodes' algorithmic acceleration from its lead [s] over the true one to that of the scheme s.

    Where the step or rho_inf changes it would else stay that of the last step, which costs an order (Bruels and
    Arnold 2008, J. Comput. Nonlinear Dyn. 3, 041007). Of stiff axial waves the difference of the two is no rate of
    change; to stretch it would excite them, so it is softened.
    """
    first, last = first_unknown(line), last_unknown(line)
    ratio = s.lead / lead if lead != 0.0 else 1.0
    if ratio == 1.0 or first > last:
        return
    assemble(line, w, s.c_m, s.c_c)
    for i in range(first, last + 1):
        b = i * SCRATCH
        for c in range(3):
            w[b + R + c] = (ratio - 1.0) * (w[b + A + c] - w[b + ACC + c])
    soften(line, s, w, first, last)
    for i in range(first, last + 1):
        b = i * SCRATCH
        for c in range(3):
            w[b + A + c] += w[b + R + c]


@kernel
def predict(s, w, n, steadily):
    """Move the nodes over the step with an acceleration that is held, or goes on changing steadily.

    The algorithmic acceleration, s.lead ahead of the true one, tells how it changes. A becomes a1 - kappa acc1.
    """
    ahead = s.h / s.lead if steadily and s.lead != 0.0 else 0.0
    for i in range(n + 1):
        b = i * SCRATCH
        for c in range(b, b + 3):
            a0 = w[c + A]
            base = s.carry_a * a0 + s.carry_acc * w[c + ACC]
            w[c + ACC] += ahead * (a0 - w[c + ACC])
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
            asked = w[e + TC] - w[e + T] + (w[e + ASKED] if line.inextensible else 0.0)
            tension = w[e + T] + fraction * asked + w[e + KE] * along
            w[e + T] = max(tension, 0.0) if line.tension_only else tension
        lx, ly, lz = dx, dy, dz


@kernel
def draw_taut(line, w):
    """Take slack segments to be taut that one which is stretched now would draw taut on its way to its own length.

    Else a Newton step draws but one segment more taut, and a line that is jerked takes as many as it has segments.
    What is not taut after all comes out of the step with T <= 0.
    """
    for direction in (1, -1):
        pull = 0.0
        for k in range(line.n):
            i = k if direction > 0 else line.n - 1 - k
            b = i * SCRATCH
            o = b + SCRATCH
            if w[b + T] > BARELY or i == line.cut:
                pull = 0.0
                continue
            x, y, z = w[o + Q] - w[b + Q], w[o + Q + 1] - w[b + Q + 1], w[o + Q + 2] - w[b + Q + 2]
            stretch = sqrt(x * x + y * y + z * z) - part(line, i).l0
            pull = max(pull, stretch) if stretch > 0.0 else max(pull + stretch, 0.0)
            if pull > 0.0:
                w[b + T] = BARELY


class Balanced(NamedTuple):
    """How a Newton iteration ended."""

    iterations: int
    residual: float  # largest imbalance [N]
    allowed: float  # what was to be put up with [N]
    converged: bool


@kernel
def newton(line, s, w):
    """Balance the free nodes at the end of the step; leaves the matrix of the last iterate in D and E.

    Returns iterations, largest imbalance [N], what is to be put up with [N], and whether it is within that.
    """
    first, last = first_unknown(line), last_unknown(line)
    allowed = allowance(line, w, line.tolerance)
    seabed.begin(line, w)
    iterations, least, since = 0, inf, 0
    while True:
        if line.tension_only and 0 < iterations <= DRAWS:
            draw_taut(line, w)
        assemble(line, w, s.c_m, s.c_c)
        residual = imbalance(line, w, first, last)
        if residual <= allowed:
            return Balanced(iterations, residual, allowed, True)
        if iterations == line.max_iterations or not isfinite(residual):
            return Balanced(iterations, residual, allowed, False)
        tighten(line, w)
        linear.solve(line, w, first, last)
        since = 0 if residual < least else since + 1
        least = min(least, residual)
        fraction = step_length(line, w, first, last) * (0.5 if since // PATIENCE % 2 == 1 else 1.0)
        correct(line, w, first, last, s.c_m, s.c_c, fraction)
        iterations += 1
