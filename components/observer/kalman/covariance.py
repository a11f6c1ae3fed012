"""The covariance of an estimate: how it grows over a step, and how a measurement shrinks it."""

from math import cos, exp, sin

from components.compiled import kernel
from components.observer.kalman.layout import COMMON, SLOW, WAVES, WHITE
from components.observer.layout import BIAS, BIAS_TIME, DAMPING, ETA, INVERSE, NU, STATES, WAVE
from components.observer.motion import swing

LOW = WAVE  # states of position, velocity and slow load


@kernel
def slope(q, state, nu, a):
    """Write the slope a (9, 9) of the rates of position, velocity and slow load about the velocity nu (3)."""
    c, s = cos(state[ETA + 2]), sin(state[ETA + 2])
    north, east = state[BIAS], state[BIAS + 1]
    for i in range(LOW):
        for j in range(LOW):
            a[i, j] = 0.0
    a[0, 2], a[1, 2] = -s * nu[0] - c * nu[1], c * nu[0] - s * nu[1]
    a[0, NU], a[0, NU + 1], a[1, NU], a[1, NU + 1], a[2, NU + 2] = c, -s, s, c, 1.0
    for i in range(3):
        m0, m1, m2 = q[INVERSE + 3 * i], q[INVERSE + 3 * i + 1], q[INVERSE + 3 * i + 2]
        a[NU + i, 2] = m0 * (c * east - s * north) - m1 * (c * north + s * east)
        for j in range(3):
            d = q[DAMPING + j], q[DAMPING + 3 + j], q[DAMPING + 6 + j]
            a[NU + i, NU + j] = -(m0 * d[0] + m1 * d[1] + m2 * d[2])
        a[NU + i, BIAS], a[NU + i, BIAS + 1], a[NU + i, BIAS + 2] = m0 * c - m1 * s, m0 * s + m1 * c, m2
        a[BIAS + i, BIAS + i] = -1.0 / q[BIAS_TIME]


@kernel
def transition(a, h, f):
    """Write f = I + h a + (h a)^2 / 2, each (9, 9)."""
    for i in range(LOW):
        for j in range(LOW):
            total = 0.0
            for k in range(LOW):
                total += a[i, k] * a[k, j]
            f[i, j] = h * a[i, j] + 0.5 * h * h * total
        f[i, i] += 1.0


@kernel
def carry(f, wave, source, target):
    """Write F S for all of the estimate: f (9, 9) of the low-frequency part, wave (4) of each wave."""
    a, b, c, d = wave
    for j in range(STATES):
        for i in range(LOW):
            total = 0.0
            for k in range(LOW):
                total += f[i, k] * source[k, j]
            target[i, j] = total
        for i in range(WAVE, STATES, 2):
            first, second = source[i, j], source[i + 1, j]
            target[i, j], target[i + 1, j] = a * first + b * second, c * first + d * second


@kernel
def transpose(m):
    """Turn a square matrix about its diagonal, in place."""
    for i in range(m.shape[0]):
        for j in range(i):
            m[i, j], m[j, i] = m[j, i], m[i, j]


@kernel
def drive(p, h, cov):
    """Add half a step's noise of white and slow loads."""
    q = p[COMMON:]
    for i in range(3):
        for j in range(3):
            cov[NU + i, NU + j] += 0.5 * h * p[WHITE + 3 * i + j]
        cov[BIAS + i, BIAS + i] += 0.5 * p[SLOW + i] * (1.0 - exp(-2.0 * h / q[BIAS_TIME]))


@kernel
def drive_waves(p, omega, wave, cov):
    """Add what keeps each wave's variance as it is: P - Phi P Phi' of its stationary P, exact for any step."""
    a, b, c, d = wave
    for k in range(3):
        i, second = WAVE + 2 * k, p[WAVES + k]
        first = second / (omega * omega)
        cov[i, i] += first - a * a * first - b * b * second
        cov[i + 1, i + 1] += second - c * c * first - d * d * second
        shared = -a * c * first - b * d * second
        cov[i, i + 1] += shared
        cov[i + 1, i] += shared


@kernel
def grow(p, state, nu, omega, zeta, h, a, f, cov, other):
    """The covariance cov (15, 15) after h [s]: F (P + Q h / 2) F' + Q h / 2, of second order in h; other: scratch."""
    slope(p[COMMON:], state, nu, a)
    transition(a, h, f)
    wave = swing(omega, zeta, h)
    drive(p, h, cov)
    carry(f, wave, cov, other)
    transpose(other)
    carry(f, wave, other, cov)
    drive(p, h, cov)
    drive_waves(p, omega, wave, cov)
    for i in range(STATES):
        for j in range(i):
            cov[i, j] = cov[j, i] = 0.5 * (cov[i, j] + cov[j, i])


@kernel
def begin_anew(cov, i, variance):
    """Nothing is known of a state but its variance."""
    for j in range(STATES):
        cov[i, j] = cov[j, i] = 0.0
    cov[i, i] = variance
