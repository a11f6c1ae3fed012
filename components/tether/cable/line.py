"""The discrete line: its constants, and where each number stands in the state and in the scratch vector."""

from typing import NamedTuple

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
SCRATCH = 36

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
    """What the kernels know of a line; "half" is what half a segment gives to the node at either of its ends."""

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
    # stepping, winch, break
    length: float  # unstretched, with nothing wound in or out [m]
    accuracy: float  # position error that a sub-step may make [m]
    breaking_load: float  # 0: never breaks [N]
    winch: int  # 0: none, 1: at end a, -1: at end b
    least_scale: float  # the winch stops hauling in there
    event_cut: int  # segment that an event cuts, counted from 1; 0: none
    scale: float  # present unstretched length over `length`
    payout: float  # its rate [m/s]
    payout_change: float  # and that one's [m/s^2]
    cut: int  # index of the segment that is cut, -1: none


@kernel
def unpack(p):
    """The whole Line from the parameter vector, where it stands in the order of its fields."""
    return present(p, 1.0, 0.0, 0.0, -1)


@kernel
def present(p, s, payout, payout_change, cut):
    """The Line with its unstretched length scaled by s, paid out at a rate [m/s] that changes [m/s^2], and cut."""
    i = HEADER
    return Line(
        int(p[i]), int(p[i + 1]), int(p[i + 2]), s * p[i + 3], p[i + 4] / s, p[i + 5], s * p[i + 6], s * p[i + 7],
        s * p[i + 8], s * p[i + 9], s * p[i + 10], s * p[i + 11], int(p[i + 12]), p[i + 13], int(p[i + 14]), p[i + 15],
        int(p[i + 16]), p[i + 17],
        p[i + 18], p[i + 19], p[i + 20], int(p[i + 21]), p[i + 22], int(p[i + 23]), s,
        payout, payout_change, cut,
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
