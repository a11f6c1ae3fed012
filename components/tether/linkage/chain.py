"""The chain of rigid segments: its constants, and where each number stands in p, u, x and the scratch vector.

n equal segments between the nodes 0 (end a) to n (end b), in a plane whose axes are north and east (or down). Segment i
has the direction t_i = (cos theta_i, sin theta_i) and the normal n_i = dt_i / dtheta_i. The joint at node i carries the
force h_i, that of what lies before it on segment i; under tension it points against t_i.
"""

from typing import NamedTuple

from components.compiled import kernel
from components.contract import HEADER

LENGTH, SEGMENTS, DRAG_S, DRAG_V, SQUARE_S, SQUARE_V, MASS, SPRING, WEIGHT = range(HEADER, HEADER + 9)
SECOND_AXIS, END_A, END_B, PARTED_A, PARTED_B = range(HEADER + 9, HEADER + 14)
TOLERANCE, ITERATIONS, TOLERATED, VIRTUAL_MASS = range(HEADER + 14, HEADER + 18)
START, CHORD, POSITION, SIDE = HEADER + 18, HEADER + 19, HEADER + 21, HEADER + 24
BED_DEPTH, BED_STIFFNESS, BED_ONSET, BED_TIME, ANGLES = range(HEADER + 25, HEADER + 30)
DRIVEN, PULLED, FREE = range(3)
STEADY, ARC, GIVEN = range(3)

# A node's record in the state: position, mean velocity of the last step, velocity, its mean rate of change over the
# last step; of the segment behind the node direction, angle, and the angle's last two increments; the joint's force.
R, U, V, Q, T, THETA, TURN, TURN_BEFORE, H = 0, 2, 4, 6, 8, 10, 11, 12, 13
STATE = 15
# A node's record in the scratch vector: position, velocity and acceleration at the step's end; of the segment behind it
# direction, increment of the angle, its last correction; the joint's force; the law of that force (matrix A as xx, xy,
# yx, yy, and alpha) and of the correction (beta and beta_0) by the next joint's; beside springs how both answer a
# moment (k and 1/w), and the law of the joint's moment (kappa, g and kappa (psi - s_theta)).
RN, VN, AN, TN, DELTA, LAST, HN, A, ALPHA, BETA, BETA_0, K, OVER, KAPPA, G, PRELOAD = (
    0, 2, 4, 6, 8, 9, 10, 12, 16, 18, 20, 21, 23, 24, 25, 27
)  # fmt: skip
SCRATCH = 28


class Bed(NamedTuple):
    """The seabed, see tether.cable's seabed.py; no stiffness: none."""

    bed_depth: float  # [m]
    bed_stiffness: float  # [N/m^2]
    bed_onset: float  # [m]
    bed_time: float  # [s]


class Chain(NamedTuple):
    """What does not change within a step.

    n: segments; l0: length of one [m]; c_S, c_V: normal and tangential drag per length and speed [N s/m^2]; k_S, k_V:
    per length and speed squared [N s^2/m^3]; mass: of a segment [kg]; spring: of a joint [N m]; weight: of a segment,
    along the second axis [N]; end_a, end_b: DRIVEN, PULLED or FREE.
    """

    n: int
    l0: float
    c_S: float
    c_V: float
    k_S: float
    k_V: float
    mass: float
    spring: float
    weight: float
    end_a: int
    end_b: int
    tolerance: float
    iterations: int
    bed: Bed


class Ends(NamedTuple):
    """Where driven ends are [m], and the forces on pulled ones [N]."""

    ax: float
    ay: float
    bx: float
    by: float
    pull_ax: float
    pull_ay: float
    pull_bx: float
    pull_by: float


@kernel
def chain_of(p):
    """The chain as the parameters have it now; an end that has parted is free."""
    n = int(p[SEGMENTS])
    l0 = p[LENGTH] / n
    return Chain(
        n=n,
        l0=l0,
        c_S=p[DRAG_S],
        c_V=p[DRAG_V],
        k_S=p[SQUARE_S],
        k_V=p[SQUARE_V],
        mass=p[MASS] * l0,
        spring=p[SPRING],
        weight=p[WEIGHT] * l0,
        end_a=FREE if p[PARTED_A] > 0.0 else int(p[END_A]),
        end_b=FREE if p[PARTED_B] > 0.0 else int(p[END_B]),
        tolerance=p[TOLERANCE],
        iterations=int(p[ITERATIONS]),
        bed=Bed(p[BED_DEPTH], p[BED_STIFFNESS], p[BED_ONSET], p[BED_TIME]),
    )


@kernel
def stretched(chain, l0):
    """The same chain with segments of another length."""
    return Chain(
        n=chain.n,
        l0=l0,
        c_S=chain.c_S,
        c_V=chain.c_V,
        k_S=chain.k_S,
        k_V=chain.k_V,
        mass=chain.mass,
        spring=chain.spring,
        weight=chain.weight,
        end_a=chain.end_a,
        end_b=chain.end_b,
        tolerance=chain.tolerance,
        iterations=chain.iterations,
        bed=chain.bed,
    )


@kernel
def massless(chain):
    """The same chain without inertia."""
    return Chain(
        n=chain.n,
        l0=chain.l0,
        c_S=chain.c_S,
        c_V=chain.c_V,
        k_S=chain.k_S,
        k_V=chain.k_V,
        mass=0.0,
        spring=chain.spring,
        weight=chain.weight,
        end_a=chain.end_a,
        end_b=chain.end_b,
        tolerance=chain.tolerance,
        iterations=chain.iterations,
        bed=chain.bed,
    )
