"""The discrete line: its constants, and where each number stands in p, in u and in the scratch vector.

n equal segments between the nodes 0 (end a) to n (end b). Segment j carries the force vector N_j, which pulls node j
forwards; the loads are lumped at the nodes, from each adjacent half segment with that segment's tangent.
"""

from typing import NamedTuple

from components.compiled import kernel
from components.contract import HEADER

LENGTH, SEGMENTS, FLEXIBILITY, WEIGHT, DRAG_N, DRAG_T, FREE, BODY_WEIGHT, BODY_DRAG, HAS_CURRENT = range(
    HEADER, HEADER + 10
)
LIMITS, POINTS = HEADER + 10, HEADER + 15
PROFILE = HEADER + 16  # rows of depth and current (north, east, down), the depths increasing
A_POSITION, A_VELOCITY, A_ACCELERATION, B_POSITION, B_VELOCITY, B_ACCELERATION = range(0, 18, 3)

# A node's record in the scratch vector: place from end a, the next segment's force, the load to begin with, the sweep's
# two affine laws (matrix and vector), the correction, and place and force that a failed attempt falls back to.
R, N, F0, P, PI, W, OM, DR, DN, SAVED = 0, 3, 6, 9, 18, 21, 30, 33, 36, 39
RECORD = 45
# Behind the records: small matrices, then the coarse mesh's results: place and tension of each node, both end forces.
SMALL, KEPT, FORCES = 64, 4, 6


class Line(NamedTuple):
    """The line on one mesh; forces in N, lengths in m.

    slack: below which a segment's force counts as none (the kink of |N| is rounded over it); scale: of the forces.
    """

    n: int
    l0: float
    length: float
    flexibility: float
    weight: float
    drag_n: float
    drag_t: float
    free: bool
    body_weight: float
    body_drag: float
    slack: float
    scale: float


@kernel
def line_of(p, n, slack, scale):
    """The line with n segments."""
    return Line(
        n=n,
        l0=p[LENGTH] / n,
        length=p[LENGTH],
        flexibility=p[FLEXIBILITY],
        weight=p[WEIGHT],
        drag_n=p[DRAG_N],
        drag_t=p[DRAG_T],
        free=p[FREE] > 0.0,
        body_weight=p[BODY_WEIGHT],
        body_drag=p[BODY_DRAG],
        slack=slack,
        scale=scale,
    )


@kernel
def with_slack(line, slack):
    """The same line with another slack."""
    return Line(
        n=line.n,
        l0=line.l0,
        length=line.length,
        flexibility=line.flexibility,
        weight=line.weight,
        drag_n=line.drag_n,
        drag_t=line.drag_t,
        free=line.free,
        body_weight=line.body_weight,
        body_drag=line.body_drag,
        slack=slack,
        scale=line.scale,
    )
