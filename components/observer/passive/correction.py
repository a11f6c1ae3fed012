"""The passive observer's correction of an estimate by one axis's innovation."""

from math import ceil

from components.compiled import kernel
from components.observer.layout import BIAS, ETA, NU, WAVE, WAVE_DAMPING, WAVE_FREQUENCY
from components.observer.motion import swing
from components.observer.passive.layout import COMMON, CUT_OFF, NOTCH, TO_SLOW, TO_VELOCITY

LONGEST = 6.0  # gap times cut-off after which the observer has followed a lasting innovation
FINE = 16.0  # steps of the midpoint rule for each time constant of the cut-off


@kernel
def follow(omega, zeta, cut, to_integral, to_wave, gap):
    """What the continuous observer makes of a measurement that stays off by one over `gap` [s].

    Returns the changes of a wave's integral [s], the wave and the position, and the integral of the innovation [s].
    """
    gap = min(gap, LONGEST / cut)
    n = ceil(gap * cut * FINE)
    first = second = place = work = 0.0
    for _ in range(n):
        h = 0.5 * gap / n
        left = 1.0 - second - place
        bend = -omega * omega * first - 2.0 * zeta * omega * second
        a, b = first + h * (second + to_integral * left), second + h * (bend + to_wave * left)
        left = 1.0 - b - place - h * cut * left
        bend = -omega * omega * a - 2.0 * zeta * omega * b
        h *= 2.0
        first += h * (b + to_integral * left)
        second += h * (bend + to_wave * left)
        place += h * cut * left
        work += h * left
    return first, second, place, work


@kernel
def correct(p, state, axis, innovation, gap, age, c, s):
    """Correct by the innovation on an axis of the world; gap: since its last sample [s]; c, s: of the heading.

    age: of the sample [s], over which what it says of the waves is carried on.

    Gains that make of innovation to error the notch (s^2 + 2 lambda omega s + omega^2) / ((s^2 + 2 zeta omega s +
    omega^2)(s + omega_c)): Fossen and Strand 1999, section 4. What the continuous observer would do between two samples
    is done at once, so that rare samples leave it stable.
    """
    q = p[COMMON:]
    omega, zeta = q[WAVE_FREQUENCY], q[WAVE_DAMPING]
    cut, wide = p[CUT_OFF + axis] * omega, p[NOTCH + axis] - zeta
    first, second, place, work = follow(omega, zeta, cut, -2.0 * wide * cut / omega, 2.0 * wide * omega, gap)
    into_first, from_second, into_second, kept = swing(omega, zeta, age)
    k = WAVE + 2 * axis
    state[k] += (into_first * first + from_second * second) * innovation
    state[k + 1] += (into_second * first + kept * second) * innovation
    state[ETA + axis] += place * innovation
    state[BIAS + axis] += p[TO_SLOW + axis] * work * innovation
    pull = p[TO_VELOCITY + axis] * work * innovation
    if axis == 0:
        state[NU] += c * pull
        state[NU + 1] -= s * pull
    elif axis == 1:
        state[NU] += s * pull
        state[NU + 1] += c * pull
    else:
        state[NU + 2] += pull
