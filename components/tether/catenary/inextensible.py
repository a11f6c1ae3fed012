"""The inextensible catenary between two points: one equation, solved to rounding by Newton's method.

Half the horizontal span in units of H/w is u = C h / 2, with Drupt et al. 2022's C = w/H (eq. 4). The length gives
sinh(u)/u = k, k = sqrt(L^2 - v^2)/h, for span h, rise v and length L. Solved as log(sinh(u)/u) = log k, whose left
side is convex and increasing, so that Newton's method converges from anywhere, and whose both sides are exact
to rounding for a near-straight line (k - 1 from L^2 - h^2 - v^2, in factors) and for a slack one (no overflow).
"""

from math import exp, hypot, log, log1p, sqrt, tanh

from components.compiled import kernel
from components.tether.catenary.status import NOT_CONVERGED, TAUT, TOO_SHORT

# Below this fraction of the length the span bends nothing: it moves a point by less than any double resolves.
VERTICAL = 1e-120
# From there on the direct formula has lost no more than one bit to cancellation, and the series is no shorter.
_SERIES = 2.0
# Newton's error is squared by a step: after a step of 1e-9 the next one is below rounding.
_SMALL_STEP = 1e-9
_ITERATIONS = 60


@kernel
def log_sinhc(u):
    """log(sinh(u)/u) and its derivative coth(u) - 1/u, for u > 0."""
    if u >= _SERIES:
        return u + log1p(-exp(-2.0 * u)) - log(2.0 * u), 1.0 / tanh(u) - 1.0 / u
    q = u * u
    term = q / 6.0
    excess = term
    slope = 2.0 * term
    n = 1
    while term > 1e-17 * excess:  # the terms fall at least as q/20; what is left out is below rounding
        n += 1
        term *= q / ((2 * n) * (2 * n + 1))
        excess += term
        slope += 2 * n * term
    return log1p(excess), slope / (u * (1.0 + excess))


@kernel
def half_span(kappa):
    """(converged, u) with log(sinh(u)/u) = kappa > 0."""
    u = sqrt(6.0 * kappa * (1.0 + 0.2 * kappa)) if kappa < 1.0 else kappa + log(2.0 * kappa + 2.0)
    for _ in range(_ITERATIONS):
        value, slope = log_sinhc(u)
        du = (kappa - value) / slope
        u = max(u + du, 0.5 * u)
        if abs(du) <= _SMALL_STEP * u:
            return True, u
    return False, u


@kernel
def inextensible(h, v):
    """(status, H, V): force at the middle of a line of unit length and weight over span h >= 0 and rise v.

    H is horizontal, V upward; V_a = V - 1/2 at end a and V_b = V + 1/2 at end b.
    """
    c = hypot(h, v)
    if c >= 1.0:
        return (TAUT if c == 1.0 else TOO_SHORT), 0.0, 0.0
    if h <= VERTICAL:
        return 0, 0.0, 0.5 * v
    kappa = 0.5 * log1p((1.0 - c) * (1.0 + c) / (h * h))
    converged, u = half_span(kappa)
    if not converged:
        return NOT_CONVERGED, 0.0, 0.0
    return 0, 0.5 * h / u, 0.5 * v / tanh(u)
