"""How a vessel moves over an observer's step: its linear model in the horizontal plane, and its motion in waves."""

from math import ceil, cos, exp, sin, sqrt

from components.compiled import kernel
from components.observer.layout import BIAS, BIAS_TIME, DAMPING, ETA, FASTEST, INVERSE, NU, STATES, WAVE


@kernel
def parts(q, h):
    """Into how many a step [s] is divided, so that the fastest velocity decays by less than half in each.

    The midpoint rule is stable up to twice its time constant.
    """
    return max(ceil(h * q[FASTEST]), 1)


@kernel
def accelerate(q, c, s, nu, bias, tau, acc):
    """Write M^-1 (tau + R' b - D nu), (3); c, s: cosine and sine of the heading."""
    pushed = (tau[0] + c * bias[0] + s * bias[1], tau[1] + c * bias[1] - s * bias[0], tau[2] + bias[2])
    for i in range(3):
        total = 0.0
        for j in range(3):
            balance = pushed[j]
            for k in range(3):
                balance -= q[DAMPING + 3 * j + k] * nu[k]
            total += q[INVERSE + 3 * i + j] * balance
        acc[i] = total


@kernel
def drift_on(q, state, tau, h, w):
    """Advance position, velocity and slow load by h [s] by the midpoint rule; w: (6) scratch, which keeps the velocity
    at the middle (3).

    The Coriolis forces of low speeds are left out (Fossen 2011, eq. 11.35).
    """
    nu, bias, middle, acc = state[NU:BIAS], state[BIAS:WAVE], w[:3], w[3:6]
    psi = state[ETA + 2]
    accelerate(q, cos(psi), sin(psi), nu, bias, tau, acc)
    for i in range(3):
        middle[i] = nu[i] + 0.5 * h * acc[i]
    psi += 0.5 * h * nu[2]
    c, s = cos(psi), sin(psi)
    accelerate(q, c, s, middle, bias, tau, acc)
    state[ETA] += h * (c * middle[0] - s * middle[1])
    state[ETA + 1] += h * (s * middle[0] + c * middle[1])
    state[ETA + 2] += h * middle[2]
    kept = exp(-h / q[BIAS_TIME])
    for i in range(3):
        nu[i] += h * acc[i]
        bias[i] *= kept


@kernel
def swing(omega, zeta, h):
    """Transition over h [s] of a wave's integral and the wave, x1' = x2, x2' = -omega^2 x1 - 2 zeta omega x2; exact.

    Fossen 2011, eqs. 8.115 to 8.119, is the same form of the motion in waves.
    """
    damped = omega * sqrt(1.0 - zeta * zeta)
    e, c, s = exp(-zeta * omega * h), cos(damped * h), sin(damped * h)
    side = zeta * omega / damped * s
    return e * (c + side), e * s / damped, -omega * omega * e * s / damped, e * (c - side)


@kernel
def swing_back(omega, zeta, age):
    """A wave `age` [s] ago, as its integral and itself tell of it now (two factors), and the part of its variance that
    they do not tell.

    The mean of the stationary process given its state now, P Phi' P^-1: unlike Phi^-1 it does not grow with the age.
    """
    _, b, _, d = swing(omega, zeta, age)
    b *= omega * omega
    return b, d, max(1.0 - b * b / (omega * omega) - d * d, 0.0)


@kernel
def swing_on(state, transition):
    """Advance the waves' part of an estimate."""
    a, b, c, d = transition
    for i in range(WAVE, STATES, 2):
        first, second = state[i], state[i + 1]
        state[i], state[i + 1] = a * first + b * second, c * first + d * second
