"""A winch along the whole line: its unstretched length in time, and the balance of material that flows past the nodes.

Nodes keep their share of the unstretched length L(t), counted from the end that is not on the winch, so that at the
share xi the material passes its node at w = -xi dL/dt towards the winch. With D the central difference of the nodes by
material length, m the mass per length and l0 = L / n, a node's material moves at V = dq/dt + w D, and Hamilton's
principle for the kinetic energy sum of m l0 V^2 / 2 gives the balance of momentum

    d/dt (m l0 V_i) + m (w_{i+1} V_{i+1} - w_{i-1} V_{i-1}) / 2 = force_i,

which the flow between nodes leaves conserved (an arbitrary Lagrangian-Eulerian form; for the continuum see Wickert and
Mote 1990, J. Appl. Mech. 57, on axially moving strings). The left side over m l0 is the node's material acceleration.
"""

from components.compiled import kernel
from components.tether.cable import balance
from components.tether.cable.line import ACC, ON_MESH, SCRATCH, Q, V, on_mesh


@kernel
def wound(line, scale, before, after, h, fraction):
    """Scale, rate [m/s] and its change [m/s^2] at a fraction of the h [s] in which the payout rate goes evenly.

    before, after: the rate at both ends [m/s]. At the least scale the winch stops.
    """
    change = (after - before) / h
    rate = before + fraction * (after - before)
    s = scale + fraction * h * (before + 0.5 * fraction * (after - before)) / line.length
    if s <= line.least_scale and rate <= 0.0:
        return line.least_scale, 0.0, 0.0
    return max(s, line.least_scale), rate, change


@kernel
def spacing(line, i):
    """The neighbours of node i (itself where it has none, or the line is cut) towards the winch and away from it."""
    back = i if i == 0 or i - 1 == line.cut else i - 1
    ahead = i if i == line.n or i == line.cut else i + 1
    return (back, ahead) if line.winch == 1 else (ahead, back)


@kernel
def share(line, i):
    """The share of the unstretched length between node i and the end that is not on the winch."""
    return (line.n - i) / line.n if line.winch == 1 else i / line.n


@kernel
def flow_in(line, w):
    """Replace the nodes' velocity and acceleration by their material's; those on the mesh are kept aside."""
    keep = on_mesh(line)
    growth = line.payout / (line.length * line.scale)
    for i in range(line.n + 1):
        for c in range(3):
            w[keep + ON_MESH * i + c] = w[i * SCRATCH + V + c]
            w[keep + ON_MESH * i + 3 + c] = w[i * SCRATCH + ACC + c]
    for i in range(line.n + 1):
        ahead, behind = spacing(line, i)
        reach = max(abs(ahead - behind), 1) * line.l0
        flow, surge = -share(line, i) * line.payout, -share(line, i) * line.payout_change
        for c in range(3):
            d = (w[ahead * SCRATCH + Q + c] - w[behind * SCRATCH + Q + c]) / reach
            rate = (w[keep + ON_MESH * ahead + c] - w[keep + ON_MESH * behind + c]) / reach
            v = w[i * SCRATCH + V + c] + flow * d
            w[i * SCRATCH + V + c] = v
            w[i * SCRATCH + ACC + c] += surge * d + flow * (rate - growth * d) + growth * v
    for i in range(line.n + 1):
        ahead, behind = spacing(line, i)
        reach = max(abs(ahead - behind), 1) * line.l0
        to, fro = -share(line, ahead) * line.payout, -share(line, behind) * line.payout
        for c in range(3):
            gain = to * w[ahead * SCRATCH + V + c] - fro * w[behind * SCRATCH + V + c]
            w[i * SCRATCH + ACC + c] += gain / reach


@kernel
def flow_out(line, w):
    """Put the nodes' velocity and acceleration on the mesh back."""
    keep = on_mesh(line)
    for i in range(line.n + 1):
        for c in range(3):
            w[i * SCRATCH + V + c] = w[keep + ON_MESH * i + c]
            w[i * SCRATCH + ACC + c] = w[keep + ON_MESH * i + 3 + c]


@kernel
def assemble(line, w, c_m, c_c):
    """As balance.assemble, with the material's motion where a winch runs; the matrix leaves its flow out."""
    if line.payout != 0.0 or line.payout_change != 0.0:
        flow_in(line, w)
        balance.assemble(line, w, c_m, c_c)
        flow_out(line, w)
    else:
        balance.assemble(line, w, c_m, c_c)
