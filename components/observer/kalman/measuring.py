"""What a measurement says of an estimate, as it was when it was taken, and whether it is to be believed."""

from math import cos, sin

from components.compiled import kernel
from components.correction import correct, project
from components.kinematics import wrapped
from components.observer.layout import ETA, NU, STATES, WAVE
from components.observer.motion import swing_back
from components.observer.reading import USED, WILD


@kernel
def expect(state, axis, omega, zeta, age, row):
    """The position or heading on an axis `age` [s] ago, the waves' part included, and its row (15) of the slope."""
    for i in range(STATES):
        row[i] = 0.0
    from_first, from_second, _ = swing_back(omega, zeta, age)
    row[ETA + axis], row[WAVE + 2 * axis], row[WAVE + 2 * axis + 1] = 1.0, from_first, from_second
    c, s, u, v = cos(state[ETA + 2]), sin(state[ETA + 2]), state[NU], state[NU + 1]
    if axis == 0:
        row[NU], row[NU + 1], row[ETA + 2] = -age * c, age * s, age * (s * u + c * v)
        rate = c * u - s * v
    elif axis == 1:
        row[NU], row[NU + 1], row[ETA + 2] = -age * s, -age * c, -age * (c * u - s * v)
        rate = s * u + c * v
    else:
        row[NU + 2] = -age
        rate = state[NU + 2]
    wave = from_first * state[WAVE + 2 * axis] + from_second * state[WAVE + 2 * axis + 1]
    return state[ETA + axis] - age * rate + wave


@kernel
def unseen(variance, omega, zeta, age):
    """Variance [m^2] of the wave when a value was taken that the wave now does not tell of."""
    _, _, share = swing_back(omega, zeta, age)
    return variance * share


@kernel
def use_heading(state, cov, value, noise, omega, zeta, age, gate, w, seen):
    """Use a heading [rad]; seen: innovation and its normalised square; USED or WILD."""
    row, by = w[:STATES], w[STATES : 2 * STATES]
    innovation = wrapped(value - expect(state, 2, omega, zeta, age, row))
    variance = project(cov, row, by) + noise
    seen[0], seen[1] = innovation, innovation * innovation / variance
    if seen[1] > gate:
        return WILD
    correct(state, cov, by, innovation, variance)
    return USED


@kernel
def use_position(state, cov, north, east, noise, omega, zeta, age, gate, w, seen):
    """Use a position [m]; seen: innovation (2) and its normalised square; USED or WILD.

    Both coordinates are judged together and then used one after the other, which is the same as at once since their
    noise is independent (Anderson and Moore 1979, section 6.4).
    """
    row, by, other = w[:STATES], w[STATES : 2 * STATES], w[2 * STATES : 3 * STATES]
    first = north - expect(state, 0, omega, zeta, age, row)
    s_nn = project(cov, row, by) + noise
    second = east - expect(state, 1, omega, zeta, age, row)
    s_ee = project(cov, row, other) + noise
    s_ne = 0.0
    for i in range(STATES):
        s_ne += row[i] * by[i]
    determinant = s_nn * s_ee - s_ne * s_ne
    square = (s_ee * first * first - 2.0 * s_ne * first * second + s_nn * second * second) / determinant
    seen[0], seen[1], seen[2] = first, second, square
    if not square <= gate:
        return WILD
    correct(state, cov, by, first, s_nn)
    # The same row, but what is expected there has moved with the first coordinate.
    left = second - s_ne / s_nn * first
    variance = project(cov, row, by) + noise
    correct(state, cov, by, left, variance)
    return USED
