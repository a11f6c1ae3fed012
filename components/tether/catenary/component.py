"""Binds the static line to the contract: world coordinates in, shape and forces out, no state."""

from math import hypot, inf

from components.compiled import kernel
from components.contract import HEADER, Component
from components.tether.catenary import model
from components.tether.catenary.frame import hanging_frame
from components.tether.catenary.line import end_tensions, neutral, parameter, point, rest, sag
from components.tether.catenary.status import TEXT
from components.tether.catenary.validity import LARGEST, Range, assess, half_depth, speed

LENGTH, FLEXIBILITY, SEGMENTS, HAS_SEABED, SEABED, FRICTION, LOAD = range(HEADER, HEADER + 7)
HAS_INPUT, LIMITS = LOAD + 3, LOAD + 4
END_A, END_B, LOAD_INPUT = 0, 9, 18
# The outputs after the nodes (n, 3) and their tensions (n,).
FORCE_A, FORCE_B, HORIZONTAL, PARAMETER, SAG, TOUCHES, GROUNDED, VALIDITY = 0, 3, 6, 7, 8, 9, 10, 11


@kernel
def write_force(y, at, frame, along, up):
    """The force with these parts along and against the load."""
    y[at] = along * frame.along_x + up * frame.up_x
    y[at + 1] = along * frame.along_y + up * frame.up_y
    y[at + 2] = along * frame.along_z + up * frame.up_z


@kernel
def write_node(y, nodes, j, u, frame, x, z, tension):
    """Node j, x along and z against the load from end a, and its tension."""
    y[3 * j] = u[END_A] + (x * frame.along_x + z * frame.up_x)
    y[3 * j + 1] = u[END_A + 1] + (x * frame.along_y + z * frame.up_y)
    y[3 * j + 2] = u[END_A + 2] + (x * frame.along_z + z * frame.up_z)
    y[3 * nodes + j] = tension


@kernel
def write_validity(p, u, y, nodes, q, yields, least):
    """The measures, from the tensions and what a load across the line would shift it."""
    limits = Range(p[LIMITS], p[LIMITS + 1], p[LIMITS + 2], p[LIMITS + 3], p[LIMITS + 4])
    T_a, T_b = y[3 * nodes], y[4 * nodes - 1]
    fastest = max(speed(u, END_A)[0], speed(u, END_B)[0])
    at = 4 * nodes + VALIDITY
    assess(y, at, u, END_A, END_B, limits, fastest, yields, T_a, T_b, least, max(T_a, T_b), q)


@kernel
def write_straight(p, u, y, nodes, frame, span):
    """The status of a line without load, and its outputs where it is taut."""
    L = p[LENGTH]
    status, T, _ = neutral(span / L, 0.0, p[FLEXIBILITY])
    if status != 0:
        return status
    for j in range(nodes):
        write_node(y, nodes, j, u, frame, span * (j / (nodes - 1)), 0.0, T)
    after = 4 * nodes
    write_force(y, after + FORCE_A, frame, T, 0.0)
    write_force(y, after + FORCE_B, frame, -T, 0.0)
    y[after + HORIZONTAL] = T
    y[after + PARAMETER] = y[after + SAG] = y[after + TOUCHES] = y[after + GROUNDED] = 0.0
    write_validity(p, u, y, nodes, 0.0, span * span / (8.0 * T) if T > 0.0 else LARGEST, T)
    return 0


@kernel
def write_curved(p, u, y, nodes, frame, q, span, rise, p_a, p_b):
    """The status of a line under the load q [N/m], and its outputs."""
    L = p[LENGTH]
    scale = q * L
    e = scale * p[FLEXIBILITY]
    status, line = rest(span / L, rise / L, e, p_a, p_b, p[FRICTION])
    if status != 0:
        return status
    for j in range(nodes):
        x, z, H, V = point(line, j / (nodes - 1))
        write_node(y, nodes, j, u, frame, L * x, L * z, scale * hypot(H, V))
    after = 4 * nodes
    H_a, H_b = end_tensions(line)
    write_force(y, after + FORCE_A, frame, scale * H_a, -scale * line.s_a)
    write_force(y, after + FORCE_B, frame, -scale * H_b, -scale * line.s_b)
    y[after + HORIZONTAL] = scale * line.H
    y[after + PARAMETER] = parameter(scale * line.H, q)
    y[after + SAG] = L * (min(p_a, p_b) if line.touches else sag(line.H, line.V, e))
    y[after + TOUCHES] = 1.0 if line.touches else 0.0
    y[after + GROUNDED] = L * (1.0 - line.s_a - line.s_b) if line.touches else 0.0
    middle = hypot(line.H, 0.0 if line.touches else line.V)
    depth = L * half_depth(1.0 + e * middle, hypot(span, rise) / L)
    write_validity(p, u, y, nodes, q, depth / q, scale * line.H)
    return 0


@kernel
def total_load(p, u, axis):
    """The parameters' load along an axis and what comes in [N/m]."""
    return p[LOAD + axis] + (u[LOAD_INPUT + axis] if p[HAS_INPUT] > 0.0 else 0.0)


def step(t_ns, dt_ns, p, u, x, y, w):
    """The line at rest between the ends where they are now."""
    north, east, down = u[END_B] - u[END_A], u[END_B + 1] - u[END_A + 1], u[END_B + 2] - u[END_A + 2]
    frame, q, span, rise = hanging_frame(
        total_load(p, u, 0), total_load(p, u, 1), total_load(p, u, 2), north, east, down
    )
    nodes = int(p[SEGMENTS]) + 1
    if q == 0.0:
        return write_straight(p, u, y, nodes, frame, span)
    p_a = p_b = inf
    if p[HAS_SEABED] > 0.0:
        p_a = (p[SEABED] - u[END_A + 2]) / p[LENGTH]
        p_b = (p[SEABED] - u[END_B + 2]) / p[LENGTH]
    return write_curved(p, u, y, nodes, frame, q, span, rise, p_a, p_b)


COMPONENT = Component(
    name="tether.catenary",
    parameters=model.Catenary,
    inputs=model.inputs,
    outputs=model.outputs,
    init=step,
    step=step,
    status_text=TEXT,
    terms=model.terms,
    validity="validity.range",
    assumptions="Uniform line without bending stiffness under a uniform load, so slow that other drag and inertia are "
    "small beside it; level seabed with Coulomb friction towards an anchored end. "
    "Valid where all of `validity` is below 1.",
)
