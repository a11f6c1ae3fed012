"""A level seabed: an elastic, damped contact of the nodes, and Coulomb friction that holds them by points on it."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable.line import ANCHOR, SCRATCH, D, Q, R, V
from components.tether.cable.part import span

# The anchor of a node that friction does not hold: NaN, which is not equal to itself.
LOOSE = float("nan")


@kernel
def pressure(sunk, line):
    """Force [N/m] per length at the depth `sunk` below the bed's surface [m], and its slope [N/m^2].

    Stiffness k beyond the onset s0, before it k s^2 / (2 s0): continuous slope, so that a touchdown that wanders
    from node to node neither chatters nor leaves Newton at a kink.
    """
    if sunk <= 0.0:
        return 0.0, 0.0
    if sunk < line.bed_onset:
        return 0.5 * line.bed_stiffness * sunk * sunk / line.bed_onset, line.bed_stiffness * sunk / line.bed_onset
    return line.bed_stiffness * (sunk - 0.5 * line.bed_onset), line.bed_stiffness


@kernel
def add(line, w, c_c):
    """Add the bed's forces to R and their stiffness and damping to D.

    Upwards max(0, f + tau f' v), f the pressure; sideways k (d + tau v) while that is within mu times the upward
    force, d the way from the node's anchor, else mu times it: Coulomb friction with an elastic stick, so that a line
    at rest does not creep. Left out of D is how friction grows with the upward force, which is not symmetric.
    """
    for i in range(line.n + 1):
        b = i * SCRATCH
        sunk = w[b + Q + 2] - line.bed_depth
        if sunk <= 0.0:
            continue
        share = span(line, i)
        force, slope = pressure(sunk, line)
        normal = max(0.0, share * (force + line.bed_time * slope * w[b + V + 2]))
        w[b + R + 2] -= normal
        w[b + D + 2] += share * slope * (1.0 + line.bed_time * c_c)
        if line.anchors:
            hold(line, w, i, normal, share * line.bed_stiffness, c_c)


@kernel
def hold(line, w, i, normal, stiffness, c_c):
    """Add the friction on node i, pressed on the bed by `normal` [N]; stiffness: of the stick [N/m]."""
    b, a = i * SCRATCH, line.anchors + i * ANCHOR
    dx, dy = w[b + Q] - w[a], w[b + Q + 1] - w[a + 1]
    way = sqrt(dx * dx + dy * dy)
    most = line.friction * normal
    if stiffness * way <= most:
        tau = line.bed_time
        w[b + R] -= stiffness * (dx + tau * w[b + V])
        w[b + R + 1] -= stiffness * (dy + tau * w[b + V + 1])
        w[b + D] += stiffness * (1.0 + tau * c_c)
        w[b + D + 1] += stiffness * (1.0 + tau * c_c)
    elif way > 0.0:
        dx, dy = dx / way, dy / way
        w[b + R] -= most * dx
        w[b + R + 1] -= most * dy
        w[b + D] += most / way * dy * dy
        w[b + D + 1] += most / way * dx * dx
        w[b + D + 3] -= most / way * dx * dy


@kernel
def drag_anchors(line, w):
    """Move each node's anchor to where friction leaves it after an accepted step: off the bed, below the node."""
    for i in range(line.n + 1):
        b, a = i * SCRATCH, line.anchors + i * ANCHOR
        sunk = w[b + Q + 2] - line.bed_depth
        force, slope = pressure(sunk, line)
        most = line.friction * max(0.0, force + line.bed_time * slope * w[b + V + 2]) / line.bed_stiffness
        dx, dy = w[b + Q] - w[a], w[b + Q + 1] - w[a + 1]
        way = sqrt(dx * dx + dy * dy)
        if not way <= most:
            kept = most / way if way > 0.0 else 0.0
            w[a] = w[b + Q] - kept * dx if kept > 0.0 else w[b + Q]
            w[a + 1] = w[b + Q + 1] - kept * dy if kept > 0.0 else w[b + Q + 1]


@kernel
def loosen(line, w):
    """Take all anchors up."""
    for k in range(line.anchors, line.anchors + ANCHOR * (line.n + 1)):
        w[k] = LOOSE


@kernel
def recall(line, x, w):
    """Copy the anchors from x to w."""
    for k in range(ANCHOR * (line.n + 1)):
        w[line.anchors + k] = x[line.memory + k]


@kernel
def keep(line, w, x):
    """Copy the anchors from w to x."""
    for k in range(ANCHOR * (line.n + 1)):
        x[line.memory + k] = w[line.anchors + k]


@kernel
def set_aside(line, w):
    """Keep the anchors behind themselves, for a sub-step that may be taken again."""
    size = ANCHOR * (line.n + 1)
    for k in range(line.anchors, line.anchors + size):
        w[k + size] = w[k]


@kernel
def put_back(line, w):
    """Return the anchors to what was set aside."""
    size = ANCHOR * (line.n + 1)
    for k in range(line.anchors, line.anchors + size):
        w[k] = w[k + size]
