"""The ends' velocities that bring a line to a shape: Bhattacharya et al. 2011, eq. 25, damped near singular shapes."""

from math import atan2, sqrt

from components.compiled import kernel
from components.controller.shape.layout import DAMPING, EDGE, GAIN, LENGTH, MAX_SPEED, NORMAL, TANGENTIAL, TARGET
from components.controller.shape.rates import turning
from components.kinematics import wrapped


@kernel
def read_angles(nodes, theta):
    """Angles of the segments between nodes (n + 1, 3), clockwise from north [rad]."""
    for i in range(len(theta)):
        theta[i] = atan2(nodes[i + 1, 1] - nodes[i, 1], nodes[i + 1, 0] - nodes[i, 0])


@kernel
def eliminate(system):
    """Solve a (4, 5) system of a symmetric positive matrix and its right side; the solution is its last column then."""
    for j in range(EDGE):
        for i in range(EDGE):
            if i != j:
                part = system[i, j] / system[j, j]
                for k in range(j, EDGE + 1):
                    system[i, k] -= part * system[j, k]
    for j in range(EDGE):
        system[j, EDGE] /= system[j, j]


@kernel
def steer(q, theta, wanted, drag, sides, rates, system, velocity):
    """Write the ends' velocities (4) [m/s]; returns the largest error [rad] and 1 if a speed was limited.

    P' = (S' S + mu^2 I)^-1 S' K (theta_D - theta), which is S^+ for mu = 0; mu is DAMPING times the root mean square of
    S's columns.
    """
    n, largest = len(theta), 0.0
    turning(theta, q[LENGTH] / n, q[NORMAL], q[TANGENTIAL], drag, sides, rates)
    for i in range(n):
        error = wrapped(q[TARGET + i] - theta[i])
        largest = max(largest, abs(error))
        wanted[i] = q[GAIN] * error
    trace = 0.0
    for j in range(EDGE):
        for k in range(EDGE):
            system[j, k] = 0.0
            for i in range(n):
                system[j, k] += rates[i, j] * rates[i, k]
        system[j, EDGE] = 0.0
        for i in range(n):
            system[j, EDGE] += rates[i, j] * wanted[i]
        trace += system[j, j]
    for j in range(EDGE):
        system[j, j] += q[DAMPING] * q[DAMPING] * trace / EDGE
    eliminate(system)
    fastest = 0.0
    for end in range(2):
        north, east = system[2 * end, EDGE], system[2 * end + 1, EDGE]
        fastest = max(fastest, sqrt(north * north + east * east))
    share = min(1.0, q[MAX_SPEED] / fastest) if fastest > 0.0 else 1.0
    for j in range(EDGE):
        velocity[j] = share * system[j, EDGE]
    return largest, 1.0 if share < 1.0 else 0.0
