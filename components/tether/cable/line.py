"""The discrete line: its constants, and where each number stands in the state and in the scratch vector."""

from typing import NamedTuple

import numpy as np

from components.compiled import kernel
from components.contract import HEADER

# A node's record in x and w: position, velocity, true and algorithmic acceleration (3 each), in x followed by
# the tension of the segment after it; in w further by what one Newton iteration needs.
Q, V, ACC, A, T = 0, 3, 6, 9, 12
STATE = 13
R = 13  # residual, then the Newton correction (3)
D = 16  # diagonal block xx, yy, zz, xy, xz, yz (6)
E = 22  # block to the next node, same order; after elimination D^-1 E, row by row (9)
TC = 31  # tension by the constitutive law at this iterate
KE = 32  # dTC / d elongation
DIR = 33  # unit tangent of the segment (3)
ASKED = 36  # of an inextensible segment: the tension that its stretch asks for on top of TC
SCRATCH = 37

# Behind the nodes' records, each only where its term is on: the water's velocity and acceleration at the nodes, with
# the levels of the port's current after the last; the points on the bed that hold the nodes; the way in which each
# slides over it in an iterate, and the force of its stick beyond friction; the rows of the banded matrix and of the
# full one, which the static start in a current needs.
WATER, ANCHOR, SLIDING, BAND, FULL = 6, 2, 3, 27, 51

FREE, DRIVEN, BONDED = range(3)

# stepping, winch, break: what follows the nodes' records in x; the last two only with a winch.
LEAD = 0  # the algorithmic acceleration is the true one so much later [s]
LEVEL = 1  # the last sub-step was the period's over 2^LEVEL
CUT = 2  # segment that is cut, counted from 1; 0: none
SCALE = 3  # unstretched length over `length`
RATE = 4  # of payout [m/s]
# In w after the records: the nodes' state where a sub-step began, then with a winch each node's motion on the mesh.
ON_MESH = 6


class Line(NamedTuple):
    """What the kernels know of a line; "half" is what half a segment gives to the node at either of its ends.

    Of a line of sections, whose segments differ, l0 and half masses are the smallest, k is the largest.
    Places in p, u, x and w are 0 where the term is off.
    """

    n: int  # segments
    end_a: int  # FREE, DRIVEN or BONDED
    end_b: int
    l0: float  # unstretched length of a segment [m]
    k: float  # EA / l0 [N/m]
    tau: float  # relaxation time of the axial damping [s]
    mass: float  # half, dry [kg]
    added_n: float  # half, added mass across the line [kg]
    added_t: float  # half, added mass along the line [kg]
    weight: float  # half, in the fluid, down [N]
    drag_n: float  # half, force per squared velocity across [N s^2/m^2]
    drag_t: float  # half, along
    tension_only: int
    rho_inf: float
    sub_steps: int
    tolerance: float
    max_iterations: int
    dry_weight: float  # of the whole line [N]
    displaced: float  # half, mass of the displaced fluid [kg]
    inextensible: int  # k is then the penalty of the multipliers' method
    special: int  # whether segments differ, the water moves or the length is fixed
    parts: int  # place in p of the segments' own constants
    current: int  # place in p of the current's levels
    heard: int  # place in u of the current that another component gives
    heard_depths: int  # place in p of the depths where it does
    waves: int  # place in p of the waves
    water: int  # place in w of the water's motion at the nodes
    clumps: int  # place in p of the clump weights
    bed: int  # whether there is a seabed
    bed_depth: float  # [m]
    bed_stiffness: float  # [N/m^2]
    bed_onset: float  # depth of sinking over which the stiffness sets in [m]
    bed_time: float  # relaxation time of the bed's damping [s]
    friction: float  # Coulomb's coefficient on the bed
    anchors: int  # place in w of the points that hold the nodes by friction
    memory: int  # place in x of the same
    stiff: float  # EI of the first segment; 0: no bending stiffness [N m^2]
    clamps: int  # place in p of the directions in which the ends are clamped (2, 3); zero: hinged
    band: int  # place in w of the banded matrix
    full: int  # place in w of the full matrix
    length: float  # unstretched, with nothing wound in or out [m]
    accuracy: float  # position error that a sub-step may make [m]
    breaking_load: float  # 0: never breaks [N]
    winch: int  # 0: none, 1: at end a, -1: at end b
    rate: int  # place in u of the payout rate
    least_scale: float  # the winch stops hauling in there
    event_cut: int  # segment that an event cuts, counted from 1; 0: none
    scale: float  # present unstretched length over `length`
    payout: float  # its rate [m/s]
    payout_change: float  # and that one's [m/s^2]
    cut: int  # index of the segment that is cut, -1: none
    t: float  # end of the step [s]
    table: np.ndarray  # p


@kernel
def unpack(p, t):
    """The whole Line from the parameter vector, where its fields stand in their order, at the end t [s] of the step."""
    return present(p, t, 1.0, 0.0, 0.0, -1)


@kernel
def present(p, t, s, payout, payout_change, cut):
    """The Line at t [s], its unstretched length scaled by s, paid out at a rate [m/s] that changes [m/s^2], and cut."""
    i = HEADER
    return Line(
        int(p[i]), int(p[i + 1]), int(p[i + 2]), s * p[i + 3], p[i + 4] / s, p[i + 5], s * p[i + 6], s * p[i + 7],
        s * p[i + 8], s * p[i + 9], s * p[i + 10], s * p[i + 11], int(p[i + 12]), p[i + 13], int(p[i + 14]), p[i + 15],
        int(p[i + 16]), p[i + 17], s * p[i + 18], int(p[i + 19]), int(p[i + 20]), int(p[i + 21]), int(p[i + 22]),
        int(p[i + 23]), int(p[i + 24]), int(p[i + 25]), int(p[i + 26]), int(p[i + 27]), int(p[i + 28]), p[i + 29],
        p[i + 30], p[i + 31], p[i + 32], p[i + 33], int(p[i + 34]), int(p[i + 35]), p[i + 36], int(p[i + 37]),
        int(p[i + 38]), int(p[i + 39]), p[i + 40], p[i + 41], p[i + 42], int(p[i + 43]), int(p[i + 44]), p[i + 45],
        int(p[i + 46]),
        s, payout, payout_change, cut, t, p,
    )  # fmt: skip


@kernel
def tail(line):
    """Where the numbers after the nodes' records begin in x."""
    return STATE * (line.n + 1)


@kernel
def saved(line):
    """Where in w the nodes' state at the beginning of a sub-step is kept."""
    return SCRATCH * (line.n + 1)


@kernel
def on_mesh(line):
    """Where in w the nodes' velocity and acceleration on the mesh are kept while a winch runs."""
    return (SCRATCH + STATE) * (line.n + 1)


@kernel
def first_unknown(line):
    """Index of the first node that moves by its own balance."""
    return 0 if line.end_a == FREE else 1


@kernel
def last_unknown(line):
    """Index of the last node that moves by its own balance."""
    return line.n if line.end_b == FREE else line.n - 1


@kernel
def load(n, x, start, w):
    """Copy the nodes' state from x[start:] to the scratch records."""
    for i in range(n + 1):
        for c in range(STATE):
            w[i * SCRATCH + c] = x[start + i * STATE + c]


@kernel
def store(n, w, x, start):
    """Copy the nodes' state from the scratch records to x[start:]."""
    for i in range(n + 1):
        for c in range(STATE):
            x[start + i * STATE + c] = w[i * SCRATCH + c]
