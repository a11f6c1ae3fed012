"""Binds the quasi-static line to the contract: ends in, shape and forces out, no state."""

from math import sqrt

from components.compiled import kernel
from components.contract import Component
from components.tether.quasistatic import model
from components.tether.quasistatic.line import (
    A_ACCELERATION,
    A_POSITION,
    A_VELOCITY,
    B_ACCELERATION,
    B_POSITION,
    B_VELOCITY,
    FLEXIBILITY,
    FREE,
    KEPT,
    LENGTH,
    LIMITS,
    SEGMENTS,
)
from components.tether.quasistatic.mesh import results, solve_both
from components.tether.quasistatic.status import NEUTRAL_SLACK, TEXT, TOO_SOFT
from components.tether.quasistatic.validity import Range, assess, half_depth

# The outputs after the nodes (n, 3) and their tensions (n,).
FORCE_A, FORCE_B, CONVERGED, RESIDUAL, ITERATIONS, ERROR, TENSION_ERROR, VALIDITY = 0, 3, 6, 7, 8, 9, 10, 11
# An error that is not known is at least the line's length; a residual stays finite.
LARGEST = 1e9


@kernel
def size(x, y, z):
    """Length of a vector."""
    return sqrt(x * x + y * y + z * z)


@kernel
def write_shape(u, w, y, n, free, smooth):
    """Nodes, tensions and end forces, and the largest error of nodes and tensions by what the meshes differ by.

    Where the shape is smooth they are improved by the third of that (Richardson); elsewhere the error is all of it.
    """
    gain = 1.0 / 3.0 if smooth else 0.0
    coarse, fine = results(n)
    shift, slip = 0.0, 0.0
    for i in range(n + 1):
        c, f = coarse + KEPT * i, fine + KEPT * i
        dx, dy, dz, dT = w[f] - w[c], w[f + 1] - w[c + 1], w[f + 2] - w[c + 2], w[f + 3] - w[c + 3]
        y[3 * i] = u[A_POSITION] + w[f] + gain * dx
        y[3 * i + 1] = u[A_POSITION + 1] + w[f + 1] + gain * dy
        y[3 * i + 2] = u[A_POSITION + 2] + w[f + 2] + gain * dz
        y[3 * (n + 1) + i] = max(w[f + 3] + gain * dT, 0.0)
        shift, slip = max(shift, size(dx, dy, dz)), max(slip, abs(dT))
    after = 4 * (n + 1)
    for k in range(6):
        c, f = coarse + KEPT * (n + 1) + k, fine + KEPT * (n + 1) + k
        y[after + k] = 0.0 if free and k >= FORCE_B else w[f] + gain * (w[f] - w[c])
    share = gain if smooth else 1.0
    return share * shift, share * slip


@kernel
def write_validity(p, u, y, n, scale, error):
    """The measures, from the tensions and what a load across the line would shift it."""
    L, tension = p[LENGTH], 3 * (n + 1)
    least = most = y[tension]
    for i in range(1, n + 1):
        least, most = min(least, y[tension + i]), max(most, y[tension + i])
    last = 3 * n
    chord = size(y[last] - y[0], y[last + 1] - y[1], y[last + 2] - y[2])
    depth = half_depth(L * (1.0 + 0.5 * (least + most) * p[FLEXIBILITY]), chord)
    acceleration = size(u[A_ACCELERATION], u[A_ACCELERATION + 1], u[A_ACCELERATION + 2])
    unsteady = 0.0
    if p[FREE] == 0.0:
        b, a = B_VELOCITY, A_VELOCITY
        unsteady = size(u[b] - u[a], u[b + 1] - u[a + 1], u[b + 2] - u[a + 2])
        b = B_ACCELERATION
        acceleration = max(acceleration, size(u[b], u[b + 1], u[b + 2]))
    limits = Range(p[LIMITS], p[LIMITS + 1], p[LIMITS + 2], p[LIMITS + 3], p[LIMITS + 4])
    q = scale / L
    assess(y, 4 * (n + 1) + VALIDITY, limits, error, unsteady, acceleration, depth / q, least, most, q)


def step(t_ns, dt_ns, p, u, x, y, w):
    """The line in balance between the ends, or below end a, where they are now."""
    n = int(p[SEGMENTS])
    dx, dy, dz = 0.0, 0.0, p[LENGTH]
    if p[FREE] == 0.0:
        b, a = B_POSITION, A_POSITION
        dx, dy, dz = u[b] - u[a], u[b + 1] - u[a + 1], u[b + 2] - u[a + 2]
    scale, iterations, residual, solved, smooth = solve_both(p, u, w, n, dx, dy, dz)
    if scale == 0.0:
        return NEUTRAL_SLACK
    if not solved and scale * p[FLEXIBILITY] > 1.0:
        return TOO_SOFT
    shift, slip = write_shape(u, w, y, n, p[FREE] > 0.0, smooth)
    if not smooth:  # a fold moves by up to a fine segment between the meshes' nodes
        shift, slip = shift + 0.5 * p[LENGTH] / n, slip + 0.5 * scale / n
    after = 4 * (n + 1)
    y[after + CONVERGED] = 1.0 if solved else 0.0
    y[after + RESIDUAL] = min(residual, LARGEST)
    y[after + ITERATIONS] = iterations
    y[after + ERROR] = shift if solved else max(shift, p[LENGTH])
    y[after + TENSION_ERROR] = slip if solved else max(slip, scale)
    write_validity(p, u, y, n, scale, y[after + ERROR])
    return 0


COMPONENT = Component(
    name="tether.quasistatic",
    parameters=model.Quasistatic,
    inputs=model.inputs,
    outputs=model.outputs,
    sizes=model.sizes,
    init=step,
    step=step,
    status_text=TEXT,
    terms=model.terms,
    validity="validity.range",
    assumptions="Uniform elastic line without bending stiffness or seabed, in balance at every instant under its "
    "weight and quadratic drag per unstretched length, moving with its ends; inertia small beside drag and weight. "
    "Of several equilibria it is one that the loads lead to from those of a line across the flow. "
    "Valid where all of `validity` is below 1.",
)
