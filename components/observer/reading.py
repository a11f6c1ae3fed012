"""An observer reads its instruments: which values are new and sound, where they put the vessel, what the wind does."""

from math import cos, exp, isfinite, sin

from components.compiled import kernel
from components.kinematics import to_world
from components.observer.layout import (
    AGAIN,
    ATTITUDE,
    ATTITUDES,
    BELIEVED_AFTER,
    COMPASS_INPUT,
    FIRST,
    FROZEN_AFTER,
    HAS_MRU,
    HAS_THRUST,
    HAS_WIND,
    INPUT,
    IS_ACOUSTIC,
    KNOWN,
    LONGEST_AGE,
    MEMORY,
    MRU_INPUT,
    PLACE,
    RECORD,
    REFERENCE,
    REFERENCES,
    SEEN,
    TRANSPONDER,
    VALUE,
    WILD_SINCE,
    WIND_TIME,
    WINDAGE,
)
from components.vessel.wind_load import blow

# Of a value: used, none since the last, none or too old, frozen, wild.
USED, SAME, LOST, FROZEN, WILD = range(5)
NEVER = -1e300
FAR = 1e12  # beyond which a number cannot be a position [m] or a heading [rad], and its square not be reckoned with
AHEAD = 1e-6  # by which a time may be beyond the present [s], since both are rounded


@kernel
def forget(record):
    """Nothing was received yet."""
    for i in range(RECORD):
        record[i] = 0.0
    record[SEEN] = record[WILD_SINCE] = NEVER


@kernel
def receive(q, record, value, valid, time, t):
    """Whether a value is new and sound at t [s]: USED, or why not."""
    is_sound = valid > 0.0 and -AHEAD <= t - time <= q[LONGEST_AGE]
    for i in range(len(value)):
        is_sound = is_sound and abs(value[i]) <= FAR
    if not is_sound:
        return LOST
    if time == record[SEEN]:
        return SAME
    is_unchanged = record[SEEN] > NEVER
    for i in range(len(value)):
        is_unchanged = is_unchanged and value[i] == record[VALUE + i]
        record[VALUE + i] = value[i]
    record[SEEN] = time
    record[AGAIN] = record[AGAIN] + 1.0 if is_unchanged else 0.0
    return FROZEN if 0.0 < q[FROZEN_AFTER] <= record[AGAIN] else USED


@kernel
def is_believed(q, record, last, t):
    """Whether a wild value is to be believed after all; notes since when all are wild.

    None but such came for BELIEVED_AFTER, and nothing else was used since `last` [s]. So an estimate that is
    itself wrong, after a wild first value or a long time without any, does not stay so.
    """
    if record[WILD_SINCE] == NEVER:
        record[WILD_SINCE] = t
    return t - max(record[WILD_SINCE], last) >= q[BELIEVED_AFTER]


@kernel
def compass_at(q):
    """Index of the compass in u."""
    return INPUT * int(q[REFERENCES])


@kernel
def tilt(q, u):
    """Roll and pitch [rad], zero where nothing measures them."""
    at = compass_at(q) + COMPASS_INPUT
    if q[HAS_MRU] > 0.0 and u[at + 2] > 0.0 and isfinite(u[at]) and isfinite(u[at + 1]):
        return u[at], u[at + 1]
    return 0.0, 0.0


@kernel
def heading_now(q, u, status, estimate, t, h):
    """The compass's heading [rad] where it was used and is of this step, else the estimate, waves included."""
    at = compass_at(q)
    return u[at] if status == USED and t - u[at + 2] < 0.5 * h else estimate


@kernel
def remember(q, u, kept, heading):
    """Keep the attitude of this step, for values that come late; heading [rad]."""
    at = ATTITUDES + ATTITUDE * (int(kept[KNOWN]) % MEMORY)
    kept[at], kept[at + 1] = tilt(q, u)
    kept[at + 2] = heading
    kept[KNOWN] += 1.0


@kernel
def attitude_at(kept, age, h):
    """Roll, pitch and heading [rad] about `age` [s] ago, or the oldest that is remembered; h: the step [s]."""
    count = int(kept[KNOWN])
    back = min(int(age / h + 0.5), count - 1, MEMORY - 1)
    at = ATTITUDES + ATTITUDE * ((count - 1 - back) % MEMORY)
    return kept[at], kept[at + 1], kept[at + 2]


@kernel
def locate(q, u, kept, index, age, h):
    """North and east [m] where a position reference puts the vessel's reference point, `age` [s] ago."""
    k = q[FIRST + REFERENCE * index : FIRST + REFERENCE * (index + 1)]
    value = u[INPUT * index : INPUT * index + 3]
    roll, pitch, heading = attitude_at(kept, age, h)
    ahead, across, below = k[PLACE], k[PLACE + 1], k[PLACE + 2]
    if k[IS_ACOUSTIC] > 0.0:
        ahead, across, below = ahead + value[0], across + value[1], below + value[2]
    north, east, _ = to_world(roll, pitch, heading, ahead, across, below)
    if k[IS_ACOUSTIC] > 0.0:
        return k[TRANSPONDER] - north, k[TRANSPONDER + 1] - east
    return value[0] - north, value[1] - east


@kernel
def feel_wind(q, u, load, h):
    """Filter the wind's load (3) on the vessel over h [s]; without a sound measurement it stays as it is."""
    if q[HAS_WIND] == 0.0:
        return
    at = compass_at(q) + COMPASS_INPUT + (MRU_INPUT if q[HAS_MRU] > 0.0 else 0)
    speed, direction = u[at], u[at + 1]
    if not (u[at + 2] > 0.0 and isfinite(speed) and isfinite(direction)):
        return
    fresh = blow(q[WINDAGE : WINDAGE + 8], speed * cos(direction), speed * sin(direction))
    kept = exp(-h / q[WIND_TIME]) if q[WIND_TIME] > 0.0 else 0.0
    for i in range(3):
        load[i] += (1.0 - kept) * (fresh[i] - load[i])


@kernel
def push(q, u, wind, tau):
    """Write the known load tau (3): the thrusters' and the wind's (3)."""
    at = len(u) - 3
    for i in range(3):
        thrust = u[at + i] if q[HAS_THRUST] > 0.0 and isfinite(u[at + i]) else 0.0
        tau[i] = wind[i] + thrust
