"""Binds the static line to the contract: world coordinates in, shape and forces out, no state."""

from math import hypot, inf

from components.compiled import kernel
from components.contract import HEADER, Component
from components.tether.catenary import model
from components.tether.catenary.line import neutral, parameter, rest, sag, upward_force
from components.tether.catenary.seabed import grounded_reach
from components.tether.catenary.shape import reach
from components.tether.catenary.status import TEXT

LENGTH, WEIGHT, FLEXIBILITY, SEGMENTS, HAS_SEABED, SEABED = range(HEADER, HEADER + 6)
END_A, END_B = 0, 9
# The outputs after the nodes (n, 3) and their tensions (n,).
FORCE_A, FORCE_B, HORIZONTAL, PARAMETER, SAG, TOUCHES, GROUNDED = 0, 3, 6, 7, 8, 9, 10


@kernel
def write_ends(y, after, scale, H, V_a, V_b, north, east, up):
    """The line's forces on what holds its ends, from its force at the ends, and its horizontal tension."""
    y[after + FORCE_A] = scale * H * north
    y[after + FORCE_A + 1] = scale * H * east
    y[after + FORCE_A + 2] = -up * scale * V_a
    y[after + FORCE_B] = -scale * H * north
    y[after + FORCE_B + 1] = -scale * H * east
    y[after + FORCE_B + 2] = up * scale * V_b
    y[after + HORIZONTAL] = scale * H


@kernel
def write_node(y, nodes, j, u, x, z, north, east, up, tension):
    """Node j, x along the horizontal and z against the load from end a, and its tension."""
    y[3 * j] = u[END_A] + x * north
    y[3 * j + 1] = u[END_A + 1] + x * east
    y[3 * j + 2] = u[END_A + 2] - up * z
    y[3 * nodes + j] = tension


@kernel
def write_straight(L, flexibility, h, v, u, y, nodes, north, east):
    """The status of a line without weight, and its outputs where it is taut."""
    status, H, V = neutral(h, v, flexibility)
    if status != 0:
        return status
    for j in range(nodes):
        s = L * j / (nodes - 1)
        write_node(y, nodes, j, u, s * h, s * v, north, east, 1.0, hypot(H, V))
    after = 4 * nodes
    write_ends(y, after, 1.0, H, V, V, north, east, 1.0)
    y[after + PARAMETER] = y[after + SAG] = y[after + TOUCHES] = y[after + GROUNDED] = 0.0
    return 0


@kernel
def write_curved(L, weight, flexibility, h, v, p_a, p_b, u, y, nodes, north, east):
    """The status of a line with weight, and its outputs; its catenary hangs in the direction of the weight."""
    up = 1.0 if weight > 0.0 else -1.0
    scale = abs(weight) * L
    e = scale * flexibility
    v *= up
    status, touches, H, V, s_a, s_b = rest(h, v, e, p_a, p_b)
    if status != 0:
        return status
    for j in range(nodes):
        s = j / (nodes - 1)
        x, z = grounded_reach(H, s, s_a, s_b, h, p_a, e) if touches else reach(H, V, s, e)
        tension = scale * hypot(H, upward_force(s, touches, s_a, s_b))
        write_node(y, nodes, j, u, L * x, L * z, north, east, up, tension)
    after = 4 * nodes
    write_ends(y, after, scale, H, -s_a, s_b, north, east, up)
    y[after + PARAMETER] = parameter(scale * H, weight)
    y[after + SAG] = L * (min(p_a, p_b) if touches else sag(H, V, e))
    y[after + TOUCHES] = 1.0 if touches else 0.0
    y[after + GROUNDED] = L * (1.0 - s_a - s_b) if touches else 0.0
    return 0


def step(t_ns, dt_ns, p, u, x, y, w):
    """The line at rest between the ends where they are now."""
    L = p[LENGTH]
    north = u[END_B] - u[END_A]
    east = u[END_B + 1] - u[END_A + 1]
    span = hypot(north, east)
    north, east = (north / span, east / span) if span > 0.0 else (1.0, 0.0)
    h = span / L
    v = (u[END_A + 2] - u[END_B + 2]) / L
    nodes = int(p[SEGMENTS]) + 1
    if p[WEIGHT] == 0.0:
        return write_straight(L, p[FLEXIBILITY], h, v, u, y, nodes, north, east)
    p_a = p_b = inf
    if p[HAS_SEABED] > 0.0:
        p_a = (p[SEABED] - u[END_A + 2]) / L
        p_b = (p[SEABED] - u[END_B + 2]) / L
    return write_curved(L, p[WEIGHT], p[FLEXIBILITY], h, v, p_a, p_b, u, y, nodes, north, east)


COMPONENT = Component(
    name="tether.catenary",
    parameters=model.Catenary,
    inputs=model.inputs,
    outputs=model.outputs,
    init=step,
    step=step,
    status_text=TEXT,
    assumptions="Uniform line without bending stiffness in still water, so slow that drag and inertia are small beside "
    "its weight; level seabed without friction.",
)
