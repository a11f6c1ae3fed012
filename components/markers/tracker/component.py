"""Binds the marker tracker to the contract."""

from math import inf

from components.bursts import probability_lost
from components.compiled import kernel
from components.contract import HEADER, SEED_HIGH, SEED_LOW, Component
from components.markers.tracker import model
from components.placement import cell, weights
from components.random import normal, uniform

LENGTH, SEGMENTS, MARKERS, SPACING, OFFSET, NOISE, VISIBLE_TIME, LOST_TIME = range(HEADER, HEADER + 8)
COUNTER, LOST = 0, 1  # in x: frames taken, then a flag a marker
HORIZONTAL, VERTICAL, FATE, STREAMS = range(4)  # of the random numbers of a marker


@kernel
def place(p, i, nodes, y):
    """Write marker i's position on the line."""
    segments = int(p[SEGMENTS])
    from_b = p[OFFSET] + (p[MARKERS] - 1 - i) * p[SPACING]
    first, f = cell((1.0 - from_b / p[LENGTH]) * segments, segments)
    a, b, c, d = weights(f)
    for k in range(3):
        n = 3 * first + k
        y[3 * i + k] = a * nodes[n] + b * nodes[n + 3] + c * nodes[n + 6] + d * nodes[n + 9]


@kernel
def see(p, i, h, counter, nodes, x, y):
    """Draw whether marker i is seen h [s] after the last frame, and write its position with noise, or zeros."""
    count = int(p[MARKERS])
    fate, _ = uniform(p[SEED_HIGH], p[SEED_LOW], STREAMS * i + FATE, counter)
    lost = fate < probability_lost(x[LOST + i], p[VISIBLE_TIME], p[LOST_TIME], h)
    x[LOST + i] = 1.0 if lost else 0.0
    y[3 * count + i] = 0.0 if lost else 1.0
    if lost:
        for k in range(3):
            y[3 * i + k] = 0.0
        return
    place(p, i, nodes, y)
    north, east = normal(p[SEED_HIGH], p[SEED_LOW], STREAMS * i + HORIZONTAL, counter)
    down, _ = normal(p[SEED_HIGH], p[SEED_LOW], STREAMS * i + VERTICAL, counter)
    y[3 * i] += p[NOISE] * north
    y[3 * i + 1] += p[NOISE] * east
    y[3 * i + 2] += p[NOISE] * down


def init(t_ns, dt_ns, p, u, x, y, w):
    """The first frame: each marker lost with the share of time that it is lost."""
    x[COUNTER] = 0.0
    for i in range(int(p[MARKERS])):
        x[LOST + i] = 0.0
        see(p, i, inf, 0, u, x, y)
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The frame at the end of the step."""
    x[COUNTER] += 1.0
    for i in range(int(p[MARKERS])):
        see(p, i, dt_ns * 1e-9, int(x[COUNTER]), u, x, y)
    return 0


COMPONENT = Component(
    name="markers.tracker",
    parameters=model.Tracker,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=init,
    step=step,
    terms=model.terms,
    assumptions=(
        "Markers stay at their points of a uniform line with equal segments, and weigh nothing; noise is white and "
        "isotropic, the same for all; markers are lost independently of each other and of the motion, never swapped."
    ),
)
