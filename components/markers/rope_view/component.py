"""Binds the view of a rope to the contract."""

from math import atan2, sqrt

from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.kinematics import wrapped
from components.markers.rope_view import model
from components.markers.rope_view.placement import seen_from, spot
from components.random import normal

(SEGMENTS, POINTS, CAMERA, STARBOARD, BEARING, FIELD, NEAREST, FARTHEST, NOISE,
 PER_RANGE) = range(HEADER, HEADER + 10)  # fmt: skip
COUNTER = 0  # in x: pictures taken


@kernel
def look(p, u, counter, y):
    """Write the picture of this number."""
    segments, points = int(p[SEGMENTS]), int(p[POINTS])
    pose = 3 * (segments + 1)
    for i in range(points):
        north, east = spot(u, segments, (i + 0.5) / points)
        x, z = seen_from(u[pose], u[pose + 1], u[pose + 2], north, east)
        from_x, from_z = x - p[CAMERA], z - p[STARBOARD]
        distance = sqrt(from_x * from_x + from_z * from_z)
        aside = abs(wrapped(atan2(from_z, from_x) - p[BEARING]))
        y[2 * i] = y[2 * i + 1] = y[2 * points + i] = 0.0
        if p[NEAREST] <= distance <= p[FARTHEST] and aside <= 0.5 * p[FIELD]:
            by_range = p[PER_RANGE] * distance
            deviation = sqrt(p[NOISE] * p[NOISE] + by_range * by_range)
            ahead, across = normal(p[SEED_HIGH], p[SEED_LOW], i, counter)
            y[2 * i], y[2 * i + 1] = x + deviation * ahead, z + deviation * across
            y[2 * points + i] = 1.0


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first picture."""
    x[COUNTER] = 0.0
    look(p, u, 0, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The picture at the end of the step."""
    x[COUNTER] += 1.0
    look(p, u, int(x[COUNTER]), y)
    return 0


COMPONENT = Component(
    name="markers.rope_view",
    parameters=model.RopeView,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions=(
        "A level boat and a line in the water's plane; the picture is mapped to the plane without distortion; hulls "
        "hide nothing; noise is white and isotropic; where along the line a point is is not told."
    ),
)
