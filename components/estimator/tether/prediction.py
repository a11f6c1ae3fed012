"""The estimate moves on: end b by a constant velocity that white accelerations drive, the rest as it decays."""

from math import exp

from components.compiled import kernel
from components.estimator.tether.layout import (
    ACROSS,
    AGITATION,
    ALONG,
    ANGLE_BIAS,
    ANGLE_TIME,
    CURRENT_TIME,
    FOLLOWED,
    FOLLOWING_TIME,
    STATES,
    SWING,
    SWING_TIME,
    B,
    C,
    D,
    R,
    V,
)


@kernel
def carry(cov, h):
    """Write F P F' for the places, which velocities carry on over h [s]."""
    for k in range(3):
        for j in range(STATES):
            cov[R + k, j] += h * cov[V + k, j]
    for k in range(3):
        for i in range(STATES):
            cov[i, R + k] += h * cov[i, V + k]


@kernel
def decay(state, cov, i, variance, time, h):
    """An Ornstein-Uhlenbeck process after h [s]: exact, of this variance at any time."""
    kept = exp(-h / time)
    state[i] *= kept
    for j in range(STATES):
        cov[i, j] *= kept
        cov[j, i] *= kept
    cov[i, i] += (1.0 - kept * kept) * variance


@kernel
def follow(q, state, kept, h):
    """The line follows end b's velocity, smoothed over the time that drag takes to bring the line along."""
    share = 1.0 - exp(-h / q[FOLLOWING_TIME])
    for k in range(3):
        kept[FOLLOWED + k] += share * (state[V + k] - kept[FOLLOWED + k])


@kernel
def predict(q, state, cov, h):
    """Estimate and covariance after h [s]; q: the filter's own numbers.

    White acceleration of density s^2 adds s^2 (h^3/3, h^2/2; h^2/2, h) to place and velocity: the integral of Van Loan
    1978 in closed form (Bar-Shalom et al. 2001, eq. 6.2.2-12).
    """
    for k in range(3):
        state[R + k] += h * state[V + k]
    carry(cov, h)
    for k in range(3):
        cov[R + k, R + k] += q[AGITATION] * h * h * h / 3.0
        cov[R + k, V + k] += q[AGITATION] * h * h / 2.0
        cov[V + k, R + k] += q[AGITATION] * h * h / 2.0
        cov[V + k, V + k] += q[AGITATION] * h
    decay(state, cov, C, q[ALONG], q[CURRENT_TIME], h)
    decay(state, cov, C + 1, q[ACROSS], q[CURRENT_TIME], h)
    for k in range(2):
        decay(state, cov, B + k, q[ANGLE_BIAS], q[ANGLE_TIME], h)
    decay(state, cov, D, q[SWING], q[SWING_TIME], h)
