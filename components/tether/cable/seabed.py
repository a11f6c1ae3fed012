"""A level seabed: an elastic, damped contact of the nodes, and Coulomb friction that holds them by points on it."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable.line import ANCHOR, SCRATCH, SLIDING, D, Q, R, V
from components.tether.cable.part import span

# The anchor of a node that friction does not hold: NaN, which is not equal to itself.
LOOSE = float("nan")


@kernel
def pressure(sunk, line):
    """Force [N/m] per length at the depth `sunk` below the bed's surface [m], its slope [N/m^2] and that one's [N/m^3].

    Stiffness k beyond the onset s0, before it k s^2 / (2 s0): continuous slope, so that a touchdown that wanders
    from node to node neither chatters nor leaves Newton at a kink.
    """
    if sunk <= 0.0:
        return 0.0, 0.0, 0.0
    if sunk < line.bed_onset:
        growth = line.bed_stiffness / line.bed_onset
        return 0.5 * growth * sunk * sunk, growth * sunk, growth
    return line.bed_stiffness * (sunk - 0.5 * line.bed_onset), line.bed_stiffness, 0.0


@kernel
def support(sunk, v, line):
    """Upward force [N/m] per length at the depth `sunk` and the velocity v down, its slopes [N/m^2], [N s/m^2] by both.

    max(0, f + tau f' v), f the pressure: the bed does not hold a node that leaves it. Never falls as a node sinks
    within a step, the quicker the deeper.
    """
    force, slope, growth = pressure(sunk, line)
    damped = force + line.bed_time * slope * v
    if damped <= 0.0:
        return 0.0, 0.0, 0.0
    return damped, slope + line.bed_time * growth * v, line.bed_time * slope


@kernel
def add(line, w, c_c):
    """Add the bed's forces to R and their stiffness and damping to D.

    Upwards `support`; sideways the force of an elastic, damped stick, k (d + tau v) with d the way from the node's
    anchor, cut down to mu times the upward force: Coulomb friction with an elastic stick, so that a line at rest does
    not creep. Left out of D is how friction grows with the upward force, which is not symmetric.
    """
    for i in range(line.n + 1):
        b = i * SCRATCH
        sunk = w[b + Q + 2] - line.bed_depth
        if sunk <= 0.0:
            if line.anchors:
                release(line, w, i)
            continue
        share = span(line, i)
        normal, stiffness, damping = support(sunk, w[b + V + 2], line)
        w[b + R + 2] -= share * normal
        w[b + D + 2] += share * (stiffness + c_c * damping)
        if line.anchors:
            hold(line, w, i, share * normal, share * line.bed_stiffness, c_c)


@kernel
def hold(line, w, i, normal, stiffness, c_c):
    """Add the friction on node i, pressed on the bed by `normal` [N]; stiffness: of the stick [N/m].

    A node that slid one way in the last iterate and would slide the other way now is taken to stick in between, with a
    force that may exceed what friction gives (`overdrawn`): else Newton goes to and fro between both ways for ever
    where the node comes to rest. An active set that a node leaves through its neighbour only, as in the primal-dual
    methods for friction (Hueber, Stadler and Wohlmuth 2008, SIAM J. Sci. Comput. 30).
    """
    b, a, f = i * SCRATCH, line.anchors + i * ANCHOR, sliding(line, i)
    tau = line.bed_time
    dx, dy = w[b + Q] - w[a] + tau * w[b + V], w[b + Q + 1] - w[a + 1] + tau * w[b + V + 1]
    way, most = sqrt(dx * dx + dy * dy), line.friction * normal
    grip = stiffness * (1.0 + tau * c_c)
    back = w[f] * dx + w[f + 1] * dy
    release(line, w, i)
    if stiffness * way <= most or back < 0.0:
        w[f + 2] = max(stiffness * way - most, 0.0)
        w[b + R] -= stiffness * dx
        w[b + R + 1] -= stiffness * dy
        w[b + D] += grip
        w[b + D + 1] += grip
    elif way > 0.0:
        ux, uy = dx / way, dy / way
        w[f], w[f + 1] = ux, uy
        w[b + R] -= most * ux
        w[b + R + 1] -= most * uy
        turn = grip * most / (stiffness * way)
        w[b + D] += turn * uy * uy
        w[b + D + 1] += turn * ux * ux
        w[b + D + 3] -= turn * ux * uy


@kernel
def sliding(line, i):
    """Place in w of how node i slides: behind the anchors and those set aside."""
    return line.anchors + 2 * ANCHOR * (line.n + 1) + SLIDING * i


@kernel
def release(line, w, i):
    """Forget that node i slid in the last iterate."""
    f = sliding(line, i)
    w[f] = w[f + 1] = w[f + 2] = 0.0


@kernel
def begin(line, w):
    """Make ready for the first iterate of a balance."""
    if line.anchors:
        for i in range(line.n + 1):
            release(line, w, i)


@kernel
def overdrawn(line, w):
    """Largest force of a stick over what friction gives [N]."""
    worst = 0.0
    if line.anchors:
        for i in range(line.n + 1):
            worst = max(worst, w[sliding(line, i) + 2])
    return worst


@kernel
def drag_anchors(line, w):
    """Move each node's anchor to where friction leaves it after an accepted step: off the bed, below the node."""
    for i in range(line.n + 1):
        b, a = i * SCRATCH, line.anchors + i * ANCHOR
        sunk = w[b + Q + 2] - line.bed_depth
        most = line.friction * support(sunk, w[b + V + 2], line)[0] / line.bed_stiffness
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
