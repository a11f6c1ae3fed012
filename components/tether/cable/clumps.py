"""Clump weights and floats: bodies on the line that are points, each shared between the two nodes next to it."""

from math import sqrt

from components.compiled import kernel
from components.tether.cable.drag import STILL
from components.tether.cable.line import ACC, SCRATCH, WATER, D, R, V

CLUMP = 6  # numbers of one: node, mass, displaced and added mass [kg], weight in the fluid [N], rho CdA / 2 [N s^2/m^2]


@kernel
def add(line, w, c_m, c_c):
    """Add to R and D of their nodes inertia, weight and drag, and the force of the water's acceleration."""
    k = line.clumps + 1
    for _ in range(int(line.table[line.clumps])):
        node, mass, displaced, added = int(line.table[k]), line.table[k + 1], line.table[k + 2], line.table[k + 3]
        weight, drag = line.table[k + 4], line.table[k + 5]
        b, f = node * SCRATCH, line.water + WATER * node
        vx, vy, vz = w[b + V], w[b + V + 1], w[b + V + 2]
        if line.water:
            vx, vy, vz = vx - w[f], vy - w[f + 1], vz - w[f + 2]
            for c in range(3):
                w[b + R + c] += (displaced + added) * w[f + 3 + c]
        speed = sqrt(vx * vx + vy * vy + vz * vz + STILL)
        for c in range(3):
            w[b + R + c] -= (mass + added) * w[b + ACC + c]
            w[b + D + c] += c_m * (mass + added) + c_c * drag * speed
        w[b + R] -= drag * speed * vx
        w[b + R + 1] -= drag * speed * vy
        w[b + R + 2] += weight - drag * speed * vz
        g = c_c * drag / speed
        w[b + D] += g * vx * vx
        w[b + D + 1] += g * vy * vy
        w[b + D + 2] += g * vz * vz
        w[b + D + 3] += g * vx * vy
        w[b + D + 4] += g * vx * vz
        w[b + D + 5] += g * vy * vz
        k += CLUMP
