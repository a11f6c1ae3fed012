"""Loads of steady wind, current and waves on a vessel that stands still."""

from math import cos, sin

from components.compiled import kernel
from components.vessel.low_speed.layout import COUNT, DAMPING, MASS, STRIPS, WINDAGE
from components.vessel.low_speed.resistance import resist_cross_flow, resist_velocity
from components.vessel.low_speed.seakeeping import look_up
from components.vessel.wind_load import blow
from components.vessel.yawing import FREE, MASSES, TRIAL, U, V, resist_acceleration

# Scratch of `stand`: the motion through the water, its balance (4) and slope (4, 4); of `drift`: a cell of the table.
SCRATCH = TRIAL + FREE + FREE * FREE


@kernel
def stand(q, wind, wind_angle, water, water_angle, w, load):
    """Write the load (3) [N, N, N m] of wind and current, their speeds [m/s] and the angles [rad] they come from.

    Angles are clockwise from the bow. The current's is the damping of the vessel's motion through the water, and the
    moment that turns a slender hull across it (Munk 1924), which is in C(nu_r) nu_r.
    """
    m, f, g = w[:TRIAL], w[TRIAL : TRIAL + FREE], w[TRIAL + FREE : SCRATCH]
    for i in range(TRIAL):
        m[i] = 0.0
    m[U], m[V] = water * cos(water_angle), water * sin(water_angle)
    resist_acceleration(q[MASS : MASS + MASSES], m, f, g)
    resist_velocity(q[DAMPING : DAMPING + 15], m, f, g)
    count = int(q[COUNT])
    resist_cross_flow(q[STRIPS : STRIPS + 2 * count], count, m, f, g)
    x, y, n = blow(q[WINDAGE : WINDAGE + 8], wind * cos(wind_angle), wind * sin(wind_angle))
    load[0], load[1], load[2] = x - f[0], y - f[1], n - f[3]


@kernel
def drift(q, frequencies, squares, chi, w, load):
    """Add the mean drift load (3) of waves of frequencies (n) [rad/s] and squared amplitudes (n) [m^2].

    chi: direction that they run to, from the bow [rad]; q: of a vessel with waves.
    """
    cell, table = w[:15], q[STRIPS + 2 * int(q[COUNT]) :]
    for i in range(len(frequencies)):
        look_up(table, frequencies[i], chi, cell)
        for k in range(3):
            load[k] += squares[i] * cell[12 + k]
