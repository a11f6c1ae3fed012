"""Where the ship is, by its observer and its motion reference unit, now and at the times of late measurements."""

from math import isfinite

from components.compiled import kernel
from components.estimator.tether.layout import (
    HAS_MRU,
    HEADING,
    HEAVE,
    MEMORY,
    POSE,
    POSES,
    POSITION,
    RING,
    ROLL_PITCH,
    WAVE,
    WAVE_HEADING,
)
from components.kinematics import to_world


@kernel
def remember(u, kept):
    """Keep the pose of this step, waves included; where the unit gives nothing, the ship is level."""
    at = RING + POSE * (int(kept[POSES]) % MEMORY)
    sound = u[HAS_MRU] > 0.0 and isfinite(u[HEAVE]) and isfinite(u[ROLL_PITCH]) and isfinite(u[ROLL_PITCH + 1])
    kept[at], kept[at + 1] = u[POSITION] + u[WAVE], u[POSITION + 1] + u[WAVE + 1]
    kept[at + 2] = u[HEAVE] if sound else 0.0
    kept[at + 3], kept[at + 4] = (u[ROLL_PITCH], u[ROLL_PITCH + 1]) if sound else (0.0, 0.0)
    kept[at + 5] = u[HEADING] + u[WAVE_HEADING]
    kept[POSES] += 1.0


@kernel
def pose_at(kept, age, h):
    """Place in kept of the pose about `age` [s] ago, or of the oldest that is remembered; h: the step [s]."""
    count = int(kept[POSES])
    back = min(int(age / h + 0.5), count - 1, MEMORY - 1)
    return RING + POSE * ((count - 1 - back) % MEMORY)


@kernel
def place_of(kept, at, lever):
    """North, east, down [m] of a point of the hull, forward, starboard and down of the reference point (3)."""
    north, east, down = to_world(kept[at + 3], kept[at + 4], kept[at + 5], lever[0], lever[1], lever[2])
    return kept[at] + north, kept[at + 1] + east, kept[at + 2] + down
