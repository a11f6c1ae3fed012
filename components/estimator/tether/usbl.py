"""What hydroacoustic positioning says of end b, as it was when the sound returned.

Range and two angles, each with white noise, the angles with a slow error as well. A value of age a tells of
r(t - a) = r - a v + e, where e is what the accelerations since then have added: uncorrelated with the innovation, but
not with the estimate, cov(r, e) = s^2 a^3 / 6 and cov(v, e) = s^2 a^2 / 2 (a measurement out of sequence, Bar-Shalom
2002, with white acceleration of density s^2).
"""

from math import asin, isfinite, sqrt

from components.compiled import kernel
from components.correction import correct, product, project
from components.estimator.tether.layout import (
    AGITATION,
    ANGLE,
    COVARIANCE,
    GATE,
    HAS_USBL,
    LONGEST_AGE,
    PLACED,
    RANGE,
    REACH,
    REFUSED,
    ROWS,
    SEEN,
    STATES,
    TRANSCEIVER,
    TRIAL,
    USBL_TIME,
    B,
    R,
    V,
)
from components.estimator.tether.pose import place_of, pose_at
from components.kinematics import to_body, to_world
from components.matrices import table

# Used, none new, none sound, refused by its NIS.
USED, SAME, LOST, WILD = range(4)
AHEAD = 1e-6  # by which a time may be beyond the present [s], since both are rounded
BELIEVED = 5  # refusals in a row after which end b is as uncertain again as at the start
NEAREST, STEEPEST = 1e-3, 0.999  # range [m] and sine of an angle up to which the slopes are taken


@kernel
def receive(q, u, kept, t):
    """Whether a value is new and sound at t [s]: USED, or why not."""
    time = u[USBL_TIME]
    sound = u[HAS_USBL] > 0.0 and -AHEAD <= t - time <= q[LONGEST_AGE] and u[REACH] > NEAREST
    for k in range(3):
        sound = sound and isfinite(u[REACH + k])
    if not sound:
        return LOST
    if time <= kept[SEEN]:
        return SAME
    kept[SEEN] = time
    return USED


@kernel
def expect(state, kept, at, origin, age, channel, row):
    """(expected value, slope to place (3)) of range, across or along; writes its row of the slope.

    at: the ship's pose then; origin: of the transceiver then.
    """
    roll, pitch, yaw = kept[at + 3], kept[at + 4], kept[at + 5]
    d = (
        state[R] - age * state[V] - origin[0],
        state[R + 1] - age * state[V + 1] - origin[1],
        state[R + 2] - age * state[V + 2] - origin[2],
    )
    reach = max(sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), NEAREST)
    value, slope = reach, (d[0] / reach, d[1] / reach, d[2] / reach)
    if channel > 0:
        ahead, across, _ = to_body(roll, pitch, yaw, d[0], d[1], d[2])
        sine = min(max((across if channel == 1 else ahead) / reach, -STEEPEST), STEEPEST)
        axis = to_world(roll, pitch, yaw, 0.0 if channel == 1 else 1.0, 1.0 if channel == 1 else 0.0, 0.0)
        per = 1.0 / (reach * sqrt(1.0 - sine * sine))
        value = asin(sine) + state[B + channel - 1]
        slope = (
            per * (axis[0] - sine * slope[0]),
            per * (axis[1] - sine * slope[1]),
            per * (axis[2] - sine * slope[2]),
        )
    for i in range(STATES):
        row[i] = 0.0
    for k in range(3):
        row[R + k], row[V + k] = slope[k], -age * slope[k]
    if channel > 0:
        row[B + channel - 1] = 1.0
    return value, slope


@kernel
def try_on(q, u, kept, age, h, before, state, cov, w):
    """Use all three channels on an estimate about the one `before`; their normalised innovation squared, together.

    One after the other is the same as at once, since their noises are independent.
    """
    row, by = w[ROWS : ROWS + STATES], w[ROWS + STATES : ROWS + 2 * STATES]
    at, total = pose_at(kept, age, h), 0.0
    origin = place_of(kept, at, q[TRANSCEIVER : TRANSCEIVER + 3])
    for channel in range(3):
        value, slope = expect(before, kept, at, origin, age, channel, row)
        innovation = u[REACH + channel] - value
        for i in range(STATES):
            innovation -= row[i] * (state[i] - before[i])
        project(cov, row, by)
        for k in range(3):
            by[R + k] += q[AGITATION] * age * age * age / 6.0 * slope[k]
            by[V + k] += q[AGITATION] * age * age / 2.0 * slope[k]
        variance = max(product(row, by), 0.0) + (q[RANGE] if channel == 0 else q[ANGLE])
        total += innovation * innovation / variance
        correct(state, cov, by, innovation, variance)
    return total


@kernel
def use_usbl(q, u, t, h, x, kept, w):
    """(what became of the value, its NIS): use it if it is new, sound and within the gate."""
    status = receive(q, u, kept, t)
    if status != USED:
        return status, 0.0
    size = STATES + STATES * STATES
    for i in range(size):
        w[TRIAL + i] = x[i]
    state, cov = w[TRIAL : TRIAL + STATES], table(w, TRIAL + COVARIANCE, STATES, STATES)
    nis = try_on(q, u, kept, t - u[USBL_TIME], h, x[:STATES], state, cov, w)
    if not nis <= q[GATE]:
        kept[REFUSED] += 1.0
        if kept[REFUSED] >= BELIEVED:
            kept[REFUSED] = 0.0
            for k in range(3):
                x[COVARIANCE + (R + k) * (STATES + 1)] += q[PLACED]
        return WILD, nis
    kept[REFUSED] = 0.0
    for i in range(size):
        x[i] = w[TRIAL + i]
    return USED, nis
